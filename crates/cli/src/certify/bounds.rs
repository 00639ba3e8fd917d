//! The long trial of the bounds: requests in random order, stopped anywhere, under every policy.

use super::requests::{self, POLICIES, Pool};
use crate::args::Output;
use crate::progress::Progress;
use coordinator::{Chance, Flaw, Verdict, trial};
use diagnostic::Failure;
use std::fmt::Write as _;

/// What is asked.
#[derive(Debug, clap::Args)]
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

/// [`Flaw`] by name.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum FlawName {
    /// Poses that are not done are taken to add nothing.
    ForgetsOpenPoses,
    /// The upper end is taken to be half way up.
    HalvesWidths,
}

/// Runs the trial. Says what was found, and whether it is what had to be.
pub(crate) fn run(args: &BoundsArgs, output: &Output) -> Result<(String, bool), Failure> {
    let flaw = args.flaw.map(|flaw| match flaw {
        FlawName::ForgetsOpenPoses => Flaw::ForgetsOpenPoses,
        FlawName::HalvesWidths => Flaw::HalvesWidths,
    });
    let pool = Pool::load(&args.body)?;
    let views = pool.views()?;
    let bar = Progress::new("stops", args.stops, output);
    let mut all = Verdict::default();
    let (mut requests, mut first) = (0_u64, None);
    let mut seed = args.seed;
    while all.stops < args.stops {
        // Every request has a seed of its own, so that one can be made again alone.
        let mut chance = Chance::new(seed);
        let candidates = 2 + chance.below(4) as usize;
        let policy = requests::policy(requests as usize)?;
        if let Some(request) = requests::request(&views, (candidates, 1.1), &mut chance, policy)? {
            let stops = (seed, args.per_request);
            let one = trial(&request, &views, args.depth, stops, flaw)?;
            if !one.violations.is_empty() && first.is_none() {
                first = Some((seed, one.violations[0].clone()));
            }
            bar.add(one.stops);
            all.stops += one.stops;
            all.certified += one.certified;
            all.intervals += one.intervals;
            all.open_intervals += one.open_intervals;
            all.violations.extend(one.violations);
            all.violations.truncate(1_000_000);
        }
        requests += 1;
        seed += 1;
    }
    let mut text = format!(
        "{} stops in {requests} requests between {} bodies ({}), {} policies, seed {}: {} \
         intervals held against the finished run, {} of them open, {} stops with a certain \
         winner and open work.\n{} violations{}.\n",
        all.stops,
        pool.names.len(),
        super::names(&pool.names),
        POLICIES.len(),
        args.seed,
        all.intervals,
        all.open_intervals,
        all.certified,
        all.violations.len(),
        if flaw.is_some() { " of bounds made wrong on purpose" } else { "" },
    );
    if let Some((seed, what)) = first {
        let _written = writeln!(text, "The first, at seed {seed}: {what}.");
    }
    Ok((text, all.violations.is_empty() == flaw.is_none()))
}
