//! Struck sides, masses, seats.

use super::*;
use crate::scene::{car, fixed, walker};

#[test]
fn struck_sides_are_45_degree_sectors_and_wrap() {
    let cases = [
        (0.0, Struck::Front),
        (44.9, Struck::Front),
        (-44.9, Struck::Front),
        (45.0, Struck::Side),
        (45.0 - 1e-13, Struck::Side),
        (-90.0, Struck::Side),
        (135.0, Struck::Side),
        (135.0 + 1e-13, Struck::Side),
        (135.1, Struck::Rear),
        (180.0, Struck::Rear),
        (-180.0, Struck::Rear),
        (185.0, Struck::Rear),
        (-185.0, Struck::Rear),
        (225.1, Struck::Side),
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
fn who_nobody_stated_is_one_driver_of_what_moves() {
    assert_eq!(*occupants(BodyKind::Sedan, 3.0, None), [Some(Seat::FrontLeft)]);
    assert_eq!(*occupants(BodyKind::Motorcycle, 3.0, None), [Some(Seat::Rider)]);
    assert!(occupants(BodyKind::Bus, 0.0, None).is_empty());
    assert!(occupants(BodyKind::Wall, 0.0, None).is_empty());
    assert_eq!(*occupants(BodyKind::Pedestrian, 0.0, None), [None]);
    assert!(occupants(BodyKind::Sedan, 3.0, Some(&[])).is_empty());
    let both = [Seat::Rider, Seat::Pillion].map(|s| Occupant { seat: Some(s) });
    let riding = occupants(BodyKind::Motorcycle, 3.0, Some(&both));
    assert_eq!(*riding, [Some(Seat::Rider), Some(Seat::Pillion)]);
    let two = [Seat::FrontLeft, Seat::RearRight].map(|s| Occupant { seat: Some(s) });
    assert_eq!(
        *occupants(BodyKind::Sedan, 0.0, Some(&two)),
        [Some(Seat::FrontLeft), Some(Seat::RearRight)]
    );
}
