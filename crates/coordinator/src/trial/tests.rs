//! A short campaign: sound bounds pass it, unsound ones do not. The long one is `trolley certify`.

use super::*;
use crate::fixtures::with_policy;
use damage::Policy;

/// The policies that ship.
pub(crate) const POLICIES: [&str; 9] = [
    include_str!("../../config/policies/acceptable-or-brake.toml"),
    include_str!("../../config/policies/default.toml"),
    include_str!("../../config/policies/ego-only.toml"),
    include_str!("../../config/policies/precaution.toml"),
    include_str!("../../config/policies/uninvolved-first.toml"),
    include_str!("../../config/policies/vulnerable-first.toml"),
    include_str!("../../config/policies/weighted.toml"),
    include_str!("../../config/policies/worst-case-averse.toml"),
    include_str!("../../config/policies/worst-off-first.toml"),
];

fn campaign(seeds: u64, flaw: Option<BoundFlaw>) -> TrialResult {
    let mut all = TrialResult::default();
    for (number, text) in POLICIES.iter().enumerate() {
        let policy = Policy::parse("policy.toml", text).expect("sound");
        with_policy(policy, |request, bodies| {
            for seed in 0..seeds {
                let seed = seed * 100 + number as u64;
                let one = trial(request, bodies, 4, (seed, 30), flaw).expect("judged");
                all.stops += one.stops;
                all.certified += one.certified;
                all.open_intervals += one.open_intervals;
                all.violations.extend(one.violations);
            }
        });
    }
    all
}

#[test]
fn final_values_lie_in_every_earlier_interval() {
    let verdict = campaign(6, None);
    assert_eq!(verdict.violations, Vec::<String>::new());
    assert!(verdict.stops > 500, "{} stops are too few to tell", verdict.stops);
    assert!(verdict.certified > 20, "{} were certified early", verdict.certified);
    assert!(verdict.open_intervals > 5_000, "{} were open", verdict.open_intervals);
}

#[test]
fn unsound_bounds_are_caught() {
    for flaw in [BoundFlaw::ForgetsOpenPoses, BoundFlaw::TakesMiddles] {
        let verdict = campaign(1, Some(flaw));
        assert!(!verdict.violations.is_empty(), "{flaw:?} went unnoticed");
    }
}
