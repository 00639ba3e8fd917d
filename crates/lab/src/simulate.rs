//! Seeded simulations, in virtual time, of everything that can fail.

use crate::progress::{Progress, SyncProgress};
use serde::Serialize;
use simulate::faults::{FaultLimits, Faults, Tally, Violation, run, shrink};
use std::fmt::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

pub use simulate::faults::SimulatedFault;

/// Which worlds to simulate.
#[derive(Clone, Debug)]
pub struct FaultOptions {
    /// Only the world of this seed.
    pub seed: Option<u64>,
    /// Number of worlds.
    pub worlds: u64,
    /// Seed of the first world.
    pub from: u64,
    /// Requests per world.
    pub requests: u64,
    /// Number of threads; `None`: one per core.
    pub threads: Option<usize>,
    /// Only these kinds of faults; empty: all.
    pub only: Vec<SimulatedFault>,
    /// All kinds of faults but these.
    pub without: Vec<SimulatedFault>,
    /// Maximum number of faults per world: only the first N happen.
    pub most: Option<u64>,
    /// Whether to log all events, if there is only one world.
    pub log: bool,
}

/// The outcome of all worlds.
#[derive(Clone, Debug, Serialize)]
pub struct Simulated {
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
    #[serde(skip)]
    log: Vec<String>,
}

/// Simulates the dispatcher with workers that crash, hang and lie, over channels that lose and
/// corrupt. `told` is called with the worlds done.
#[must_use]
pub fn faults(options: &FaultOptions, told: SyncProgress<'_>) -> Simulated {
    let mut kinds = options.only.iter().fold(Faults::NONE, |all, fault| all.with(*fault));
    if options.only.is_empty() {
        kinds = Faults::ALL;
    }
    let kinds = options.without.iter().fold(kinds, |all, fault| all.without(*fault));
    let most = options.most.unwrap_or(u64::MAX);
    let limits = FaultLimits { kinds, most, requests: options.requests.max(1) };
    let (from, worlds) = options.seed.map_or((options.from, options.worlds), |seed| (seed, 1));
    let mut log = Vec::new();
    if options.log && options.seed.is_some() {
        // The outcome of the same world is reported below.
        let _end = run(from, &limits, Some(&mut log));
    }
    let begun_ns = runtime::clock::now_ns();
    let cores = runtime::affinity::allowed_cores().len().max(1);
    let threads = options.threads.unwrap_or(cores).clamp(1, 64);
    let progress = Progress::new(worlds, told);
    let (tally, failed) = all(from, worlds, &limits, threads, &progress);
    let shrunk = failed.as_ref().and_then(|violation| shrink(violation.seed, &limits));
    let replay = shrunk.as_ref().map(|shrunk| {
        let FaultLimits { kinds, most, requests, .. } = shrunk.limits;
        let names: Vec<&str> = kinds.iter().map(SimulatedFault::name).collect();
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
    Simulated {
        schema: "trolley.simulated-faults/1",
        worlds,
        requests: tally.requests,
        disturbed: tally.disturbed,
        jobs: tally.jobs,
        complete: tally.complete,
        degraded: tally.degraded,
        refused: tally.refused,
        faults: SimulatedFault::ALL
            .iter()
            .map(|f| f.name())
            .zip(tally.struck.iter().copied())
            .collect(),
        reissued: tally.reissued,
        abandoned: tally.abandoned,
        fenced: tally.fenced,
        deaths: tally.deaths,
        killed: tally.killed,
        violations: violations.map(ToString::to_string).collect(),
        replay,
        seconds: (runtime::clock::now_ns() - begun_ns) as f64 / 1e9,
        log,
    }
}

impl Simulated {
    /// Whether all invariants hold.
    #[must_use]
    pub fn is_right(&self) -> bool {
        self.violations.is_empty()
    }

    /// The events of the single world, if requested.
    #[must_use]
    pub fn log(&self) -> &[String] {
        &self.log
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        page(self)
    }
}

/// Runs all worlds on several threads; returns the failure with the lowest seed, if any.
fn all(
    from: u64,
    worlds: u64,
    limits: &FaultLimits,
    threads: usize,
    progress: &Progress<'_>,
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
        // No thread panics while it holds the lock.
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

fn page(document: &Simulated) -> String {
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
