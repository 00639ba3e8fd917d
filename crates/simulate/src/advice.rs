//! Which depth to cut at, and whether to cut at all: from dry runs at a few depths.
//!
//! Between dry runs each quantity is taken to grow by the same factor per level. Workers share the
//! kernel's time, and wait at the end for one that has just begun the largest job (Graham, *Bounds
//! on Multiprocessing Timing Anomalies*, 1969), or still has a full queue that nobody takes from
//! it; the coordinator's time bounds it all from below.

use crate::costs::Costs;
use crate::trace::Trace;
use dispatch::{Descent, Queues};
use serde::Serialize;
use std::ops::RangeInclusive;

/// What a dry run at one depth showed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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
    /// Hits of all jobs; 0 where descents alone are known.
    pub hits: f64,
}

/// Who is to do the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Team {
    /// Workers.
    pub workers: usize,
    /// Cores for them and the coordinator.
    pub cores: usize,
    /// Sizes of their queues and batches.
    pub queues: Queues,
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
        let descent_nb = trace.tasks.iter().map(|task| task.descent_nb as f64).sum();
        let mut dry =
            Self { depth, tasks: trace.tasks.len() as f64, descent_nb, ..Self::default() };
        for job in trace.jobs() {
            let ns = costs.kernel_ns(job.nb, job.np, job.hits);
            dry.jobs += 1.0;
            dry.kernel_ns += ns;
            dry.largest_ns = dry.largest_ns.max(ns);
            dry.hits += job.hits as f64;
        }
        dry
    }

    /// From a descent at one pose, in which so many pairs of leaves would overlap.
    #[must_use]
    pub fn of_descent(descent: &Descent, leaf_pairs: f64, costs: &Costs) -> Self {
        let (jobs, work_ns) = (descent.jobs as f64, costs.leaves_ns * leaf_pairs);
        Self {
            depth: descent.depth,
            tasks: 1.0,
            jobs,
            descent_nb: descent.nb as f64,
            kernel_ns: costs.job_ns * jobs + work_ns,
            largest_ns: costs.job_ns + work_ns * descent.largest,
            hits: 0.0,
        }
    }

    /// So many poses of the same work.
    #[must_use]
    pub fn times(&self, poses: f64) -> Self {
        Self {
            tasks: self.tasks * poses,
            jobs: self.jobs * poses,
            descent_nb: self.descent_nb * poses,
            kernel_ns: self.kernel_ns * poses,
            hits: self.hits * poses,
            ..*self
        }
    }

    /// This work and another, at the same depth.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            depth: self.depth,
            tasks: self.tasks + other.tasks,
            jobs: self.jobs + other.jobs,
            descent_nb: self.descent_nb + other.descent_nb,
            kernel_ns: self.kernel_ns + other.kernel_ns,
            largest_ns: self.largest_ns.max(other.largest_ns),
            hits: self.hits + other.hits,
        }
    }

    /// Predicted time by a team \[ns\].
    #[must_use]
    pub fn time_ns(&self, costs: &Costs, team: &Team) -> f64 {
        let workers = team.workers.min(team.cores).max(1) as f64;
        let Queues { capacity, batch, .. } = team.queues;
        let serial = costs.task_ns * self.tasks
            + costs.descent_ns * self.descent_nb
            + (costs.place_ns + costs.take_ns + costs.batch_ns / f64::from(batch.max(1)))
                * self.jobs
            + costs.fold_hit_ns * self.hits;
        // Without a core of its own the coordinator takes its time from the workers.
        let shared = if team.cores > team.workers { 0.0 } else { serial };
        let kernel = self.kernel_ns + costs.send_ns * self.jobs;
        let queue = kernel * (f64::from(capacity) / self.jobs.max(1.0)).min(1.0);
        let last = queue.max(self.largest_ns + costs.send_ns).min(kernel);
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

/// How many pairs of leaves would overlap, by descents of one pose in order of depth: their jobs go
/// on growing as over the last two, down to `levels`, where the leaves are.
#[must_use]
pub fn leaf_pairs(descents: &[Descent], levels: f64) -> f64 {
    let [.., a, b] = descents else { return 0.0 };
    let (at_a, at_b) = (a.jobs as f64, b.jobs as f64);
    let below = levels - f64::from(b.depth);
    if at_a == 0.0 || below <= 0.0 {
        return at_b;
    }
    // A level of both trees makes no more than four pairs out of one.
    let growth = (at_b / at_a).powf(1.0 / f64::from(b.depth - a.depth)).clamp(1.0, 4.0);
    at_b * growth.powf(below)
}

/// Advises on a depth among these, from dry runs in order of depth; `None` if there are fewer than
/// two. The first of them stands for the work in one piece.
#[must_use]
pub fn advise(
    dry: &[DryRun],
    costs: &Costs,
    team: &Team,
    depths: RangeInclusive<u32>,
) -> Option<Advice> {
    let [first, .., _] = dry else { return None };
    let at = |depth: u32| {
        let upper = dry.iter().position(|run| run.depth >= depth).unwrap_or(dry.len() - 1).max(1);
        DryRun::between(&dry[upper - 1], &dry[upper], depth)
    };
    let times = depths.map(|depth| (at(depth).time_ns(costs, team), depth));
    let (predicted_ns, depth) = times.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let whole_ns = first.time_ns(costs, &Team { workers: 1, ..*team });
    Some(Advice { depth, predicted_ns, whole_ns, distribute: predicted_ns < whole_ns })
}

#[cfg(test)]
mod tests;
