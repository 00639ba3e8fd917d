//! Results of a sweep over one pair, with the fields of the written document.
//!
//! A measured time is the fastest of its repeats unless it is called a median.

use super::row::Row;
use dispatch::LogEntry;
use serde::Serialize;
use simulate::Costs;

/// A prediction and the measured value.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Check {
    pub(crate) workers: u8,
    pub(crate) depth: u32,
    pub(crate) predicted_ms: f64,
    pub(crate) measured_ms: f64,
    /// Speed-ups, each over the in-process kernel of its kind.
    pub(crate) predicted_speed_up: f64,
    pub(crate) measured_speed_up: f64,
}

impl Check {
    /// Relative error of the predicted speed-up: 0.1 is 10 %.
    pub(crate) fn error(&self) -> f64 {
        self.predicted_speed_up / self.measured_speed_up - 1.0
    }
}

/// Where the time of a run went, per core: shares of the run's time.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Shares {
    pub(crate) workers: u8,
    pub(crate) depth: u32,
    pub(crate) run_ms: f64,
    pub(crate) speed_up: f64,
    /// Kernel time over all workers, and that of the in-process kernel (ms).
    pub(crate) kernel_ms: f64,
    pub(crate) kernel_alone_ms: f64,
    /// Least and most that one worker worked (ms).
    pub(crate) worker_least_ms: f64,
    pub(crate) worker_most_ms: f64,
    pub(crate) descent_ms: f64,
    pub(crate) fold_ms: f64,
    pub(crate) decide_ms: f64,
    pub(crate) send_ms: f64,
    pub(crate) take_ms: f64,
}

/// Results of one pair.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Swept {
    pub(crate) pair: String,
    pub(crate) triangles: [usize; 2],
    pub(crate) poses: usize,
    pub(crate) pairs_found: u64,
    pub(crate) model_bytes: u64,
    pub(crate) costs: Costs,
    /// The in-process kernel (ms), its best depth.
    pub(crate) alone_ms: f64,
    /// Median of its repeats (ms).
    pub(crate) alone_median_ms: f64,
    pub(crate) alone_depth: u32,
    /// Number of threads of one process that share each pose, and their time (ms).
    pub(crate) threads: usize,
    pub(crate) threads_ms: f64,
    /// The in-process kernel by the cost model (ms).
    pub(crate) alone_predicted_ms: f64,
    pub(crate) checks: Vec<Check>,
    pub(crate) shares: Vec<Shares>,
    pub(crate) rows: Vec<Row>,
    /// Job log of the last measured run, if it was kept.
    #[serde(skip)]
    pub(crate) log: Vec<LogEntry>,
}
