//! Every source wakes the sleeper, and silence does not.

use super::*;
use crate::process::{Spawn, spawn};
use crate::{clock, futex};
use core::sync::atomic::{AtomicU32, Ordering};
use std::path::Path;
use std::sync::Arc;

const LONG: u64 = 20_000_000_000;

#[test]
fn bells_processes_and_silence_are_told_apart() {
    let poller = Poller::new().unwrap();
    let bell = EventFd::new().unwrap();
    poller.add_bell(&bell, 3).unwrap();
    let mut wakes = Vec::new();
    poller.wait(1_000, &mut wakes).unwrap();
    assert_eq!(wakes, []);
    bell.ring();
    bell.ring();
    poller.wait(LONG, &mut wakes).unwrap();
    assert_eq!(wakes, [Wake::Bell(3)]);
    bell.hush();
    let args = ["-c".to_owned(), "exit 0".to_owned()];
    let program = Path::new("/bin/sh");
    let spec = Spawn { program, name: "sh", args: &args, fds: &[], core: None };
    let mut child = spawn(&spec).unwrap();
    poller.add_process(&child, 5).unwrap();
    poller.wait(LONG, &mut wakes).unwrap();
    assert_eq!(wakes, [Wake::Process(5)]);
    child.wait_ns(LONG).unwrap();
    poller.remove_process(&child);
    poller.wait(1_000, &mut wakes).unwrap();
    assert_eq!(wakes, []);
}

#[test]
fn a_signal_is_an_event_while_the_poller_lives() {
    let mut poller = Poller::new().unwrap();
    poller.take_signals().unwrap();
    // To this thread alone: other tests run beside.
    // SAFETY: a system call on the calling thread, which blocks the signal.
    unsafe { libc::pthread_kill(libc::pthread_self(), libc::SIGTERM) };
    let mut wakes = Vec::new();
    poller.wait(LONG, &mut wakes).unwrap();
    assert_eq!(wakes, [Wake::Signal(libc::SIGTERM)]);
}

#[test]
fn a_futex_wakes_and_times_out() {
    let word = Arc::new(AtomicU32::new(0));
    let before = clock::now_ns();
    futex::wait(&word, 0, 2_000_000);
    assert!(clock::now_ns() - before >= 2_000_000);
    let theirs = Arc::clone(&word);
    let waker = std::thread::spawn(move || futex::wake(&theirs));
    while word.load(Ordering::SeqCst) == 0 {
        futex::wait(&word, 0, LONG);
    }
    waker.join().unwrap();
}
