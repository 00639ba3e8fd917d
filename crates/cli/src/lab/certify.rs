//! `trolley certify`: checks bounds, deadlines, budgets and members on random requests.
//!
//! Each verb prints a table, or a JSON document; after a violation the exit code is 1.

use super::shown::show;
use crate::named::named;
use crate::output::Output;
use ::lab::certify::{
    BUDGET, BoundsOptions, BudgetOptions, CourseFlaw, DeadlineOptions, MembersOptions,
    ShareOptions, bounds, budget, deadline, members, share,
};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, FailureKind, Until};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley certify share --requests 24
  trolley certify bounds --stops 140000
  trolley certify bounds --stops 1000 --flaw forgets-open
  trolley certify deadline --body sedan:1000000 --body sedan:1000000 --body pole:2000
  trolley certify deadline --members 32 --candidates 16 --others 12 --deadline-ms 100
  trolley certify budget --body sedan:20000 --body suv:20000
  trolley certify members --scenes 12 config/scenarios/crossing.toml";

/// What to measure.
#[derive(Clone, Debug, clap::Subcommand)]
pub(crate) enum Verb {
    /// Measure after what share of the work the winner, or the order, is certain.
    Share(ShareArgs),
    /// Stop random scenes anywhere, and hold what is said against the finished run.
    Bounds(BoundsArgs),
    /// Measure how late answers are, over many requests.
    Deadline(DeadlineArgs),
    /// Check that jobs keep their budget, in tests and in CPU time.
    Budget(BudgetArgs),
    /// Compare orders by few members with those by many.
    Members(MembersArgs),
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct MembersArgs {
    /// Recordings and scenarios, each a family of its own beside the generated ones.
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Number of scenes of each generated family.
    #[arg(long, value_name = "N", default_value_t = 12)]
    scenes: u32,
    /// Seed of the generated scenes.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ShareArgs {
    /// Bodies, as model files or shape:triangles; the first is the ego [default: seven generated
    /// ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Number of scenes, of 6 to 16 candidates each.
    #[arg(long, value_name = "N", default_value_t = 24)]
    requests: u32,
    /// Seed of the random scenes.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Only scenes in which every candidate meets somebody.
    #[arg(long)]
    unavoidable: bool,
    /// Follow the candidates in N members at first, and in up to 128 where the best two are too
    /// close to call.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=128))]
    members: u32,
    /// Distribution depth.
    #[arg(long, value_name = "D", default_value_t = 5)]
    depth: u32,
    /// Also write the table to this file.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BoundsArgs {
    /// Number of stops; at each, all that is said is compared with the finished run.
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    stops: u64,
    /// Stops per scene.
    #[arg(long, value_name = "N", default_value_t = 25)]
    per_scene: u64,
    /// Seed of the random scenes.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Distribution depth.
    #[arg(long, value_name = "D", default_value_t = 4)]
    depth: u32,
    /// Make answers wrong on purpose, to see that violations are found.
    #[arg(long, value_name = "HOW", value_parser = named(CourseFlaw::ALL, CourseFlaw::name))]
    flaw: Option<CourseFlaw>,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct DeadlineArgs {
    /// Bodies, as model files or shape:triangles; the first is the ego. A second body like the
    /// first is placed inside it [default: seven generated ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Number of requests.
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    requests: u32,
    /// Deadline of each request, from its acceptance (ms).
    #[arg(long, value_name = "MS", default_value_t = 20.0)]
    deadline_ms: f64,
    /// Seed of the random requests.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Number of worker processes.
    #[arg(long, value_name = "N", default_value_t = 4)]
    workers: u8,
    /// Number of threads that only consume CPU time.
    #[arg(long, value_name = "N", default_value_t = 0)]
    load: usize,
    /// Maximum number of tests per job.
    #[arg(long, value_name = "TESTS", default_value_t = BUDGET)]
    budget: u64,
    /// When to stop: see `trolley rank --help`.
    #[arg(long, value_name = "WHEN", default_value = "complete",
          value_parser = named(Until::ALL, Until::name))]
    until: Until,
    /// Follow the candidates in N members at first, and in up to 128 where the best two are too
    /// close to call.
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=128))]
    members: u32,
    /// Number of candidates of each request, 1 to 16 [default: 6 to 16].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=16))]
    candidates: Option<u8>,
    /// Number of parties besides the ego, 1 to 32 [default: up to twice as many as bodies].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=32))]
    others: Option<u8>,
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct BudgetArgs {
    /// Bodies, as model files or shape:triangles; the first is the ego [default: seven generated
    /// ones].
    #[arg(long, value_name = "BODY")]
    body: Vec<String>,
    /// Maximum number of tests per job.
    #[arg(long, value_name = "TESTS", default_value_t = BUDGET)]
    budget: u64,
    /// Number of jobs.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    jobs: u64,
}

pub(crate) fn run(verb: &Verb, output: &Output) -> Result<ExitCode, Failure> {
    let progress = output.progress(match verb {
        Verb::Share(_) | Verb::Deadline(_) => "requests",
        Verb::Bounds(_) => "stops",
        Verb::Budget(_) => "jobs",
        Verb::Members(_) => "scenes",
    });
    let told = |done, total| progress.set(done, total);
    match verb.clone() {
        Verb::Share(args) => {
            let ShareArgs { body: bodies, requests, seed, unavoidable, members, depth, out } = args;
            let options = ShareOptions { bodies, requests, seed, unavoidable, members, depth, out };
            let report = share(&options, &told)?;
            show(&report, || report.text(), output)
        }
        Verb::Bounds(args) => {
            let BoundsArgs { stops, per_scene, seed, depth, flaw } = args;
            let report = bounds(&BoundsOptions { stops, per_scene, seed, depth, flaw }, &told)?;
            let shown = show(&report, || report.text(), output)?;
            Ok(if report.is_right() { shown } else { FailureKind::CheckFailed.into() })
        }
        Verb::Members(MembersArgs { files, scenes, seed }) => {
            let report = members(&MembersOptions { files, scenes, seed }, &told)?;
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
                until: args.until,
                members: args.members,
                candidates: args.candidates.map(usize::from),
                others: args.others.map(usize::from),
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
