//! A doorbell between processes: an eventfd.

use crate::error::{OsError, Result};
use rustix::event::EventfdFlags;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// An eventfd. Rings add up until they are drained.
#[derive(Debug)]
pub struct EventFd(OwnedFd);

impl EventFd {
    /// A silent one.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn create() -> Result<Self> {
        let flags = EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK;
        rustix::event::eventfd(0, flags).map(Self).map_err(OsError::at("create", "eventfd"))
    }

    /// Takes over one that was inherited.
    #[must_use]
    pub fn from_fd(fd: OwnedFd) -> Self {
        Self(fd)
    }

    /// Rings; never blocks. If it was rung 2⁶⁴ − 2 times already, it is loud enough.
    pub fn notify(&self) {
        if let Err(error) = rustix::io::write(&self.0, &1_u64.to_ne_bytes())
            && error != rustix::io::Errno::AGAIN
        {
            tracing::debug!(%error, "cannot ring an eventfd");
        }
    }

    /// Takes all rings back; `false` if there were none. Never blocks.
    #[must_use = "says whether it was rung"]
    pub fn drain(&self) -> bool {
        drain(self.fd())
    }

    /// To be inherited.
    #[must_use]
    pub fn fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Reads the counter of a non-blocking eventfd or timerfd; `false` if it was zero.
pub(super) fn drain(fd: BorrowedFd<'_>) -> bool {
    rustix::io::read(fd, &mut [0; 8]).is_ok_and(|got| got == 8)
}
