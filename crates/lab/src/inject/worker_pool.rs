//! Worker pools for fault injection: how they are started, and what they leave behind.

use super::plan::Plan;
use coordinator::Options;
use dispatch::Intensity;
use runtime::affinity;
use trolley::BUILD;

/// Options of a worker pool for fault injection.
pub(super) fn options(plan: &Plan, instance: &str) -> Options {
    let cores = affinity::in_turn(&affinity::allowed_cores(), plan.workers.into());
    Options { intensity: Intensity::UNLIMITED, obeys: true, ..Options::new(instance, BUILD, cores) }
}

/// What shared memory holds of an instance.
pub(super) fn names_of(instance: &str) -> Vec<String> {
    let entries =
        std::fs::read_dir(trolley::doctor::shared_folder()).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(&format!("trolley.{instance}."))).collect()
}
