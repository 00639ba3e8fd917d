//! `trolley policy check`: checks policies and curves, and prints what they say.

use crate::output::Output;
use crate::print;
use crate::reference_args::ReferenceArgs;
use clap::Subcommand;
use report::text::wrap;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::policy::{CheckOptions, CheckedFile, CheckedRegression, Day};
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley policy check config/policies/*.toml
  trolley policy check board.toml --curves my-curves.toml
  trolley policy check board.toml --today 2027-01-01

Refused are: unknown keys (age, sex and condition of persons by name), curves without unit or
source, non-numbers, a severer injury likelier than a milder one, weights that are
negative or do not sum to 1, ties left open, and a policy whose outcome a kind of person lacks.

A policy may say in [dossier] who signed it and until when it is valid, and in [[regression]] who
must win in which scenario. Refused are a policy whose last day is over, and one that lets another
candidate win than it says. Without a dossier it is valid, and said to be unsigned.

Exit codes: 0 all is sound, 65 something is refused.";

#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Check policies and sets of curves, and describe them in words.
    #[command(after_help = EXAMPLES)]
    Check {
        /// Policies and sets of curves, TOML; the tables of a file tell which it is.
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// Curves in which the policies must find their outcome [default: the built-in ones].
        #[arg(long, value_name = "FILE")]
        curves: Option<PathBuf>,
        /// The day on which policies must be valid, YYYY-MM-DD [default: today, UTC].
        #[arg(long, value_name = "DAY", value_parser = day)]
        today: Option<Day>,
        #[command(flatten)]
        references: ReferenceArgs,
    },
}

fn day(text: &str) -> Result<Day, String> {
    Day::parse(text).ok_or_else(|| "write a day of the calendar as YYYY-MM-DD".to_owned())
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Check { files, curves, today, references } = verb;
    let options = CheckOptions {
        curves: curves.as_deref(),
        today: *today,
        references: references.references(),
    };
    let checked = trolley::policy::check_with(files, &options)?;
    if output.json {
        #[derive(Serialize)]
        struct Document<'a> {
            schema: &'static str,
            files: &'a [CheckedFile],
        }
        let document = Document { schema: "trolley.policy-check/1", files: &checked };
        print::out(&print::json(&document)?)?;
    } else {
        for one in checked.iter().filter(|one| one.fault.is_none()) {
            let (file, kind, name) = (&one.file, one.kind, &one.name);
            let verdict = if one.is_sound() { "is sound" } else { "is refused" };
            print::out(&format!("{file}: {kind} \"{name}\" {verdict}"))?;
            for says in &one.says {
                print::out(&wrap(&format!("  {says}")))?;
            }
            let kept = one.regressions.iter().filter(|regression| regression.fault.is_none());
            for regression in kept {
                print::out(&wrap(&format!("  {}", as_stated(regression))))?;
            }
        }
        for one in &checked {
            let broken = one.regressions.iter().filter_map(|regression| regression.fault.as_ref());
            for fault in one.fault.iter().chain(broken) {
                print::err(&format!("error: {fault}"));
            }
        }
    }
    let is_sound = checked.iter().all(CheckedFile::is_sound);
    Ok(if is_sound { ExitCode::SUCCESS } else { FailureKind::Input.into() })
}

/// "../scenarios/small.toml: "wall" wins and "pedestrian" comes last, as stated: nobody on foot".
fn as_stated(regression: &CheckedRegression) -> String {
    let CheckedRegression { scenario, expected, reason, .. } = regression;
    let winner = match &expected.winner {
        Some(winner) => format!("\"{winner}\" wins"),
        None => "nobody wins".to_owned(),
    };
    let worst = expected.worst.as_ref().map(|worst| format!(" and \"{worst}\" comes last"));
    format!("{scenario}: {winner}{}, as stated: {reason}", worst.unwrap_or_default())
}
