//! Each source wakes, once for each reason, and none wakes after it was removed.

use super::*;
use crate::clock::now_ns;
use crate::process::{Exit, Spawn};
use std::path::Path;

const MS: u64 = 1_000_000;

fn wakes(poller: &mut Poller, timeout_ns: u64) -> Vec<Wake> {
    poller.wait(Some(timeout_ns)).unwrap().collect()
}

fn sleeper() -> Child {
    let args = ["1000".to_owned()];
    let program = Path::new("/bin/sleep");
    crate::process::spawn(Spawn { program, args: &args, fds: &[], core: None }).unwrap()
}

#[test]
fn nothing_happens_for_as_long_as_was_said() {
    let mut poller = Poller::new().unwrap();
    for ns in [0, 300_000, 2 * MS] {
        let start = now_ns();
        assert_eq!(wakes(&mut poller, ns), []);
        assert!(now_ns() - start >= ns);
    }
}

#[test]
fn an_event_wakes_after_each_ring() {
    let mut poller = Poller::new().unwrap();
    let (a, b) = (poller.add_event(1).unwrap(), poller.add_event(2).unwrap());
    a.notify();
    a.notify();
    assert_eq!(wakes(&mut poller, 1000 * MS), [Wake::Event(1)]);
    assert_eq!(wakes(&mut poller, 0), [], "emptied");
    a.notify();
    b.notify();
    let mut both = wakes(&mut poller, 1000 * MS);
    both.sort();
    assert_eq!(both, [Wake::Event(1), Wake::Event(2)]);
    b.notify();
    assert!(b.drain() && !b.drain());
    assert_eq!(wakes(&mut poller, 0), []);
}

#[test]
fn an_event_wakes_a_sleeper() {
    let mut poller = Poller::new().unwrap();
    let event = poller.add_event(5).unwrap();
    let far = std::thread::spawn(move || event.notify());
    assert_eq!(poller.wait(None).unwrap().next(), Some(Wake::Event(5)));
    far.join().unwrap();
}

#[test]
fn what_was_removed_or_replaced_is_silent() {
    let mut poller = Poller::new().unwrap();
    let old = poller.add_event(1).unwrap();
    let new = poller.add_event(1).unwrap();
    old.notify();
    assert_eq!(wakes(&mut poller, 0), []);
    new.notify();
    poller.remove_event(1);
    poller.remove_event(1);
    assert_eq!(wakes(&mut poller, 0), []);
}

#[test]
fn a_dead_child_is_reported_once_and_its_key_is_free_again() {
    let mut poller = Poller::new().unwrap();
    let mut first = sleeper();
    // An event with the same key is another thing.
    let event = poller.add_event(7).unwrap();
    poller.add_process(&first, 7).unwrap();
    assert_eq!(wakes(&mut poller, 0), []);
    first.kill().unwrap();
    assert_eq!(wakes(&mut poller, 30_000 * MS), [Wake::Process(7)]);
    assert_eq!(wakes(&mut poller, 0), [], "once, although it is not reaped");
    assert_eq!(first.try_wait().unwrap(), Some(Exit::Signal(libc::SIGKILL)));

    let second = sleeper();
    poller.add_process(&second, 7).unwrap();
    drop(first);
    assert_eq!(wakes(&mut poller, 0), []);
    second.kill().unwrap();
    assert_eq!(wakes(&mut poller, 30_000 * MS), [Wake::Process(7)]);

    let third = sleeper();
    poller.add_process(&third, 8).unwrap();
    poller.remove_process(8);
    drop(third);
    event.notify();
    assert_eq!(wakes(&mut poller, 0), [Wake::Event(7)]);
}

#[test]
fn the_timer_comes_at_its_time_and_once() {
    let mut poller = Poller::new().unwrap();
    let at = now_ns() + 3 * MS;
    poller.arm_ns(at).unwrap();
    assert_eq!(poller.wait(None).unwrap().collect::<Vec<_>>(), [Wake::Timer]);
    assert!(now_ns() >= at);
    assert_eq!(wakes(&mut poller, 0), []);

    poller.arm_ns(0).unwrap();
    assert_eq!(wakes(&mut poller, 1_000 * MS), [Wake::Timer], "the past is now");
    poller.arm_ns(now_ns() + 2 * MS).unwrap();
    poller.disarm().unwrap();
    assert_eq!(wakes(&mut poller, 4 * MS), []);
    poller.arm_ns(now_ns() + 100_000 * MS).unwrap();
    poller.arm_ns(now_ns() + MS).unwrap();
    assert_eq!(wakes(&mut poller, 1_000 * MS), [Wake::Timer], "the later arming counts");
}

#[test]
fn signals_are_reported_and_not_died_of() {
    let mut poller = Poller::new().unwrap();
    poller.catch_signals().unwrap();
    poller.catch_signals().unwrap();
    assert_eq!(wakes(&mut poller, 0), []);
    // SIGINT may be ignored, as in what a script starts with `&`.
    for number in super::signals::ending() {
        // SAFETY: to this thread, where it is blocked.
        assert_eq!(unsafe { libc::raise(number) }, 0);
        assert_eq!(wakes(&mut poller, 1_000 * MS), [Wake::Signal(number)]);
    }
    assert_eq!(wakes(&mut poller, 0), []);
}

#[test]
fn more_wake_ups_than_fit_come_with_the_next_wait() {
    let mut poller = Poller::new().unwrap();
    let count = 2 * WAKES_MAX as u32;
    let events: Vec<_> = (0..count).map(|key| poller.add_event(key).unwrap()).collect();
    events.iter().for_each(EventFd::notify);
    let mut seen = wakes(&mut poller, 0);
    seen.extend(wakes(&mut poller, 0));
    seen.sort();
    assert_eq!(seen, (0..count).map(Wake::Event).collect::<Vec<_>>());
}
