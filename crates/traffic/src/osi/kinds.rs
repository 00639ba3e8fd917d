//! Which type of the library of bodies an object of OSI is.

use crate::trace::{car_by_size, kind_by_size};

/// `MovingObject.Type` and `VehicleClassification.Type` as a type of the library, and whether its
/// size decided.
pub(super) fn moving(
    kind: Option<i32>,
    vehicle: Option<i32>,
    size_m: [f64; 3],
) -> (&'static str, bool) {
    match (kind, vehicle) {
        (Some(3), _) => ("pedestrian", false),
        // Animals, and what the simulator calls other.
        (Some(1 | 4), _) => ("unknown", false),
        // Small, compact, medium and luxury car, delivery van.
        (_, Some(2..=6)) => (car_by_size(size_m), false),
        // Heavy truck, semitrailer, trailer, tractor of one.
        (_, Some(7 | 8 | 9 | 16)) => ("truck", false),
        (_, Some(10)) => ("motorcycle", false),
        (_, Some(11)) => ("bicycle", false),
        (_, Some(12)) => ("bus", false),
        // Tram, train.
        (_, Some(13 | 14)) => ("train", false),
        // Wheelchair, standing scooter, another device for one: a person without a shell.
        (_, Some(15 | 17 | 18)) => ("pedestrian", false),
        // Work machine; vessel, aircraft.
        (_, Some(19)) => ("truck", false),
        (_, Some(20 | 21)) => ("unknown", false),
        _ => (kind_by_size(size_m), true),
    }
}

/// `StationaryObject.Classification.Type` as a type of the library; the error is what it is called,
/// if road users pass over, below or beside it.
pub(super) fn stationary(kind: Option<i32>) -> Result<&'static str, &'static str> {
    match kind {
        Some(2) => Err("bridge"),
        Some(10) => Err("curbstone"),
        Some(14) => Err("overhead structure"),
        Some(17) => Err("speed bump"),
        Some(3) => Ok("building"),
        // Pole, pylon, delineator, tree, vertical and reflective structures, lamps.
        Some(4..=7 | 12 | 15 | 18) => Ok("pillar"),
        // Barrier, wall, rectangular structure.
        Some(8 | 11 | 13) => Ok("roadBoundary"),
        Some(16) => Ok("constructionZone"),
        _ => Ok("unknown"),
    }
}
