//! Sleeping and waking, between threads and between processes.

use super::*;
use crate::clock::now_ns;
use crate::memory::StatusMemory;
use crate::testing;
use core::sync::atomic::Ordering;

#[test]
fn a_word_that_has_changed_is_not_waited_for() {
    assert_eq!(wait(&AtomicU32::new(4), 5, None), Waited::Changed);
}

#[test]
fn nobody_wakes_us_and_time_is_up() {
    let start = now_ns();
    assert_eq!(wait(&AtomicU32::new(5), 5, Some(3_000_000)), Waited::TimedOut);
    assert!(now_ns() - start >= 3_000_000);
}

/// The child sleeps on a word of the page; the parent changes it and wakes. If that needed the
/// time-out, the child's test fails.
#[test]
fn a_process_wakes_another() {
    if let Some(fd) = testing::handed_over() {
        let memory = StatusMemory::from_fd(fd).unwrap();
        let (line, answer) = (&memory.page().coordinator[2], &memory.page().workers[2]);
        answer.sleeping.store(1, Ordering::SeqCst);
        while line.wake.load(Ordering::SeqCst) == 0 {
            assert_ne!(wait(&line.wake, 0, Some(10_000_000_000)), Waited::TimedOut);
        }
        answer.beat.store(99, Ordering::SeqCst);
        return;
    }
    let memory = StatusMemory::create().unwrap();
    let page = memory.page();
    let mut child = testing::again("futex::tests::a_process_wakes_another", memory.fd());
    let pid = child.pid();
    // Until it sleeps in the kernel, or a second has passed: both must work.
    let end = now_ns() + 1_000_000_000;
    while page.workers[2].sleeping.load(Ordering::SeqCst) == 0
        && child.try_wait().unwrap().is_none()
    {
        std::thread::yield_now();
    }
    let asleep = || crate::process::stat(pid).is_some_and(|stat| stat.state == 'S');
    while !asleep() && now_ns() < end {
        std::thread::yield_now();
    }
    page.coordinator[2].wake.store(1, Ordering::SeqCst);
    wake(&page.coordinator[2].wake);
    testing::must_pass(child);
    assert_eq!(page.workers[2].beat.load(Ordering::SeqCst), 99);
}
