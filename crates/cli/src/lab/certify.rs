//! `trolley certify`: what bounds, deadlines and budgets are worth, measured on requests of chance.
//!
//! Each verb prints a table for people, or a document; a violation ends the command with exit
//! code 1.

use super::shown::show;
use crate::output::Output;
use ::lab::certify::{
    BUDGET, BoundFlaw, BoundsOptions, BudgetOptions, DeadlineOptions, ShareOptions, bounds, budget,
    deadline, share,
};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley certify share --requests 24
  trolley certify bounds --stops 100000
  trolley certify bounds --stops 1000 --flaw forgets-open-poses
  trolley certify deadline --body sedan:1000000 --body sedan:1000000 --body pole:2000
  trolley certify budget --body sedan.trolley --body suv.trolley";

/// What is measured.
#[derive(Clone, Debug, clap::Subcommand)]
pub(crate) enum Verb {
    /// After which share of the work the winner is certain, by strategy and depth.
    Share(ShareArgs),
    /// Whether every interval holds the final value, wherever the work is stopped.
    Bounds(BoundsArgs),
    /// How late answers are, over many requests.
    Deadline(DeadlineArgs),
    /// Whether jobs keep their budget, in tests and in CPU time.
    Budget(BudgetArgs),
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ShareArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Requests, of 6 to 16 candidates each.
    #[arg(long, value_name = "N", default_value_t = 24)]
    requests: u32,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only requests whose every candidate touches: no way past is left.
    #[arg(long)]
    unavoidable: bool,
    /// Distribution depths.
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "3,5,8")]
    depth: Vec<u32>,
    /// Write the table to this file besides.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BoundsArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Stops, at each of which all intervals are held against the finished run.
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    stops: u64,
    /// Stops per request.
    #[arg(long, value_name = "N", default_value_t = 50)]
    per_request: u64,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Distribution depth.
    #[arg(long, value_name = "D", default_value_t = 4)]
    depth: u32,
    /// Make the bounds wrong on purpose: then violations must be found.
    #[arg(long, value_name = "HOW")]
    flaw: Option<FlawName>,
}

/// [`BoundFlaw`] by name.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FlawName {
    /// Poses that are not done are taken to add nothing.
    ForgetsOpenPoses,
    /// The upper end is taken to be half way up.
    HalvesWidths,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct DeadlineArgs {
    /// Bodies, as files or shape:triangles; the first is the ego. A second body like the first is
    /// put right into it [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Requests.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    requests: u32,
    /// Each is due so many milliseconds after it was accepted.
    #[arg(long, value_name = "MS", default_value_t = 20.0)]
    deadline_ms: f64,
    /// Which requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Worker processes.
    #[arg(long, value_name = "N", default_value_t = 4)]
    workers: u8,
    /// Threads that do nothing but take time from everybody.
    #[arg(long, value_name = "N", default_value_t = 0)]
    load: usize,
    /// Most tests of a job.
    #[arg(long, value_name = "TESTS", default_value_t = BUDGET)]
    budget: u64,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BudgetArgs {
    /// Bodies, as files or shape:triangles; the first is the ego [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Most tests of a job.
    #[arg(long, value_name = "TESTS", default_value_t = BUDGET)]
    budget: u64,
    /// Jobs.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    jobs: u64,
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let progress = output.progress(match verb {
        Verb::Share(_) | Verb::Deadline(_) => "requests",
        Verb::Bounds(_) => "stops",
        Verb::Budget(_) => "jobs",
    });
    let told = |done, total| progress.set(done, total);
    match verb.clone() {
        Verb::Share(ShareArgs { body: bodies, requests, seed, unavoidable, depth, out }) => {
            let depths = depth;
            let options = ShareOptions { bodies, requests, seed, unavoidable, depths, out };
            let report = share(&options, &told)?;
            show(&report, || report.text(), output)
        }
        Verb::Bounds(args) => {
            let options = BoundsOptions {
                bodies: args.body,
                stops: args.stops,
                per_request: args.per_request,
                seed: args.seed,
                depth: args.depth,
                flaw: args.flaw.map(|flaw| match flaw {
                    FlawName::ForgetsOpenPoses => BoundFlaw::ForgetsOpenPoses,
                    FlawName::HalvesWidths => BoundFlaw::HalvesWidths,
                }),
            };
            let report = bounds(&options, &told)?;
            let shown = show(&report, || report.text(), output)?;
            Ok(if report.is_right() { shown } else { FailureKind::CheckFailed.into() })
        }
        Verb::Deadline(args) => {
            let options = DeadlineOptions {
                bodies: args.body,
                requests: args.requests,
                deadline_ms: args.deadline_ms,
                seed: args.seed,
                workers: args.workers,
                load: args.load,
                budget: args.budget,
            };
            let report = deadline(&options, &told)?;
            show(&report, || report.text(), output)
        }
        Verb::Budget(BudgetArgs { body: bodies, budget: most, jobs }) => {
            let report = budget(&BudgetOptions { bodies, budget: most, jobs }, &told)?;
            show(&report, || report.text(), output)
        }
    }
}
