//! What is wrong with a scenario, where, and what to do about it.
//!
//! [`Misfit`] knows the fault and the remedy, [`ScenarioError`] also the place. Both are written
//! for a person at a terminal; nothing here knows colours or prefixes.

use crate::document::TextPosition;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// A scenario that cannot be used: file, place and fault, in that order; the remedy beside.
///
/// ```
/// let error = trolley_scenario::ScenarioError::new(
///     "left-turn.toml",
///     trolley_scenario::TextPosition { line: 14, column: 9 },
///     "party \"suvv\" is not defined",
///     "parties defined here: ego, suv.  Did you mean \"suv\"?",
/// );
/// assert_eq!(
///     diagnostic::Failure::from(error).to_string(),
///     "left-turn.toml:14:9: party \"suvv\" is not defined\n  \
///      help: parties defined here: ego, suv.  Did you mean \"suv\"?"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{place}: {what}")]
pub struct ScenarioError {
    /// The file, as named by the caller.
    pub file: String,
    /// Where in it.
    pub place: TextPosition,
    /// What is wrong, on one line.
    pub what: String,
    /// What to do about it, on one line.
    pub remedy: String,
}

impl ScenarioError {
    /// An error found later, when a file that the scenario names is opened.
    #[must_use]
    pub fn new(
        file: impl Into<String>,
        place: TextPosition,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { file: file.into(), place, what: what.into(), remedy: remedy.into() }
    }
}

/// A value that breaks a rule, wherever it was written: fault and remedy without a place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}")]
pub struct Misfit {
    /// Which setting, by its name in a scenario.
    pub setting: &'static str,
    /// What is wrong, on one line.
    pub what: String,
    /// What to do about it, on one line.
    pub remedy: String,
}

impl Misfit {
    pub(crate) fn new(
        setting: &'static str,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self { setting, what: what.into(), remedy: remedy.into() }
    }
}

impl Diagnostic for ScenarioError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn place(&self) -> Option<String> {
        Some(format!("{}:{}", self.file, self.place))
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

impl Diagnostic for Misfit {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}
