//! Defects found in public code for ethical trajectory planning and crash severity, by number: each
//! is a test that fails where the defect is.

use super::*;
use crate::dynamics::{Impact, ImpactBody, Surface};
use crate::injury::Speeds;
use crate::party::{Struck, wrapped};
use crate::policy::{DEFAULT_POLICY, Policy};
use crate::rank::rank;
use crate::rule::{Measure, Rule, Stake, Term};

const OTHER: Stake = Stake { is_ego: false, is_vulnerable: false, responsibility: 0.0 };
const STAKES: [Stake; 2] = [Stake { is_ego: true, ..OTHER }, OTHER];

fn by(rule: &str) -> Policy {
    let head = DEFAULT_POLICY.split("[[level]]").next().unwrap_or_default();
    let text = format!("{head}[[level]]\nrule = \"{rule}\"\ntolerance = 0.0\n");
    Policy::parse("test.toml", &text).expect("a sound policy")
}

fn on_foot(speed: f64) -> Scene {
    let mut scene = head_on(0.0);
    scene.velocity = [speed, 0.0];
    scene.b = Prism::round(0.25, [2.4, 0.3]);
    scene.party_b = walker(1, [2.4, 0.3]);
    scene
}

#[test]
fn d01_maximin_has_no_mask_that_keeps_only_the_unharmed() {
    let worst = |risks: &[f64]| Rule::Maximin.value(risks, &STAKES);
    assert_eq!([worst(&[0.0, 0.4]), worst(&[0.2, 0.2])], [0.4, 0.2]);
}

#[test]
fn d02_each_figure_is_returned_under_its_own_name() {
    let harm = harm(&on_foot(12.0));
    let driver = &harm.persons[0];
    let walker = &harm.persons[1];
    assert_eq!((driver.party, walker.party), (0, 1));
    assert_eq!((driver.victim, walker.victim), (Victim::OccupantFront, Victim::Pedestrian));
    near(walker.x_m_s.hi(), 12.0);
    near(walker.work.hi(), curve_of(walker).risk(walker.dose()));
    near(driver.x_m_s.hi(), harm.delta_v[0].work.hi());
}

fn curve_of(person: &PersonHarm) -> crate::curve::Curve {
    let curves = Curves::shipped().expect("sound");
    curves.curves.iter().find(|curve| curve.id == person.curve).cloned().expect("shipped")
}

#[test]
fn d03_a_curve_is_the_persons_own_whoever_came_before() {
    let (first, second) = (harm(&on_foot(12.0)), harm(&head_on(0.0)));
    assert_eq!(&*first.persons[1].curve, "lubbe-pedestrian");
    assert_eq!(&*second.persons[1].curve, "wang-frontal");
    assert_eq!(first, harm(&on_foot(12.0)));
}

#[test]
fn d04_responsibility_weighs_once() {
    let stakes = [STAKES[0], Stake { responsibility: 0.5, ..STAKES[1] }];
    let rule = Rule::Responsibility;
    assert_eq!(rule.value(&[0.0, 0.4], &stakes), 0.1);
    let sum = Measure::Weighted(vec![Term { rule, weight: 1.0 }].into());
    assert_eq!(sum.value(&[0.0, 0.4], 0.0, &stakes), 0.1);
    assert_eq!(Rule::Bayes.value(&[0.0, 0.4], &stakes), 0.2);
}

#[test]
fn d05_what_is_reported_is_what_was_decided_by() {
    let harms = [harm(&head_on(0.0)), harm(&on_foot(12.0))];
    let ranking = rank(&by("bayes"), &STAKES, &harms).expect("sound");
    for place in &ranking.places {
        let persons = &harms[place.candidate].persons;
        let mean = persons.iter().map(|p| p.work.hi()).sum::<f64>() / 2.0;
        assert!((place.work.hi() - mean).abs() < 2e-9, "{place:?}");
    }
}

#[test]
fn d06_where_a_candidate_leads_does_not_rescale_it() {
    let alone = rank(&by("bayes"), &STAKES, &[harm(&on_foot(12.0))]).expect("sound");
    let among = [harm(&on_foot(12.0)), harm(&on_foot(3.0)), harm(&head_on(2.5))];
    let among = rank(&by("bayes"), &STAKES, &among).expect("sound");
    let same = among.places.iter().find(|place| place.candidate == 0).expect("ranked");
    assert_eq!(same.work, alone.places[0].work);
}

#[test]
fn d07_front_and_rear_are_sectors_of_45_degrees_either_way_and_wrap() {
    for (degrees, side) in [
        (0.0, Struck::Front),
        (-44.9, Struck::Front),
        (359.0, Struck::Front),
        (46.0, Struck::Left),
        (270.0, Struck::Right),
        (-135.1, Struck::Rear),
        (180.0, Struck::Rear),
        (-540.0, Struck::Rear),
    ] {
        assert_eq!(Struck::at(degrees), side, "{degrees}");
    }
}

#[test]
fn d08_half_a_turn_is_180_degrees_and_not_180_radians() {
    assert_eq!(wrapped(30.0 + 180.0), -150.0);
    let mut scene = head_on(0.0);
    scene.party_b = car(1, 1800.0, [4.4, 0.0], 0.0);
    assert_eq!(harm(&scene).persons[1].victim, Victim::OccupantRear);
}

#[test]
fn d09_no_mass_is_zero_or_negative() {
    for mass in [0.0, -0.0, -5.0, f64::NEG_INFINITY, f64::NAN] {
        let mut scene = head_on(0.0);
        scene.party_a.mass_kg = Some(mass);
        assert_eq!(scene.harm(), Err(AssessError::Party('A', PartyError::Mass)), "{mass}");
    }
}

#[test]
fn d10_nobody_is_hurt_at_speed_zero() {
    let curves = Curves::shipped().expect("sound");
    for curve in &*curves.curves {
        assert_eq!(curve.risk(crate::curve::Dose::at(0.0)).to_bits(), 0, "{}", curve.id);
        // The published curve is well above 0 there.
        assert!(1.0 / (1.0 + libm::exp(-curve.a)) > 1e-4, "{}", curve.id);
    }
}

#[test]
fn d11_a_severer_injury_is_never_likelier() {
    let text = include_str!("../../../config/curves/levels.toml");
    let curves = Curves::parse("levels.toml", text).expect("sound");
    for victim in Victim::ALL {
        for k in 0..400 {
            let risk = |level| {
                let rung = curves.rung(victim, level).ok()?;
                let v = 0.1 * f64::from(k);
                let speeds = Speeds { delta_v: v, normal: v, closing: v, front_m: 0.9 };
                Some(curves.risk(rung, &speeds))
            };
            let ladder = [risk(Level::Fatal), risk(Level::Mais3), risk(Level::Mais2)];
            let known: Vec<f64> = ladder.into_iter().flatten().collect();
            assert!(known.is_sorted(), "{victim:?} at {k}");
        }
    }
}

#[test]
fn d12_a_fixed_object_is_not_certain_harm() {
    let mut scene = head_on(0.0);
    scene.velocity = [2.0, 0.0];
    scene.b = Prism::cuboid(0.5, 20.0, [2.4, 0.0], 0.0);
    scene.party_b = fixed(BodyKind::Wall, [2.4, 0.0]);
    let risk = harm(&scene).persons[0].work.hi();
    assert!(risk > 0.0 && risk < 0.01, "{risk}");
}

#[test]
fn d13_equal_velocities_change_no_velocity() {
    let car = ImpactBody { inverse_mass: 1.0 / 1500.0, gyration_m: 1.2, arm_m: [1.0, 0.3] };
    let surface = Surface::Coupled { restitution: 0.1, friction: 0.7 };
    let impact = Impact { velocity_m_s: [0.0; 2], surface, sides: [car; 2] };
    assert_eq!(impact.respond(), Response::default());
    let mut scene = head_on(0.0);
    (scene.velocity, scene.b) = ([0.0, 0.0], scene.b.moved([0.5, 0.0]));
    assert!(harm(&scene).persons.iter().all(|person| person.work == Interval::ZERO));
}

#[test]
fn d14_who_has_no_curve_is_refused_and_not_taken_for_a_pedestrian() {
    let mut curves = Curves::shipped().expect("sound");
    curves.rungs.retain(|rung| rung.victim != Victim::Cyclist);
    let level = Level::Mais3;
    let missing = MissingCurve { victim: Victim::Cyclist, level };
    assert_eq!(curves.rung(Victim::Cyclist, level).err(), Some(missing));
    let mut scene = on_foot(12.0);
    scene.party_b.kind = BodyKind::Cyclist;
    let parameters = Parameters::shipped().expect("sound");
    let Touching { scene, approach, plane } = scene.touching().expect("they meet");
    let (a, b) = (&scene.party_a, &scene.party_b);
    let encounter = Encounter { approach: &approach, plane: Some(&plane), a, b, probability: 1.0 };
    let basis = Basis { curves: &curves, level, parameters: &parameters };
    let refused = assess(&encounter, &Evidence::none(), &basis);
    assert_eq!(refused, Err(AssessError::Curve(missing)));
}
