//! Which cores the coordinator and its workers run on.

use crate::Failure;
use runtime::affinity;
use scenario::{Cores, EngineSettings as Settings};

/// Pins this process to the core that the settings name for the coordinator, if they name one.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// // The scenario names no core for the coordinator, so it is not pinned.
/// trolley::pin_coordinator(&scenario.parsed().engine)?;
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If this process may not use that core.
pub fn pin_coordinator(settings: &Settings) -> Result<(), Failure> {
    let Some(core) = settings.coordinator_core else { return Ok(()) };
    affinity::pin_self(usize::from(core)).map_err(|error| {
        Failure::setting(diagnostic::chain(&error))
            .with_remedy("choose a core that this process may use: taskset -p $$")
    })
}

/// Returns the core of each worker; `None` means not pinned. `granted` lists the allowed cores.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// let engine = &scenario.parsed().engine;
/// let cores = trolley::worker_cores(engine, &[0, 1, 2, 3])?;
/// assert_eq!(cores.len(), engine.workers);
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If a core is named that this process may not use.
pub fn worker_cores(settings: &Settings, granted: &[usize]) -> Result<Vec<Option<usize>>, Failure> {
    match &settings.cores {
        Cores::Unpinned => Ok(vec![None; settings.workers]),
        Cores::Granted => Ok(affinity::in_turn(granted, settings.workers)),
        Cores::Listed(cores) => {
            let cores = cores.iter().map(|core| usize::from(*core));
            if let Some(core) = cores.clone().find(|core| !granted.contains(core)) {
                let what = format!("core {core} is not one that this process may use");
                return Err(Failure::setting(what).with_remedy(format!(
                    "cores granted here: {granted:?}; see taskset and cpusets"
                )));
            }
            Ok(cores.map(Some).collect())
        }
    }
}
