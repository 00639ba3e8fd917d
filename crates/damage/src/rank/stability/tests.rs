//! Worked flips of K1 to K3, and the law that a flip is one: the winner changes there, not before.

use super::*;
use crate::curve::Dose;
use crate::injury::Curves;
use crate::rank::tests::{
    among, k, level, policies, policy, ranked, risks, settled, stakes, weighted,
};
use proptest::prelude::*;

fn of(policy: &Policy, candidates: &[CandidateHarm]) -> Stability {
    let stakes = stakes(candidates[0].persons.len());
    let policy = &*among(policy, candidates.len());
    let in_use = |curve: &&Curve| {
        let mut persons = candidates.iter().flat_map(|harm| &harm.persons);
        persons.any(|person| *person.curve == *curve.id)
    };
    let all = Curves::shipped().expect("sound").curves;
    let curves: Vec<Curve> = all.iter().filter(in_use).cloned().collect();
    let with_curve = |curve: &Curve| candidates.iter().map(|harm| harm.with_curve(curve)).collect();
    stability(policy, &stakes, candidates, &curves, &with_curve).expect("sound candidates")
}

fn reserve(stability: &Stability, knob: &Knob) -> Reserve {
    stability.reserves.iter().find(|r| r.knob == *knob).expect("it is moved").clone()
}

#[test]
fn k_only_the_weight_of_bayes_flips_a_weighted_winner() {
    let stability = of(&weighted(0.5, 0.2, 0.3), &k());
    assert_eq!(stability.winner, Some(1));
    let bayes = reserve(&stability, &Knob::Weight { rule: Rule::Bayes });
    assert!((bayes.flips_at.expect("it flips") - 0.928_57).abs() < 1e-5, "{bayes:?}");
    assert_eq!(bayes.winner, Some(2));
    for rule in [Rule::Equality, Rule::Maximin] {
        assert_eq!(reserve(&stability, &Knob::Weight { rule }).flips_at, None, "{rule:?}");
    }
    // 0.21 - 0.15: within a tolerance of as much the third comes into reach, and property decides.
    assert_eq!(stability.margins[0].next, Some((2, 0.21)));
}

#[test]
fn k_an_accepted_risk_flips_where_the_next_becomes_acceptable() {
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.3\n";
    let policy = policy("lexicographic", &(first.to_owned() + &level("bayes", 0.0)));
    let accept = reserve(&of(&policy, &k()), &Knob::Accept { level: 0 });
    assert_eq!((accept.flips_at, accept.winner), (Some(0.35), Some(2)));
}

/// A value may be the very place: below it the third is not acceptable any more.
#[test]
fn k_an_accepted_risk_may_lie_where_it_flips() {
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.35\n";
    let policy = policy("lexicographic", &(first.to_owned() + &level("bayes", 0.0)));
    let stability = of(&policy, &k());
    assert_eq!(stability.winner, Some(2));
    let accept = reserve(&stability, &Knob::Accept { level: 0 });
    assert_eq!((accept.flips_at, accept.winner), (Some(0.35), Some(1)));
}

/// Between refusing and letting somebody win lies a flip as well.
#[test]
fn k_a_refusal_flips_where_somebody_becomes_acceptable() {
    let first = "[[level]]\nrule = \"precaution\"\naccept = 0.1\notherwise = \"refuse\"\n";
    let policy = policy("lexicographic", &(first.to_owned() + &level("bayes", 0.0)));
    let stability = of(&policy, &k());
    assert_eq!(stability.winner, None);
    let accept = reserve(&stability, &Knob::Accept { level: 0 });
    assert_eq!((accept.flips_at, accept.winner), (Some(0.2), Some(1)));
}

#[test]
fn a_tolerance_flips_where_the_next_comes_within_reach() {
    let two = level("bayes", 0.0) + &level("maximin", 0.0);
    let stability = of(&policy("lexicographic", &two), &k());
    assert_eq!(stability.winner, Some(2));
    let bayes = reserve(&stability, &Knob::Tolerance { level: Some(0) });
    assert!((bayes.flips_at.expect("it flips") - 0.01).abs() < 1e-8, "{bayes:?}");
    assert_eq!(bayes.winner, Some(1));
}

/// Two pedestrians, struck at 12 m/s and one and a half times as fast, and one occupant.
#[test]
fn a_curve_flips_where_its_own_risks_overtake() {
    let curves = Curves::shipped().expect("sound");
    let curve = |id: &str| curves.curves.iter().find(|c| *c.id == *id).expect("shipped").clone();
    let with = |id: &str, v: f64| {
        let mut harm = settled(&[curve(id).risk(Dose::at(v))]);
        harm.persons[0].curve = id.into();
        harm.persons[0].x_m_s = Interval::exactly(v);
        harm
    };
    let candidates = [with("lubbe-pedestrian", 12.0), with("wang-frontal", 15.0)];
    let policy = policy("lexicographic", &level("bayes", 0.0));
    let stability = of(&policy, &candidates);
    assert_eq!(stability.winner, Some(1));
    for id in ["lubbe-pedestrian", "wang-frontal"] {
        let reserve = reserve(&stability, &Knob::Intercept { curve: id.to_owned() });
        let a = reserve.flips_at.expect("it flips");
        let moved = |own: &str, v: f64| {
            let own = curve(own);
            Curve { a: if *own.id == *id { a } else { own.a }, ..own }.risk(Dose::at(v))
        };
        let gap = moved("lubbe-pedestrian", 12.0) - moved("wang-frontal", 15.0);
        assert!(gap.abs() < 1e-8, "{id}: {gap}");
        assert_eq!(reserve.winner, Some(0));
        let reserve = self::reserve(&stability, &Knob::Slope { curve: id.to_owned() });
        let b = reserve.flips_at.expect("it flips");
        let moved = |own: &str, v: f64| {
            let own = curve(own);
            Curve { b: if *own.id == *id { b } else { own.b }, ..own }.risk(Dose::at(v))
        };
        let gap = moved("lubbe-pedestrian", 12.0) - moved("wang-frontal", 15.0);
        assert!(gap.abs() < 1e-8, "{id}: {gap}");
        assert_eq!(reserve.winner, Some(0));
    }
}

/// Of flips either way the nearer one counts: against a search in steps of a thousandth.
#[test]
fn of_two_flips_of_a_curve_the_nearer_one_counts() {
    let all = Curves::shipped().expect("sound").curves;
    let curve = all.iter().find(|c| *c.id == *"lubbe-pedestrian").expect("shipped");
    let risk_at = |v: f64| curve.risk(Dose::at(v));
    // The first is both on the curve, the second one of them, the third none.
    let with = |on_curve: &[f64], fixed: &[f64]| {
        let risks: Vec<f64> =
            on_curve.iter().map(|v| risk_at(*v)).chain(fixed.iter().copied()).collect();
        let mut harm = settled(&risks);
        for (person, v) in harm.persons.iter_mut().zip(on_curve) {
            person.curve = curve.id.clone();
            person.x_m_s = Interval::exactly(*v);
        }
        harm
    };
    let policy = policy("lexicographic", &level("bayes", 0.0));
    let mut sides = [0, 0];
    for above in [0.01, 0.03, 0.1, 0.2] {
        let own = risk_at(14.0);
        let low = own - 0.02;
        let candidates =
            [with(&[14.0, 14.0], &[]), with(&[14.0], &[low]), with(&[], &[own, low + above])];
        let stability = of(&policy, &candidates);
        assert_eq!(stability.winner, Some(1));
        let knob = Knob::Intercept { curve: curve.id.to_string() };
        let flips_at = reserve(&stability, &knob).flips_at.expect("it flips");
        let winner = |a: f64| {
            let moved = Curve { a, ..curve.clone() };
            let moved: Vec<_> = candidates.iter().map(|harm| harm.with_curve(&moved)).collect();
            ranked(&policy, &moved).places[0].candidate
        };
        let mut steps = (1..6_000).map(|step| 1e-3 * f64::from(step));
        let nearest = steps
            .find_map(|by| [-by, by].into_iter().find(|by| winner(curve.a + by) != 1))
            .expect("it flips");
        assert!((flips_at - curve.a - nearest).abs() <= 1e-3, "{flips_at} {nearest}");
        sides[usize::from(nearest > 0.0)] += 1;
    }
    assert!(sides.iter().all(|count| *count > 0), "{sides:?}");
}

/// A sum is followed by itself without its tolerance, so that flips nothing.
#[test]
fn a_tolerance_flips_the_worst_off_and_no_sum() {
    let tolerance = Knob::Tolerance { level: None };
    let worst_off = reserve(&of(&policy("leximin", ""), &k()), &tolerance);
    assert!((worst_off.flips_at.expect("it flips") - 0.15).abs() < 1e-8, "{worst_off:?}");
    assert_eq!(worst_off.winner, Some(2));
    let [first, second, third] = k();
    let third = CandidateHarm { energy_j: Interval::exactly(500.0), ..third };
    let sum = reserve(&of(&weighted(0.5, 0.2, 0.3), &[first, second, third]), &tolerance);
    assert_eq!(sum.flips_at, None);
}

/// A weight flips where sums are equal, whatever the tolerance and whoever comes first.
#[test]
fn a_weight_flips_where_sums_are_equal() {
    let a = settled(&[0.3, 0.3, 0.3, 0.3, 0.0, 0.0]);
    let b = settled(&[0.6, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let b = CandidateHarm { energy_j: Interval::exactly(500.0), ..b };
    let terms = ["bayes", "maximin"].map(|r| format!("[[term]]\nrule = \"{r}\"\nweight = 0.5\n"));
    for tolerance in ["", "tolerance = 0.05\n"] {
        let policy = policy("weighted", &(tolerance.to_owned() + &terms.concat()));
        for (candidates, winner) in [([a.clone(), b.clone()], 0), ([b.clone(), a.clone()], 1)] {
            let stability = of(&policy, &candidates);
            assert_eq!(stability.winner, Some(winner));
            let bayes = reserve(&stability, &Knob::Weight { rule: Rule::Bayes });
            assert!((bayes.flips_at.expect("it flips") - 0.75).abs() < 1e-8, "{bayes:?}");
            assert_eq!(bayes.winner, Some(1 - winner));
        }
    }
}

/// The others could not keep their proportions: they have none.
#[test]
fn a_weight_that_is_alone_is_not_moved() {
    let stability = of(&weighted(1.0, 0.0, 0.0), &k());
    let is_of_bayes = |r: &Reserve| r.knob == Knob::Weight { rule: Rule::Bayes };
    assert!(!stability.reserves.iter().any(is_of_bayes));
    assert!(reserve(&stability, &Knob::Weight { rule: Rule::Maximin }).flips_at.is_some());
}

proptest! {
    /// On the value's side of a flip the winner stays, on the other it does not.
    #[test]
    fn a_flip_of_a_weight_or_tolerance_is_one(policy in policies(), risks in risks()) {
        let candidates: Vec<_> = risks.iter()
            .map(|person| settled(&person.iter().map(|r| r.0).collect::<Vec<_>>())).collect();
        let stability = of(&policy, &candidates);
        let winner = |policy: &Policy| {
            let ranking = ranked(policy, &candidates);
            (!ranking.is_refused()).then(|| ranking.places[0].candidate)
        };
        prop_assert_eq!(stability.winner, winner(&policy));
        for reserve in &stability.reserves {
            let Some(at) = reserve.flips_at else { continue };
            let with = |x: f64| match (&reserve.knob, &policy.composition) {
                (Knob::Weight { rule }, Composition::Weighted { terms, tolerance }) => {
                    let term = Term { rule: *rule, weight: reserve.value };
                    let (terms, tolerance) = (reweighed(terms, term, x), *tolerance);
                    let composition = Composition::Weighted { terms, tolerance };
                    Some(Policy { composition, ..policy.clone() })
                }
                (Knob::Tolerance { level: Some(level) }, _) => {
                    let mut policy = policy.clone();
                    let Step::Least { tolerance, .. } = &mut policy.levels[*level] else {
                        return None;
                    };
                    *tolerance = x;
                    Some(policy)
                }
                _ => None,
            };
            let inside = with(reserve.value + 0.999 * (at - reserve.value));
            if let Some(inside) = inside.filter(|_| (at - reserve.value).abs() > 1e-6) {
                prop_assert_eq!(winner(&inside), stability.winner, "{:?}", reserve);
            }
        }
    }
}
