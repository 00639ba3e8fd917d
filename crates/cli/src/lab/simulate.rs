//! `trolley simulate faults`: seeded worlds in which everything goes wrong, in virtual time.

use super::shown::show;
use crate::output::Output;
use crate::print;
use ::lab::simulate::{FaultOptions, SimulatedFault, faults};
use std::process::ExitCode;
use trolley::{Failure, FailureKind};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley simulate faults                          2,000 worlds of 4 requests each
  trolley simulate faults --worlds 250000          a million requests
  trolley simulate faults --seed 173 -v            one world, with all that happens in it
  trolley simulate faults --only crash,lose-result

Exit codes: 0 all laws hold, 1 one was broken: the seed is printed, with the smallest world found.";

#[derive(Clone, Debug, clap::Subcommand)]
pub(crate) enum Verb {
    /// The dispatcher among workers that crash, hang and lie, on channels that lose and garble.
    #[command(after_help = EXAMPLES)]
    Faults(FaultArgs),
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct FaultArgs {
    /// This world alone.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// How many worlds.
    #[arg(long, value_name = "N", default_value_t = 2_000)]
    worlds: u64,
    /// The first one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    from: u64,
    /// Requests in each.
    #[arg(long, value_name = "N", default_value_t = 4)]
    requests: u64,
    /// Threads [default: one for each core].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// These kinds of faults alone.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = kind)]
    only: Vec<SimulatedFault>,
    /// Not these.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = kind)]
    without: Vec<SimulatedFault>,
    /// So many faults in a world at most: the first ones.
    #[arg(long, value_name = "N")]
    most: Option<u64>,
}

fn kind(name: &str) -> Result<SimulatedFault, String> {
    SimulatedFault::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = SimulatedFault::ALL.iter().map(|fault| fault.name()).collect();
        format!("there are: {}", names.join(", "))
    })
}

pub(crate) fn run(verb: &Verb, verbose: u8, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Faults(args) = verb.clone();
    let progress = output.progress("worlds");
    let told = |done, total| progress.set(done, total);
    let options = FaultOptions {
        seed: args.seed,
        worlds: args.worlds,
        from: args.from,
        requests: args.requests,
        threads: args.threads,
        only: args.only,
        without: args.without,
        most: args.most,
        log: verbose > 0,
    };
    let simulated = faults(&options, &told);
    drop(progress);
    simulated.log().iter().for_each(|line| print::err(line));
    let shown = show(&simulated, || simulated.text(), output)?;
    Ok(if simulated.is_right() { shown } else { FailureKind::CheckFailed.into() })
}
