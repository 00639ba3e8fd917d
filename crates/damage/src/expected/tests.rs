//! Means hold what their members hold, and spreads are those of worked examples.

use super::*;
use crate::party::PersonId;
use crate::rank::rank;

fn harm(risks: &[f64]) -> CourseHarm {
    let person = |(id, risk): (usize, &f64)| Risk {
        id: PersonId(id),
        work: Interval::exactly(*risk),
        range: Range::new(0.5 * risk, (2.0 * risk).min(1.0)),
        high: Interval::exactly((2.0 * risk).min(1.0)),
    };
    let persons = risks.iter().enumerate().filter(|(_, risk)| **risk > 0.0).map(person).collect();
    CourseHarm { persons, energy_j: Interval::exactly(100.0), ..CourseHarm::none() }
}

fn stakes() -> Vec<Stake> {
    vec![Stake { is_ego: true, ..Stake::default() }, Stake::default()]
}

#[test]
fn a_mean_is_of_persons() {
    let courses = [harm(&[0.2, 0.0]), harm(&[0.0, 0.4]), harm(&[0.1, 0.0]), harm(&[0.0, 0.0])];
    let mean = mean(courses.iter());
    let risks: Vec<f64> = mean.persons.iter().map(|risk| risk.work.hi()).collect();
    assert!((risks[0] - 0.075).abs() < 1e-15 && (risks[1] - 0.1).abs() < 1e-15, "{risks:?}");
    assert_eq!((mean.energy_j, mean.is_open), (Interval::exactly(100.0), false));
    assert!((mean.persons[1].range.high() - 0.2).abs() < 1e-15);
}

/// A single course is its own mean, to the bit.
#[test]
fn of_one_it_is_the_same() {
    let course = harm(&[0.1 + 0.2, 1.0 / 3.0]);
    assert_eq!(mean([&course].into_iter()), course);
}

/// Whatever open work finds, the mean of what it finds is in the mean of the bounds.
#[test]
fn what_is_open_stays_within_the_mean() {
    let mut open = harm(&[0.2, 0.0]);
    open.leave_open([PersonId(0), PersonId(1)].into_iter(), 50.0);
    let bound = mean([&harm(&[0.1, 0.3]), &open].into_iter());
    assert!(bound.is_open);
    for found in [[0.2, 0.0], [0.9, 0.4], [1.0, 1.0]] {
        let mut end = harm(&found);
        end.energy_j = Interval::exactly(150.0);
        let end = mean([&harm(&[0.1, 0.3]), &end].into_iter());
        for (bound, end) in bound.persons.iter().zip(&end.persons) {
            assert!(bound.work.lo() <= end.work.lo() && end.work.hi() <= bound.work.hi());
            assert!(end.range.high() <= bound.range.high());
        }
        assert!(end.energy_j.hi() <= bound.energy_j.hi());
    }
}

#[test]
fn spreads_are_those_of_a_worked_example() {
    let policy = Policy::shipped().expect("sound");
    // Of two persons: candidate 0 has mean risks 0.1, 0.3, 0.1, 0.1; candidate 1 always 0.2.
    let member = |risk: f64| vec![harm(&[risk, risk]), harm(&[0.2, 0.2])];
    let harms = [member(0.1), member(0.3), member(0.1), member(0.1)];
    let spreads = spreads(&policy, &stakes(), &harms, &[0, 1]).expect("they can be ranked");
    let [first, second] = [spreads.candidates[0], spreads.candidates[1]];
    assert_eq!((first.best, second.best), (0.75, 0.25));
    assert!((first.regret - 0.025).abs() < 1e-9 && (second.regret - 0.075).abs() < 1e-9);
    assert_eq!(first.quantiles, [0.1, 0.1, 0.3]);
    // s = 0.1, over four.
    assert!((first.error - 0.05).abs() < 1e-9 && second.error.abs() < 1e-9);
    let lead = spreads.lead.expect("there are two");
    assert!((lead.mean - 0.05).abs() < 1e-9 && (lead.error - 0.05).abs() < 1e-9);
}

#[test]
fn identical_candidates_tie_and_a_dominated_one_is_never_best() {
    let policy = Policy::shipped().expect("sound");
    let member = |risk: f64| vec![harm(&[risk, 0.0]), harm(&[risk + 0.1, 0.0]), harm(&[risk, 0.0])];
    let harms = [member(0.1), member(0.5), member(0.0)];
    let means: Vec<CourseHarm> =
        (0..3).map(|k| mean(harms.iter().map(|member| &member[k]))).collect();
    let ranking = rank(&policy, &stakes(), &means).expect("they can be ranked");
    let order: Vec<usize> = ranking.places.iter().map(|place| place.candidate).collect();
    assert_eq!(order, [0, 2, 1]);
    let spreads = spreads(&policy, &stakes(), &harms, &order).expect("they can be ranked");
    let best: Vec<f64> = spreads.candidates.iter().map(|spread| spread.best).collect();
    assert_eq!(best, [0.5, 0.0, 0.5]);
    let lead = spreads.lead.expect("there are several");
    assert!(!lead.is_close(), "equal ones stay equal, however many members there are: {lead:?}");
}

/// What is called far enough apart early stays so, whatever is found; and a finished stage is
/// called as by its lead.
#[test]
fn no_open_work_makes_a_clear_lead_close() {
    use geometry::rng::Rng;
    let policy = Policy::shipped().expect("sound");
    let mut rng = Rng::new(34);
    let (mut clear, mut close) = (0, 0);
    for _ in 0..2000 {
        let (gap, noise, width) =
            (rng.between(0.0, 0.4), rng.between(0.0, 0.2), rng.between(0.0, 0.2));
        let mut bounds = Vec::new();
        let mut ends = Vec::new();
        for _ in 0..8 {
            let is_open = rng.below(3) == 0;
            let mut member = Vec::new();
            let mut end = Vec::new();
            for k in 0..3 {
                let low = (0.1 + gap * f64::from(k) + rng.between(0.0, noise)).min(0.9);
                // Of some nothing is known but that they are harmful.
                let high = if is_open && k > 0 { 1.0 } else { low + rng.between(0.0, width) };
                let high = high.min(1.0);
                let mut open = harm(&[low, low]);
                for risk in &mut open.persons {
                    risk.work = Interval::new(low, high);
                    risk.range = Range::new(0.0, 1.0);
                }
                member.push(open);
                let found = rng.between(low, high);
                end.push(harm(&[found, found]));
            }
            bounds.push(member);
            ends.push(end);
        }
        let first = rng.below(3) as usize;
        let may = |harms: &[Vec<CourseHarm>]| {
            may_be_close(&policy, &stakes(), harms, first).expect("they can be ranked")
        };
        let (before, after) = (may(&bounds), may(&ends));
        for second in (0..3).filter(|k| *k != first) {
            let order = [first, second, 3 - first - second];
            let spreads = spreads(&policy, &stakes(), &ends, &order).expect("sound");
            let one = lead(&policy, &stakes(), &ends, [first, second]).expect("sound");
            assert_eq!(spreads.lead, Some(one));
            assert_eq!(after[second], one.is_close(), "{one:?}");
            if before[second] {
                close += 1;
            } else {
                clear += 1;
                assert!(!one.is_close(), "{one:?}");
            }
        }
        assert!(!before[first] && !after[first]);
    }
    assert!(clear > 400 && close > 400, "{clear} clear, {close} close");
}
