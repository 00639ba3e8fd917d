//! From contact to harm: crashes that can be computed by hand, laws, and defects of public code.

use super::*;
use crate::evidence::Seen;
use crate::injury::{Speeds, Victim};

use crate::contact::ContactPatch;
use crate::harm::PersonHarm;
use crate::path::survey;
use crate::plane::PlaneOrigin;
use crate::scene::{Prism, Scene, Touching, car, fixed, head_on, walker};
use body::{BodyKind, Seat, Zones};
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
fn a_central_frontal_crash() {
    let harm = harm(&head_on(0.0));
    let patch = harm.contact.as_ref().expect("contact");
    assert!(patch.origin == PlaneOrigin::Chord && patch.normal_degrees.abs() < 1e-9, "{patch:?}");
    let ego = &harm.persons[0];
    assert_eq!((ego.victim, &*ego.curve), (Victim::OccupantFront, "wang-frontal"));
    near(ego.x_m_s.hi(), 13.2);
    let p = |mph: f64| 1.0 / (1.0 + libm::exp(6.9774 - 0.162 * mph));
    near(ego.work.lo(), (p(13.2 / 0.44704) - p(0.0)) / (1.0 - p(0.0)));
    assert!(ego.work.is_settled() && harm.is_settled());
    assert!((harm.energy_j.hi() - 142_560.0).abs() < 1.0);
    // Reported ΔV: restitution 0 to 0.3, speed 5 %, masses 10 % against each other, and the normal
    // turned by 10 degrees at the low end.
    near(harm.delta_v[0].range.high(), 1.3 * 21.0 * 1980.0 / (1080.0 + 1980.0));
    assert!(harm.delta_v[0].range.low() < 19.0 * 1620.0 / (1320.0 + 1620.0));
    assert!(harm.force_degrees.iter().all(|d| d.abs() < 1e-6), "{:?}", harm.force_degrees);
}

#[test]
fn what_grazes_exchanges_nothing() {
    // Along each other's flanks: the outlines touch and never cross.
    let mut scene = head_on(0.0);
    scene.b = Prism::cuboid(4.5, 1.7, [4.6, 1.75], 180.0);
    scene.party_b = car(1, 1800.0, [4.6, 1.75], 180.0);
    let touching = scene.touching();
    if let Some(touching) = touching {
        assert_eq!(touching.plane.origin, PlaneOrigin::Graze);
        let harm = touching.harm_by(&touching.evidence()).expect("sound");
        assert!(harm.persons.iter().all(|person| person.work == Interval::ZERO));
    }
}

#[test]
fn a_sideswipe_harms_little_however_long_the_patch_is() {
    // 2 cm of overlap.
    let mut scene = head_on(0.0);
    scene.b = Prism::cuboid(4.5, 1.7, [4.6, 1.73], 180.0);
    scene.party_b = car(1, 1800.0, [4.6, 1.73], 180.0);
    let (glance, crash) = (harm(&scene), harm(&head_on(0.0)));
    let patch = glance.contact.as_ref().expect("contact");
    assert!(patch.normal_degrees.abs() >= 75.0, "{patch:?}");
    assert!(glance.normal_m_s < 0.3 * glance.closing_m_s);
    for (a, b) in glance.persons.iter().zip(&crash.persons) {
        assert!(a.work.hi() < 0.25 * b.work.hi(), "{a:?}");
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
    // The driver sits at the left, and is struck from the left.
    assert_eq!(harm.persons[1].victim, Victim::OccupantNear);
    assert!(harm.persons[1].work.hi() > harm.persons[0].work.hi());
    scene.party_b.persons[0].seat = Some(Seat::FrontRight);
    let far = super::tests::harm(&scene);
    assert_eq!(far.persons[1].victim, Victim::OccupantFar);
    assert!(far.persons[1].work.hi() < harm.persons[1].work.hi());
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
    assert!(harm.persons[0].work.hi() < 0.3);
    assert_eq!(harm.delta_v[1].work, Interval::ZERO);
}

#[test]
fn equal_velocities_harm_nobody() {
    let mut scene = head_on(0.0);
    scene.velocity = [0.0, 0.0];
    let harm = harm(&scene);
    assert!(harm.persons.iter().all(|p| p.range == Range::ZERO && p.work == Interval::ZERO));
}

#[test]
fn what_cannot_be_evaluated_is_anything_from_nothing_to_all() {
    let Touching { scene, approach, .. } = head_on(0.0).touching().expect("they meet");
    let (curves, parameters) = (Curves::shipped(), Parameters::shipped());
    let (curves, parameters) = (curves.expect("sound"), parameters.expect("sound"));
    let basis = Basis { curves: &curves, level: Level::Mais3, parameters: &parameters };
    let (a, b) = (&scene.party_a, &scene.party_b);
    let encounter = Encounter { approach: &approach, plane: None, a, b, probability: 1.0 };
    let harm = assess(&encounter, &Evidence::none(), &basis).expect("sound");
    assert_eq!(harm.unevaluable, Some(Unevaluable::AlreadyOverlapping));
    for person in &harm.persons {
        assert_eq!((person.work, person.range), (Interval::new(0.0, 1.0), Range::new(0.0, 1.0)));
    }
    assert!(!harm.is_settled());
    // Who only turns can lose no more than the energy of that.
    let turning = Approach { closing_m_s: 0.0, yaw_rad_s: [2.0, 0.0], ..approach.clone() };
    let encounter = Encounter { approach: &turning, ..encounter };
    let energy_j = assess(&encounter, &Evidence::none(), &basis).expect("sound").energy_j;
    let speed_m_s = 2.0 * a.gyration_m;
    assert_eq!(energy_j, Interval::new(0.0, 0.5 * 1200.0 * speed_m_s * speed_m_s));
}

/// Turning brings the point of contact nearer, or away from it.
#[test]
fn yaw_rates_before_the_impact_count() {
    let with = |yaw_rad_s: [f64; 2]| harm(&Scene { yaw_rad_s, ..head_on(0.8) });
    let (still, into, away) = (with([0.0; 2]), with([1.0, 0.0]), with([-1.0, 0.0]));
    // The point is ahead of A and to its left: a turn to the left moves it back and to the left.
    assert!((still.normal_m_s - into.normal_m_s).abs() > 0.1);
    let middle = 0.5 * (into.normal_m_s + away.normal_m_s);
    assert!((middle - still.normal_m_s).abs() < 1e-9);
    assert_eq!(into.yaw_rad_s[0][0], 1.0);
    let turned = into.response.delta_yaw_rad_s;
    assert!((into.yaw_rad_s[0][1] - 1.0 - turned[0]).abs() < 1e-12 && turned[1] != 0.0);
}

/// A rider is thrown by a wall more than by somebody on foot.
#[test]
fn a_rider_fares_worse_against_a_wall_than_against_a_person() {
    let rider = |b: Prism, party_b: CollisionParty| {
        let mut scene = Scene { b, party_b, velocity: [12.0, 0.0], ..head_on(0.0) };
        scene.a = Prism::cuboid(2.2, 0.8, [0.0, 0.0], 0.0);
        scene.party_a = CollisionParty { kind: BodyKind::Motorcycle, ..scene.party_a };
        scene.party_a.mass_kg = Some(325.0);
        scene.party_a.persons[0].seat = Some(Seat::Rider);
        harm(&scene).persons[0].work.hi()
    };
    let wall = rider(Prism::cuboid(0.5, 20.0, [2.4, 0.0], 0.0), fixed(BodyKind::Wall, [2.4, 0.0]));
    let person = rider(Prism::round(0.25, [2.4, 0.0]), walker(1, [2.4, 0.0]));
    assert!(wall > 2.0 * person, "{wall} {person}");
}

/// A zone beside the driver lifts the range, never the nominal figure.
#[test]
fn intrusion_beside_a_seat_lifts_the_upper_end_alone() {
    let touching = head_on(0.0).touching().expect("they meet");
    let plain = touching.evidence();
    let mut intruding = plain;
    let seat = Seen { zones_a: Zones(1 << 8), ..Seen::NOTHING };
    intruding.add_hits(0.0, &seat);
    let [plain, intruding] =
        [plain, intruding].map(|evidence| touching.harm_by(&evidence).expect("sound"));
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
    let risk = |victim, v| {
        let speeds = Speeds { delta_v: v, normal: v, closing: v, front_m: 0.7 };
        curves.risk(curves.rung(victim, Level::Mais3).expect("has a curve"), &speeds)
    };
    for k in 10..250 {
        let v = f64::from(k) * 0.1;
        for side in [Victim::OccupantFront, Victim::OccupantFar, Victim::OccupantRear] {
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
    assert_eq!(&*forwards[1].persons[1].curve, "lubbe-pedestrian");
    near(forwards[1].persons[1].x_m_s.hi(), 20.0);
}
