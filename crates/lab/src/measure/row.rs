//! One line of a measurement's table: the configuration of a run, and its results.

use scenario::Scheme;
use serde::Serialize;
use trolley::dispatch_options::TransferMode;

/// Where a figure comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mode {
    /// Real processes on this machine's cores.
    Measured,
    /// Virtual cores, the coordinator on one of its own.
    SimulatedOwnCore,
    /// Virtual cores, the coordinator on that of worker 0.
    SimulatedSharedCore,
}

impl Mode {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::SimulatedOwnCore => "simulated-own-core",
            Self::SimulatedSharedCore => "simulated-shared-core",
        }
    }
}

/// One configuration on one pair, and its results.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) pair: String,
    pub(crate) mode: Mode,
    pub(crate) transfer: TransferMode,
    pub(crate) scheme: Scheme,
    pub(crate) depth: u32,
    pub(crate) workers: u8,
    pub(crate) queue: u32,
    pub(crate) batch: u32,
    /// Empty where the run thrashed.
    pub(crate) time_ms: Option<f64>,
    /// Median of the repeats; `time_ms` is the fastest. Empty in a simulation.
    pub(crate) median_ms: Option<f64>,
    /// The in-process kernel's best time over this one; in a simulation, over its own prediction.
    pub(crate) speed_up: Option<f64>,
    pub(crate) jobs: u64,
    pub(crate) messages: u64,
    pub(crate) message_bytes: Option<u64>,
    pub(crate) cache_lines: Option<u64>,
    pub(crate) section_bytes: Option<u64>,
    /// Section bytes over the bytes of both bodies.
    pub(crate) relative_to_models: Option<f64>,
    /// Section bytes over those of every section with every job.
    pub(crate) relative_to_unshared: Option<f64>,
    pub(crate) thrashed: Option<String>,
}

/// The rows as CSV, with a line of names.
pub(crate) fn csv(rows: &[Row]) -> String {
    fn or_empty<T: ToString>(value: Option<&T>) -> String {
        value.map(T::to_string).unwrap_or_default()
    }
    let mut text = String::from(
        "pair,mode,transfer,scheme,depth,workers,queue,batch,time_ms,median_ms,speed_up,jobs,\
         messages,message_bytes,cache_lines,section_bytes,relative_to_models,\
         relative_to_unshared,thrashed\n",
    );
    for row in rows {
        let fields = [
            row.pair.clone(),
            row.mode.name().to_owned(),
            row.transfer.name().to_owned(),
            row.scheme.name().to_owned(),
            row.depth.to_string(),
            row.workers.to_string(),
            row.queue.to_string(),
            row.batch.to_string(),
            or_empty(row.time_ms.as_ref()),
            or_empty(row.median_ms.as_ref()),
            or_empty(row.speed_up.as_ref()),
            row.jobs.to_string(),
            row.messages.to_string(),
            or_empty(row.message_bytes.as_ref()),
            or_empty(row.cache_lines.as_ref()),
            or_empty(row.section_bytes.as_ref()),
            or_empty(row.relative_to_models.as_ref()),
            or_empty(row.relative_to_unshared.as_ref()),
            or_empty(row.thrashed.as_ref()).replace(',', ";"),
        ];
        text.push_str(&fields.join(","));
        text.push('\n');
    }
    text
}
