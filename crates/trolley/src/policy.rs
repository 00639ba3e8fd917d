//! Checks of policies and sets of curves: whether they are accepted, and what they say; whether a
//! policy is still valid, and whether the outcomes that its board signed are still its outcomes.
//!
//! ```
//! for file in trolley::policy::check(&["../../config/policies/weighted.toml"], None)? {
//!     println!("{}: {}", file.name, file.says.join("; "));
//!     assert!(file.fault.is_none());
//! }
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::texts;
use crate::{Failure, References, SourceText};
use damage::curve::Level;
use damage::injury::Victim;
use damage::policy::dossier::Dossier;
use damage::{Curves, Policy};
use runtime::clock;
use serde::Serialize;
use std::path::Path;

pub mod map;
mod regression;

pub use regression::{CheckedRegression, ScenarioOutcome};

/// A day of the calendar, as a policy states it.
///
/// ```
/// use trolley::policy::Day;
///
/// assert_eq!(Day::parse("2028-02-29").map(|day| day.to_string()), Some("2028-02-29".into()));
/// assert_eq!(Day::parse("2027-02-29"), None);
/// ```
pub use damage::policy::dossier::Day;

/// What a check of one file found.
///
/// ```
/// let files = ["../../config/policies/default.toml", "../../config/curves/default.toml"];
/// let checked = trolley::policy::check(&files, None)?;
/// let kinds: Vec<_> = checked.iter().map(|file| file.kind).collect();
/// assert_eq!(kinds, ["policy", "curve set"]);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CheckedFile {
    /// The file.
    pub file: String,
    /// What it is: "policy", "curve set", or "file" if it could not be read.
    pub kind: &'static str,
    /// The name that it states; empty if it is not valid.
    pub name: String,
    /// What it says, in sentences.
    pub says: Vec<String>,
    /// What is wrong with it; `None` if it is valid.
    pub fault: Option<String>,
    /// The outcomes that a policy states, and what was found.
    pub regressions: Vec<CheckedRegression>,
}

impl CheckedFile {
    /// Returns whether the file is valid, and all outcomes are as it states.
    ///
    /// ```
    /// let file = "../../config/policies/default.toml";
    /// assert!(trolley::policy::check(&[file], None)?[0].is_sound());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.fault.is_none() && self.regressions.iter().all(|one| one.fault.is_none())
    }
}

/// Length of a day (ns).
const DAY_NS: u64 = 86_400 * 1_000_000_000;

/// With what policies are checked.
///
/// ```
/// use trolley::policy::{CheckOptions, Day, check_with};
///
/// let files = ["../../config/policies/acceptable-or-brake.toml"];
/// let today = Day::parse("2999-01-01");
/// let checked = check_with(&files, &CheckOptions { today, ..CheckOptions::default() })?;
/// assert!(checked[0].fault.as_ref().is_some_and(|fault| fault.contains("valid until")));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct CheckOptions<'a> {
    /// Curves in which policies must find their outcome, and with which their outcomes are
    /// checked; `None`: the built-in ones, and for an outcome those that its scenario names.
    pub curves: Option<&'a Path>,
    /// The day on which a policy must be valid; `None`: [`today`].
    pub today: Option<Day>,
    /// Which scenarios a policy may name: those in folders beside its own, unless it may name all.
    pub references: References,
}

/// Returns the day, as the clock of this machine has it (UTC).
///
/// ```
/// use trolley::policy::{Day, today};
///
/// assert!(Day::parse("2020-01-01").is_some_and(|past| past < today()));
/// ```
#[must_use]
pub fn today() -> Day {
    Day::of_unix_days(clock::time_of_day_ns() / DAY_NS).unwrap_or(Day::LAST)
}

/// Says that a policy is not valid any more on that day, if that is so. It still ranks: a clock is
/// no part of an answer.
///
/// ```
/// use trolley::policy::{Day, expiry};
///
/// let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// let day = Day::parse("2999-01-01").ok_or(trolley::Failure::internal("no day"))?;
/// assert_eq!(expiry(&scenario.criteria().policy, day), None, "its policy states no last day");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[must_use]
pub fn expiry(policy: &Policy, day: Day) -> Option<String> {
    let (last, _) = policy.dossier.as_ref()?.expired(day)?;
    Some(format!(
        "policy \"{}\" was valid until {last}: its board has to sign it again",
        policy.name
    ))
}

/// Checks policies and sets of curves; the tables in a file tell which of the two it is. The
/// outcome of a policy must be in `curves`; `None` means the built-in curves. A policy must be
/// valid today, and the outcomes that it states are looked at: see [`check_with`].
///
/// ```
/// let files = ["../../config/policies/default.toml", "../../config/curves/default.toml"];
/// let checked = trolley::policy::check(&files, None)?;
/// assert!(checked.iter().all(|file| file.is_sound()));
///
/// let missing = trolley::policy::check(&["no-such-file.toml"], None)?;
/// assert!(missing[0].fault.is_some());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If `curves` cannot be read or is not valid. A fault in one of `files` is not an error, but
/// [`CheckedFile::fault`].
pub fn check<P: AsRef<Path>>(
    files: &[P],
    curves: Option<&Path>,
) -> Result<Vec<CheckedFile>, Failure> {
    check_with(files, &CheckOptions { curves, ..CheckOptions::default() })
}

/// As [`check`]. The scenarios of the outcomes that a policy states are ranked in this process,
/// as [`Engine::rank`](crate::Engine::rank) does.
///
/// ```
/// use trolley::policy::{CheckOptions, check_with};
///
/// let files = ["../../config/policies/acceptable-or-brake.toml"];
/// let checked = check_with(&files, &CheckOptions::default())?;
/// assert!(checked[0].is_sound() && !checked[0].regressions.is_empty(), "{checked:#?}");
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// As [`check`], or if no engine can be built.
pub fn check_with<P: AsRef<Path>>(
    files: &[P],
    options: &CheckOptions<'_>,
) -> Result<Vec<CheckedFile>, Failure> {
    let given = options.curves.map(|path| texts::CURVES.named_by_user(path)).transpose()?;
    let curves = match &given {
        None => Curves::shipped(),
        Some(given) => Curves::parse(&given.name, &given.text),
    };
    let curves = curves?;
    let mut regressions = regression::Regressions::new(given, options.references);
    let mut check_one = |file: &P| {
        let (mut checked, policy) = check_file(file.as_ref(), &curves);
        let Some((policy, dossier)) = policy.filter(|_| checked.fault.is_none()) else {
            return Ok(checked);
        };
        if let Some((last, line)) = dossier.expired(options.today.unwrap_or_else(today)) {
            let fault = format!("it was valid until {last}, and that day is over");
            let remedy = "let its board look at it again, sign it, and set valid_until";
            let place = format!("{}:{line}", checked.file);
            checked.fault = Some(Failure::input(fault).at(place).with_remedy(remedy).to_string());
            return Ok(checked);
        }
        for regression in &dossier.regressions {
            checked.regressions.push(regressions.check(file.as_ref(), &policy, regression)?);
        }
        Ok(checked)
    };
    files.iter().map(&mut check_one).collect()
}

/// A file without its outcomes; of a policy with a dossier, its text and dossier.
fn check_file(path: &Path, curves: &Curves) -> (CheckedFile, Option<(SourceText, Dossier)>) {
    let file = path.display().to_string();
    let file_of = |kind: &'static str, read: Result<(String, Vec<String>), Failure>| {
        let (file, regressions) = (file.clone(), Vec::new());
        match read {
            Ok((name, says)) => CheckedFile { file, kind, name, says, fault: None, regressions },
            Err(failure) => {
                let (name, says, fault) = (String::new(), Vec::new(), Some(failure.to_string()));
                CheckedFile { file, kind, name, says, fault, regressions }
            }
        }
    };
    // Policies and curves are no longer than each other.
    let text = match texts::POLICY.named_by_user(path) {
        Ok(SourceText { text, .. }) => text,
        Err(failure) => return (file_of("file", Err(failure)), None),
    };
    if text.lines().any(|line| line.trim_start().starts_with("[[curve]]")) {
        let read = Curves::parse(&file, &text).map(|set| (set.name.clone(), of_curves(&set)));
        return (file_of("curve set", read.map_err(Failure::from)), None);
    }
    let policy = match Policy::parse(&file, &text) {
        Ok(policy) => policy,
        Err(fault) => return (file_of("policy", Err(fault.into())), None),
    };
    let checked = file_of("policy", Ok((policy.name.clone(), of_policy(&policy, curves))));
    let uncovered = curves.covers(policy.outcome).err();
    let fault =
        uncovered.map(|missing| format!("{file}: outcome {}: {missing}", policy.outcome.name()));
    let dossier = policy.dossier.as_deref().cloned();
    let source = SourceText { name: file.clone(), text };
    (CheckedFile { fault, ..checked }, dossier.map(|dossier| (source, dossier)))
}

fn of_policy(policy: &Policy, curves: &Curves) -> Vec<String> {
    // The worst-off of three stand for all: leximin goes through everybody.
    let steps: Vec<String> = policy.steps(3).iter().map(ToString::to_string).collect();
    let mut says = vec![
        format!("board: {}", policy.board),
        format!("outcome: {}, with curves \"{}\"", policy.outcome.name(), curves.name),
        format!("compares in turn (as for three persons): {}", steps.join("; then ")),
    ];
    if policy.is_ego_only() {
        says.push("looks at the ego vehicle's occupants alone in some rule: answers say so".into());
    }
    if !policy.preferred.is_empty() {
        let names: Vec<String> =
            policy.preferred.iter().map(|named| format!("\"{}\"", named.name)).collect();
        says.push(format!("among equals prefers, in turn: {}", names.join(", ")));
    }
    says.extend(of_dossier(policy.dossier.as_deref()));
    says
}

/// What a policy says of who answers for it.
fn of_dossier(dossier: Option<&Dossier>) -> Vec<String> {
    let unsigned = || "unsigned: nobody answers for it by name".to_owned();
    let Some(dossier) = dossier else { return vec![unsigned()] };
    let signed =
        dossier.signed.iter().map(|by| format!("{}, {}, on {}", by.name, by.role, by.date));
    let signed: Vec<String> = signed.collect();
    let mut says = match signed.as_slice() {
        [] => vec![unsigned()],
        signed => vec![format!("signed by {}", signed.join("; "))],
    };
    says.extend(dossier.valid_until.map(|(last, _)| format!("valid until {last}")));
    let dissent =
        dossier.dissent.iter().map(|one| format!("dissent of {}: {}", one.name, one.text));
    says.extend(dissent);
    if !dossier.evidence.is_empty() {
        says.push(format!("rests on: {}", dossier.evidence.join("; ")));
    }
    says
}

fn of_curves(set: &Curves) -> Vec<String> {
    let mut says = Vec::new();
    for level in Level::ALL {
        let has = |victim: &Victim| set.rung(*victim, level).is_ok();
        let (with, without): (Vec<Victim>, Vec<Victim>) =
            Victim::ALL.into_iter().partition(|victim| has(victim));
        let names = |victims: &[Victim]| {
            victims.iter().map(|victim| victim.name()).collect::<Vec<_>>().join(", ")
        };
        match (with.is_empty(), without.is_empty()) {
            (true, _) => says.push(format!("{}: nobody", level.name())),
            (false, true) => says.push(format!("{}: everybody", level.name())),
            (false, false) => says.push(format!(
                "{}: {}; not {}, so a policy with this outcome is refused",
                level.name(),
                names(&with),
                names(&without)
            )),
        }
    }
    let doubts = set.curves.iter().filter(|curve| !curve.note.is_empty());
    says.extend(doubts.map(|curve| format!("{}: {}", curve.id, curve.note)));
    says
}
