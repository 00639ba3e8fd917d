//! Cores: which there are for us, and staying on one.

use crate::{Doing as _, OsError};
use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};

/// The cores that this process may use, ascending.
///
/// # Errors
///
/// If the system does not say.
pub fn allowed_cores() -> Result<Vec<usize>, OsError> {
    let set = sched_getaffinity(None).doing(|| "read the allowed cores".to_owned())?;
    Ok((0..CpuSet::MAX_CPU).filter(|core| set.is_set(*core)).collect())
}

/// Keeps this thread, and what it starts, on one core.
///
/// # Errors
///
/// If there is no such core, or it is not ours.
pub fn pin_self(core: usize) -> Result<(), OsError> {
    let mut set = CpuSet::new();
    if core < CpuSet::MAX_CPU {
        set.set(core);
    }
    sched_setaffinity(None, &set).doing(|| format!("stay on core {core}"))
}

/// The core that this thread runs on just now.
#[must_use]
pub fn current_core() -> usize {
    sched_getcpu()
}
