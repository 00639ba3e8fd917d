//! Checks of policies and sets of curves: whether they are accepted, and what they say.
//!
//! ```
//! for file in trolley::policy::check(&["../../config/policies/weighted.toml"], None)? {
//!     println!("{}: {}", file.name, file.says.join("; "));
//!     assert!(file.fault.is_none());
//! }
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::Failure;
use crate::files::{self, InputKind};
use damage::curve::Level;
use damage::injury::Victim;
use damage::{Curves, Policy};
use serde::Serialize;
use std::path::Path;

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
}

/// Checks policies and sets of curves; the tables in a file tell which of the two it is. The
/// outcome of a policy must be in `curves`; `None` means the built-in curves.
///
/// ```
/// let files = ["../../config/policies/default.toml", "../../config/curves/default.toml"];
/// let checked = trolley::policy::check(&files, None)?;
/// assert!(checked.iter().all(|file| file.fault.is_none()));
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
    let curves = match curves {
        None => Curves::shipped(),
        Some(path) => {
            Curves::parse(&path.display().to_string(), &files::text(path, InputKind::Curves)?)
        }
    };
    let curves = curves?;
    Ok(files.iter().map(|file| check_one(file.as_ref(), &curves)).collect())
}

fn check_one(path: &Path, curves: &Curves) -> CheckedFile {
    let file = path.display().to_string();
    let text = match files::text(path, InputKind::Policy) {
        Ok(text) => text,
        Err(failure) => {
            let (kind, name, says) = ("file", String::new(), Vec::new());
            return CheckedFile { file, kind, name, says, fault: Some(failure.to_string()) };
        }
    };
    let is_curves = text.lines().any(|line| line.trim_start().starts_with("[[curve]]"));
    let (kind, read) = if is_curves {
        ("curve set", Curves::parse(&file, &text).map(|set| (set.name.clone(), of_curves(&set))))
    } else {
        ("policy", Policy::parse(&file, &text).map(|p| (p.name.clone(), of_policy(&p, curves))))
    };
    let uncovered = (!is_curves).then(|| {
        let policy = Policy::parse(&file, &text).ok()?;
        let missing = curves.covers(policy.outcome).err()?;
        Some(format!("{file}: outcome {}: {missing}", policy.outcome.name()))
    });
    match (read, uncovered.flatten()) {
        (Ok((name, says)), fault) => CheckedFile { file, kind, name, says, fault },
        (Err(fault), _) => {
            let (name, says) = (String::new(), Vec::new());
            CheckedFile { file, kind, name, says, fault: Some(Failure::from(fault).to_string()) }
        }
    }
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
