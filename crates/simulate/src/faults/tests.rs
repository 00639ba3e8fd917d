//! Each kind of fault strikes, none is survived wrongly, and mistakes are caught and made small.

use super::*;
use dispatch::Flaw;

/// Worlds of this test; `cargo x soak` runs a thousand times as many.
const WORLDS: u64 = 5_000;

#[test]
fn whatever_strikes_the_laws_hold() {
    let mut sum = Tally::default();
    for seed in 0..WORLDS {
        match run(seed, &Limits::default(), None) {
            Ok(tally) => sum.add(&tally),
            Err(violation) => panic!("{violation}: trolley simulate faults --seed {seed}"),
        }
    }
    for (fault, struck) in Fault::ALL.iter().zip(&sum.struck) {
        assert!(*struck > 50, "{fault} struck {struck} times only");
    }
    assert_eq!(sum.requests, 4 * WORLDS);
    assert!(sum.complete > WORLDS / 2 && sum.degraded > 100 && sum.refused > 10, "{sum:?}");
}

#[test]
fn each_kind_of_fault_alone_is_survived() {
    for fault in Fault::ALL {
        let limits = Limits { kinds: Faults::NONE.with(*fault), ..Limits::default() };
        let mut struck = 0;
        // A successor takes a worker that died before.
        let kinds = match fault {
            Fault::ExitedAtStart => limits.kinds.with(Fault::Crash),
            _ => limits.kinds,
        };
        let limits = Limits { kinds, ..limits };
        for seed in 0..400 {
            let tally = run(seed, &limits, None).unwrap_or_else(|v| panic!("{fault}: {v}"));
            struck += tally.struck[*fault as usize];
        }
        assert!(struck > 0, "{fault} never struck");
    }
}

#[test]
fn without_faults_every_answer_is_complete() {
    let limits = Limits { kinds: Faults::NONE, ..Limits::default() };
    for seed in 0..500 {
        let tally = run(seed, &limits, None).unwrap();
        assert_eq!((tally.complete, tally.faults(), tally.deaths), (tally.requests, 0, 0));
    }
}

#[test]
fn equal_seeds_give_equal_worlds() {
    for seed in 0..50 {
        let [mut first, mut second] = [Vec::new(), Vec::new()];
        let tally = run(seed, &Limits::default(), Some(&mut first));
        assert_eq!(tally, run(seed, &Limits::default(), Some(&mut second)));
        assert_eq!(first, second);
    }
}

/// Prints how many seeds it took: `cargo test -p simulate mistakes -- --nocapture`.
#[test]
fn deliberate_mistakes_are_caught_and_made_small() {
    for flaw in Flaw::ALL {
        let limits = Limits { flaw: Some(flaw), ..Limits::default() };
        let caught = (0..WORLDS).find(|seed| run(*seed, &limits, None).is_err());
        let seed = caught.unwrap_or_else(|| panic!("{flaw:?} was not caught"));
        let shrunk = shrink(seed, &limits).unwrap();
        let struck: u64 = shrunk.violation.struck.iter().sum();
        println!("{flaw:?}: seed {seed}, {struck} fault(s): {}", shrunk.violation);
        assert!(struck <= 5, "{flaw:?} takes {struck} faults: {:?}", shrunk.limits);
    }
}
