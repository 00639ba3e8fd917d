//! What a run took, and what became of each worker.

use dispatch::{Counts, Transfer};
use serde::Serialize;

/// What became of one worker.
#[derive(Clone, Debug, Serialize)]
pub struct WorkerReport {
    /// Worker number.
    pub worker: u8,
    /// Process id.
    pub pid: u32,
    /// The core it was pinned to.
    pub core: Option<usize>,
    /// Jobs it finished.
    pub jobs: u64,
    /// Box and triangle tests of long jobs, as it counted them.
    pub tests: u64,
    /// Batches sent to it.
    pub batches: u64,
    /// Bytes of these, headers included.
    pub batch_bytes: u64,
    /// Cache lines that these lie in.
    pub batch_lines: u64,
    /// Result messages taken from it.
    pub results: u64,
    /// Bytes of these, headers included.
    pub result_bytes: u64,
    /// Cache lines that these lie in.
    pub result_lines: u64,
    /// Time that its jobs took by the clock on the wall (ns).
    pub busy_ns: u64,
    /// How it ended, if it was lost.
    pub lost: Option<String>,
}

/// What a run took.
#[derive(Clone, Debug)]
pub struct CrewReport {
    /// Jobs, batches, fence.
    pub counts: Counts,
    /// The transfer ledger.
    pub transfer: Transfer,
    /// Messages that were turned away: foreign, stale or corrupt.
    pub rejected: u64,
    /// Each worker.
    pub workers: Vec<WorkerReport>,
}
