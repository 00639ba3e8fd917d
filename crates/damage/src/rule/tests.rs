//! Rules against the worked cases K1 to K3, and laws of their intervals.

use super::*;
use proptest::prelude::*;

/// Ego occupant, occupant of the other car, pedestrian.
const K: [[f64; 3]; 3] = [[0.01, 0.0, 0.40], [0.20, 0.18, 0.0], [0.35, 0.0, 0.0]];

fn stakes(pedestrian: f64) -> [Stake; 3] {
    let mut stakes = [Stake::default(); 3];
    stakes[0].is_ego = true;
    stakes[2].responsibility = pedestrian;
    stakes
}

fn values(measure: &Measure, stakes: &[Stake]) -> [f64; 3] {
    K.map(|risks| (measure.value(&risks, 0.0, stakes) * 1e5).round() / 1e5)
}

/// One value per rule: nothing is computed under one name and returned under another.
#[test]
fn every_rule_gives_its_own_worked_values() {
    let rule_values = |rule: Rule| values(&Measure::Rule(rule), &stakes(0.0));
    assert_eq!(rule_values(Rule::Bayes), [0.13667, 0.12667, 0.11667]);
    assert_eq!(rule_values(Rule::Equality), [0.26667, 0.13333, 0.23333]);
    assert_eq!(rule_values(Rule::Maximin), [0.4, 0.2, 0.35]);
    assert_eq!(rule_values(Rule::EgoOnly), [0.01, 0.2, 0.35]);
    assert_eq!(rule_values(Rule::Responsibility), rule_values(Rule::Bayes));
}

/// Half the responsibility halves the pedestrian's share, once.
#[test]
fn responsibility_is_applied_once() {
    let rule = Rule::Responsibility;
    let alone = values(&Measure::Rule(rule), &stakes(0.5));
    assert_eq!(alone, [0.07, 0.12667, 0.11667]);
    let sum = Measure::Weighted(vec![Term { rule, weight: 1.0 }].into());
    assert_eq!(values(&sum, &stakes(0.5)), alone);
}

#[test]
fn a_weighted_sum_is_the_sum_of_weighted_rules() {
    let weights = [(Rule::Bayes, 0.5), (Rule::Equality, 0.2), (Rule::Maximin, 0.3)];
    let terms = weights.map(|(rule, weight)| Term { rule, weight });
    assert_eq!(
        values(&Measure::Weighted(terms.as_slice().into()), &stakes(0.0)),
        [0.24167, 0.15, 0.21]
    );
}

#[test]
fn one_person_or_none_is_never_unequal() {
    for rule in [Rule::Equality, Rule::Bayes, Rule::Maximin, Rule::EgoOnly] {
        assert_eq!(rule.value(&[], &[]).to_bits(), 0);
    }
    assert_eq!(Rule::Equality.value(&[0.7], &[Stake::default()]).to_bits(), 0);
}

proptest! {
    /// Whatever values open work leaves within the persons' intervals, a measure's interval holds
    /// it.
    #[test]
    fn intervals_hold_every_value_inside(
        ends in prop::collection::vec(prop::array::uniform4(0.0..1.0_f64), 1..6),
        bayes in 0.4..0.8_f64,
    ) {
        let stakes: Vec<Stake> = ends.iter().enumerate()
            .map(|(i, e)| Stake { is_ego: i % 2 == 0, responsibility: e[3] }).collect();
        let works: Vec<Interval> = ends.iter().map(|e| Interval::new(e[0], e[1])).collect();
        let inside: Vec<f64> = works.iter().zip(&ends)
            .map(|(w, e)| (w.lo() + e[2] * (w.hi() - w.lo())).clamp(w.lo(), w.hi())).collect();
        let sum = Measure::Weighted(vec![
            Term { rule: Rule::Bayes, weight: bayes },
            Term { rule: Rule::Equality, weight: 0.5 * bayes },
            Term { rule: Rule::Maximin, weight: 1.0 - 1.5 * bayes.min(0.66) },
        ].into());
        let rules = [Rule::Bayes, Rule::Equality, Rule::Maximin, Rule::Responsibility];
        let others = [Measure::Rule(Rule::EgoOnly), sum, Measure::Worst(0), Measure::Worst(1)];
        let measures = rules.map(Measure::Rule).into_iter().chain(others);
        for measure in measures {
            let over = measure.over(&works, Interval::ZERO, &stakes);
            let value = measure.value(&inside, 0.0, &stakes);
            let holds = over.lo() - 1e-12 <= value && value <= over.hi() + 1e-12;
            prop_assert!(holds, "{measure:?} {over:?} {value}");
            let settled: Vec<Interval> = inside.iter().map(|r| Interval::exactly(*r)).collect();
            prop_assert!(measure.over(&settled, Interval::ZERO, &stakes).is_settled());
        }
    }
}

#[test]
fn persons_who_may_be_there_change_means_alone() {
    // Two at stake at 0.3 in the mean; three more at 0.5 each make 2.1 / 5.
    let with = |measure: Measure| measure.with_others(0.3, 2, (3, 1.5));
    assert!((with(Measure::Rule(Rule::Bayes)) - 0.42).abs() < 1e-12);
    assert_eq!(with(Measure::Rule(Rule::Maximin)).to_bits(), 0.3_f64.to_bits());
    assert_eq!(with(Measure::Energy).to_bits(), 0.3_f64.to_bits());
    // Unharmed ones do not lower it: they may as well not be there.
    let unharmed = Measure::Rule(Rule::Bayes).with_others(0.3, 2, (3, 0.0));
    assert_eq!(unharmed.to_bits(), 0.3_f64.to_bits());
}
