//! From contact to harm: worked vectors I6 and I7, laws, and defects of public code.

use super::*;
use crate::evidence::Seen;
use crate::injury::Victim;

use crate::contact::ContactPatch;
use crate::harm::PersonHarm;
use crate::path::plan;
use crate::scene::{Prism, Scene, car, fixed, head_on, walker};
use body::{BodyKind, Zones};
use geometry::{DVec3, Supports};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

mod defects;
mod laws;

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() <= 1e-5, "{value} is not {expected}");
}

fn harm(scene: &Scene) -> CandidateHarm {
    scene.harm().expect("a sound scene")
}

#[test]
fn i6_a_central_frontal_crash() {
    let harm = harm(&head_on(0.0));
    assert_eq!(harm.contact.touch, Touch::Yes);
    let patch = harm.contact.patch.as_ref().expect("contact");
    assert_eq!((patch.normal_degrees, patch.normals_degrees.as_slice()), (0.0, &[0.0][..]));
    let ego = &harm.persons[0];
    assert_eq!((ego.victim, &*ego.curve), (Victim::OccupantFront, "tum-lr4s-front"));
    near(ego.x_m_s.hi(), 13.2);
    near(ego.work.lo(), 0.09676);
    assert!(ego.work.is_settled() && harm.is_settled());
    near(ego.range.low(), 0.03368);
    near(ego.range.high(), 0.44093);
    assert!((harm.energy_j.hi() - 142_560.0).abs() < 1.0);
    // Reported ΔV: restitution 0 to 0.3, speed 5 %, masses 10 % against each other.
    near(harm.delta_v[0].range.low(), 19.0 * 1620.0 / (1320.0 + 1620.0));
    near(harm.delta_v[0].range.high(), 1.3 * 21.0 * 1980.0 / (1080.0 + 1980.0));
    assert!(harm.force_degrees.iter().all(|d| d.abs() < 1e-6), "{:?}", harm.force_degrees);
}

#[test]
fn i7_an_open_lever_arm_leaves_an_interval() {
    let mut scene = head_on(0.0);
    // B does not turn, so its own arm is ignored.
    scene.party_b.gyration_m = 1e9;
    let approach = scene.approach();
    let meeting = plan(&approach).expect("sound");
    let mut evidence = Evidence::none((0.0, 0.0));
    evidence.touched();
    let mut open = Seen::NOTHING;
    for across in [0.0, 0.6] {
        for along in [2.2, 2.3] {
            open.patch.add(&approach.directions, DVec3::new(along, across, 0.5));
        }
    }
    evidence.add_open(0.0, &open);
    let harm = scene.harm_by(&approach, &meeting, &evidence).expect("sound");
    near(harm.persons[0].work.lo(), 0.07251);
    near(harm.persons[0].work.hi(), 0.09676);
    assert!(harm.is_open && !harm.is_settled());
}

/// The false positive of boxes: they overlap, bodies do not.
#[test]
fn without_contact_nobody_is_harmed_at_all() {
    let scene = Scene {
        a: Prism::over(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
        b: Prism::over(&[[1.1, 1.1], [0.1, 1.1], [1.1, 0.1]]),
        velocity: [5.0, -5.0],
        ..head_on(0.0)
    };
    let harm = harm(&scene);
    assert_eq!((harm.contact.touch, harm.contact.near_miss), (Touch::No, false));
    for person in &harm.persons {
        assert_eq!((person.work, person.range), (Interval::ZERO, Range::ZERO));
        assert_eq!(person.work.hi().to_bits(), 0);
    }
    assert_eq!((harm.energy_j, harm.response), (Interval::ZERO, Response::default()));
    assert!(harm.is_settled() && harm.contact.patch.is_none());
}

#[test]
fn a_near_miss_is_nothing_that_could_have_been_something() {
    let [missed, passed] = [1.80, 1.95].map(|across| harm(&head_on(across)));
    assert!(missed.contact.near_miss && !passed.contact.near_miss);
    near(missed.contact.hull_gap_m, 0.05);
    for (near_miss, pass) in missed.persons.iter().zip(&passed.persons) {
        assert_eq!((near_miss.work, near_miss.range.low()), (Interval::ZERO, 0.0));
        assert!(near_miss.range.high() > 0.0 && near_miss.high_at_least == near_miss.range.high());
        assert_eq!(pass.range, Range::ZERO);
    }
    // At worst it would have been a sideswipe, not a head-on crash.
    assert!(missed.persons[0].range.high() < 0.5 * harm(&head_on(0.0)).persons[0].range.high());
}

#[test]
fn a_sideswipe_harms_little_however_long_the_patch_is() {
    let glance = harm(&head_on(1.70));
    let crash = harm(&head_on(0.0));
    let patch = glance.contact.patch.as_ref().expect("contact");
    assert!(patch.normal_degrees.abs() >= 75.0);
    assert!(glance.normal_m_s.hi() < 0.3 * glance.closing_m_s);
    for (a, b) in glance.persons.iter().zip(&crash.persons) {
        assert!(a.work.hi() < 0.25 * b.work.hi(), "{a:?}");
        assert_eq!(a.victim, Victim::OccupantSide);
    }
}

/// The angle of B is not A's plus 180 of some unit: the struck side follows from each body's frame.
#[test]
fn in_a_rear_end_crash_one_front_and_one_rear_are_struck() {
    for turned in [0.0, 30.0, 90.0, 179.0, -135.0] {
        let mut scene = head_on(0.0);
        scene.party_b = car(1, 1800.0, [4.4, 0.0], 0.0);
        let harm = harm(&scene.displaced(turned, [3.0, -7.0]));
        let victims: Vec<_> = harm.persons.iter().map(|p| p.victim).collect();
        assert_eq!(victims, [Victim::OccupantFront, Victim::OccupantRear], "{turned}");
        assert!(harm.force_degrees[1].abs() > 179.9, "{:?}", harm.force_degrees);
    }
}

#[test]
fn a_struck_flank_is_a_side_and_its_occupants_fare_worse() {
    let mut scene = head_on(0.0);
    scene.b = Prism::cuboid(4.5, 1.7, [3.0, 0.0], 90.0);
    scene.party_b = car(1, 1200.0, [3.0, 0.0], 90.0);
    let harm = harm(&scene);
    assert_eq!(harm.persons[1].victim, Victim::OccupantSide);
    assert!(harm.persons[1].work.hi() > harm.persons[0].work.hi());
}

#[test]
fn a_fixed_object_is_not_certain_death_and_has_nobody_in_it() {
    let mut scene = head_on(0.0);
    scene.velocity = [15.0, 0.0];
    scene.b = Prism::cuboid(0.5, 20.0, [2.4, 0.0], 0.0);
    scene.party_b = fixed(BodyKind::Wall, [2.4, 0.0]);
    let harm = harm(&scene);
    assert_eq!(harm.persons.len(), 1);
    near(harm.persons[0].x_m_s.hi(), 16.5);
    assert!(harm.persons[0].work.hi() < 0.2);
    assert_eq!(harm.delta_v[1].work, Interval::ZERO);
}

#[test]
fn equal_velocities_harm_nobody() {
    let mut scene = head_on(0.0);
    scene.b = scene.b.moved([1.0, 0.0]);
    scene.velocity = [0.0, 0.0];
    let harm = harm(&scene);
    assert!(harm.persons.iter().all(|p| p.range == Range::ZERO && p.work == Interval::ZERO));
}

#[test]
fn what_cannot_be_evaluated_is_anything_from_nothing_to_all() {
    let still = Scene { velocity: [0.0, 0.0], ..head_on(0.0) };
    let harm = harm(&still);
    assert_eq!(harm.unevaluable, Some(Unevaluable::AlreadyOverlapping));
    for person in &harm.persons {
        assert_eq!((person.work, person.range), (Interval::new(0.0, 1.0), Range::new(0.0, 1.0)));
    }
    assert!(!harm.is_settled());
}

#[test]
fn a_concave_body_is_met_along_the_way_or_not_at_all() {
    let mut scene = head_on(0.0);
    scene.b = Prism::cuboid(10.0, 20.0, [7.0, 4.0], 20.0);
    scene.party_b = fixed(BodyKind::Building, [7.0, 4.0]);
    let harm = harm(&scene);
    assert!(harm.concave);
    let ego = &harm.persons[0];
    assert!(ego.range.low() == 0.0 && ego.work.lo() > 0.0);
    assert_eq!(harm.contact.patch.map(|p| p.normals_degrees), Some(smallvec::smallvec![0.0]));
}

/// A zone beside the driver lifts the range, never the nominal figure.
#[test]
fn intrusion_beside_a_seat_lifts_the_upper_end_alone() {
    let scene = head_on(0.0);
    let approach = scene.approach();
    let meeting = plan(&approach).expect("sound");
    let Meeting::Path(path) = &meeting else { panic!("no path") };
    let plain = scene.evidence(&approach, path);
    let mut intruding = plain;
    let seat = Seen { zones_a: Zones(1 << 8), ..Seen::NOTHING };
    intruding.add_hits(0.0, &seat);
    let [plain, intruding] = [plain, intruding]
        .map(|evidence| scene.harm_by(&approach, &meeting, &evidence).expect("sound"));
    let (before, after) = (&plain.persons[0], &intruding.persons[0]);
    assert!(after.intrusion && !before.intrusion);
    assert_eq!((before.work, before.range.low()), (after.work, after.range.low()));
    assert!(before.range.high() <= after.range.high());
    assert_eq!(plain.persons[1], intruding.persons[1]);
}

/// From 1 m/s on, a person struck on foot fares no better than an occupant of a car whose velocity
/// changes by as much.
#[test]
fn on_foot_is_never_safer() {
    let curves = Curves::shipped().expect("sound");
    let risk =
        |victim, v| curves.nominal(curves.rung(victim, Level::Mais3).expect("has a curve")).risk(v);
    for k in 10..400 {
        let v = f64::from(k) * 0.1;
        for side in [Victim::OccupantFront, Victim::OccupantSide, Victim::OccupantRear] {
            assert!(risk(Victim::Pedestrian, v) >= risk(side, v), "{side:?} at {v}");
        }
    }
}

#[test]
fn impossible_candidates_are_refused() {
    let wall = || fixed(BodyKind::Wall, [4.4, 0.0]);
    let both = Scene { party_a: wall(), party_b: wall(), ..head_on(0.0) };
    assert_eq!(both.harm(), Err(AssessError::BothFixed));
    for mass in [0.0, -1.0, f64::NAN] {
        let mut scene = head_on(0.0);
        scene.party_b.mass_kg = Some(mass);
        assert_eq!(scene.harm(), Err(AssessError::Party('B', PartyError::Mass)));
    }
    let mut scene = head_on(0.0);
    scene.party_b.persons[0].id = PersonId(0);
    assert_eq!(scene.harm(), Err(AssessError::Party('B', PartyError::Twice(PersonId(0)))));
    let mut scene = head_on(0.0);
    scene.velocity = [f64::NAN, 0.0];
    assert!(matches!(scene.harm(), Err(AssessError::Approach(_))));
}

/// Neither curves nor figures are kept from one candidate to the next.
#[test]
fn candidates_do_not_depend_on_each_other() {
    let mut on_foot = head_on(0.0);
    on_foot.b = Prism::round(0.25, [2.4, 0.3]);
    on_foot.party_b = walker(1, [2.4, 0.3]);
    let scenes = [head_on(0.0), on_foot, head_on(1.0)];
    let forwards: Vec<_> = scenes.iter().map(harm).collect();
    let mut backwards: Vec<_> = scenes.iter().rev().map(harm).collect();
    backwards.reverse();
    assert_eq!(forwards, backwards);
    assert_eq!(&*forwards[1].persons[1].curve, "rosen-2010");
    near(forwards[1].persons[1].x_m_s.hi(), 20.0);
}
