//! Defaults follow their sources, are accepted by every reader, and give way to the side file.

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

fn assembled(kind: Kind, mesh: &Mesh) -> Meta {
    let origin = Origin { name: "n", kind, origin: "o", hash: "h" };
    assemble(origin, mesh, None).expect("defaults do not contradict each other")
}

proptest! {
    /// Whatever the size, a default is a figure that can be divided by, and lies in the body.
    #[test]
    fn defaults_are_always_usable(
        size in prop::array::uniform3(0.0_f32..1.0e5),
        kind in prop::sample::select(Kind::ALL.to_vec()),
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
        let of = |footprint| mass(Kind::Sedan, footprint).0.expect("a car has a mass");
        prop_assert!((a <= b) == (of(a) <= of(b)) || of(a) == of(b));
    }
}

#[test]
fn a_sedan_has_the_mass_of_the_formula() {
    let meta = assembled(Kind::Sedan, &body(4.5, 1.8, 1.4));
    // 526.9 · 8.1^0.8 − 1333.5, by another calculator.
    let mass = meta.mass_kg.expect("a car has a mass");
    assert!((mass - 1475.28).abs() < 0.5, "{mass}");
    assert!((meta.gyration_m - 1.26).abs() < 1e-6);
    assert!((meta.centre_m[2] - (0.2 + 0.56)).abs() < 1e-6);
    assert_eq!(meta.mass_source, "default, TUM formula of length times width");
    let toy = assembled(Kind::Suv, &body(2.0, 1.0, 1.0));
    assert!(toy.mass_source.ends_with("footprint 2.00 m² taken as 5 m²"), "{}", toy.mass_source);
}

#[test]
fn the_side_file_wins_and_is_named() {
    let mesh = body(4.5, 1.8, 1.4);
    let text = "name = \"taxi\"\nmass_kg = 1550.0\ncentre_m = [3.0, 0.0, 0.7]\n\
                yaw_inertia_kg_m2 = 1053.5\noccupants = [{ seat = \"front-left\" }]\n\
                source = \"a data sheet\"\n";
    let side = Side::parse("cars/taxi.toml", text).expect("valid");
    let origin = Origin { name: "mesh", kind: Kind::Sedan, origin: "o", hash: "h" };
    let meta = assemble(origin, &mesh, Some(&side)).expect("it fits");
    assert_eq!((&*meta.name, meta.mass_kg, meta.centre_m), ("taxi", Some(1550.0), [3.0, 0.0, 0.7]));
    assert!((meta.gyration_m * meta.gyration_m * 1550.0 - 1053.5).abs() < 1e-9);
    assert_eq!(meta.occupants.map(|them| them.len()), Some(1));
    let source = "mass, centre, yaw inertia, occupants from taxi.toml (a data sheet), else default";
    assert_eq!(meta.mass_source, source);
}

#[test]
fn a_side_file_that_does_not_fit_is_refused_at_its_place() {
    let mesh = body(4.5, 1.8, 1.4);
    let cases = [
        (
            Kind::Sedan,
            "centre_m = [3.0, 0.0, 70.0]",
            "a.toml:1:12: centre_m [3.0, 0.0, 70.0] is far",
        ),
        (Kind::Wall, "\nmass_kg = 100.0", "a.toml:2:11: a wall is fixed to the ground"),
        (Kind::Pole, "yaw_inertia_kg_m2 = 1.0", "a.toml:1:21: a pole is fixed to the ground"),
        (
            Kind::Pedestrian,
            "occupants = [{ seat = \"rider\" }]",
            "a.toml:1:13: a pedestrian has no seat rider",
        ),
        (Kind::Sedan, "occupants = [{}]", "a.toml:1:13: an occupant of a sedan needs a seat"),
        (
            Kind::Cyclist,
            "occupants = [{ seat = \"rider\" }, { seat = \"rider\" }]",
            "a.toml:1:13: two occupants on seat rider",
        ),
    ];
    for (kind, text, expected) in cases {
        let side = Side::parse("a.toml", text).expect("right by itself");
        let origin = Origin { name: "mesh", kind, origin: "o", hash: "h" };
        let fault = assemble(origin, &mesh, Some(&side)).expect_err(text);
        assert!(fault.to_string().starts_with(expected), "{fault}");
    }
}
