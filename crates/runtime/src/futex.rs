//! Sleeping until a word in shared memory changes.
//!
//! The futexes are shared ones (no `FUTEX_PRIVATE_FLAG`): waiter and waker may be different
//! processes with different mappings of the same page.

use crate::clock::timespec;
use core::sync::atomic::AtomicU32;
use rustix::io::Errno;
use rustix::thread::futex::{self, Flags};

/// Why a wait ended. In every case the caller must check its words again: none is a guarantee.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waited {
    /// Woken, or interrupted by a signal.
    Woken,
    /// The word was not what was expected: there was nothing to wait for.
    Changed,
    /// Time was up.
    TimedOut,
}

/// Sleeps while `word` holds `expected`, until woken, at most `timeout_ns`; `None`: forever.
///
/// Between the comparison and the sleep no wake-up can be lost: the kernel compares.
#[must_use]
pub fn wait(word: &AtomicU32, expected: u32, timeout_ns: Option<u64>) -> Waited {
    let timeout = timeout_ns.map(timespec);
    match futex::wait(word, Flags::empty(), expected, timeout.as_ref()) {
        Err(Errno::AGAIN) => Waited::Changed,
        Err(Errno::TIMEDOUT) => Waited::TimedOut,
        // Anything else is a reason to check again, which costs the caller one iteration.
        Ok(()) | Err(_) => Waited::Woken,
    }
}

/// Wakes all threads that sleep on `word`; returns how many. Change the word first.
pub fn wake(word: &AtomicU32) -> usize {
    futex::wake(word, Flags::empty(), i32::MAX.unsigned_abs()).unwrap_or(0)
}

#[cfg(test)]
mod tests;
