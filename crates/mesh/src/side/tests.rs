//! A side file is read whole or refused with file, line and column.

use super::*;
use body::Mesh;
use body::defaults::{Origin, assemble};
use body::testing::mesh_of;

#[test]
fn every_fault_has_line_and_column() {
    let cases = [
        ("mass_kg = 1.0\nmas_kg = 1.0\n", "a.toml:2:1: unknown field `mas_kg`"),
        ("\n  mass_kg = -1.0\n", "a.toml:2:13: mass_kg = -1 is not in (0, 1000000]"),
        ("mass_kg = nan", "a.toml:1:11: mass_kg = NaN is not in (0, 1000000]"),
        ("mass_kg = inf", "a.toml:1:11: mass_kg = inf is not in (0, 1000000]"),
        ("gyration_m = 0.0", "a.toml:1:14: gyration_m = 0 is not in (0, 1000000]"),
        ("centre_m = [0.0, nan, 1.0]", "a.toml:1:12: centre_m [0.0, NaN, 1.0] is not finite"),
        (
            "yaw_inertia_kg_m2 = 9.0\ngyration_m = 1.0",
            "a.toml:1:21: yaw_inertia_kg_m2 and gyration_m",
        ),
        ("name = \"  \"", "a.toml:1:8: the name is empty"),
        ("kind = \"boat\"", "a.toml:1:8: unknown variant `boat`"),
        ("occupants = [{ chair = 1 }]", "a.toml:1:16: unknown field `chair`"),
        ("name = \"\u{e9}\" mass", "a.toml:1:12: "),
        ("mass_kg = 1.0\nmass_kg = 2.0", "a.toml:2:1: \"mass_kg\" stands here a second time"),
        ("\n[impact]\nmass_share = 0.1", "a.toml:2:1: what is known of its impacts has no source"),
        ("source = \" \"\n[impact]\nmass_share = 0.1", "a.toml:2:1: what is known of its impacts"),
        ("source = \"s\"\n[impact]\nslip = 0.1", "a.toml:3:1: unknown field `slip`"),
        ("source = \"s\"\n[impact]\nfriction = 0.1", "a.toml:3:12: invalid type"),
    ];
    for (text, expected) in cases {
        let fault = SideFile::parse("a.toml", text).expect_err(text);
        assert!(fault.to_string().starts_with(expected), "{text:?}: {fault}");
        assert!(!fault.remedy.is_empty());
    }
}

#[test]
fn an_empty_file_says_nothing() {
    let side = SideFile::parse("a.toml", "# nothing is known\n").expect("valid");
    assert_eq!((side.name(), side.kind()), (None, None));
}

#[test]
fn the_documented_example_is_read() {
    let text = "name = \"sedan\"\nkind = \"sedan\"\nmass_kg = 1550.0\ncentre_m = [0.0, 0.0, 0.7]\n\
                yaw_inertia_kg_m2 = 1053.5\noccupants = [{ seat = \"front-left\" }]\n\
                source = \"maker's data sheet, 2024\"\n";
    let side = SideFile::parse("a.toml", text).expect("valid");
    assert_eq!((side.name(), side.kind()), (Some("sedan"), Some(BodyKind::Sedan)));
}

/// A body of one triangle whose box has this size (m).
fn body_of_size(length: f32, width: f32, height: f32) -> Mesh {
    mesh_of(vec![[
        [1.0, -0.5 * width, 0.2],
        [1.0 + length, 0.5 * width, 0.2],
        [1.0, 0.0, 0.2 + height],
    ]])
}

#[test]
fn the_side_file_wins_and_is_named() {
    let mesh = body_of_size(4.5, 1.8, 1.4);
    let text = "name = \"taxi\"\nmass_kg = 1550.0\ncentre_m = [3.0, 0.0, 0.7]\n\
                yaw_inertia_kg_m2 = 1053.5\noccupants = [{ seat = \"front-left\" }]\n\
                source = \"a data sheet\"\n\
                [impact]\nrestitution = { low = 0.1, nominal = 0.2, high = 0.2 }\n";
    let side = SideFile::parse("cars/taxi.toml", text).expect("valid");
    let origin = Origin { name: "mesh", kind: BodyKind::Sedan, origin: "o", hash: "h" };
    let mut meta = assemble(origin, &mesh);
    side.apply(&mut meta, &mesh.bounds()).expect("it fits");
    assert_eq!((&*meta.name, meta.mass_kg, meta.centre_m), ("taxi", Some(1550.0), [3.0, 0.0, 0.7]));
    assert!((meta.gyration_m * meta.gyration_m * 1550.0 - 1053.5).abs() < 1e-9);
    assert_eq!(meta.occupants.map(|them| them.len()), Some(1));
    let source = "mass, centre, yaw inertia, occupants from taxi.toml (a data sheet), else default";
    assert_eq!(meta.mass_source, source);
    let own = meta.impact.restitution.map(|of| [of.low, of.nominal, of.high]);
    assert_eq!((own, meta.impact.friction), (Some([0.1, 0.2, 0.2]), None));
    assert_eq!(meta.impact_source, "taxi.toml (a data sheet)");
}

#[test]
fn a_side_file_that_does_not_fit_is_refused_at_its_place() {
    let mesh = body_of_size(4.5, 1.8, 1.4);
    let cases = [
        (
            BodyKind::Sedan,
            "centre_m = [3.0, 0.0, 70.0]",
            "a.toml:1:12: centre_m [3.0, 0.0, 70.0] is far",
        ),
        (
            BodyKind::Wall,
            "source = \"s\"\n[impact]\nmass_share = 0.1",
            "a.toml:2:1: a wall is fixed to the ground",
        ),
        (
            BodyKind::Sedan,
            "source = \"s\"\n[impact]\nfriction = { low = 0.2, nominal = 0.1, high = 0.3 }",
            "a.toml:2:1: friction is not 0 ≤ low ≤ nominal ≤ high ≤ 10",
        ),
        (
            BodyKind::Sedan,
            "source = \"s\"\n[impact]\nface_tangential_share = 0.1",
            "a.toml:2:1: a sedan has no long flat face",
        ),
        (BodyKind::Wall, "\nmass_kg = 100.0", "a.toml:2:11: a wall is fixed to the ground"),
        (BodyKind::Pole, "yaw_inertia_kg_m2 = 1.0", "a.toml:1:21: a pole is fixed to the ground"),
        (
            BodyKind::Pedestrian,
            "occupants = [{ seat = \"rider\" }]",
            "a.toml:1:13: a pedestrian has no seat rider",
        ),
        (BodyKind::Sedan, "occupants = [{}]", "a.toml:1:13: an occupant of a sedan needs a seat"),
        (
            BodyKind::Cyclist,
            "occupants = [{ seat = \"rider\" }, { seat = \"rider\" }]",
            "a.toml:1:13: two occupants on seat rider",
        ),
    ];
    for (kind, text, expected) in cases {
        let side = SideFile::parse("a.toml", text).expect("right by itself");
        let origin = Origin { name: "mesh", kind, origin: "o", hash: "h" };
        let mut meta = assemble(origin, &mesh);
        let fault = side.apply(&mut meta, &mesh.bounds()).expect_err(text);
        assert!(fault.to_string().starts_with(expected), "{fault}");
    }
}
