//! `trolley policy check`: would these policies and curves be accepted, and what do they say?

use crate::output::Output;
use crate::{inputs, print};
use clap::Subcommand;
use damage::curve::Level;
use damage::injury::Victim;
use damage::{Curves, Policy};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use trolley::{Failure, Kind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley policy check config/policies/*.toml
  trolley policy check board.toml --curves my-curves.toml

Refused are: unknown keys (age, sex and condition of persons by name), curves without unit or
source, numbers that are none, a severer injury likelier than a milder one, weights that are
negative or do not sum to 1, ties left open, and a policy whose outcome a kind of person lacks.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Check policies and sets of curves, and say in words what they hold.
    #[command(after_help = EXAMPLES)]
    Check {
        /// Policies and sets of curves, TOML; which of the two a file is, its tables say.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// Curves that the policies must find their outcome in [default: the program's].
        #[arg(long, value_name = "FILE")]
        curves: Option<PathBuf>,
    },
}

/// One file, checked.
#[derive(Serialize)]
struct Checked {
    file: String,
    kind: &'static str,
    name: String,
    /// What it says, in sentences.
    says: Vec<String>,
    /// `None`: sound.
    fault: Option<String>,
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Check { files, curves } = verb;
    let curves = match curves {
        None => Curves::shipped(),
        Some(path) => Curves::parse(&path.display().to_string(), &trolley::read_text(path)?),
    };
    let curves = curves?;
    let checked: Vec<Checked> = files.iter().map(|file| check(file, &curves)).collect();
    if output.json {
        #[derive(Serialize)]
        struct Document<'a> {
            schema: &'static str,
            files: &'a [Checked],
        }
        let document = Document { schema: "trolley.policy-check/1", files: &checked };
        print::out(&print::json(&document)?)?;
    } else {
        for one in checked.iter().filter(|one| one.fault.is_none()) {
            print::out(&format!("{}: {} \"{}\" is sound", one.file, one.kind, one.name))?;
            for says in &one.says {
                print::out(&crate::table::wrap(&format!("  {says}")))?;
            }
        }
        for fault in checked.iter().filter_map(|one| one.fault.as_ref()) {
            print::err(&format!("error: {fault}"));
        }
    }
    let is_sound = checked.iter().all(|one| one.fault.is_none());
    Ok(if is_sound { ExitCode::SUCCESS } else { Kind::Input.into() })
}

fn check(path: &Path, curves: &Curves) -> Checked {
    let file = path.display().to_string();
    let text = match trolley::read_text(path) {
        Ok(text) => text,
        Err(failure) => {
            let (kind, name, says) = ("file", String::new(), Vec::new());
            return Checked { file, kind, name, says, fault: Some(failure.to_string()) };
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
        (Ok((name, says)), fault) => Checked { file, kind, name, says, fault },
        (Err(fault), _) => {
            let (name, says) = (String::new(), Vec::new());
            Checked { file, kind, name, says, fault: Some(Failure::from(fault).to_string()) }
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
