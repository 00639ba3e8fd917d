//! Struck sides, masses, seats.

use super::*;
use crate::scene::{car, fixed, walker};

#[test]
fn struck_sides_are_45_degree_sectors_and_wrap() {
    let cases = [
        (0.0, Struck::Front),
        (44.9, Struck::Front),
        (-44.9, Struck::Front),
        (45.0, Struck::Left),
        (45.0 - 1e-13, Struck::Left),
        (-90.0, Struck::Right),
        (135.0, Struck::Left),
        (135.0 + 1e-13, Struck::Left),
        (135.1, Struck::Rear),
        (180.0, Struck::Rear),
        (-180.0, Struck::Rear),
        (185.0, Struck::Rear),
        (-185.0, Struck::Rear),
        (225.1, Struck::Right),
        (350.0, Struck::Front),
        (-350.0, Struck::Front),
    ];
    for (degrees, side) in cases {
        assert_eq!(Struck::at(degrees), side, "{degrees}");
    }
}

#[test]
fn angles_wrap_into_one_turn() {
    for (degrees, expected) in [(190.0, -170.0), (-190.0, 170.0), (-180.0, 180.0), (540.0, 180.0)] {
        assert!((wrapped(degrees) - expected).abs() < 1e-9);
    }
}

#[test]
fn a_bearing_is_positive_to_the_left_of_the_body_not_of_the_frame() {
    let facing_left = car(0, 1000.0, [0.0, 0.0], 90.0);
    assert!((facing_left.bearing(DVec3::X, DVec3::Z) + 90.0).abs() < 1e-9);
    assert!((facing_left.bearing(DVec3::Y, DVec3::Z)).abs() < 1e-9);
}

#[test]
fn impossible_parties_are_refused() {
    for mass in [0.0, -1200.0, f64::NAN, f64::INFINITY] {
        let party = CollisionParty { mass_kg: Some(mass), ..car(0, 1200.0, [0.0, 0.0], 0.0) };
        assert_eq!(party.check(), Err(PartyError::Mass));
    }
    for gyration_m in [0.0, -1.0, f64::NAN] {
        let party = CollisionParty { gyration_m, ..car(0, 1200.0, [0.0, 0.0], 0.0) };
        assert_eq!(party.check(), Err(PartyError::Gyration));
    }
    let nowhere = CollisionParty { centre_m: DVec3::NAN, ..walker(0, [0.0, 0.0]) };
    assert_eq!(nowhere.check(), Err(PartyError::Place));
    let persons = walker(0, [0.0, 0.0]).persons;
    let haunted = CollisionParty { persons, ..fixed(BodyKind::Wall, [0.0, 0.0]) };
    assert_eq!(haunted.check(), Err(PartyError::PersonsInFixed));
    let mut full = car(3, 1200.0, [0.0, 0.0], 0.0);
    full.persons.push(full.persons[0]);
    assert_eq!(full.check(), Err(PartyError::Twice(PersonId(3))));
    assert_eq!(fixed(BodyKind::Pole, [0.0, 0.0]).check(), Ok(()));
}

#[test]
fn the_seat_decides_which_side_is_near() {
    let bus = CollisionParty { kind: BodyKind::Bus, ..car(0, 1200.0, [0.0, 0.0], 0.0) };
    let victim = |side, seat| bus.victim(side, Some(seat)).expect("an occupant");
    for (seat, left, right) in [
        (Seat::FrontLeft, Victim::OccupantNear, Victim::OccupantFar),
        (Seat::RearRight, Victim::OccupantFar, Victim::OccupantNear),
        (Seat::RearMiddle, Victim::OccupantNear, Victim::OccupantNear),
    ] {
        assert_eq!([victim(Struck::Left, seat), victim(Struck::Right, seat)], [left, right]);
        assert_eq!(victim(Struck::Front, seat), Victim::OccupantFront);
    }
}

#[test]
fn who_is_light_throws_less_and_nobody_more_than_a_car() {
    let share = |kg| throw_share(BodyKind::Motorcycle, kg);
    assert_eq!([share(None), share(Some(1500.0)), share(Some(20_000.0))], [1.0; 3]);
    assert!(share(Some(75.0)) < share(Some(90.0)) && share(Some(90.0)) < share(Some(1000.0)));
    assert!(share(Some(75.0)) > 0.2 && share(Some(1200.0)) > 0.95);
}
