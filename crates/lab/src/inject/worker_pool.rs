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

/// All files and folders that an instance shares.
pub(super) fn names_of(instance: &str) -> Vec<String> {
    let shared = trolley::doctor::shared_folder();
    let mut folders = vec![shared.clone()];
    let mut names = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if folder == shared && !name.starts_with(&format!("trolley.{instance}.")) {
                continue;
            }
            names.push(name);
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(entry.path());
            }
        }
    }
    names
}
