//! `trolley certify`: what bounds, deadlines and budgets are worth, measured on requests of chance.
//!
//! Each verb prints a table for people; what must hold is checked on the way, and a violation ends
//! the command with exit code 1.

use crate::args::Output;
use crate::{print, transfer};
use diagnostic::Failure;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

mod bounds;
mod budget;
mod deadline;
mod requests;
mod share;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley certify share --requests 24
  trolley certify bounds --stops 100000
  trolley certify bounds --stops 1000 --flaw forgets-open-poses
  trolley certify deadline --body sedan:1000000 --body sedan:1000000 --body pole:2000
  trolley certify budget --body sedan.trolley --body suv.trolley";

/// What is measured.
#[derive(Debug, clap::Subcommand)]
pub(crate) enum Verb {
    /// After which share of the work the winner is certain, by strategy and depth.
    Share {
        #[command(flatten)]
        args: share::ShareArgs,
        /// Write the table to this file besides.
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
    /// Whether every interval holds the final value, wherever the work is stopped.
    Bounds(bounds::BoundsArgs),
    /// How late answers are, over many requests.
    Deadline(deadline::DeadlineArgs),
    /// Whether jobs keep their budget, in tests and in CPU time.
    Budget(budget::BudgetArgs),
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    match verb {
        Verb::Share { args, out } => {
            out.as_deref().map(transfer::ready).transpose()?;
            let text = share::table(args, output)?;
            if let Some(path) = out {
                transfer::write(path, text.as_bytes())?;
            }
            print::out(&text)
        }
        Verb::Bounds(args) => {
            let (text, is_right) = bounds::run(args, output)?;
            print::out(&text)?;
            Ok(if is_right { ExitCode::SUCCESS } else { ExitCode::FAILURE })
        }
        Verb::Deadline(args) => print::out(&deadline::run(args, output)?),
        Verb::Budget(args) => print::out(&budget::run(args, output)?),
    }
}

/// What must never be.
fn wrong(what: String) -> Failure {
    Failure::internal(what)
}

/// Names of bodies without their folders.
fn names(all: &[String]) -> String {
    let name = |text: &String| {
        let file = Path::new(text).file_stem().unwrap_or_default();
        file.to_string_lossy().into_owned()
    };
    all.iter().map(name).collect::<Vec<_>>().join(", ")
}

/// The middle of some figures; not a number if there are none.
fn median(figures: &mut [f64]) -> f64 {
    percentile(figures, 0.5)
}

/// The figure below which such a share of all lies.
fn percentile(figures: &mut [f64], share: f64) -> f64 {
    figures.sort_by(f64::total_cmp);
    let at = ((figures.len() as f64 * share) as usize).min(figures.len().saturating_sub(1));
    figures.get(at).copied().unwrap_or(f64::NAN)
}
