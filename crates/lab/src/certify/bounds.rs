//! Long test of the bounds: random requests, stopped anywhere, under every policy.

use super::figures::names;
use super::requests::{self, POLICIES, Pool};
use crate::progress::{Progress, SyncProgress};
use coordinator::{BoundFlaw, TrialResult, trial};
use geometry::rng::Rng;
use serde::Serialize;
use std::fmt::Write as _;
use trolley::Failure;

/// What to test.
#[derive(Clone, Debug)]
pub struct BoundsOptions {
    /// Bodies, as model files or shape:triangles; the first is the ego. Empty: seven generated
    /// ones.
    pub bodies: Vec<String>,
    /// Number of stops; at each, all intervals are compared with the finished run.
    pub stops: u64,
    /// Stops per request.
    pub per_request: u64,
    /// Seed of the random requests.
    pub seed: u64,
    /// Distribution depth.
    pub depth: u32,
    /// Makes the bounds wrong on purpose, so that violations must be found.
    pub flaw: Option<BoundFlaw>,
}

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct BoundsReport {
    schema: &'static str,
    bodies: Vec<String>,
    policies: usize,
    seed: u64,
    requests: u64,
    stops: u64,
    intervals: u64,
    open_intervals: u64,
    certified: u64,
    violations: usize,
    is_flawed: bool,
    first: Option<Violation>,
}

/// An interval that did not hold.
#[derive(Clone, Debug, Serialize)]
struct Violation {
    seed: u64,
    what: String,
}

/// Runs the test. `told` is called with the stops done.
///
/// # Errors
///
/// If a body cannot be used or a request cannot be executed. Violations are no error: see
/// [`BoundsReport::is_right`].
pub fn bounds(options: &BoundsOptions, told: SyncProgress<'_>) -> Result<BoundsReport, Failure> {
    let pool = Pool::load(&options.bodies)?;
    let views = pool.bodies.views()?;
    let bar = Progress::new(options.stops, told);
    let mut all = TrialResult::default();
    let (mut requests, mut first) = (0_u64, None);
    let mut seed = options.seed;
    while all.stops < options.stops {
        // Every request has its own seed, so that it can be reproduced alone.
        let mut rng = Rng::new(seed);
        let candidates = 2 + rng.below(4) as usize;
        let policy = requests::policy(requests as usize)?;
        if let Some(request) = requests::request(&views, (candidates, 1.1), &mut rng, policy)? {
            let stops = (seed, options.per_request);
            let one = trial(&request, &views, options.depth, stops, options.flaw)?;
            if let (Some(what), None) = (one.violations.first(), &first) {
                first = Some(Violation { seed, what: what.clone() });
            }
            bar.add(one.stops);
            all.add(one);
        }
        requests += 1;
        seed += 1;
    }
    Ok(BoundsReport {
        schema: "trolley.certify-bounds/1",
        bodies: pool.names,
        policies: POLICIES.len(),
        seed: options.seed,
        requests,
        stops: all.stops,
        intervals: all.intervals,
        open_intervals: all.open_intervals,
        certified: all.certified,
        violations: all.violations.len(),
        is_flawed: options.flaw.is_some(),
        first,
    })
}

impl BoundsReport {
    /// Whether the result is as expected: no violations, unless the bounds were made wrong.
    #[must_use]
    pub fn is_right(&self) -> bool {
        (self.violations > 0) == self.is_flawed
    }

    /// The report as text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} stops in {} requests between {} bodies ({}), {} policies, seed {}: {} intervals \
             compared with the finished run, {} of them open, {} stops with a certain winner and \
             open work.\n{} violations{}.\n",
            self.stops,
            self.requests,
            self.bodies.len(),
            names(&self.bodies),
            self.policies,
            self.seed,
            self.intervals,
            self.open_intervals,
            self.certified,
            self.violations,
            if self.is_flawed { " of bounds made wrong on purpose" } else { "" },
        );
        if let Some(Violation { seed, what }) = &self.first {
            // A String takes whatever it is given.
            let _written = writeln!(text, "The first, at seed {seed}: {what}.");
        }
        text
    }
}
