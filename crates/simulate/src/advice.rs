//! Which depth to cut at, and whether to cut at all: from dry runs at a few depths.
//!
//! Between dry runs each quantity is taken to grow by the same factor per level. Workers share the
//! kernel's time, and wait at the end for one that has just begun the largest job (Graham, *Bounds
//! on Multiprocessing Timing Anomalies*, 1969); the coordinator's time bounds it all from below.

use crate::costs::Costs;
use crate::machine::Home;
use crate::trace::Trace;
use serde::Serialize;

/// Jobs per batch that is reckoned with.
const BATCH: f64 = 4.0;

/// What a dry run at one depth showed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DryRun {
    /// The depth.
    pub depth: u32,
    /// Tasks.
    pub tasks: f64,
    /// Jobs.
    pub jobs: f64,
    /// Tests of boxes of all descents.
    pub descent_nb: f64,
    /// Kernel time of all jobs (ns).
    pub kernel_ns: f64,
    /// That of the largest (ns).
    pub largest_ns: f64,
    /// Hits of all jobs.
    pub hits: f64,
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The depth with the least predicted time.
    pub depth: u32,
    /// That time (ns).
    pub predicted_ns: f64,
    /// The predicted time in one piece, on one worker (ns).
    pub whole_ns: f64,
    /// Whether to distribute: whether that is predicted to be quicker than one piece.
    pub distribute: bool,
}

impl DryRun {
    /// From a trace at this depth.
    #[must_use]
    pub fn of(depth: u32, trace: &Trace, costs: &Costs) -> Self {
        let mut dry = Self {
            depth,
            tasks: trace.tasks.len() as f64,
            jobs: 0.0,
            descent_nb: trace.tasks.iter().map(|task| task.descent_nb as f64).sum(),
            kernel_ns: 0.0,
            largest_ns: 0.0,
            hits: 0.0,
        };
        for job in trace.jobs() {
            let ns = costs.kernel_ns(job.nb, job.np, job.hits);
            dry.jobs += 1.0;
            dry.kernel_ns += ns;
            dry.largest_ns = dry.largest_ns.max(ns);
            dry.hits += job.hits as f64;
        }
        dry
    }

    /// Predicted time with so many workers \[ns\].
    #[must_use]
    pub fn time_ns(&self, costs: &Costs, workers: u8, home: Home) -> f64 {
        let workers = f64::from(workers.max(1));
        let serial = costs.task_ns * self.tasks
            + costs.descent_ns * self.descent_nb
            + (costs.place_ns + costs.take_ns + costs.batch_ns / BATCH) * self.jobs
            + costs.fold_hit_ns * self.hits;
        let shared = match home {
            Home::Own => 0.0,
            Home::Shared => serial,
        };
        let kernel = self.kernel_ns + costs.send_ns * self.jobs;
        let last = self.largest_ns + costs.send_ns;
        let parallel = (kernel + shared) / workers + last * (1.0 - 1.0 / workers);
        parallel.max(serial) + 2.0 * costs.flight_ns
    }

    /// Between (or beyond) two dry runs.
    fn between(a: &Self, b: &Self, depth: u32) -> Self {
        let span = f64::from(b.depth) - f64::from(a.depth);
        let share = (f64::from(depth) - f64::from(a.depth)) / span;
        let at = |a: f64, b: f64| {
            if a > 0.0 && b > 0.0 { a * (b / a).powf(share) } else { a + (b - a) * share }
        };
        Self {
            depth,
            tasks: at(a.tasks, b.tasks),
            jobs: at(a.jobs, b.jobs),
            descent_nb: at(a.descent_nb, b.descent_nb).max(0.0),
            kernel_ns: at(a.kernel_ns, b.kernel_ns).max(0.0),
            largest_ns: at(a.largest_ns, b.largest_ns).max(0.0),
            hits: at(a.hits, b.hits).max(0.0),
        }
    }
}

/// Advises on depths up to `deepest`, from dry runs in order of depth; `None` if there are fewer
/// than two. The first of them stands for the work in one piece.
#[must_use]
pub fn advise(
    dry: &[DryRun],
    costs: &Costs,
    workers: u8,
    home: Home,
    deepest: u32,
) -> Option<Advice> {
    let [first, .., _] = dry else { return None };
    let at = |depth: u32| {
        let upper = dry.iter().position(|run| run.depth >= depth).unwrap_or(dry.len() - 1).max(1);
        DryRun::between(&dry[upper - 1], &dry[upper], depth)
    };
    let depths = first.depth..=deepest.max(first.depth);
    let times = depths.map(|depth| (at(depth).time_ns(costs, workers, home), depth));
    let (predicted_ns, depth) = times.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let whole_ns = first.time_ns(costs, 1, home);
    Some(Advice { depth, predicted_ns, whole_ns, distribute: predicted_ns < whole_ns })
}

#[cfg(test)]
mod tests;
