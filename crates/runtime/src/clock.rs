//! The only clock: CLOCK_MONOTONIC and CPU time in nanoseconds; and the only source of randomness.
//!
//! The time of day is for signed statements alone: it may jump, and no answer depends on it.

use crate::error::{OsError, Result};
use rustix::time::{ClockId, Timespec, clock_gettime};

/// Nanoseconds on CLOCK_MONOTONIC: since some point before this process started.
#[must_use]
pub fn now_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::Monotonic))
}

/// The time of day, for people: nanoseconds since 1970-01-01 (UTC), as the machine's clock is set.
#[must_use]
pub fn time_of_day_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::Realtime))
}

/// CPU time that the calling thread has used \[ns\].
#[must_use]
pub fn thread_cpu_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::ThreadCPUTime))
}

/// CPU time that all threads of this process have used \[ns\].
#[must_use]
pub fn process_cpu_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::ProcessCPUTime))
}

/// CPU time that all threads of another process have used \[ns\]; `None` if there is none.
///
/// The kernel counts a running process up to now, so this moves while the process runs; the
/// figures under /proc move in steps of 10 ms.
#[must_use]
pub fn cpu_ns_of(pid: u32) -> Option<u64> {
    let pid = i32::try_from(pid).ok()?;
    let mut id = 0;
    // SAFETY: `id` is a valid place for the answer.
    if unsafe { libc::clock_getcpuclockid(pid, &raw mut id) } != 0 {
        return None;
    }
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `time` is a valid place for the answer; an id of a dead process gives an error.
    if unsafe { libc::clock_gettime(id, &raw mut time) } != 0 {
        return None;
    }
    Some(nanoseconds(Timespec { tv_sec: time.tv_sec, tv_nsec: time.tv_nsec }))
}

/// Sleeps for `ns`, or until a signal comes: for threads that nothing waits for.
pub fn nap_ns(length_ns: u64) {
    let _early = rustix::thread::nanosleep(&timespec(length_ns));
}

/// An unpredictable number: for the name of a run.
///
/// # Errors
///
/// If the kernel has no randomness to give: no getrandom(2), or a sandbox that forbids it.
pub fn random_u64() -> Result<u64> {
    let mut bytes = [0_u8; 8];
    // The kernel never interrupts a draw of up to 256 bytes, nor cuts it short.
    rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty())
        .map_err(OsError::at("draw", "random number"))?;
    Ok(u64::from_ne_bytes(bytes))
}

fn nanoseconds(time: Timespec) -> u64 {
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let rest = u64::try_from(time.tv_nsec).unwrap_or(0);
    seconds.saturating_mul(1_000_000_000).saturating_add(rest)
}

/// This time in the kernel's form.
pub(crate) fn timespec(ns: u64) -> Timespec {
    Timespec {
        tv_sec: i64::try_from(ns / 1_000_000_000).unwrap_or(i64::MAX),
        tv_nsec: i64::try_from(ns % 1_000_000_000).unwrap_or(0),
    }
}

#[cfg(test)]
mod tests;
