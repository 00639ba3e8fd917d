//! `trolley simulate faults`: seeded worlds in which everything goes wrong, in virtual time.

use crate::args::Output;
use crate::print;
use crate::progress::Progress;
use clap::{Args, Subcommand};
use diagnostic::Failure;
use serde::Serialize;
use simulate::faults::{Fault, Faults, Limits, Tally, Violation, run, shrink};
use std::fmt::Write as _;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley simulate faults                          2,000 worlds of 4 requests each
  trolley simulate faults --worlds 250000          a million requests
  trolley simulate faults --seed 173 -v            one world, with all that happens in it
  trolley simulate faults --only crash,lose-result

Exit codes: 0 all laws hold, 1 one was broken: the seed is printed, with the smallest world found.";

#[derive(Clone, Debug, Subcommand)]
pub(crate) enum Verb {
    /// The dispatcher among workers that crash, hang and lie, on channels that lose and garble.
    #[command(after_help = EXAMPLES)]
    Faults(FaultArgs),
}

#[derive(Clone, Debug, Args)]
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
    only: Vec<Fault>,
    /// Not these.
    #[arg(long, value_name = "KINDS", value_delimiter = ',', value_parser = kind)]
    without: Vec<Fault>,
    /// So many faults in a world at most: the first ones.
    #[arg(long, value_name = "N")]
    most: Option<u64>,
}

fn kind(name: &str) -> Result<Fault, String> {
    Fault::from_name(name).ok_or_else(|| {
        let names: Vec<&str> = Fault::ALL.iter().map(|fault| fault.name()).collect();
        format!("there are: {}", names.join(", "))
    })
}

/// What `--json` prints.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    worlds: u64,
    requests: u64,
    disturbed: u64,
    jobs: u64,
    complete: u64,
    degraded: u64,
    refused: u64,
    faults: std::collections::BTreeMap<&'static str, u64>,
    reissued: u64,
    abandoned: u64,
    fenced: u64,
    deaths: u64,
    killed: u64,
    violations: Vec<String>,
    replay: Option<String>,
    seconds: f64,
}

pub(crate) fn simulate(verb: &Verb, verbose: u8, output: &Output) -> Result<ExitCode, Failure> {
    let Verb::Faults(args) = verb;
    let mut kinds = args.only.iter().fold(Faults::NONE, |all, fault| all.with(*fault));
    if args.only.is_empty() {
        kinds = Faults::ALL;
    }
    let kinds = args.without.iter().fold(kinds, |all, fault| all.without(*fault));
    let limits =
        Limits { kinds, most: args.most.unwrap_or(u64::MAX), requests: args.requests.max(1) };
    let (from, worlds) = args.seed.map_or((args.from, args.worlds), |seed| (seed, 1));
    if verbose > 0 && args.seed.is_some() {
        let mut log = Vec::new();
        // How it ends is told below, of the same world.
        let _end = run(from, &limits, Some(&mut log));
        log.iter().for_each(|line| print::err(line));
    }
    let begun_ns = runtime::clock::now_ns();
    let cores = runtime::affinity::allowed_cores().len().max(1);
    let threads = args.threads.unwrap_or(cores).clamp(1, 64);
    let progress = Progress::new("worlds", worlds, output);
    let (tally, failed) = all(from, worlds, &limits, threads, &progress);
    drop(progress);
    let shrunk = failed.as_ref().and_then(|violation| shrink(violation.seed, &limits));
    let replay = shrunk.as_ref().map(|shrunk| {
        let Limits { kinds, most, requests, .. } = shrunk.limits;
        let names: Vec<&str> = kinds.iter().map(Fault::name).collect();
        let mut command = format!(
            "trolley simulate faults -v --seed {} --requests {requests} --only {}",
            shrunk.violation.seed,
            names.join(",")
        );
        if most < u64::MAX {
            // Writing to a string cannot fail.
            let _written = write!(command, " --most {most}");
        }
        command
    });
    let violations = failed.iter().chain(shrunk.as_ref().map(|shrunk| &shrunk.violation));
    let document = Document {
        schema: "trolley.simulated-faults/1",
        worlds,
        requests: tally.requests,
        disturbed: tally.disturbed,
        jobs: tally.jobs,
        complete: tally.complete,
        degraded: tally.degraded,
        refused: tally.refused,
        faults: Fault::ALL.iter().map(|f| f.name()).zip(tally.struck.iter().copied()).collect(),
        reissued: tally.reissued,
        abandoned: tally.abandoned,
        fenced: tally.fenced,
        deaths: tally.deaths,
        killed: tally.killed,
        violations: violations.map(ToString::to_string).collect(),
        replay,
        seconds: (runtime::clock::now_ns() - begun_ns) as f64 / 1e9,
    };
    if output.json {
        print::out(&print::json(&document)?)?;
    } else {
        print::out(&page(&document))?;
    }
    Ok(ExitCode::from(u8::from(failed.is_some())))
}

/// All worlds, on several threads; the failure with the lowest seed, if there is one.
fn all(
    from: u64,
    worlds: u64,
    limits: &Limits,
    threads: usize,
    progress: &Progress,
) -> (Tally, Option<Violation>) {
    const PIECE: u64 = 64;
    let next = AtomicU64::new(0);
    let sum = Mutex::new((Tally::default(), None::<Violation>));
    let work = || {
        let mut own = Tally::default();
        let mut failed: Option<Violation> = None;
        loop {
            let piece = next.fetch_add(PIECE, Ordering::Relaxed);
            if piece >= worlds || failed.is_some() {
                break;
            }
            let end = (piece + PIECE).min(worlds);
            for seed in from.saturating_add(piece)..from.saturating_add(end) {
                match run(seed, limits, None) {
                    Ok(tally) => own.add(&tally),
                    Err(violation) => {
                        failed.get_or_insert(violation);
                    }
                }
            }
            progress.add(end - piece);
        }
        // Nobody panics while holding it.
        if let Ok(mut sum) = sum.lock() {
            sum.0.add(&own);
            let first = sum.1.take().into_iter().chain(failed).min_by_key(|v| v.seed);
            sum.1 = first;
        }
    };
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| {
            scope.spawn(work);
        });
        work();
    });
    sum.into_inner().unwrap_or_default()
}

fn page(document: &Document) -> String {
    let mut text = String::new();
    let mut line = |words: std::fmt::Arguments<'_>| {
        // Writing to a string cannot fail.
        let _written = writeln!(text, "{words}");
    };
    line(format_args!(
        "{} requests in {} worlds, {} of them disturbed, in {:.1} s",
        document.requests, document.worlds, document.disturbed, document.seconds
    ));
    line(format_args!(
        "answers: {} complete, {} degraded, {} refused; wrong: {}",
        document.complete,
        document.degraded,
        document.refused,
        document.violations.len().min(1)
    ));
    line(format_args!(
        "{} jobs, {} leases ended without a result, {} parts fenced off, {} jobs given up",
        document.jobs, document.reissued, document.fenced, document.abandoned
    ));
    line(format_args!(
        "{} workers died, {} of them killed by the coordinator",
        document.deaths, document.killed
    ));
    line(format_args!("\nfaults that struck:"));
    for (name, struck) in &document.faults {
        line(format_args!("  {name:<14} {struck:>10}"));
    }
    for violation in &document.violations {
        line(format_args!("BROKEN: {violation}"));
    }
    if let Some(replay) = &document.replay {
        line(format_args!("again, as small as could be found:\n  {replay}"));
    }
    text.trim_end().to_owned()
}
