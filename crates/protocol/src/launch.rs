//! What a coordinator passes to a worker on its command line: one word, encoded and decoded here.

use crate::id::{Boot, Incarnation};

/// Descriptor of the model store in a worker.
pub const STORE_FD: i32 = 10;
/// Descriptor of the status page in a worker.
pub const STATUS_FD: i32 = 11;
/// Descriptor of the eventfd that wakes the coordinator.
pub const EVENT_FD: i32 = 12;

/// Descriptor of the memory of paths in a worker.
pub const PATHS_FD: i32 = 13;

/// Words of the memory of paths: 4 MiB.
pub const PATHS_WORDS: usize = 1 << 19;

/// Flag: it works on copies.
const COPIES: u8 = 1;
/// Flag: it executes fault commands. Reserved without the feature `faults`.
#[cfg(feature = "faults")]
const OBEYS: u8 = 2;
/// The flags that this build supports.
#[cfg(feature = "faults")]
const KNOWN: u8 = COPIES | OBEYS;
#[cfg(not(feature = "faults"))]
const KNOWN: u8 = COPIES;

/// How a worker is started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Which worker this is.
    pub who: Incarnation,
    /// The coordinator that starts it.
    pub boot: Boot,
    /// Maximum number of jobs in a batch.
    pub batch: u32,
    /// Maximum number of jobs that it holds.
    pub queue: u32,
    /// Whether it works on copies of sections sent to it, instead of on the store in place.
    pub copies: bool,
    /// Whether it executes [`crate::FaultCommand`]s: only for fault injection.
    #[cfg(feature = "faults")]
    pub obeys: bool,
    /// The thread of the coordinator, as the kernel numbers it.
    pub thread: u32,
    /// The cores of that thread, one bit each, if it has none for itself, and a worker without work
    /// calls it to its own; 0: it does not.
    pub cores: u64,
    /// The location of its channels: text written and read by the transport.
    pub domain: String,
}

impl Launch {
    /// Encodes the word.
    #[must_use]
    pub fn to_word(&self) -> String {
        let Self { who, boot, batch, queue, copies, thread, cores, domain, .. } = self;
        let flags = u8::from(*copies) * COPIES;
        #[cfg(feature = "faults")]
        let flags = flags | (u8::from(self.obeys) * OBEYS);
        let Incarnation { worker, inc } = who;
        let boot = boot.0;
        format!("{worker}.{inc}:{boot:x}:{batch}:{queue}:{flags}:{thread}:{cores:x}:{domain}")
    }

    /// Decodes the word; `None` if it was not written by [`Launch::to_word`], or requires something
    /// that this build does not support: one without the feature `faults` never starts as a worker
    /// that obeys.
    #[must_use]
    pub fn from_word(word: &str) -> Option<Self> {
        let mut fields = word.splitn(8, ':');
        let (worker, inc) = fields.next()?.split_once('.')?;
        let who = Incarnation { worker: worker.parse().ok()?, inc: inc.parse().ok()? };
        let boot = Boot(u64::from_str_radix(fields.next()?, 16).ok()?);
        let (batch, queue) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
        let flags: u8 = fields.next()?.parse().ok()?;
        if flags & !KNOWN != 0 {
            return None;
        }
        Some(Self {
            who,
            boot,
            batch,
            queue,
            copies: flags & COPIES != 0,
            #[cfg(feature = "faults")]
            obeys: flags & OBEYS != 0,
            thread: fields.next()?.parse().ok()?,
            cores: u64::from_str_radix(fields.next()?, 16).ok()?,
            domain: fields.next()?.to_owned(),
        })
    }

    /// Capacity (words) of a message to the worker: every job may bring a task of its own, and
    /// sections are sent in large chunks.
    #[must_use]
    pub fn batch_words(&self) -> usize {
        let batch = crate::job::batch_words(self.batch as usize, self.batch as usize);
        if self.copies { batch.max(CHUNK_WORDS) } else { batch }
    }

    /// Maximum number of batches in a job channel: one per job in the worst case.
    #[must_use]
    pub fn batches(&self) -> usize {
        self.queue as usize
    }
}

/// Words of a chunk of sections: 64 KiB.
pub const CHUNK_WORDS: usize = 8192;

/// Words of a result message: 16 KiB, for about 3,900 hits; more go in further parts.
pub const RESULT_WORDS: usize = 2048;

/// Maximum number of results in a result channel: a worker's credits.
pub const RESULTS: usize = 32;

/// What the argument of a process begins with that cleans up after dead clients.
const CLEAN: &str = "clean:";

/// The argument of a process that cleans up in this place, in place of [`Launch::to_word`].
#[must_use]
pub fn clean_word(place: &str) -> String {
    format!("{CLEAN}{place}")
}

/// The place to clean up in, if this is such an argument.
#[must_use]
pub fn read_clean_word(word: &str) -> Option<&str> {
    word.strip_prefix(CLEAN)
}

#[cfg(test)]
mod tests {
    //! A word decodes to what was encoded.
    use super::*;

    #[test]
    fn the_word_comes_back() {
        let launch = Launch {
            who: Incarnation { worker: 3, inc: 17 },
            boot: Boot(0xfeed_beef_0123),
            batch: 16,
            queue: 64,
            copies: true,
            #[cfg(feature = "faults")]
            obeys: true,
            thread: 4_194_304,
            cores: 0x8000_0000_0000_0003,
            domain: "/dev/shm/trolley.demo:with:colons".to_owned(),
        };
        assert_eq!(Launch::from_word(&launch.to_word()), Some(launch));
        assert_eq!(Launch::from_word(""), None);
        assert_eq!(Launch::from_word("1:2:3:4:5:6:7:8"), None);
    }

    #[test]
    fn flags_that_this_build_cannot_follow_are_refused() {
        let read = |flags: u8| Launch::from_word(&format!("0.0:1:16:64:{flags}:1:0:x"));
        assert_eq!(read(1).map(|launch| launch.copies), Some(true));
        assert_eq!(read(2).is_some(), cfg!(feature = "faults"));
        assert_eq!(read(4), None);
    }
}
