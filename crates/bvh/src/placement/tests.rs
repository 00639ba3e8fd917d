//! The invariant of box tests: boxes whose points can meet are never apart.

use super::*;
use crate::fixtures::{Random, pose, triangles};
use geometry::{Corners, Pose, triangle};
use proptest::prelude::*;

fn box_of(corners: &[Corners]) -> Aabb {
    corners.iter().map(Aabb::of).fold(Aabb::EMPTY, |sum, box_| sum.union(&box_))
}

fn apart(placement: &Placement, a: &Aabb, b: &Aabb) -> bool {
    placement.apart(&placement.box_a(a), &placement.box_b(b))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn triangles_that_meet_are_never_apart(a in triangles(12), b in triangles(12), pose in pose()) {
        let placement = Placement::new(&pose, &box_of(&a), &box_of(&b));
        for of_a in &a {
            let at_a = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY).triangle(of_a);
            for of_b in &b {
                if triangle::intersect(&at_a, &pose.triangle(of_b)) {
                    prop_assert!(!apart(&placement, &Aabb::of(of_a), &Aabb::of(of_b)));
                }
            }
        }
    }

    /// The axes of one frame alone reject less: what they reject, the axes of both frames do too.
    #[test]
    fn both_frames_reject_what_one_does(a in triangles(6), b in triangles(6), pose in pose()) {
        let placement = Placement::new(&pose, &box_of(&a), &box_of(&b));
        for (of_a, of_b) in a.iter().zip(&b).map(|(a, b)| (Aabb::of(a), Aabb::of(b))) {
            // Within a hair either result is possible: boxes are shrunk by more than the slack.
            let placed = pose.bounds(&of_b);
            let gap = (placed.min - of_a.bounds().max).max(of_a.bounds().min - placed.max);
            if gap.max_element() > 1e-9 {
                prop_assert!(apart(&placement, &of_a, &of_b));
            }
        }
    }

    /// A point of B placed exactly on a point of A, far from both origins, where rounding is worst.
    #[test]
    fn points_that_coincide_are_never_apart(
        seed in any::<u32>(), yaw in -180.0..180.0, pitch in -90.0..90.0, far in 0_i32..7,
    ) {
        let mut random = Random::new(u64::from(seed) << 20);
        let scale = 10_f32.powi(far);
        let mut point = || [0; 3].map(|_| scale * (random.unit() - 0.5));
        let (on_a, on_b) = (point(), point());
        let turned = Pose::from_degrees(yaw, pitch, 33.0, [0.0; 3]);
        let mut pose = RelativePose::between(&Pose::IDENTITY, &turned);
        let away = pose.point(on_b);
        pose.translation = [0, 1, 2].map(|i| f64::from(on_a[i]) - away[i]);
        let (a, b) = (Aabb { min: on_a, max: on_a }, Aabb { min: on_b, max: on_b });
        // What the translation loses to rounding is a real gap.
        let gap = (pose.point(on_b) - a.bounds().min).abs().max_element();
        prop_assert!(gap <= 1e-15 * f64::from(scale) * 16.0);
        prop_assert!(!apart(&Placement::new(&pose, &a, &b), &a, &b));
    }

    /// What touches on its way does not pass.
    #[test]
    fn triangles_that_meet_on_their_way_do_not_pass(
        a in triangles(8), b in triangles(8), pose in pose(),
        angle in 0.0..360.0_f64, rise in -1.0..1.0_f64, from_m in -9.0..0.0, length_m in 0.0..9.0,
    ) {
        let (sin, cos) = angle.to_radians().sin_cos();
        let ahead = DVec3::new(cos, sin, if rise.abs() < 0.5 { 0.0 } else { rise }).normalize();
        let sweep = Sweep::new(ahead, from_m, from_m + length_m).expect("a motion");
        for of_a in &a {
            for of_b in &b {
                let (at_a, at_b) = (geometry::Triangle::stored(of_a), pose.triangle(of_b));
                if geometry::sweep::first_contact(&at_a, &at_b, &sweep).is_some() {
                    let boxes = [&Aabb::of(of_a), &Aabb::of(of_b)];
                    prop_assert!(!pass_apart(&pose, boxes, &sweep));
                }
            }
        }
    }

    /// A point of B that comes to a point of A at the begin, on the way or at the end.
    #[test]
    fn points_that_come_together_do_not_pass(
        seed in any::<u32>(), yaw in -180.0..180.0, far in 0_i32..7, share in 0_u8..3,
    ) {
        let mut random = Random::new(u64::from(seed) << 20);
        let scale = 10_f32.powi(far);
        let mut point = || [0; 3].map(|_| scale * (random.unit() - 0.5));
        let (on_a, on_b, ahead) = (point(), point(), point());
        let ahead = DVec3::from_array(ahead.map(f64::from)).normalize();
        let sweep = Sweep::new(ahead, -3.0, 5.0).expect("a motion");
        let at_m = -3.0 + 4.0 * f64::from(share);
        let mut pose =
            RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(yaw, 7.0, 33.0, [0.0; 3]));
        let (away, ahead) = (pose.point(on_b), sweep.direction());
        pose.translation =
            [0, 1, 2].map(|i| f64::from(on_a[i]) - away[i] - ahead[i] * at_m);
        let (a, b) = (Aabb { min: on_a, max: on_a }, Aabb { min: on_b, max: on_b });
        prop_assert!(!pass_apart(&pose, [&a, &b], &sweep));
    }

    /// R need not be orthonormal: a wrong one costs speed, never a pair.
    #[test]
    fn a_rotation_that_is_none_loses_nothing(
        a in triangles(8), b in triangles(8), pose in pose(),
        stretch in 0.5..2.0, shear in -0.5..0.5,
    ) {
        let mut pose = pose;
        for row in &mut pose.rotation {
            *row = [row[0] * stretch, row[1] + shear * row[2], row[2]];
        }
        let placement = Placement::new(&pose, &box_of(&a), &box_of(&b));
        for of_a in &a {
            let at_a = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY).triangle(of_a);
            for of_b in &b {
                if triangle::intersect(&at_a, &pose.triangle(of_b)) {
                    prop_assert!(!apart(&placement, &Aabb::of(of_a), &Aabb::of(of_b)));
                }
            }
        }
    }
}

#[test]
fn boxes_a_hand_apart_are_apart() {
    let cube = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let apart_at = |x: f64, yaw: f64| {
        let there = Pose::from_degrees(yaw, 0.0, 0.0, [x, 0.0, 0.0]);
        let pose = RelativePose::between(&Pose::IDENTITY, &there);
        apart(&Placement::new(&pose, &cube, &cube), &cube, &cube)
    };
    assert_eq!([apart_at(2.0, 0.0), apart_at(2.000_001, 0.0)], [false, true]);
    // Turned by 45°, the edge of one cube comes to lie 1 + √2 from the middle of the other.
    assert_eq!([apart_at(2.414, 45.0), apart_at(2.415, 45.0)], [false, true]);
}

#[test]
fn cubes_pass_beside_each_other_and_before_they_meet() {
    let cube = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let passes = |[x, y]: [f64; 2], to_m: f64| {
        let there = Pose::from_degrees(0.0, 0.0, 0.0, [x, y, 0.0]);
        let pose = RelativePose::between(&Pose::IDENTITY, &there);
        let sweep = Sweep::new(DVec3::NEG_X, 0.0, to_m).expect("a motion");
        pass_apart(&pose, [&cube, &cube], &sweep)
    };
    assert_eq!([passes([9.0, 2.000_001], 20.0), passes([9.0, 2.0], 20.0)], [true, false]);
    assert_eq!([passes([9.0, 0.0], 6.999), passes([9.0, 0.0], 7.0)], [true, false]);
    assert!(passes([-9.0, 0.0], 20.0), "it moves away");
    assert!(!passes([f64::NAN, f64::NAN], 20.0));
}

#[test]
fn a_corner_that_points_past_is_apart_along_an_axis_of_b() {
    let (slab, cube) =
        (Aabb { min: [-1.0; 3], max: [1.0; 3] }, Aabb { min: [-1.0; 3], max: [1.0; 3] });
    // Diagonal neighbours: boxes around them overlap in A's frame, but not in B's.
    let there = Pose::from_degrees(45.0, 0.0, 0.0, [1.9, 1.9, 0.0]);
    let pose = RelativePose::between(&Pose::IDENTITY, &there);
    assert!(pose.bounds(&cube).overlaps(&slab.bounds()));
    assert!(apart(&Placement::new(&pose, &slab, &cube), &slab, &cube));
}

#[test]
fn what_is_not_finite_is_not_apart() {
    let cube = Aabb { min: [-1.0; 3], max: [1.0; 3] };
    let mut pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    pose.translation[1] = f64::NAN;
    assert!(!apart(&Placement::new(&pose, &cube, &cube), &cube, &cube));
}
