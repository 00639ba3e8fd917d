//! What every error says: what went wrong, where, how to mend it, and of which kind it is.
//!
//! ```text
//! a crate's own error --impl Diagnostic--> Failure --> a person: "place: what\n  help: remedy"
//!                                                  --> the shell: FailureKind::exit_code
//! ```
//!
//! A library crate keeps its own error type, which programs can match, and says here what a person
//! is told of it. [`Failure`] is the one type that holds any of them.

use core::error::Error;
use core::fmt;
use std::borrow::Cow;

/// What kind of failure it is, and so what a shell is told; after sysexits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FailureKind {
    /// A check that was asked for has failed.
    CheckFailed = 1,
    /// The answer is degraded: bounds, not figures.
    Degraded = 3,
    /// No answer can be given to this request.
    Refused = 4,
    /// A mesh, model, scenario, policy or curve file is at fault.
    Input = 65,
    /// Memory, shared memory, descriptors or workers ran out.
    Resources = 69,
    /// A mistake of ours.
    Internal = 70,
    /// The operating system refused.
    System = 71,
    /// Somebody else is in the way: try again.
    TryAgain = 75,
    /// Two versions of this program met.
    Skew = 76,
    /// Real time was required, and is not to be had.
    NoRealtime = 77,
    /// A setting is at fault.
    Configuration = 78,
    /// SIGINT or SIGTERM.
    Interrupted = 130,
}

impl FailureKind {
    /// The exit code of a program that ends with it.
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

/// An error that a person can do something about.
pub trait Diagnostic: Error {
    /// What kind of failure it is.
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

/// Any failure, for the person at the terminal and for the shell.
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
/// `Debug` says what `Display` says, so that `main` may return it.
#[derive(Clone, PartialEq, Eq)]
pub struct Failure {
    kind: FailureKind,
    what: String,
    remedy: Option<String>,
}

impl Failure {
    /// A failure without a place and a remedy.
    #[must_use]
    pub fn new(kind: FailureKind, what: impl Into<String>) -> Self {
        Self { kind, what: what.into(), remedy: None }
    }

    /// A file that a person gave is at fault.
    #[must_use]
    pub fn input(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Input, what)
    }

    /// A setting is at fault.
    #[must_use]
    pub fn setting(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Configuration, what)
    }

    /// A mistake of ours.
    #[must_use]
    pub fn internal(what: impl Into<String>) -> Self {
        Self::new(FailureKind::Internal, what)
    }

    /// The same, with what to do about it.
    #[must_use]
    pub fn with_remedy(self, remedy: impl Into<String>) -> Self {
        Self { remedy: Some(remedy.into()), ..self }
    }

    /// The same, found at this place: a file, a line of it, or the name of a part.
    #[must_use]
    pub fn at(self, place: impl fmt::Display) -> Self {
        Self { what: format!("{place}: {}", self.what), ..self }
    }

    /// The same, of another kind: whose fault it is may depend on who asked.
    #[must_use]
    pub fn of_kind(self, kind: FailureKind) -> Self {
        Self { kind, ..self }
    }

    /// What kind of failure it is.
    #[must_use]
    pub fn kind(&self) -> FailureKind {
        self.kind
    }

    /// Where and what, on one line.
    #[must_use]
    pub fn what(&self) -> &str {
        &self.what
    }

    /// What to do about it.
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

/// An error with all its causes on one line. What an error has said of its cause is not repeated.
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
