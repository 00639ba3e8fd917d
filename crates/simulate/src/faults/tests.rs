//! Each kind of fault strikes, none leads to a wrong answer, and flaws are caught and shrunk.

use super::*;
use dispatch::DispatcherFlaw;

/// Worlds of this test; `cargo x soak` runs a thousand times as many.
const WORLDS: u64 = 5_000;

#[test]
fn whatever_strikes_the_laws_hold() {
    let mut sum = Tally::default();
    for seed in 0..WORLDS {
        match run(seed, &FaultLimits::default(), None) {
            Ok(tally) => sum.add(&tally),
            Err(violation) => panic!("{violation}: trolley simulate faults --seed {seed}"),
        }
    }
    for (fault, struck) in SimulatedFault::ALL.iter().zip(&sum.struck) {
        assert!(*struck > 50, "{fault} struck {struck} times only");
    }
    assert_eq!(sum.requests, 4 * WORLDS);
    assert!(sum.complete > WORLDS / 2 && sum.degraded > 100 && sum.refused > 10, "{sum:?}");
}

#[test]
fn each_kind_of_fault_alone_is_survived() {
    for fault in SimulatedFault::ALL {
        let limits = FaultLimits { kinds: Faults::NONE.with(*fault), ..FaultLimits::default() };
        let mut struck = 0;
        // A successor takes a worker that died before.
        let kinds = match fault {
            SimulatedFault::ExitedAtStart => limits.kinds.with(SimulatedFault::Crash),
            _ => limits.kinds,
        };
        let limits = FaultLimits { kinds, ..limits };
        for seed in 0..400 {
            let tally = run(seed, &limits, None).unwrap_or_else(|v| panic!("{fault}: {v}"));
            struck += tally.struck[*fault as usize];
        }
        assert!(struck > 0, "{fault} never struck");
    }
}

#[test]
fn without_faults_every_answer_is_complete() {
    let limits = FaultLimits { kinds: Faults::NONE, ..FaultLimits::default() };
    for seed in 0..500 {
        let tally = run(seed, &limits, None).unwrap();
        assert_eq!((tally.complete, tally.faults(), tally.deaths), (tally.requests, 0, 0));
    }
}

#[test]
fn equal_seeds_give_equal_worlds() {
    for seed in 0..50 {
        let [mut first, mut second] = [Vec::new(), Vec::new()];
        let tally = run(seed, &FaultLimits::default(), Some(&mut first));
        assert_eq!(tally, run(seed, &FaultLimits::default(), Some(&mut second)));
        assert_eq!(first, second);
    }
}

/// Prints how many seeds it takes: `cargo test -p simulate mistakes -- --nocapture`.
#[test]
fn deliberate_mistakes_are_caught_and_made_small() {
    for flaw in DispatcherFlaw::ALL {
        let limits = FaultLimits { flaw: Some(flaw), ..FaultLimits::default() };
        let caught = (0..WORLDS).find(|seed| run(*seed, &limits, None).is_err());
        let seed = caught.unwrap_or_else(|| panic!("{flaw:?} was not caught"));
        let shrunk = shrink(seed, &limits).unwrap();
        let struck: u64 = shrunk.violation.struck.iter().sum();
        println!("{flaw:?}: seed {seed}, {struck} fault(s): {}", shrunk.violation);
        assert!(struck <= 5, "{flaw:?} takes {struck} faults: {:?}", shrunk.limits);
    }
}
