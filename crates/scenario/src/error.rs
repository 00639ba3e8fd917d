//! What is wrong with a scenario, where, and what to do about it.
//!
//! [`Misfit`] knows the fault and the remedy, [`ScenarioError`] also the place. Both are written
//! for a person at a terminal; nothing here knows colours, prefixes or exit codes.

use crate::document::Place;

/// A scenario that cannot be used: file, place, fault and remedy, in that order.
///
/// ```
/// let error = scenario::ScenarioError::new(
///     "left-turn.toml",
///     scenario::Place { line: 14, column: 9 },
///     "party \"suvv\" is not defined",
///     "parties defined here: ego, suv.  Did you mean \"suv\"?",
/// );
/// assert_eq!(
///     error.to_string(),
///     "left-turn.toml:14:9: party \"suvv\" is not defined\n  \
///      help: parties defined here: ego, suv.  Did you mean \"suv\"?"
/// );
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{place}: {fault}\n  help: {help}")]
pub struct ScenarioError {
    /// The file as it was named by whoever opened it.
    pub file: String,
    /// Where in it.
    pub place: Place,
    /// What is wrong, on one line.
    pub fault: String,
    /// What to do about it, on one line.
    pub help: String,
}

impl ScenarioError {
    /// An error found later, by somebody who opened what the scenario names.
    #[must_use]
    pub fn new(
        file: impl Into<String>,
        place: Place,
        fault: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { file: file.into(), place, fault: fault.into(), help: help.into() }
    }
}

/// A value that breaks a rule, wherever it was written: fault and remedy without a place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{fault}\n  help: {help}")]
pub struct Misfit {
    /// Which setting, by its name in a scenario.
    pub setting: &'static str,
    /// What is wrong, on one line.
    pub fault: String,
    /// What to do about it, on one line.
    pub help: String,
}

impl Misfit {
    pub(crate) fn new(
        setting: &'static str,
        fault: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self { setting, fault: fault.into(), help: help.into() }
    }
}
