//! What every error reports: what went wrong, where, how to fix it, and its kind.
//!
//! ```text
//! a crate's own error --impl Diagnostic--> Failure --> a person: "place: what\n  help: remedy"
//!                                                  --> the shell: FailureKind::exit_code
//! ```
//!
//! A library crate keeps its own error type, which programs can match, and implements
//! [`Diagnostic`] to describe it to a person. [`Failure`] is the one type that holds any of them.

use core::error::Error;
use core::fmt;
use std::borrow::Cow;

/// The kind of a failure, which determines the exit code; after sysexits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FailureKind {
    /// A requested check has failed.
    CheckFailed = 1,
    /// The answer is degraded: bounds instead of exact figures.
    Degraded = 3,
    /// This request cannot be answered.
    Refused = 4,
    /// A mesh, model, scenario, policy or curve file is at fault.
    Input = 65,
    /// Memory, shared memory, descriptors or workers ran out.
    Resources = 69,
    /// An internal error (a bug).
    Internal = 70,
    /// An operating system call failed.
    System = 71,
    /// Another process is in the way: try again.
    TryAgain = 75,
    /// Two versions of this program are in use.
    Skew = 76,
    /// Real-time operation was required but is not available.
    NoRealtime = 77,
    /// A setting is at fault.
    Configuration = 78,
    /// SIGINT, SIGTERM, SIGQUIT or SIGHUP.
    Interrupted = 130,
}

impl FailureKind {
    /// The exit code of a program that ends with this kind of failure.
    #[must_use]
    pub const fn exit_code(self) -> u8 {
        self as u8
    }
}

impl From<FailureKind> for std::process::ExitCode {
    fn from(kind: FailureKind) -> Self {
        Self::from(kind.exit_code())
    }
}

/// An error with advice for the user.
pub trait Diagnostic: Error {
    /// The kind of failure.
    fn kind(&self) -> FailureKind;

    /// File, line and column, as far as they are known and not part of [`Self::what`].
    fn place(&self) -> Option<String> {
        None
    }

    /// What is wrong, on one line.
    fn what(&self) -> String
    where
        Self: Sized,
    {
        chain(self)
    }

    /// What to do about it, on one line.
    fn remedy(&self) -> Option<Cow<'_, str>> {
        None
    }
}

/// Any failure, for the user at the terminal and for the shell.
///
/// ```
/// use trolley_diagnostic::{Failure, FailureKind};
///
/// let failure = Failure::new(FailureKind::Input, "body \"suvv\" is not defined")
///     .at("left-turn.toml:14:9")
///     .with_remedy("bodies defined here: ego, suv");
/// assert_eq!(
///     failure.to_string(),
///     "left-turn.toml:14:9: body \"suvv\" is not defined\n  help: bodies defined here: ego, suv"
/// );
/// assert_eq!(failure.kind().exit_code(), 65);
/// ```
///
/// `Debug` prints what `Display` prints, so that `main` may return it.
#[derive(Clone, PartialEq, Eq)]
pub struct Failure {
    kind: FailureKind,
    what: String,
    remedy: Option<String>,
}

impl Failure {
    /// Creates a failure without a place and a remedy.
    #[must_use]
    pub fn new(kind: FailureKind, what: impl Into<String>) -> Self {
        Self { kind, what: what.into(), remedy: None }
    }

    /// Creates a failure of an input file.
    #[must_use]
    pub fn input(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Input, what)
    }

    /// Creates a failure of a setting.
    #[must_use]
    pub fn setting(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Configuration, what)
    }

    /// Creates a failure for an internal error.
    #[must_use]
    pub fn internal(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Internal, what)
    }

    /// Sets the remedy.
    #[must_use]
    pub fn with_remedy(self, remedy: impl Into<String>) -> Self {
        Self { remedy: Some(remedy.into()), ..self }
    }

    /// Sets the place: a file, a line of it, or the name of a part.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self { what: format!("{place}: {}", self.what), ..self }
    }

    /// Changes the kind, which may depend on the caller.
    #[must_use]
    pub fn of_kind(self, kind: FailureKind) -> Self {
        Self { kind, ..self }
    }

    /// The kind of failure.
    #[must_use]
    pub fn kind(&self) -> FailureKind {
        self.kind
    }

    /// Where and what, on one line.
    #[must_use]
    pub fn what(&self) -> &str {
        &self.what
    }

    /// The remedy.
    #[must_use]
    pub fn remedy(&self) -> Option<&str> {
        self.remedy.as_deref()
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.remedy {
            Some(remedy) => write!(f, "{}\n  help: {remedy}", self.what),
            None => f.write_str(&self.what),
        }
    }
}

impl fmt::Debug for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Error for Failure {}

impl<E: Diagnostic> From<E> for Failure {
    fn from(error: E) -> Self {
        let failure = Self {
            kind: error.kind(),
            what: error.what(),
            remedy: error.remedy().map(Cow::into_owned),
        };
        match error.place() {
            Some(place) => failure.at(place),
            None => failure,
        }
    }
}

/// Returns an error with all its causes on one line. A cause already included in an error's text is
/// not repeated.
#[must_use]
pub fn chain(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        let more = next.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = next.source();
    }
    text
}
