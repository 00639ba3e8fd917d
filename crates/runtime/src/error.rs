//! A failed system call, in words for the person at the terminal.

use diagnostic::{Diagnostic, FailureKind};
use std::io;

/// A call to the operating system failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot {step} '{what}'")]
pub struct OsError {
    step: &'static str,
    what: String,
    source: io::Error,
}

/// Short for this crate's results.
pub type Result<T> = core::result::Result<T, OsError>;

impl OsError {
    /// Names the step, the thing it was about, and what the system said.
    pub fn new(step: &'static str, what: impl Into<String>, source: impl Into<io::Error>) -> Self {
        Self { step, what: what.into(), source: source.into() }
    }

    /// What kind of failure the system reported.
    #[must_use]
    pub fn io_kind(&self) -> io::ErrorKind {
        self.source.kind()
    }

    /// The system's error number, if it gave one.
    #[must_use]
    pub fn errno(&self) -> Option<i32> {
        self.source.raw_os_error()
    }

    /// Turns any system error into one with a step and a name: for `map_err`.
    pub(crate) fn at<'a, E: Into<io::Error>>(
        step: &'static str,
        what: &'a str,
    ) -> impl FnOnce(E) -> Self + use<'a, E> {
        move |source| Self::new(step, what, source)
    }
}

impl Diagnostic for OsError {
    fn kind(&self) -> FailureKind {
        FailureKind::System
    }
}
