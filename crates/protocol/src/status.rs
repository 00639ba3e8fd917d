//! The status page: data for liveness and flow control, in one memory page shared by all.
//!
//! Each worker has one line written only by itself, and one written only by the coordinator; each
//! has 128 bytes, so that two cores never contend for a line (adjacent-line prefetch included).
//! Everything is atomic: a read returns the old or the new value, never a mixture. All zeros is a
//! valid page.

use crate::WORKERS_MAX;
use crate::id::{Incarnation, JobId, RequestId};
use core::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// The whole page.
#[repr(C, align(128))]
#[derive(Debug, Default)]
pub struct StatusPage {
    /// Written by the worker with that number.
    pub workers: [WorkerLine; WORKERS_MAX],
    /// Written by the coordinator for the worker with that number.
    pub coordinator: [CoordinatorLine; WORKERS_MAX],
}

/// The line of a worker.
#[repr(C, align(128))]
#[derive(Debug, Default)]
pub struct WorkerLine {
    /// Advances at least every thousand tests while it works, and at every wake-up.
    pub beat: AtomicU64,
    /// The job it is working on, see [`started`]; 0: none.
    pub started: AtomicU64,
    /// Result messages sent by this incarnation: with `consumed`, its credits.
    pub sent: AtomicU64,
    /// Payload and header bytes of these.
    pub bytes: AtomicU64,
    /// Box and triangle tests done.
    pub tests: AtomicU64,
    /// Jobs finished.
    pub jobs: AtomicU64,
    /// Number of the first batch that it may still be working on: all below it are processed or
    /// rejected, and everything to be sent for them was sent before this was written.
    pub answered: AtomicU64,
    /// When it last executed a fault command (ns, monotonic); 0: never. Reserved without the
    /// feature `faults`.
    pub obeyed_ns: AtomicU64,
    /// A [`WorkerState`].
    pub state: AtomicU32,
    /// 1 while it sleeps on [`CoordinatorLine::wake`].
    pub sleeping: AtomicU32,
    /// The CPU it last ran on, plus one; 0: not reported.
    pub cpu: AtomicU32,
    /// Its incarnation.
    pub inc: AtomicU32,
}

/// The coordinator's line for one worker.
#[repr(C, align(128))]
#[derive(Debug, Default)]
pub struct CoordinatorLine {
    /// Result messages received from this incarnation.
    pub consumed: AtomicU64,
    /// The last request whose jobs are obsolete.
    pub cancelled: AtomicU64,
    /// Futex word: changes when there may be something to do.
    pub wake: AtomicU32,
    /// 1: finish the current job, then exit.
    pub stop: AtomicU32,
    /// 1 while the coordinator sleeps, so that a worker must signal its eventfd.
    pub sleeping: AtomicU32,
    /// The current fault command; 0: none. Reserved without the feature `faults`.
    pub fault_command: AtomicU64,
}

const _: () = {
    assert!(size_of::<WorkerLine>() == 128 && size_of::<CoordinatorLine>() == 128);
    assert!(size_of::<StatusPage>() == 256 * WORKERS_MAX);
};

/// The progress of a worker: it only ever increases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum WorkerState {
    /// Nothing was received yet.
    Silent = 0,
    /// Its channels are open and its hello is sent.
    Hello = 1,
    /// It accepts jobs.
    Ready = 2,
    /// It has said goodbye.
    Bye = 3,
}

impl WorkerState {
    /// The state with this number.
    #[must_use]
    pub fn from_number(number: u32) -> Option<Self> {
        [Self::Silent, Self::Hello, Self::Ready, Self::Bye]
            .into_iter()
            .find(|state| *state as u32 == number)
    }
}

/// Packs the current job into one word, so that reads are never torn: a flag, the low 15 bits of
/// the incarnation, the low 8 of the request, the attempt, the job.
#[must_use]
pub fn started(from: Incarnation, request: RequestId, job: JobId, attempt: u8) -> u64 {
    let whose = u64::from(from.inc & 0x7fff) << 8 | (request.0 & 0xff);
    1 << 63 | whose << 40 | u64::from(attempt) << 32 | u64::from(job.0)
}

/// The job and attempt of this request that a worker of this incarnation has started; `None` if
/// there is none: job numbers are reused across requests.
#[must_use]
pub fn read_started(word: u64, from: Incarnation, request: RequestId) -> Option<(JobId, u8)> {
    let (job, attempt) = (JobId((word & 0xffff_ffff) as u32), (word >> 32 & 0xff) as u8);
    (word == started(from, request, job, attempt)).then_some((job, attempt))
}

#[cfg(feature = "faults")]
impl StatusPage {
    /// Flips one bit of the two lines of a worker: bit `bit / 16` of word `bit % 16`, modulo their
    /// numbers. The words of fault commands stay.
    pub fn flip(&self, worker: usize, bit: u64) {
        let (Some(theirs), Some(ours)) = (self.workers.get(worker), self.coordinator.get(worker))
        else {
            return;
        };
        let WorkerLine { beat, started, sent, bytes, tests, jobs, answered, .. } = theirs;
        let long =
            [beat, started, sent, bytes, tests, jobs, answered, &ours.consumed, &ours.cancelled];
        let WorkerLine { state, sleeping, cpu, inc, .. } = theirs;
        let short = [state, sleeping, cpu, inc, &ours.wake, &ours.stop, &ours.sleeping];
        let (word, bit) = ((bit % 16) as usize, bit / 16);
        match long.get(word) {
            Some(word) => _ = word.fetch_xor(1 << (bit % 64), Ordering::SeqCst),
            None => _ = short[word - long.len()].fetch_xor(1 << (bit % 32), Ordering::SeqCst),
        }
    }
}

impl WorkerLine {
    /// The state, if it is one.
    #[must_use]
    pub fn state(&self) -> Option<WorkerState> {
        WorkerState::from_number(self.state.load(Ordering::Acquire))
    }

    /// Whether it has opened its channels.
    #[must_use]
    pub fn has_opened(&self) -> bool {
        self.state().is_some_and(|state| state != WorkerState::Silent)
    }

    /// Clears the line for the next incarnation. Only while no process writes it.
    pub fn reset(&self) {
        let Self { beat, started, sent, bytes, tests, jobs, answered, obeyed_ns, .. } = self;
        for word in [beat, started, sent, bytes, tests, jobs, answered, obeyed_ns] {
            word.store(0, Ordering::Release);
        }
        for word in [&self.state, &self.sleeping, &self.cpu, &self.inc] {
            word.store(0, Ordering::Release);
        }
    }
}

impl CoordinatorLine {
    /// Clears the line for the next incarnation. Only while no worker reads it.
    pub fn reset(&self) {
        for word in [&self.consumed, &self.fault_command] {
            word.store(0, Ordering::Release);
        }
        for word in [&self.wake, &self.stop, &self.sleeping] {
            word.store(0, Ordering::Release);
        }
    }
}

#[cfg(test)]
mod tests;
