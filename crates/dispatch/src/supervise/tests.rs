//! Invariants of supervision: a worker that progresses, rests or waits survives; one that stands
//! still is detected in time.

use super::*;
use proptest::prelude::*;

const MS: u64 = 1_000_000;

proptest! {
    #[test]
    fn a_worker_that_beats_or_has_nothing_to_do_is_never_killed(
        looks in prop::collection::vec((1_u64..10_000, any::<bool>(), any::<bool>()), 1..60),
    ) {
        let (mut watch, mut now, mut beat) = (Watch::default(), 0, 0);
        for (gap, stopped, busy) in looks {
            now += gap * MS;
            beat += u64::from(busy);
            let pulse = Pulse { beat, cpu_ns: now, stopped, busy };
            prop_assert_eq!(watch.look(pulse, now, &Patience::default()), Liveness::Alive);
        }
    }

    #[test]
    fn a_busy_worker_that_stands_still_is_found_within_the_bound(
        every in 1_u64..50, stopped in any::<bool>(), share in 0_u64..=100,
    ) {
        let (mut watch, patience) = (Watch::default(), Patience::default());
        let mut now = 0;
        let verdict = loop {
            let pulse = Pulse { beat: 7, cpu_ns: now * share / 100, stopped, busy: true };
            match watch.look(pulse, now, &patience) {
                Liveness::Alive => now += every * MS,
                verdict => break verdict,
            }
        };
        prop_assert!(now <= patience.silent_ns + every * MS);
        let expected = if stopped {
            Liveness::Stopped
        } else if share >= 26 {
            Liveness::Hung
        } else {
            Liveness::Silent
        };
        prop_assert!(verdict == expected || share < 28, "{verdict:?} at {share} %");
    }
}

#[test]
fn a_worker_that_waits_for_its_core_is_given_time() {
    let mut watch = Watch::default();
    for now in [0, 300 * MS, 900 * MS, 1_900 * MS] {
        let pulse = Pulse { beat: 1, cpu_ns: 5, stopped: false, busy: true };
        assert_eq!(watch.look(pulse, now, &Patience::default()), Liveness::Alive);
    }
}

/// Found by `cargo mutants`: that it is found in time had been asked, not that it is not too early.
#[test]
fn a_worker_that_is_stopped_has_some_time_to_go_on() {
    let (mut watch, patience) = (Watch::default(), Patience::default());
    let pulse = Pulse { beat: 7, cpu_ns: 0, stopped: true, busy: true };
    let mut looks = |now| watch.look(pulse, now, &patience);
    assert_eq!([looks(0), looks(patience.stopped_ns - 1)], [Liveness::Alive; 2]);
    assert_eq!(looks(patience.stopped_ns), Liveness::Stopped);
}

#[test]
fn reports_name_each_state_as_it_is() {
    let all = [Liveness::Alive, Liveness::Stopped, Liveness::Hung, Liveness::Silent];
    for state in all {
        assert_eq!(state.name(), format!("{state:?}").to_lowercase());
    }
}

/// When a start is given up that looks the same every `every_ms` from its beginning, and why.
fn given_up(pulse: impl Fn(u64) -> StartPulse, every_ms: u64) -> (u64, Liveness) {
    let (mut watch, patience) = (StartWatch::new(0), StartPatience::default());
    (0..)
        .map(|look| look * every_ms * MS)
        .map(|now| (now, watch.look(pulse(now), now, &patience)))
        .find(|(_, verdict)| *verdict != Liveness::Alive)
        .expect("every start ends")
}

proptest! {
    #[test]
    fn every_start_ends_and_sooner_the_less_it_moves(every_ms in 1_u64..50, from in 0_u64..2_000) {
        let most = every_ms * MS;
        let still = |stopped, runnable| move |_| StartPulse { cpu_ns: 7, stopped, runnable };
        let (at, why) = given_up(still(true, false), every_ms);
        prop_assert!(why == Liveness::Stopped && at <= 100 * MS + most, "{at}");
        let (at, why) = given_up(still(false, false), every_ms);
        prop_assert!(why == Liveness::Silent && 2 * at <= 2_000 * MS && at >= 800 * MS, "{at}");
        // One that waits for its core, or runs, has time, but not for ever.
        let (at, why) = given_up(still(false, true), every_ms);
        prop_assert!(why == Liveness::Hung && (20_000 * MS..20_000 * MS + most).contains(&at));
        let runs = |now| StartPulse { cpu_ns: now / 100, stopped: false, runnable: false };
        prop_assert_eq!(given_up(runs, every_ms), (at, Liveness::Hung));
        // Whatever it did before, being stopped is noticed at once.
        let later = |now| StartPulse { cpu_ns: now, stopped: now >= from * MS, runnable: true };
        let (at, why) = given_up(later, every_ms);
        prop_assert!(why == Liveness::Stopped && at <= (from + 100) * MS + 2 * most, "{at}");
    }
}
