//! `trolley inject`: injects faults into real workers during requests, and reports each outcome.

use super::shown::show;
use crate::output::Output;
use crate::reference_args::ReferenceArgs;
use ::lab::inject::{InjectOptions, inject};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley inject config/faults/quick.toml
  trolley inject config/faults/campaign.toml --seed 7 --json --junit faults.xml

Kinds of faults: config/faults/campaign.toml has every one. Those that this machine does not permit
(ptrace, mount namespaces) are reported as not injected.

Exit codes: 0 survived; 1 a wrong answer, a hang, a false kill, or something left behind;
65 the plan cannot be read.";

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct InjectArgs {
    /// Plan, TOML: which faults, how often, against which scenario.
    plan: PathBuf,
    #[command(flatten)]
    references: ReferenceArgs,
    /// Seed of the order and places of the faults; equal seeds give equal plans, not equal times.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Also write the report as JUnit XML, with a test case for each kind of fault.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
}

pub(crate) fn run(args: &InjectArgs, output: &Output) -> Result<ExitCode, Failure> {
    let InjectArgs { plan, references, seed, junit } = args.clone();
    let references = references.references();
    let program = std::env::current_exe()
        .map_err(|error| Failure::new(FailureKind::System, format!("this program: {error}")))?;
    output.say(
        "processes are made to fail: what they say then, as \"fatal runtime error: stack \
         overflow\", is theirs, and part of the plan",
    );
    let progress = output.progress("faults");
    let told = |done, total| progress.set(done, total);
    let injected = inject(&InjectOptions { plan, references, seed, junit, program }, &told)?;
    drop(progress);
    let shown = show(&injected, || injected.text(), output)?;
    Ok(match (injected.is_interrupted(), injected.is_survived()) {
        (true, _) => FailureKind::Interrupted.into(),
        (false, true) => shown,
        (false, false) => FailureKind::CheckFailed.into(),
    })
}
