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
            .map(|(i, e)| Stake {
                is_ego: i % 2 == 0,
                is_vulnerable: e[1] < 0.5,
                responsibility: if e[0] < 0.4 { 0.0 } else { e[3] },
            }).collect();
        let works: Vec<Interval> = ends.iter().map(|e| Interval::new(e[0], e[1])).collect();
        let inside: Vec<f64> = works.iter().zip(&ends)
            .map(|(w, e)| (w.lo() + e[2] * (w.hi() - w.lo())).clamp(w.lo(), w.hi())).collect();
        let sum = Measure::Weighted(vec![
            Term { rule: Rule::Bayes, weight: bayes },
            Term { rule: Rule::Equality, weight: 0.5 * bayes },
            Term { rule: Rule::Maximin, weight: 1.0 - 1.5 * bayes.min(0.66) },
        ].into());
        let rules = [
            Rule::Bayes, Rule::Equality, Rule::Maximin, Rule::Responsibility, Rule::Vulnerable,
            Rule::Uninvolved,
        ];
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

    /// As defined: sums over those whom the definition names, one by one, by their number.
    #[test]
    fn the_vulnerable_and_the_uninvolved_are_those_defined(
        persons in prop::collection::vec(
            (0.0..1.0_f64, any::<bool>(), any::<bool>(), prop_oneof![Just(0.0), 0.0..1.0_f64]),
            0..7,
        ),
    ) {
        let risks: Vec<f64> = persons.iter().map(|person| person.0).collect();
        let stakes: Vec<Stake> = persons.iter().map(|person| Stake {
            is_ego: person.1, is_vulnerable: person.2, responsibility: person.3,
        }).collect();
        let (mut sums, mut counts) = ([0.0; 2], [0.0; 2]);
        for (risk, is_ego, is_vulnerable, responsibility) in &persons {
            if *is_vulnerable {
                sums[0] += risk;
                counts[0] += 1.0;
            }
            if !is_ego && *responsibility == 0.0 {
                sums[1] += risk;
                counts[1] += 1.0;
            }
        }
        for (k, rule) in [Rule::Vulnerable, Rule::Uninvolved].into_iter().enumerate() {
            let expected = if counts[k] > 0.0 { sums[k] / counts[k] } else { 0.0 };
            let value = rule.value(&risks, &stakes);
            prop_assert!((value - expected).abs() < 1e-12, "{rule:?} {value} {expected}");
            // Whoever is not meant does not count, however harmed.
            let is_meant = |s: &Stake| [s.is_vulnerable, s.is_uninvolved()][k];
            let changed: Vec<f64> = risks.iter().zip(&stakes)
                .map(|(risk, stake)| if is_meant(stake) { *risk } else { 1.0 - risk }).collect();
            prop_assert_eq!(rule.value(&changed, &stakes).to_bits(), value.to_bits());
        }
    }
}

fn with_of(rule: Rule, stakes: &[Stake], others: &Others) -> f64 {
    Measure::Rule(rule).with_others(0.3, stakes, others)
}

#[test]
fn persons_who_may_be_there_change_means_alone() {
    // Two at stake at 0.3 in the mean; three more at 0.5 each make 2.1 / 5.
    let mut others = Others::default();
    others.add(&Stake::default(), 3, 0.5);
    let stakes = [Stake::default(), Stake { is_vulnerable: true, ..Stake::default() }];
    let with = |measure: Measure| measure.with_others(0.3, &stakes, &others);
    assert!((with(Measure::Rule(Rule::Bayes)) - 0.42).abs() < 1e-12);
    assert_eq!(with(Measure::Rule(Rule::Maximin)).to_bits(), 0.3_f64.to_bits());
    assert_eq!(with(Measure::Energy).to_bits(), 0.3_f64.to_bits());
    // Unharmed ones do not lower it: they may as well not be there.
    let mut unhurt = Others::default();
    unhurt.add(&Stake::default(), 3, 0.0);
    let unharmed = Measure::Rule(Rule::Bayes).with_others(0.3, &stakes, &unhurt);
    assert_eq!(unharmed.to_bits(), 0.3_f64.to_bits());
    // They sit in a car: so they are not involved, and not vulnerable.
    assert!((with(Measure::Rule(Rule::Uninvolved)) - 0.42).abs() < 1e-12);
    assert_eq!(with(Measure::Rule(Rule::Vulnerable)).to_bits(), 0.3_f64.to_bits());
    // A pillion rider at 0.5 besides the one vulnerable person at 0.3.
    others.add(&stakes[1], 1, 0.5);
    assert!((with_of(Rule::Vulnerable, &stakes, &others) - 0.4).abs() < 1e-12);
}
