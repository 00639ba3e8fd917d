//! `trolley policy check`: checks policies and curves, and prints what they say.

use crate::output::Output;
use crate::print;
use clap::Subcommand;
use report::text::wrap;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::policy::CheckedFile;
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley policy check config/policies/*.toml
  trolley policy check board.toml --curves my-curves.toml

Refused are: unknown keys (age, sex and condition of persons by name), curves without unit or
source, non-numbers, a severer injury likelier than a milder one, weights that are
negative or do not sum to 1, ties left open, and a policy whose outcome a kind of person lacks.";

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
    },
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Check { files, curves } = verb;
    let checked = trolley::policy::check(files, curves.as_deref())?;
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
            print::out(&format!("{}: {} \"{}\" is sound", one.file, one.kind, one.name))?;
            for says in &one.says {
                print::out(&wrap(&format!("  {says}")))?;
            }
        }
        for fault in checked.iter().filter_map(|one| one.fault.as_ref()) {
            print::err(&format!("error: {fault}"));
        }
    }
    let is_sound = checked.iter().all(|one| one.fault.is_none());
    Ok(if is_sound { ExitCode::SUCCESS } else { FailureKind::Input.into() })
}
