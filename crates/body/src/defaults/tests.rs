//! Defaults follow their sources and are accepted by every reader.

use super::*;
use crate::testing::mesh_of;
use proptest::prelude::*;

fn body(length: f32, width: f32, height: f32) -> Mesh {
    mesh_of(vec![[
        [1.0, -0.5 * width, 0.2],
        [1.0 + length, 0.5 * width, 0.2],
        [1.0, 0.0, 0.2 + height],
    ]])
}

fn assembled(kind: BodyKind, mesh: &Mesh) -> Meta {
    let origin = Origin { name: "n", kind, origin: "o", hash: "h" };
    assemble(origin, mesh)
}

proptest! {
    /// Whatever the size, defaults are valid divisors, and the centre lies in the body.
    #[test]
    fn defaults_are_always_usable(
        size in prop::array::uniform3(0.0_f32..1.0e5),
        kind in prop::sample::select(BodyKind::ALL.to_vec()),
    ) {
        let [length, width, height] = size;
        let mesh = body(length, width, height);
        let meta = assembled(kind, &mesh);
        prop_assert_eq!(meta.check(), Ok(()));
        prop_assert_eq!(meta.mass_kg.is_none(), kind.is_fixed());
        let bounds = Aabb::of(&mesh.corners[0]);
        for axis in 0..3 {
            let at = meta.centre_m[axis];
            prop_assert!(f64::from(bounds.min[axis]) <= at && at <= f64::from(bounds.max[axis]));
        }
    }

    /// The larger car is the heavier one.
    #[test]
    fn mass_rises_with_the_footprint(a in 1.0_f64..20.0, b in 1.0_f64..20.0) {
        let mass_of = |footprint| mass(BodyKind::Sedan, footprint).0.expect("a car has a mass");
        prop_assert!((a <= b) == (mass_of(a) <= mass_of(b)) || mass_of(a) == mass_of(b));
    }
}

#[test]
fn a_sedan_has_the_mass_of_the_formula() {
    let meta = assembled(BodyKind::Sedan, &body(4.5, 1.8, 1.4));
    // 526.9 · 8.1^0.8 − 1333.5, calculated independently.
    let mass = meta.mass_kg.expect("a car has a mass");
    assert!((mass - 1475.28).abs() < 0.5, "{mass}");
    assert!((meta.gyration_m - 1.26).abs() < 1e-6);
    assert!((meta.centre_m[2] - (0.2 + 0.56)).abs() < 1e-6);
    assert_eq!(meta.mass_source, "default, TUM formula of length times width");
    let toy = assembled(BodyKind::Suv, &body(2.0, 1.0, 1.0));
    assert!(toy.mass_source.ends_with("footprint 2.00 m² taken as 5 m²"), "{}", toy.mass_source);
}
