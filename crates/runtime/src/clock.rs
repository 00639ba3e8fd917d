//! Time and chance: CLOCK_MONOTONIC, CPU time, and random numbers of the system.

use rustix::time::{ClockId, clock_gettime};

fn read(clock: ClockId) -> u64 {
    let time = clock_gettime(clock);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

/// Monotonic time [ns].
#[must_use]
pub fn now_ns() -> u64 {
    read(ClockId::Monotonic)
}

/// CPU time of this thread [ns].
#[must_use]
pub fn thread_cpu_ns() -> u64 {
    read(ClockId::ThreadCPUTime)
}

/// A random number from the system; where it gives none, one from clock and process id.
#[must_use]
pub fn random_u64() -> u64 {
    let mut bytes = [0; 8];
    match rustix::rand::getrandom(&mut bytes, rustix::rand::GetRandomFlags::empty()) {
        Ok(8) => u64::from_le_bytes(bytes),
        _ => now_ns().rotate_left(32) ^ u64::from(std::process::id()),
    }
}
