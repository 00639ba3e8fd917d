//! The sending end of a channel: a message is written where the receiver will read it.

use crate::error::UseError;
use crate::ipc::Ipc;
use crate::wire::{Output, Wire};
use crate::{OpenError, Traffic};
use core::cell::Cell;
use core::fmt;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{LoanError, SendError};
use iceoryx2::sample_mut::SampleMut;
use protocol::{Head, seal};

/// Sends messages to one receiver.
pub struct Sender {
    port: Output,
    words: usize,
    messages: Cell<u64>,
    bytes: Cell<u64>,
    lines: Cell<u64>,
}

impl Sender {
    pub(crate) fn new(port: Output, words: usize) -> Self {
        let (messages, bytes, lines) = (Cell::new(0), Cell::new(0), Cell::new(0));
        Self { port, words, messages, bytes, lines }
    }

    pub(crate) fn connect(&self, channel: &str) -> Result<(), OpenError> {
        self.port.update_connections().map_err(OpenError::at("connect", channel))
    }

    /// Opens a message. Only one can be open at a time.
    ///
    /// # Errors
    ///
    /// [`UseError::Full`] if one is open already or no chunk is free, [`UseError::Broken`] if the
    /// channel's memory is not what it should be.
    pub fn loan(&self) -> Result<OpenMessage<'_>, UseError> {
        let sample = self.port.loan_slice_uninit(self.words).map_err(|error| match error {
            LoanError::ExceedsMaxLoans | LoanError::OutOfMemory => UseError::Full,
            LoanError::ExceedsMaxLoanSize => UseError::TooLong,
            LoanError::InternalFailure => UseError::Broken,
        })?;
        // SAFETY: the chunk lies in a mapping that the kernel zeroed and that only ever held words,
        // so every word is initialised, and every bit pattern is a `u64`.
        let sample = unsafe { sample.assume_init() };
        Ok(OpenMessage { sample, sender: self })
    }

    /// Maximum number of words of a message.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.words
    }

    /// Messages sent so far.
    #[must_use]
    pub fn traffic(&self) -> Traffic {
        let (messages, bytes) = (self.messages.get(), self.bytes.get());
        Traffic { messages, bytes, lines: self.lines.get() }
    }
}

impl fmt::Debug for Sender {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Sender")
            .field("words", &self.words)
            .field("traffic", &self.traffic())
            .finish_non_exhaustive()
    }
}

/// A message that is being written. If it is dropped unsent, the receiver never sees it.
///
/// It borrows its sender, so that the sender cannot be dropped first.
#[must_use = "a message that is not sent is dropped"]
pub struct OpenMessage<'s> {
    sample: SampleMut<Ipc, [u64], Wire>,
    sender: &'s Sender,
}

impl OpenMessage<'_> {
    /// The whole payload buffer. It holds leftovers of an earlier message.
    pub fn words(&mut self) -> &mut [u64] {
        self.sample.payload_mut()
    }

    /// Sends the first `used` words after `head`, whose length, sequence number and checksum are
    /// written here.
    ///
    /// # Errors
    ///
    /// In each case nothing is sent, and what was written is lost: the work has to be done again.
    /// [`UseError::Full`]: the queue is full (credits prevent that) or no receiver is connected.
    /// [`UseError::TooLong`]: `used` exceeds the buffer. [`UseError::Broken`]: the channel is gone.
    pub fn send(self, head: Head, used: usize) -> Result<(), UseError> {
        self.send_changed(head, used, |_, _| {})
    }

    /// [`OpenMessage::send`], except that `corrupt` may change header and payload after they are
    /// sealed: for fault injection.
    ///
    /// # Errors
    ///
    /// As [`OpenMessage::send`].
    #[cfg(feature = "faults")]
    pub fn send_corrupted(
        self,
        head: Head,
        used: usize,
        corrupt: impl FnOnce(&mut Head, &mut [u64]),
    ) -> Result<(), UseError> {
        self.send_changed(head, used, corrupt)
    }

    /// Seals a message, applies `corrupt`, and sends it.
    fn send_changed(
        mut self,
        head: Head,
        used: usize,
        change: impl FnOnce(&mut Head, &mut [u64]),
    ) -> Result<(), UseError> {
        let sent = self.sender.messages.get();
        let payload = self.sample.payload_mut().get_mut(..used).ok_or(UseError::TooLong)?;
        // Counts modulo 2³²: a gap shows, whatever the number is.
        let mut head = seal(Head { seq: (sent & 0xffff_ffff) as u32, ..head }, payload);
        change(&mut head, payload);
        let lines = crate::lines(payload.as_ptr() as usize, size_of_val(payload))
            + crate::lines(&raw const *self.sample.user_header() as usize, size_of::<Head>());
        *self.sample.user_header_mut() = Wire::new(head);
        match self.sample.send() {
            Ok(1) => {}
            Ok(_) | Err(SendError::UnableToDeliver) => return Err(UseError::Full),
            Err(_) => return Err(UseError::Broken),
        }
        let bytes = size_of::<Head>() + size_of::<u64>() * used;
        self.sender.messages.set(sent + 1);
        self.sender.lines.set(self.sender.lines.get() + lines);
        self.sender.bytes.set(self.sender.bytes.get() + bytes as u64);
        Ok(())
    }
}

impl fmt::Debug for OpenMessage<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OpenMessage").field("sender", self.sender).finish_non_exhaustive()
    }
}
