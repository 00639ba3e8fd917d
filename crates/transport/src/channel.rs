//! The two ends of a channel: words behind a header, from one process to one other.

use crate::UseError;
use core::marker::PhantomData;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{ZeroCopySend, ipc};
use iceoryx2::sample_mut::SampleMut;
use protocol::{Boot, Head, Incarnation, Kind, Reject, seal, verify};

/// A header as iceoryx2 carries it.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wire(pub(crate) Head);

impl Default for Wire {
    fn default() -> Self {
        Self(bytemuck::Zeroable::zeroed())
    }
}

// SAFETY: `Head` is plain old data in C layout, without padding or pointers, pinned by assertions in
// its crate; the name carries the layout's version, and the build attribute guards the rest.
unsafe impl ZeroCopySend for Wire {
    unsafe fn type_name() -> &'static str {
        "trolley.Head.v1"
    }
}

/// The sending end.
#[derive(Debug)]
pub struct Sender {
    port: Publisher<ipc::Service, [u64], Wire>,
    words: usize,
}

/// A message in shared memory, open for writing. Dropped, it goes back unsent.
#[must_use = "a dropped message goes back unsent"]
#[derive(Debug)]
pub struct OpenMessage<'s> {
    sample: SampleMut<ipc::Service, [u64], Wire>,
    // A sender dropped earlier would make `send` fail at run time.
    sender: PhantomData<&'s Sender>,
}

impl Sender {
    pub(crate) fn new(port: Publisher<ipc::Service, [u64], Wire>, words: usize) -> Self {
        Self { port, words }
    }

    /// Opens a message of the channel's full size. One heap allocation, made by iceoryx2.
    ///
    /// # Errors
    ///
    /// If another message is open, or the channel is gone.
    pub fn loan(&self) -> Result<OpenMessage<'_>, UseError> {
        let sample = self.port.loan_slice_uninit(self.words).map_err(|error| {
            tracing::debug!(?error, "no message to loan");
            UseError::Broken
        })?;
        // SAFETY: the memory was zeroed by the kernel and only ever holds words and headers, of
        // which every bit pattern is a value.
        let sample = unsafe { sample.assume_init() };
        Ok(OpenMessage { sample, sender: PhantomData })
    }

    /// Sends words that are already laid out.
    ///
    /// # Errors
    ///
    /// As [`Sender::loan`] and [`OpenMessage::send`]; [`UseError::Broken`] if they do not fit.
    pub fn send(&self, head: Head, words: &[u64]) -> Result<(), UseError> {
        let mut message = self.loan()?;
        message.words().get_mut(..words.len()).ok_or(UseError::Broken)?.copy_from_slice(words);
        message.send(head, words.len())
    }
}

impl OpenMessage<'_> {
    /// The payload: all the words there are, holding whatever was there before.
    #[must_use]
    pub fn words(&mut self) -> &mut [u64] {
        self.sample.payload_mut()
    }

    /// Seals the first `used` words behind `head` and hands them over.
    ///
    /// # Errors
    ///
    /// [`UseError::Full`] if nobody took it: the message is spent, so what it carried must be made
    /// again.
    pub fn send(mut self, head: Head, used: usize) -> Result<(), UseError> {
        let head = seal(head, self.sample.payload().get(..used).ok_or(UseError::Broken)?);
        *self.sample.user_header_mut() = Wire(head);
        match self.sample.send() {
            Ok(1) => Ok(()),
            Ok(_) => Err(UseError::Full),
            Err(error) => {
                tracing::debug!(?error, "message not sent");
                Err(UseError::Broken)
            }
        }
    }
}

/// The receiving end.
#[derive(Debug)]
pub struct Receiver {
    port: Subscriber<ipc::Service, [u64], Wire>,
    boot: Boot,
    peer: Incarnation,
}

/// A message that arrived: its header and what it is. The payload lies in the scratch memory.
pub type Arrived = Result<(Head, Kind), Reject>;

impl Receiver {
    pub(crate) fn new(
        port: Subscriber<ipc::Service, [u64], Wire>,
        boot: Boot,
        peer: Incarnation,
    ) -> Self {
        Self { port, boot, peer }
    }

    /// Takes the next message, if there is one, copying its payload into `scratch`.
    ///
    /// Each word is read from shared memory once, then checked on the copy: the sender may still
    /// write, but not to what was checked. The shared slot is free again on return.
    ///
    /// # Errors
    ///
    /// If the channel is gone. A message that was turned away is no error of the channel.
    pub fn take(&self, scratch: &mut Vec<u64>) -> Result<Option<Arrived>, UseError> {
        let sample = match self.port.receive() {
            Ok(Some(sample)) => sample,
            Ok(None) => return Ok(None),
            Err(error) => {
                tracing::debug!(?error, "nothing to receive from");
                return Err(UseError::Broken);
            }
        };
        let head = sample.user_header().0;
        let payload = sample.payload();
        let arrived = head.accept(self.boot, self.peer, payload.len()).and_then(|kind| {
            scratch.clear();
            scratch.extend_from_slice(&payload[..head.len as usize]);
            verify(&head, scratch).map(|()| (head, kind))
        });
        Ok(Some(arrived))
    }
}
