//! The cost of a run, and what became of each worker.

use dispatch::{Counts, Transfer};
use runtime::OsError;
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
    /// Bytes of these messages, headers included.
    pub batch_bytes: u64,
    /// Cache lines that these messages occupy.
    pub batch_lines: u64,
    /// Result messages taken from it.
    pub results: u64,
    /// Bytes of these messages, headers included.
    pub result_bytes: u64,
    /// Cache lines that these messages occupy.
    pub result_lines: u64,
    /// Wall-clock time that its jobs took (ns).
    pub busy_ns: u64,
    /// When each result was taken, and the wall-clock time of its job (ns); monotonic clock.
    #[serde(skip)]
    pub spans: Vec<[u64; 2]>,
    /// Hardware counts of the request, in user mode.
    pub hardware: Hardware,
    /// How it ended, if it was lost.
    pub lost: Option<String>,
}

impl WorkerReport {
    /// Adds the counts of an earlier request; spans and how it ended stay those of this one.
    pub fn include(&mut self, before: Self) {
        self.jobs += before.jobs;
        self.tests += before.tests;
        self.batches += before.batches;
        self.batch_bytes += before.batch_bytes;
        self.batch_lines += before.batch_lines;
        self.results += before.results;
        self.result_bytes += before.result_bytes;
        self.result_lines += before.result_lines;
        self.busy_ns += before.busy_ns;
        self.lost = self.lost.take().or(before.lost);
        if let (
            Hardware::Counted { instructions, cache_misses },
            Hardware::Counted { instructions: more, cache_misses: missed },
        ) = (&mut self.hardware, before.hardware)
        {
            *instructions += more;
            *cache_misses += missed;
        }
    }
}

/// Hardware counters of one worker.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Hardware {
    /// Counts of the processor.
    Counted {
        /// Instructions retired.
        instructions: u64,
        /// Last-level cache misses.
        cache_misses: u64,
    },
    /// "not available", and the reason.
    NotAvailable(String),
}

impl From<OsError> for Hardware {
    fn from(error: OsError) -> Self {
        let why = std::error::Error::source(&error).map(ToString::to_string);
        Self::NotAvailable(format!("not available: {}", why.unwrap_or_else(|| error.to_string())))
    }
}

/// Where the coordinator's time went in one request; the rest is waiting.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Duty {
    /// From the start to the last result folded (ns).
    pub run_ns: u64,
    /// Copying results out of their channels and checking them (ns).
    pub take_ns: u64,
    /// Dispatching, with the traversals and folds that follow (ns).
    pub step_ns: u64,
    /// Laying out and sending batches (ns).
    pub send_ns: u64,
}

/// The cost of a run.
#[derive(Clone, Debug)]
pub struct WorkerPoolReport {
    /// Where the coordinator's time went.
    pub duty: Duty,
    /// Jobs, batches, fence.
    pub counts: Counts,
    /// The transfer account.
    pub transfer: Transfer,
    /// Messages that were rejected: foreign, stale or corrupt.
    pub rejected: u64,
    /// Each worker.
    pub workers: Vec<WorkerReport>,
}
