//! What the coordinator observed of a fault, and when: the other half of a fault report.

use super::WorkerPool;
use dispatch::{Liveness, Why};
use protocol::{Incarnation, Reject};
use runtime::clock;

/// Maximum number of incidents kept until somebody takes them.
const MOST: usize = 4096;

/// A fault of a worker that was noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incident {
    /// When it was noticed (ns, monotonic).
    pub at_ns: u64,
    /// The worker.
    pub who: Incarnation,
    /// What was noticed.
    pub observation: Observation,
}

/// What was noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observation {
    /// The process has ended.
    Ended,
    /// It made no progress, and was killed.
    StoodStill(Liveness),
    /// Its message was rejected.
    TurnedAway(Reject),
    /// Its result was not wanted: late, repeated, or out of order.
    Fenced,
    /// It reported that a job failed.
    Failed,
    /// It answered a batch, but results are missing.
    Unanswered,
    /// Its queue was full.
    Full,
    /// It did this too often, and was killed.
    Distrusted(Why),
    /// Its line on the status page said what cannot be, and it was killed.
    Impossible,
}

impl WorkerPool {
    /// Takes what was noticed since the last time, up to a bound.
    pub fn take_incidents(&mut self) -> Vec<Incident> {
        core::mem::take(&mut self.incidents)
    }

    pub(super) fn observe(&mut self, who: Incarnation, observation: Observation) {
        if self.incidents.len() < MOST {
            self.incidents.push(Incident { at_ns: clock::now_ns(), who, observation });
        }
    }
}
