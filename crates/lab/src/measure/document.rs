//! What all documents of a measurement have: the machine in words, and their form.

use serde::Serialize;
use trolley::Failure;

/// A document as readable JSON.
pub(crate) fn json(document: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(document).map_err(|error| Failure::internal(error.to_string()))
}

/// The machine in one sentence.
pub(crate) fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = text.lines().find(|line| line.starts_with("model name"));
    let model = model.and_then(|line| line.split_once(": ")).map_or("unknown processor", |m| m.1);
    let cores = runtime::affinity::allowed_cores().len();
    format!(
        "Machine: {model}, {cores} cores granted; workers pinned to cores in turn, the coordinator \
         wherever there is room. Hardware counters: {}.",
        hardware()
    )
}

/// Whether this machine counts instructions and cache misses.
fn hardware() -> String {
    match runtime::counters::HardwareCounters::of(std::process::id()) {
        Ok(_) => "available, see `run.workers` of `trolley rank --json`".to_owned(),
        Err(error) => match coordinator::Hardware::from(error) {
            coordinator::Hardware::NotAvailable(why) => {
                format!("{why}; transfer is counted by the ledger and by the channels")
            }
            coordinator::Hardware::Counted { .. } => String::new(),
        },
    }
}
