//! The operating system: clocks, memory files, processes, cores, waiting.
//!
//! Linux only. One of the crates that may hold `unsafe`; each block does one thing and says why it
//! is sound. It knows no channel, no job and no triangle; of the messages it knows only the status
//! page, whose memory it maps.
//!
//! # Invariants
//!
//! - What is sealed cannot change for anybody, and what is mapped from it is read-only:
//!   `memory/tests.rs`.
//! - A child dies with the thread that started it, and a dropped [`process::Child`] is killed and
//!   reaped: `process/tests.rs`.
//! - All time is CLOCK_MONOTONIC; the wall clock is never read.
#![expect(unsafe_code, reason = "mapping memory, fork hooks and resource limits")]

pub mod affinity;
pub mod clock;
pub mod futex;
pub mod memory;
pub mod process;
pub mod wait;

/// Something asked of the operating system failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot {what}: {source}")]
pub struct OsError {
    what: String,
    source: std::io::Error,
}

impl OsError {
    /// "cannot `what`: `source`".
    #[must_use]
    pub fn new(what: impl Into<String>, source: impl Into<std::io::Error>) -> Self {
        Self { what: what.into(), source: source.into() }
    }
}

/// Names what was being done when it failed.
pub(crate) trait Doing<T> {
    fn doing(self, what: impl FnOnce() -> String) -> Result<T, OsError>;
}

impl<T, E: Into<std::io::Error>> Doing<T> for Result<T, E> {
    fn doing(self, what: impl FnOnce() -> String) -> Result<T, OsError> {
        self.map_err(|source| OsError::new(what(), source))
    }
}
