//! `trolley inject`: requests to real workers while faults are injected, and a ledger of what came
//! of each.
//!
//! ```text
//! plan ──▶ faults in a seeded order ──▶ a request with some of them ──▶ answer: same as without?
//!          signals, orders, messages       crew of real processes  ──▶ seen when? whole when?
//!          whole runs of their own         children of this program ──▶ right, refused, left
//! behind?
//! ```
//!
//! The reference is the answer of this process without workers. A complete answer must be the same
//! bytes; the intervals of a degraded one must hold its; everything else is an error that was told.

mod child;
mod kind;
mod live;
mod plan;
mod report;
mod signals;

use crate::args::Output;
use crate::bodies;
use crate::inputs::{self, Inputs, Read};
use crate::print;
use crate::progress::Progress;
use crate::terms::TermsArgs;
use coordinator::{Request, Work, run_in_process};
use diagnostic::Failure;
use kind::Kind;
use plan::Plan;
use report::Report;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley inject config/faults/quick.toml
  trolley inject config/faults/campaign.toml --seed 7 --json --junit faults.xml

Exit codes: 0 survived; 1 a wrong answer, a hang, a false kill, or something left behind;
65 the plan cannot be read.";

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct InjectArgs {
    /// Plan, TOML: which faults, how often, against which scenario.
    plan: PathBuf,
    /// Order and places of the faults; equal seeds give equal plans, not equal times.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Write the ledger as JUnit too: a test case for each kind of fault.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

pub(crate) fn run(args: &InjectArgs, output: &Output) -> Result<ExitCode, Failure> {
    let plan = Plan::read(&args.plan)?;
    let scenario_text = inputs::text(&plan.scenario)?;
    let inputs = Inputs::of(&plan.scenario, &scenario_text)?;
    let Read { scenario, policy, curves } = inputs.read()?;
    let folder = plan.scenario.parent().unwrap_or(Path::new(""));
    let beside = |_: usize, reference: &scenario::FileRef| folder.join(&reference.path);
    let engine = scenario
        .engine
        .apply(&scenario::Overrides::default())
        .map_err(|misfit| Failure::from(misfit).of_kind(diagnostic::Kind::Configuration))?;
    let bodies = bodies::load(&scenario, &engine, &inputs.scenario.name, &beside, output)?;
    let files: Vec<&[u8]> = bodies.iter().map(|body| body.bytes.bytes()).collect();
    let store = coordinator::seal(&files)?;
    drop(bodies);
    let views =
        body::store::open(store.bytes()).map_err(|error| Failure::internal(error.to_string()))?;
    let request = Request::new(&scenario, &views, policy, curves)?;
    let mut alone = Work::new(&request, &views, plan.depth);
    let _jobs = run_in_process(&mut alone, &views);
    let reference = alone.answer()?;

    let asked = TermsArgs { deadline_ms: plan.deadline_ms.map(f64::from), ..Default::default() };
    let terms = asked.terms(None, false)?;
    let work = || Work::new(&request, &views, plan.depth).with_terms(terms);

    let begun_ns = runtime::clock::now_ns();
    let mut report = Report::new(args.seed);
    report.deadline_ms = plan.deadline_ms;
    let (runs, live): (Vec<_>, Vec<_>) =
        plan.shuffled(args.seed).into_iter().partition(|kind| kind.is_whole_run());
    let progress = Progress::new("faults", (runs.len() + live.len()) as u64, output);
    if !live.is_empty() {
        let stage = live::Stage { plan: &plan, store: &store, reference: &reference };
        live::run(&stage, &work, &live, args.seed, &mut report, &progress)?;
    }
    for (number, kind) in runs.iter().enumerate() {
        if report.is_interrupted {
            break;
        }
        let known = (&reference, &store);
        child::run(&plan, *kind, args.seed, number as u64, known, &mut report)?;
        progress.add(1);
    }
    report.left_behind += child::left_behind(&plan)?;
    drop(progress);
    report.seconds = (runtime::clock::now_ns() - begun_ns) as f64 / 1e9;
    report.replay = format!("trolley inject {} --seed {}", args.plan.display(), args.seed);
    let document = report.document();
    if let Some(path) = &args.junit {
        crate::transfer::write(path, report::junit(&document).as_bytes())?;
    }
    if output.json {
        print::out(&print::json(&document)?)?;
    } else {
        print::out(&report::page(&document))?;
    }
    if report.is_interrupted {
        return Ok(diagnostic::Kind::Interrupted.into());
    }
    Ok(ExitCode::from(u8::from(!document.is_survived)))
}

/// Names of kinds, for messages.
fn kinds() -> String {
    let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
    names.join(", ")
}
