//! Which cores this process may use, staying on one of them, and calling somebody there.
//!
//! Cores have the kernel's numbers. Cores that are not allowed (a container's cpuset) are treated
//! as absent.

use crate::error::{OsError, Result};
use rustix::io::Errno;
use rustix::thread::{CpuSet, Pid, gettid, sched_getaffinity, sched_getcpu, sched_setaffinity};

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

/// Moves a thread, of this process or of another one, to a core, and lets it run on all of `cores`
/// again. Where it waits for its turn on another core, or takes the turn of somebody there, it goes
/// on here at once. Returns whether it was called: it is left alone where it may not run on all of
/// `cores` now, or on others too.
///
/// If this process dies in between, the thread stays on that core until it
/// [widens](widen_self) where it may run.
///
/// # Errors
///
/// If there is no such thread, it is somebody else's, or one of the cores is not allowed.
pub fn call(thread: u32, core: usize, cores: &[usize]) -> Result<bool> {
    let pid = i32::try_from(thread).ok().and_then(Pid::from_raw);
    let moved = pid.ok_or_else(|| std::io::Error::from(Errno::SRCH)).and_then(|pid| {
        let now = sched_getaffinity(Some(pid))?;
        let mut all = CpuSet::new();
        cores.iter().filter(|core| **core < CpuSet::MAX_CPU).for_each(|core| all.set(*core));
        if now != all {
            return Ok(false);
        }
        sched_setaffinity(Some(pid), &only(core)?)?;
        sched_setaffinity(Some(pid), &all)?;
        Ok(true)
    });
    moved.map_err(|source| OsError::new("call to core", core.to_string(), source))
}

/// The kernel's number of the calling thread.
#[must_use]
pub fn this_thread() -> u32 {
    gettid().as_raw_pid().unsigned_abs()
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
