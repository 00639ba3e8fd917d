//! The receiving end of a channel: one copy into private memory, checked there.
//!
//! The sender's process can still write to what it sent. So each word is read once, and what was
//! checked is what is used.

use crate::error::UseError;
use crate::wire::Input;
use crate::{OpenError, Traffic};
use core::cell::Cell;
use core::fmt;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::update_connections::UpdateConnections;
use protocol::head::MAGIC;
use protocol::{Boot, Head, Incarnation, Reject, verify};

/// Receives messages from one sender.
pub struct Receiver {
    port: Input,
    boot: Boot,
    peer: Incarnation,
    messages: Cell<u64>,
    bytes: Cell<u64>,
    lines: Cell<u64>,
}

impl Receiver {
    pub(crate) fn new(port: Input, boot: Boot, peer: Incarnation) -> Self {
        let (messages, bytes, lines) = (Cell::new(0), Cell::new(0), Cell::new(0));
        Self { port, boot, peer, messages, bytes, lines }
    }

    pub(crate) fn connect(&self, channel: &str) -> Result<(), OpenError> {
        self.port.update_connections().map_err(OpenError::at("connect", channel))
    }

    /// Takes the oldest message, if there is one. Does not wait.
    ///
    /// Its payload replaces the contents of `scratch`, which grows only if it never held as much
    /// before. A rejected message is gone, and leaves `scratch` empty: that is the inner error. A
    /// checksum mismatch is reported before anything else in the header, because then the header
    /// cannot be trusted.
    ///
    /// # Errors
    ///
    /// [`UseError::Broken`] if the channel's memory is corrupt.
    pub fn take(&self, scratch: &mut Vec<u64>) -> Result<Option<Result<Head, Reject>>, UseError> {
        scratch.clear();
        let sample = match self.port.receive() {
            Ok(None) => return Ok(None),
            Ok(Some(sample)) => sample,
            Err(ReceiveError::ExceedsMaxBorrows) => return Err(UseError::Full),
            Err(ReceiveError::ConnectionFailure(_)) => return Err(UseError::Broken),
        };
        let head = sample.user_header().read();
        let room = sample.payload().len();
        let mut lines = crate::lines(&raw const *sample.user_header() as usize, size_of::<Head>());
        if let Some(payload) = sample.payload().get(..head.len as usize) {
            lines += crate::lines(payload.as_ptr() as usize, size_of_val(payload));
            scratch.extend_from_slice(payload);
        }
        drop(sample);
        let bytes = size_of::<Head>() + size_of_val(scratch.as_slice());
        self.messages.set(self.messages.get() + 1);
        self.lines.set(self.lines.get() + lines);
        self.bytes.set(self.bytes.get() + bytes as u64);

        let checked = self.check(&head, scratch, room);
        if checked.is_err() {
            scratch.clear();
        }
        Ok(Some(checked.map(|()| head)))
    }

    fn check(&self, head: &Head, payload: &[u64], room: usize) -> Result<(), Reject> {
        // Another program's checksum may cover other bytes, so that comes first.
        if head.magic != MAGIC || head.layout != protocol::LAYOUT {
            return Err(Reject::Foreign);
        }
        verify(head, payload)?;
        head.accept(self.boot, self.peer, room).map(|_kind| ())
    }

    /// Messages taken so far.
    #[must_use]
    pub fn traffic(&self) -> Traffic {
        let (messages, bytes) = (self.messages.get(), self.bytes.get());
        Traffic { messages, bytes, lines: self.lines.get() }
    }
}

impl fmt::Debug for Receiver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Receiver")
            .field("peer", &self.peer)
            .field("traffic", &self.traffic())
            .finish_non_exhaustive()
    }
}
