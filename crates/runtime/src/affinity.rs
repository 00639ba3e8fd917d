//! Which cores this process may use, and staying on one of them.
//!
//! Cores have the kernel's numbers. Cores that are not allowed (a container's cpuset) are treated
//! as absent.

use crate::error::{OsError, Result};
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// The cores that the calling thread may run on, ascending; empty if the kernel does not say.
#[must_use]
pub fn allowed_cores() -> Vec<usize> {
    let Ok(set) = sched_getaffinity(None) else { return Vec::new() };
    (0..CpuSet::MAX_CPU).filter(|core| set.is_set(*core)).collect()
}

/// Cores for a number of workers: assigned in turn, starting over at the first when they run out.
/// `None`, wherever the system puts it, if no core is known.
#[must_use]
pub fn in_turn(cores: &[usize], workers: usize) -> Vec<Option<usize>> {
    let core = |worker: usize| cores.get(worker % cores.len().max(1)).copied();
    (0..workers).map(core).collect()
}

/// The core that the calling thread ran on a moment ago.
#[must_use]
pub fn current_core() -> Option<usize> {
    let core = sched_getcpu();
    (core < CpuSet::MAX_CPU).then_some(core)
}

/// Keeps the calling thread, and the threads and children it starts later, on one core.
///
/// # Errors
///
/// If there is no such core, or it is not allowed, or it is offline.
pub fn pin_self(core: usize) -> Result<()> {
    only(core)
        .and_then(|set| Ok(sched_setaffinity(None, &set)?))
        .map_err(|source| OsError::new("pin to core", core.to_string(), source))
}

/// Lets the calling thread run on these cores too, besides those where it may.
///
/// # Errors
///
/// If none of all these is allowed.
pub fn widen_self(cores: &[usize]) -> Result<()> {
    let widened = sched_getaffinity(None).and_then(|mut set| {
        cores.iter().filter(|core| **core < CpuSet::MAX_CPU).for_each(|core| set.set(*core));
        sched_setaffinity(None, &set)
    });
    widened.map_err(OsError::at("widen to cores", "those of workers"))
}

/// The set of this core alone.
pub(crate) fn only(core: usize) -> std::io::Result<CpuSet> {
    if core >= CpuSet::MAX_CPU {
        return Err(std::io::ErrorKind::InvalidInput.into());
    }
    let mut set = CpuSet::new();
    set.set(core);
    Ok(set)
}

#[cfg(test)]
mod tests;
