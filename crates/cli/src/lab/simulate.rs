//! `trolley simulate faults`: seeded simulations, in virtual time, of everything that can fail.

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
  trolley simulate faults --seed 173 -v            one world, with a log of its events
  trolley simulate faults --only crash,lose-result

Exit codes: 0 all invariants hold; 1 one is violated: its seed and the smallest failing world are
printed.";

#[derive(Clone, Debug, clap::Subcommand)]
pub(crate) enum Verb {
    /// Run the dispatcher with workers that crash, hang and lie, over channels that lose and
    /// corrupt.
    #[command(after_help = EXAMPLES)]
    Faults(FaultArgs),
}

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct FaultArgs {
    /// Run only the world of this seed.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Number of worlds.
    #[arg(long, value_name = "N", default_value_t = 2_000)]
    worlds: u64,
    /// Seed of the first world.
    #[arg(long, value_name = "N", default_value_t = 0)]
    from: u64,
    /// Requests per world.
    #[arg(long, value_name = "N", default_value_t = 4)]
    requests: u64,
    /// Number of threads [default: one per core].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Only these kinds of faults.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = kind)]
    only: Vec<SimulatedFault>,
    /// All kinds of faults but these.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = kind)]
    without: Vec<SimulatedFault>,
    /// Maximum number of faults per world: only the first N happen.
    #[arg(long, value_name = "N")]
    most: Option<u64>,
}

fn kind(name: &str) -> Result<SimulatedFault, String> {
    SimulatedFault::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = SimulatedFault::ALL.iter().map(|fault| fault.name()).collect();
        format!("expected one of: {}", names.join(", "))
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
