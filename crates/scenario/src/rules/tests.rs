//! The rules here and those of model files agree, case by case.

use super::*;
use body::{Build, Meta, Seat};

fn seats() -> impl Iterator<Item = Option<Seat>> {
    [None].into_iter().chain(Seat::ALL.map(Some))
}

/// What a model file would have to say, checked by its own crate: the oracle.
fn model_accepts(kind: BodyKind, mass_kg: Option<f64>, persons: &[Occupant]) -> bool {
    let meta = Meta {
        name: String::new(),
        kind,
        mass_kg: mass_kg.or((!kind.is_fixed()).then_some(1.0)),
        centre_m: [0.0; 3],
        gyration_m: 1.0,
        mass_source: String::new(),
        impact: body::OwnParameters::default(),
        impact_source: String::new(),
        occupants: Some(persons.to_vec()),
        parts: Vec::new(),
        origin: String::new(),
        origin_hash: String::new(),
        degenerate: 0,
        build: Build::Paper,
        leaf_size: 1,
        depth: 1,
        outlines: Default::default(),
        front_height_m: None,
    };
    meta.check().is_ok()
}

fn persons_fit(kind: Option<BodyKind>, persons: &[Occupant]) -> bool {
    (0..persons.len()).all(|i| person_fits(kind, persons[i], &persons[..i]).is_ok())
}

#[test]
fn persons_fit_wherever_a_model_file_may_have_them() {
    for kind in BodyKind::ALL {
        for first in seats() {
            for second in seats() {
                let persons = [Occupant { seat: first }, Occupant { seat: second }];
                for persons in [&persons[..], &persons[..1], &[]] {
                    let expected = model_accepts(kind, None, persons);
                    assert_eq!(persons_fit(Some(kind), persons), expected, "{kind} {persons:?}");
                    // What fits some kind is not refused before the kind is known.
                    assert!(!expected || persons_fit(None, persons), "{kind} {persons:?}");
                }
            }
        }
    }
}

#[test]
fn a_mass_fits_wherever_a_model_file_may_have_one() {
    for kind in BodyKind::ALL {
        assert!(mass_fits(kind, None).is_ok());
        assert_eq!(mass_fits(kind, Some(80.0)).is_ok(), model_accepts(kind, Some(80.0), &[]));
    }
}

#[test]
fn what_has_no_mass_cannot_drive() {
    for kind in BodyKind::ALL {
        assert!(ego_fits(kind).is_err() || mass_fits(kind, Some(1.0)).is_ok(), "{kind}");
        // An ego carries persons on seats.
        assert_eq!(ego_fits(kind).is_ok(), !kind.seats().is_empty() && kind != BodyKind::Cyclist);
    }
}
