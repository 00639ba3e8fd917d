//! The outcomes that a policy states: scenarios in which its board said who must win.

use crate::references::beside;
use crate::{AnswerState, Engine, Failure, Limits, References, Scenario, SourceText};
use damage::policy::dossier::Regression;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Who wins in a scenario, and who comes last.
///
/// ```
/// let files = ["../../config/policies/acceptable-or-brake.toml"];
/// for regression in &trolley::policy::check(&files, None)?[0].regressions {
///     let winner = regression.expected.winner.as_deref().unwrap_or("nobody");
///     println!("{}: {winner} is to win", regression.scenario);
///     assert_eq!(regression.found.as_ref().map(|found| &found.winner),
///         Some(&regression.expected.winner));
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ScenarioOutcome {
    /// The candidate that wins; `None`: the policy lets none be chosen.
    pub winner: Option<String>,
    /// The candidate that comes last; `None`: it is not stated.
    pub worst: Option<String>,
}

/// An outcome that a policy states, and what was found.
///
/// ```
/// let files = ["../../config/policies/acceptable-or-brake.toml"];
/// for regression in &trolley::policy::check(&files, None)?[0].regressions {
///     println!("{}: {}", regression.scenario, regression.reason);
///     assert_eq!(regression.fault, None);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CheckedRegression {
    /// The scenario, as the policy names it.
    pub scenario: String,
    /// What the policy states.
    pub expected: ScenarioOutcome,
    /// Why that is right, as the policy says.
    pub reason: String,
    /// What was found; `None`: it could not be ranked.
    pub found: Option<ScenarioOutcome>,
    /// What is wrong; `None`: what was found is what the policy states.
    pub fault: Option<String>,
}

/// What outcomes are checked with.
pub(super) struct Regressions {
    curves: Option<SourceText>,
    references: References,
    engine: Option<Engine>,
}

impl Regressions {
    pub(super) fn new(curves: Option<SourceText>, references: References) -> Self {
        Self { curves, references, engine: None }
    }

    /// Ranks one scenario under the policy of a file, and compares.
    pub(super) fn check(
        &mut self,
        file: &Path,
        policy: &SourceText,
        regression: &Regression,
    ) -> Result<CheckedRegression, Failure> {
        let Regression { scenario, winner, worst, reason, line } = regression.clone();
        let place = format!("{}:{line}", file.display());
        let expected = ScenarioOutcome { winner, worst };
        let found = self.found(file, &place, policy, &scenario, &expected)?;
        let (found, fault) = match found {
            Ok(found) => {
                let fault = difference(&scenario, &expected, &found).map(|what| {
                    let remedy = "find out why with trolley rank --explain; if it is right now, \
                                  the board has to sign it as the outcome";
                    Failure::input(what).at(place).with_remedy(remedy)
                });
                (Some(found), fault)
            }
            Err(failure) => (None, Some(failure)),
        };
        let fault = fault.map(|fault| fault.to_string());
        Ok(CheckedRegression { scenario, expected, reason, found, fault })
    }

    /// What is found, or why nothing is.
    fn found(
        &mut self,
        file: &Path,
        place: &str,
        policy: &SourceText,
        written: &str,
        expected: &ScenarioOutcome,
    ) -> Result<Result<ScenarioOutcome, Failure>, Failure> {
        let scenario = match self.opened(file, place, policy, written) {
            Ok(scenario) => scenario,
            Err(failure) => return Ok(Err(failure)),
        };
        let names: Vec<&str> =
            scenario.parsed().candidates.iter().map(|candidate| &*candidate.name).collect();
        let named = [&expected.winner, &expected.worst].into_iter().flatten();
        if let Some(unknown) = named.into_iter().find(|name| !names.contains(&name.as_str())) {
            let fault = format!("{written} has no candidate \"{unknown}\"");
            let remedy = format!("name one of its candidates: {}", names.join("; "));
            return Ok(Err(Failure::input(fault).at(place).with_remedy(remedy)));
        }
        let engine = match &mut self.engine {
            Some(engine) => engine,
            none => none.insert(Engine::builder().in_process().build()?),
        };
        let ranking = match engine.rank(&scenario, &Limits::default()) {
            Ok(ranking) => ranking,
            Err(failure) => return Ok(Err(failure.at(format!("{place}: {written}")))),
        };
        let answer = ranking.answer;
        if !matches!(answer.state, AnswerState::Complete | AnswerState::Certified) {
            let fault = format!("the answer to {written} is {}", answer.state.name());
            let remedy = "give it more time: its outcome is not known";
            return Ok(Err(Failure::input(fault).at(place).with_remedy(remedy)));
        }
        Ok(Ok(ScenarioOutcome {
            winner: answer.best().map(|row| row.name.clone()),
            worst: answer.ranking.last().map(|row| row.name.clone()),
        }))
    }

    /// A scenario that a policy names, under that policy.
    fn opened(
        &self,
        file: &Path,
        place: &str,
        policy: &SourceText,
        written: &str,
    ) -> Result<Scenario, Failure> {
        let path = beside(file, written.as_ref());
        // The folder of the policy's folder, as a file in it would name it.
        let folder = absolute_folder(file);
        let inside = folder.file_name().map_or_else(PathBuf::new, PathBuf::from);
        self.references.check(&folder, place, &inside.join(written))?;
        let placed = |failure: Failure| {
            let remedy = failure.remedy().map(ToString::to_string);
            let told = failure.at(place);
            match remedy {
                Some(_) => told,
                None => told.with_remedy("write the path of a scenario relative to this file"),
            }
        };
        let scenario = Scenario::open_with(&path, self.references).map_err(placed)?;
        let scenario = match &self.curves {
            Some(curves) => scenario.with_curves(curves.clone())?,
            None => scenario,
        };
        Ok(scenario.with_policy(policy.clone())?.without_deadline())
    }
}

/// The folder of a file, without links and `..`.
fn absolute_folder(file: &Path) -> PathBuf {
    let folder = match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

/// How an outcome differs from the one expected, in a sentence.
fn difference(
    scenario: &str,
    expected: &ScenarioOutcome,
    found: &ScenarioOutcome,
) -> Option<String> {
    let says = |name: &Option<String>| match name {
        Some(name) => format!("\"{name}\""),
        None => "nobody".to_owned(),
    };
    let mut parts = Vec::new();
    if expected.winner != found.winner {
        let (expected, found) = (says(&expected.winner), says(&found.winner));
        parts.push(format!("expected {expected} to win, got {found}"));
    }
    if expected.worst.is_some() && expected.worst != found.worst {
        let (expected, found) = (says(&expected.worst), says(&found.worst));
        parts.push(format!("expected {expected} to come last, got {found}"));
    }
    (!parts.is_empty()).then(|| format!("the outcome of {scenario} changed: {}", parts.join("; ")))
}
