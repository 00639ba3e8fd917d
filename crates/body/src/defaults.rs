//! Default mass, centre of mass and yaw gyration of a body, each with its source.
//!
//! Sources: the mass of cars is the regression that the ethical trajectory planner of the Technical
//! University of Munich uses, −1333.5 + 526.9 (L W)^0.8 kg over length times width, which it states
//! for 5 to 14 m²; its table gives the other road users. Yaw gyration 0.28 L: three cars with known
//! inertia have 0.261, 0.283 and 0.284. The height of the centre of mass is an assumption of this
//! project.

use crate::outline::{self, Outlines};
use crate::{BodyKind, Mesh, Meta};
use geometry::Aabb;

/// Yaw radius of gyration over the greatest horizontal extent.
pub const GYRATION_RATIO: f64 = 0.28;

/// Range of footprints covered by the mass formula for cars `[m²]`.
const FOOTPRINT_M2: [f64; 2] = [5.0, 14.0];

/// The identity of a body and the origin of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Origin<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// Its kind.
    pub kind: BodyKind,
    /// File, unit and axes, or the generator's call.
    pub origin: &'a str,
    /// BLAKE3 of the source, hexadecimal.
    pub hash: &'a str,
}

/// Mass, centre and gyration, with their source.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertia {
    /// Mass `[kg]`; `None` for an object fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Centre of mass, body frame `[m]`.
    pub centre_m: [f64; 3],
    /// Yaw radius of gyration `[m]`.
    pub gyration_m: f64,
    /// Source of the mass.
    pub mass_source: String,
}

/// Default inertia of a body of this kind with this box. The box must not be empty.
#[must_use]
pub fn inertia(kind: BodyKind, bounds: &Aabb) -> Inertia {
    let [length, width, height] =
        [0, 1, 2].map(|axis| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]));
    let middle = |axis: usize| (f64::from(bounds.min[axis]) + f64::from(bounds.max[axis])) / 2.0;
    let centre_height = f64::from(bounds.min[2]) + height * centre_height_ratio(kind);
    let (mass_kg, mass_source) = mass(kind, length * width);
    Inertia {
        mass_kg,
        centre_m: [middle(0), middle(1), centre_height],
        // A body without horizontal extent can still turn: a millimetre keeps the division finite.
        gyration_m: (GYRATION_RATIO * length.max(width)).max(0.001),
        mass_source,
    }
}

/// Height of the centre of mass relative to the height of the body `[A]`: engines and floors are
/// low, a standing person's centre is at the navel, a rider sits above the wheels.
fn centre_height_ratio(kind: BodyKind) -> f64 {
    match kind {
        BodyKind::Sedan | BodyKind::Suv | BodyKind::Truck | BodyKind::Bus => 0.4,
        BodyKind::Motorcycle | BodyKind::Cyclist => 0.5,
        BodyKind::Pedestrian => 0.55,
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => 0.5,
    }
}

fn mass(kind: BodyKind, footprint_m2: f64) -> (Option<f64>, String) {
    let table = |mass: f64, note: &str| (Some(mass), format!("default, TUM table{note}"));
    match kind {
        BodyKind::Sedan | BodyKind::Suv => {
            let [least, greatest] = FOOTPRINT_M2;
            let used = footprint_m2.clamp(least, greatest);
            let mass = -1333.5 + 526.9 * libm::pow(used, 0.8);
            let note = if used == footprint_m2 {
                String::new()
            } else {
                format!(", footprint {footprint_m2:.2} m² taken as {used} m²")
            };
            (Some(mass), format!("default, TUM formula of length times width{note}"))
        }
        BodyKind::Truck => table(25_000.0, ""),
        BodyKind::Bus => table(13_000.0, ""),
        BodyKind::Motorcycle => table(250.0, ", rider not counted"),
        BodyKind::Cyclist => table(90.0, ", bicycle with rider"),
        BodyKind::Pedestrian => table(75.0, ""),
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => {
            (None, "fixed to the ground".to_owned())
        }
    }
}

/// The default metadata of a body. Depth, leaf size and build must be filled in from the tree.
#[must_use]
pub fn assemble(origin: Origin<'_>, mesh: &Mesh) -> Meta {
    let outlines = Outlines::of(mesh, origin.kind);
    let mut usual = inertia(origin.kind, &mesh.bounds());
    if let Some([length, width]) = outlines.size_m().filter(|_| origin.kind.is_car_like()) {
        // Mirrors would make a car a sixth heavier.
        (usual.mass_kg, usual.mass_source) = mass(origin.kind, length * width);
    }
    Meta {
        name: origin.name.to_owned(),
        kind: origin.kind,
        mass_kg: usual.mass_kg,
        centre_m: usual.centre_m,
        gyration_m: usual.gyration_m,
        mass_source: usual.mass_source,
        impact: crate::OwnParameters::default(),
        impact_source: String::new(),
        occupants: None,
        parts: mesh.parts.clone(),
        origin: origin.origin.to_owned(),
        origin_hash: origin.hash.to_owned(),
        degenerate: mesh.degenerate,
        build: crate::Build::default(),
        leaf_size: 0,
        depth: 0,
        front_height_m: outline::front_height_m(mesh).filter(|_| origin.kind.is_car_like()),
        outlines,
    }
}

#[cfg(test)]
mod tests;
