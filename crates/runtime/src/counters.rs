//! Hardware counters of a process, where the kernel and the machine have any.
//!
//! They count from outside: the process knows nothing of it. Virtual machines often have none, and
//! `/proc/sys/kernel/perf_event_paranoid` above 2 forbids them: each case is an error with that
//! reason.

use crate::error::{OsError, Result};
use std::fs::File;
use std::io::{self, Read as _};
use std::os::fd::{FromRawFd as _, OwnedFd};

/// Counts of a process since its counters were opened, in user mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct HardwareCounts {
    /// Instructions retired.
    pub instructions: u64,
    /// Last-level cache misses, as the processor's own event defines them.
    pub cache_misses: u64,
}

/// The counters of one process: of its first thread.
#[derive(Debug)]
pub struct HardwareCounters {
    instructions: File,
    cache_misses: File,
}

/// The head of the kernel's `perf_event_attr`, as long as its first version.
#[repr(C)]
struct Attributes {
    kind: u32,
    size: u32,
    config: u64,
    sample_period: u64,
    sample_type: u64,
    read_format: u64,
    flags: u64,
    wakeup_events: u32,
    breakpoint_type: u32,
    config1: u64,
}

/// Type and number of an event, by `linux/perf_event.h`.
type Event = (u32, u64);
const INSTRUCTIONS: Event = (0, 1);
const CACHE_MISSES: Event = (0, 3);
/// Beside the count, the time that was asked for and the time that was counted.
const READ_FORMAT: u64 = 1 | 2;
/// Neither the kernel (bit 5) nor a hypervisor (bit 6).
const USER_ONLY: u64 = 1 << 5 | 1 << 6;

/// The flag of the call that keeps the descriptor from children.
const CLOSE_ON_EXEC: libc::c_ulong = 1 << 3;

impl HardwareCounters {
    /// Opens the counters of a process of the same user.
    ///
    /// # Errors
    ///
    /// If the machine has no such counters, or the kernel does not let this user have them.
    pub fn of(pid: u32) -> Result<Self> {
        let failed =
            |source| OsError::new("count instructions and cache misses of", name(pid), source);
        Ok(Self {
            instructions: open(pid, INSTRUCTIONS).map_err(failed)?,
            cache_misses: open(pid, CACHE_MISSES).map_err(failed)?,
        })
    }

    /// Counted so far; both only grow.
    ///
    /// # Errors
    ///
    /// If the kernel took a counter away.
    pub fn read(&self) -> Result<HardwareCounts> {
        let failed = |source| OsError::new("read the", "hardware counters", source);
        Ok(HardwareCounts {
            instructions: count(&self.instructions).map_err(failed)?,
            cache_misses: count(&self.cache_misses).map_err(failed)?,
        })
    }
}

fn name(pid: u32) -> String {
    format!("process {pid}")
}

fn open(pid: u32, (kind, config): Event) -> io::Result<File> {
    let attributes = Attributes {
        kind,
        size: size_of::<Attributes>() as u32,
        config,
        sample_period: 0,
        sample_type: 0,
        read_format: READ_FORMAT,
        flags: USER_ONLY,
        wakeup_events: 0,
        breakpoint_type: 0,
        config1: 0,
    };
    let pid = libc::pid_t::try_from(pid).map_err(io::Error::other)?;
    let (pid, any): (libc::c_long, libc::c_long) = (pid.into(), -1);
    // SAFETY: `attributes` outlives the call and is as long as it says; the kernel reads it alone.
    // The rest are numbers as wide as the call wants them: on any core, in no group.
    let fd = unsafe {
        let attributes = &raw const attributes;
        libc::syscall(libc::SYS_perf_event_open, attributes, pid, any, any, CLOSE_ON_EXEC)
    };
    let fd = i32::try_from(fd).ok().filter(|fd| *fd >= 0).ok_or_else(io::Error::last_os_error)?;
    // SAFETY: the kernel has just made this descriptor, and nothing else owns it.
    Ok(File::from(unsafe { OwnedFd::from_raw_fd(fd) }))
}

/// The count, stretched to the whole time where the counter had to share its place with others.
fn count(mut file: &File) -> io::Result<u64> {
    let mut bytes = [0; 24];
    file.read_exact(&mut bytes)?;
    let word = |at: usize| {
        let mut word = [0; 8];
        word.copy_from_slice(&bytes[at..at + 8]);
        u128::from(u64::from_ne_bytes(word))
    };
    let (value, asked_ns, counted_ns) = (word(0), word(8), word(16));
    Ok(u64::try_from(value * asked_ns / counted_ns.max(1)).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests;
