//! A counter counts what its process does; where there is none, that is said.

use super::*;
use crate::clock::thread_cpu_ns;

/// CPU time in nanoseconds: a software event that every kernel has.
const TASK_CLOCK: Event = (1, 1);

#[test]
fn a_counter_counts_what_this_process_does() {
    // Sandboxes without perf events at all have nothing to test here.
    let Ok(counter) = open(std::process::id(), TASK_CLOCK) else { return };
    // It counts the first thread, which only waits for this one: opened again for this thread.
    drop(counter);
    let own = rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs();
    let counter = open(own, TASK_CLOCK).expect("as above");
    let before = count(&counter).expect("it can be read");
    let begun_ns = thread_cpu_ns();
    while thread_cpu_ns() < begun_ns + 20_000_000 {
        core::hint::spin_loop();
    }
    let counted_ns = count(&counter).expect("it can be read") - before;
    assert!(counted_ns > 10_000_000, "{counted_ns} ns of 20 ms");
}

#[test]
fn hardware_counters_count_or_say_why_not() {
    let own = rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs();
    match HardwareCounters::of(own) {
        Ok(counters) => {
            let first = counters.read().expect("they can be read");
            let second = counters.read().expect("they can be read");
            assert!(second.instructions > first.instructions, "{first:?} {second:?}");
        }
        Err(error) => {
            assert!(error.to_string().contains(&format!("process {own}")), "{error}");
            assert!(error.errno().is_some(), "the kernel gives a reason: {error:?}");
        }
    }
    assert!(HardwareCounters::of(u32::MAX).is_err(), "no process has this number");
}
