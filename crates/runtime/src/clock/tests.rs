//! Clocks go forwards, and CPU time is counted while it is used.

use super::*;

/// Uses so much CPU time of this thread, however long that takes.
fn burn(ns: u64) {
    let end = thread_cpu_ns() + ns;
    while thread_cpu_ns() < end {
        core::hint::spin_loop();
    }
}

#[test]
fn time_goes_forwards() {
    let times: Vec<u64> = (0..1000).map(|_| now_ns()).collect();
    assert!(times.is_sorted() && times[0] > 0);
    assert!(times[0] < times[999], "a thousand looks take more than a nanosecond");
}

#[test]
fn cpu_time_is_what_was_used() {
    let me = std::process::id();
    // The thread's clock is read last and first: what it shows lies within what the others show.
    let (other, process, thread) = (cpu_ns_of(me).unwrap(), process_cpu_ns(), thread_cpu_ns());
    burn(3_000_000);
    let used = thread_cpu_ns() - thread;
    assert!(process_cpu_ns() - process >= used);
    assert!(cpu_ns_of(me).unwrap() - other >= used, "seen from outside, without a 10 ms step");
    assert_eq!(cpu_ns_of(0x7fff_fff0), None);
}

#[test]
fn kernel_time_and_ours_are_the_same() {
    for ns in [0, 1, 999_999_999, 1_000_000_000, 123_456_789_012] {
        assert_eq!(nanoseconds(timespec(ns)), ns);
    }
}

#[test]
fn no_two_random_numbers_are_the_same() {
    let mut drawn: Vec<u64> = (0..100).map(|_| random_u64().unwrap()).collect();
    drawn.sort_unstable();
    drawn.dedup();
    assert_eq!(drawn.len(), 100);
}

#[test]
fn the_time_of_day_is_that_of_the_system() {
    let now = || std::time::SystemTime::UNIX_EPOCH.elapsed().unwrap().as_nanos() as u64;
    let (before, read, after) = (now(), time_of_day_ns(), now());
    assert!((before..=after).contains(&read), "{before} {read} {after}");
}
