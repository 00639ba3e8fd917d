//! Pinning, on whatever cores this machine allows.

use super::*;
use crate::clock::{nap_ns, now_ns};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[test]
fn a_pinned_thread_stays_where_it_is() {
    let cores = allowed_cores();
    assert!(!cores.is_empty() && cores.is_sorted());
    for core in cores {
        // A thread of its own: pinning lasts.
        let seen = std::thread::spawn(move || {
            pin_self(core).unwrap();
            (allowed_cores(), current_core())
        });
        assert_eq!(seen.join().unwrap(), (vec![core], Some(core)));
    }
}

#[test]
fn a_thread_on_one_core_may_run_on_more() {
    let all = allowed_cores();
    let (first, more) = (all[0], all.clone());
    let seen = std::thread::spawn(move || {
        pin_self(first).unwrap();
        // One core that is not there changes nothing.
        widen_self(&[usize::MAX]).unwrap();
        let alone = allowed_cores();
        widen_self(&more).unwrap();
        (alone, allowed_cores())
    });
    assert_eq!(seen.join().unwrap(), (vec![first], all));
}

#[test]
fn a_thread_that_is_called_goes_on_there_and_may_run_anywhere_again() {
    let cores = allowed_cores();
    let (tell, told) = std::sync::mpsc::channel();
    let (seen, is_over) = (AtomicUsize::new(usize::MAX), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let thread = scope.spawn(|| {
            tell.send(this_thread()).unwrap();
            // It works all the time, as one does that is called away from somebody's core.
            while !is_over.load(Ordering::SeqCst) {
                seen.store(current_core().unwrap_or(usize::MAX), Ordering::SeqCst);
            }
            allowed_cores()
        });
        let called = told.recv().unwrap();
        let end_ns = now_ns() + 20_000_000_000;
        for core in cores.iter().cycle().take(3 * cores.len()) {
            while seen.load(Ordering::SeqCst) != *core && now_ns() < end_ns {
                assert!(call(called, *core, &cores).unwrap());
                nap_ns(1_000_000);
            }
        }
        is_over.store(true, Ordering::SeqCst);
        assert!(now_ns() < end_ns, "it never got there");
        assert_eq!(thread.join().unwrap(), cores);
    });
}

#[test]
fn nobody_is_called_who_is_not_there() {
    let cores = allowed_cores();
    // Beyond the greatest number that the kernel gives.
    for thread in [0, 1 << 22, u32::MAX] {
        assert!(call(thread, cores[0], &cores).is_err(), "{thread}");
    }
    call(this_thread(), usize::MAX, &cores).expect_err("there is no such core");
    assert_eq!(allowed_cores(), cores);
}

#[test]
fn a_thread_that_stays_on_some_cores_is_left_alone() {
    let cores = allowed_cores();
    for core in cores.clone() {
        let all = cores.clone();
        let stays = move || {
            pin_self(core).unwrap();
            let called = all.iter().any(|to| call(this_thread(), *to, &all).unwrap());
            (called, allowed_cores())
        };
        let is_alone = cores.len() == 1;
        assert_eq!(std::thread::spawn(stays).join().unwrap(), (is_alone, vec![core]));
    }
}

#[test]
fn workers_get_cores_in_turn_and_share_those_there_are() {
    assert_eq!(in_turn(&[2, 5], 5), [2, 5, 2, 5, 2].map(Some));
    assert_eq!(in_turn(&[2, 5], 1), [Some(2)]);
    assert_eq!(in_turn(&[], 2), [None; 2]);
}

#[test]
fn a_core_that_is_not_there_is_an_error() {
    for core in [CpuSet::MAX_CPU - 1, CpuSet::MAX_CPU, usize::MAX] {
        let error = pin_self(core).unwrap_err();
        assert!(error.to_string().contains(&core.to_string()), "{error}");
    }
}
