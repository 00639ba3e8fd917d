//! Laws of N, and which normals common crashes get.

use super::*;
use crate::path::{Meeting, plan};
use crate::scene::{Prism, Scene, car, head_on};
use proptest::prelude::*;

/// Angles of N from u, least and greatest, at pose r after first contact.
fn normals(scene: &Scene) -> (f64, f64) {
    let approach = scene.approach();
    let Ok(Meeting::Path(path)) = plan(&approach) else { panic!("no path") };
    let f = scene.first(&path, &approach).expect("contact");
    let r = path.patch_end(f);
    let normals = Normals::between(&approach, r, r, 0.0);
    let angles = || normals.possible.iter().map(|&i| 5.0 * turn(i) as f64);
    (angles().fold(f64::INFINITY, f64::min), angles().fold(0.0, f64::max))
}

/// Oncoming cars whose paths overlap by so much.
fn overlapping(lateral: f64) -> Scene {
    head_on(1.75 - lateral)
}

#[test]
fn narrow_overlaps_glance_and_wide_ones_meet_head_on() {
    for lateral in [0.02, 0.05, 0.1] {
        let (least, most) = normals(&overlapping(lateral));
        assert!(least >= 75.0 && most >= 90.0, "{lateral}: {least} to {most}");
    }
    for lateral in [0.2, 0.25, 0.3] {
        let (least, most) = normals(&overlapping(lateral));
        assert!(least == 0.0 && most >= 75.0, "{lateral}: {least} to {most}");
    }
    let (least, most) = normals(&overlapping(0.5));
    assert!(least == 0.0 && most <= 15.0, "{least} to {most}");
}

#[test]
fn a_pole_is_met_along_the_way() {
    let pole = |y: f64| Scene {
        b: Prism::round(0.05, [2.3, y]),
        party_b: car(1, 900.0, [2.3, y], 0.0),
        ..head_on(0.0)
    };
    for y in [0.0, 0.3, 0.5] {
        let (least, most) = normals(&pole(y));
        assert!(least == 0.0 && most <= 15.0, "{y}: {least} to {most}");
    }
}

proptest! {
    /// While the first contact is known only between two travels, everything that any first contact
    /// between them would give is possible, and what is sure belongs to each.
    #[test]
    fn normals_of_a_bracket_enclose_those_of_every_pose_in_it(
        x in 3.0..5.0_f64, y in -2.0..2.0_f64, turned in -180.0..180.0_f64,
        from in 0.0..0.5_f64, length in 0.0..0.3_f64, part in 0.0..1.0_f64,
    ) {
        let scene = Scene { b: Prism::cuboid(4.0, 1.7, [x, y], turned), ..head_on(0.0) };
        let approach = scene.approach();
        let bracket = Normals::between(&approach, from, from + length, 0.0);
        let at = from + part * length;
        let point = Normals::between(&approach, at, at, 0.0);
        prop_assert_eq!(point.nominal.len(), 1);
        prop_assert_eq!(&point.possible, &point.sure);
        prop_assert!(point.possible.iter().all(|i| bracket.possible.contains(i)));
        prop_assert!(bracket.sure.iter().all(|i| point.possible.contains(i)));
        prop_assert!(point.nominal.iter().all(|i| bracket.nominal.contains(i)));
    }
}

#[test]
fn degrees_are_signed_to_the_left() {
    assert_eq!([0, 1, 35, 36, 37, 71].map(degrees), [0.0, 5.0, 175.0, 180.0, -175.0, -5.0]);
}
