//! A service whose answering thread stands still: it ends all the same when it is told to.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
#![cfg(feature = "lab")]

use crate::support::service::{Serving, deployment, left_behind, serve};
use crate::support::{Place, children, signal, skipped, wait_for};
use runtime::clock;
use runtime::process::{Frozen, may_trace};
use rustix::process::Signal;
use std::time::Duration;

const BODIES: &[(&str, u32, u32)] = &[("sedan", 2000, 0), ("wall", 600, 0)];
/// How long a service may take to end, whatever hangs in it.
const BOUND: Duration = Duration::from_secs(2);

/// How a service ends whose first thread is frozen, after what `tell` does; and how long that took.
fn frozen_and_told(extra: &[&str], tell: impl Fn(&Serving)) -> (Option<i32>, Duration) {
    let place = Place::new();
    let mut serving = serve(&deployment(&place, 2, BODIES), extra);
    let workers = children(serving.child.id());
    assert_eq!(workers.len(), if extra.is_empty() { 2 } else { 0 });
    let frozen = Frozen::first_thread(serving.child.id()).unwrap();
    let told_ns = clock::now_ns();
    tell(&serving);
    let status = wait_for(10_000, || serving.child.try_wait().unwrap());
    let lasted = Duration::from_nanos(clock::now_ns() - told_ns);
    drop(frozen);
    // One that has ended is a zombie until the first process of the machine reaps it.
    let alive = |pid: &u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        stat.rsplit_once(") ").is_some_and(|(_, rest)| !rest.starts_with(['Z', 'X']))
    };
    let gone = wait_for(1_000, || (!workers.iter().any(alive)).then_some(()));
    assert!(gone.is_some(), "workers are left");
    assert_eq!(left_behind(&serving.instance), Vec::<String>::new());
    (status.expect("it ends").code(), lasted)
}

// verifies REQ-END
#[test]
fn a_service_that_hangs_ends_within_two_seconds_of_a_signal_and_leaves_nothing() {
    if !may_trace() {
        return skipped("a service that hangs: this machine does not permit ptrace");
    }
    for extra in [&[][..], &["--in-process"]] {
        let terminate = |serving: &Serving| signal(serving.child.id(), Signal::TERM);
        let (code, lasted) = frozen_and_told(extra, terminate);
        assert_eq!(code, Some(128 + 15), "{extra:?}");
        assert!(lasted < BOUND, "{extra:?}: {lasted:?}");
    }
}

#[test]
fn a_second_signal_ends_a_service_that_hangs_at_once() {
    if !may_trace() {
        return skipped("a service that hangs: this machine does not permit ptrace");
    }
    let (code, lasted) = frozen_and_told(&[], |serving| {
        signal(serving.child.id(), Signal::TERM);
        wait_for::<()>(300, || None);
        signal(serving.child.id(), Signal::TERM);
    });
    assert_eq!(code, Some(128 + 15));
    assert!(lasted < Duration::from_millis(1_300), "{lasted:?}");
}
