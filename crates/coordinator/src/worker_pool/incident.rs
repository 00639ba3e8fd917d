//! What the coordinator saw of a fault, and when: the other half of a fault report.

use super::WorkerPool;
use dispatch::{Liveness, Why};
use protocol::{Incarnation, Reject};
use runtime::clock;

/// How many are kept of one request.
const MOST: usize = 4096;

/// Something went wrong with a worker, and was noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incident {
    /// When it was noticed (ns, monotonic).
    pub at_ns: u64,
    /// With whom.
    pub who: Incarnation,
    /// What was noticed.
    pub observation: Observation,
}

/// What was noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observation {
    /// The process has ended.
    Ended,
    /// It stood still, and was killed.
    StoodStill(Liveness),
    /// Its message was turned away.
    TurnedAway(Reject),
    /// Its result was not wanted: late, repeated, or out of order.
    Fenced,
    /// It said that a job failed.
    Failed,
    /// It answered a batch, and results are missing.
    Unanswered,
    /// Its queue was full.
    Full,
    /// It did too much of this, and was killed.
    Distrusted(Why),
}

impl WorkerPool {
    /// What was noticed since the start of the last request.
    #[must_use]
    pub fn incidents(&self) -> &[Incident] {
        &self.incidents
    }

    pub(super) fn observe(&mut self, who: Incarnation, observation: Observation) {
        if self.incidents.len() < MOST {
            self.incidents.push(Incident { at_ns: clock::now_ns(), who, observation });
        }
    }
}
