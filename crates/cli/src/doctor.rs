//! `trolley doctor`: what this machine lacks for the service, and the remedy; and what a deployment
//! takes of it.

use crate::output::Output;
use crate::print;
use crate::reference_args::ReferenceArgs;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::doctor::{DeploymentBounds, DoctorReport};
use trolley::{Failure, FailureKind, OpenDeployment};

/// What to check besides this machine.
#[derive(Clone, Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Compute what this deployment takes, and bound its times by what jobs cost here.
    #[arg(long, value_name = "FILE")]
    deployment: Option<PathBuf>,
    /// Jobs that are made to be dear, to measure what they cost: more find dearer ones.
    #[arg(long, value_name = "N", requires = "deployment", default_value_t = 20_000)]
    jobs: u64,
    /// As for a service without workers.
    #[arg(long, requires = "deployment")]
    in_process: bool,
    #[command(flatten)]
    references: ReferenceArgs,
}

pub(crate) fn run(args: &DoctorArgs, output: &Output) -> Result<ExitCode, Failure> {
    let find = |file: &PathBuf| {
        let opened = OpenDeployment::open_with(file, None, args.references.references())?;
        DeploymentBounds::find(&opened, args.jobs, args.in_process)
    };
    let report = DoctorReport::with(args.deployment.as_ref().map(find).transpose()?);
    if output.json {
        print::out(&print::json(&report)?)?;
    } else {
        print::lines(&report.to_string())?;
    }
    Ok(if report.has_problem() { FailureKind::CheckFailed.into() } else { ExitCode::SUCCESS })
}
