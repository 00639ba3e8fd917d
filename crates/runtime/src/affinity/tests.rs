//! Pinning, on whatever cores this machine allows.

use super::*;

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
