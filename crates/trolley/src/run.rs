//! How the work was done: everything beside the answer, which does not depend on it.

use body::Build;
use coordinator::{Certainty, RankingRun, WorkerPoolReport, WorkerReport};
use core::time::Duration;
use record::Mode;
use scenario::Scheme;
use serde::Serialize;

/// Times of the stages, in milliseconds.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stages {
    /// Reading or generating bodies, building trees, sealing the store.
    pub load_ms: f64,
    /// Hulls and paths.
    pub plan_ms: f64,
    /// Starting workers and waiting for their greetings.
    pub start_ms: f64,
    /// Descending, intersecting, folding.
    pub work_ms: f64,
    /// Harm and ranking.
    pub assess_ms: f64,
    /// Stopping workers and cleaning up.
    pub stop_ms: f64,
}

/// What it took.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Name of the build.
    pub build: &'static str,
    /// Who did the jobs.
    pub mode: Mode,
    /// Times of the stages.
    pub stages: Stages,
    /// Distribution depth.
    pub depth: u32,
    /// How the trees were built.
    pub tree: Build,
    /// How jobs were matched to workers.
    pub scheme: Scheme,
    /// How the deadline was kept, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deadline: Option<Kept>,
    /// When no open work could change the winner any more; absent if that never was so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub winner_certain: Option<Certain>,
    /// The same of the whole order, if somebody waited for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order_certain: Option<Certain>,
    /// Bodies in the store.
    pub bodies: usize,
    /// Their triangles.
    pub triangles: usize,
    /// Bytes of the store; 0 without workers.
    pub store_bytes: usize,
    /// Cores that this process may use.
    pub cores_granted: Vec<usize>,
    /// Plain statements on what is not as it should be.
    pub remarks: Vec<String>,
    /// Questions about poses.
    pub tasks: u64,
    /// Node pairs that the kernel was asked about.
    pub jobs: u64,
    /// Jobs that nobody needed any more.
    pub jobs_cut: u64,
    /// Jobs given up.
    pub jobs_abandoned: u64,
    /// Jobs handed out again.
    pub jobs_reissued: u64,
    /// Box tests of the coordinator's descent.
    pub nb_descent: u64,
    /// Box tests of the jobs.
    pub nb: u64,
    /// Triangle tests of the jobs.
    pub np: u64,
    /// Messages to and from workers.
    pub messages: u64,
    /// Bytes of these, headers included.
    pub message_bytes: u64,
    /// Messages turned away: foreign, stale or corrupt.
    pub messages_rejected: u64,
    /// Parts of results that came too late or twice.
    pub parts_fenced: u64,
    /// Bytes of sections that a core did not hold yet.
    pub section_bytes: u64,
    /// The same if none were ever held.
    pub section_bytes_unshared: u64,
    /// Sections that made room for others.
    pub sections_evicted: u64,
    /// What each worker did.
    pub workers: Vec<WorkerReport>,
}

/// How a deadline was kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// When the answer was due, after the request was accepted.
    pub due_ms: f64,
    /// When it was made.
    pub answered_ms: f64,
    /// How much later than due that was; 0 if it was not.
    pub late_ms: f64,
}

/// When something became certain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certain {
    /// Tests of boxes and triangles by then, in units of all that were done.
    pub share: f64,
    /// Jobs done by then.
    pub jobs: u64,
    /// Time since the request was accepted.
    pub ms: f64,
}

pub(crate) fn milliseconds(ns: u64) -> f64 {
    ns as f64 / 1e6
}

impl Kept {
    /// Of an answer that took so long (ns).
    pub(crate) fn of(due: Duration, answered_ns: u64) -> Self {
        let (due_ms, answered_ms) = (due.as_secs_f64() * 1e3, milliseconds(answered_ns));
        Self { due_ms, answered_ms, late_ms: (answered_ms - due_ms).max(0.0) }
    }
}

impl Run {
    /// Adds what the work itself counted.
    pub(crate) fn with_effort(self, work: &RankingRun<'_>) -> Self {
        let effort = work.effort();
        let [winner_certain, order_certain] = certain(work);
        Self {
            tasks: effort.tasks,
            nb_descent: effort.descent.nb,
            nb: effort.jobs.nb,
            np: effort.jobs.np,
            winner_certain,
            order_certain,
            ..self
        }
    }

    /// Adds what the workers and the channels to them counted.
    pub(crate) fn with_worker_pool(self, report: WorkerPoolReport, store_bytes: usize) -> Self {
        let counts = report.counts;
        Self {
            store_bytes,
            jobs: counts.jobs,
            jobs_cut: counts.cut,
            jobs_abandoned: counts.abandoned,
            jobs_reissued: counts.reissued,
            messages: report.workers.iter().map(|worker| worker.batches + worker.results).sum(),
            message_bytes: report.workers.iter().map(|w| w.batch_bytes + w.result_bytes).sum(),
            messages_rejected: report.rejected,
            parts_fenced: counts.fence.sum(),
            section_bytes: report.transfer.section_bytes,
            section_bytes_unshared: report.transfer.unshared_bytes,
            sections_evicted: report.transfer.evicted,
            workers: report.workers,
            ..self
        }
    }
}

/// When winner and order were certain.
#[must_use]
pub fn certain(work: &RankingRun<'_>) -> [Option<Certain>; 2] {
    let effort = work.effort();
    let all = (effort.descent.tests() + effort.jobs.tests()).max(1) as f64;
    let one = |certainty: Certainty| Certain {
        share: certainty.tests as f64 / all,
        jobs: certainty.jobs,
        ms: milliseconds(certainty.ns),
    };
    work.certainties().map(|certainty| certainty.map(one))
}
