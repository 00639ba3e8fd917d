//! Boxes never lose a point; poses compose like matrices.

use super::*;
use proptest::prelude::*;

/// Angles (°) with exact and almost exact zeros among their sines, and minute ones.
fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-4_i8..=4).prop_map(|quarter| 90.0 * f64::from(quarter)),
        -180.0..180.0_f64,
        (-180.0..180.0_f64, 0..1060_i32).prop_map(|(x, down)| libm::scalbn(x, -down)),
    ]
}

fn pose() -> impl Strategy<Value = Pose> {
    let metres = prop_oneof![
        Just(0.0),
        -100.0..100.0_f64,
        (-1.0..1.0_f64, -1060..300_i32).prop_map(|(x, e)| libm::scalbn(x, e)),
    ];
    (angle(), angle(), angle(), [metres.clone(), metres.clone(), metres])
        .prop_map(|(yaw, pitch, roll, at)| Pose::from_degrees(yaw, pitch, roll, at))
}

/// Any finite f32: huge, denormal, zero, and ordinary ones more often.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        3 => -10.0..10.0_f32,
        1 => any::<f32>().prop_filter("finite", |x| x.is_finite()),
        1 => (-3_i8..=3).prop_map(|n| f32::from(n) * f32::from_bits(1)),
    ]
}

fn corner() -> impl Strategy<Value = [f32; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    /// The box in A's frame contains the corners of B's box, points of its faces, and points
    /// inside.
    #[test]
    fn bounds_hold_every_point(
        a in pose(),
        b in pose(),
        p in corner(),
        q in corner(),
        picks in prop::collection::vec([0_usize..3, 0_usize..3, 0_usize..3], 1..20),
        shares in [0.0..=1.0_f32, 0.0..=1.0_f32, 0.0..=1.0_f32],
    ) {
        let pose = RelativePose::between(&a, &b);
        let mut box_ = Aabb::EMPTY;
        box_.grow(p);
        box_.grow(q);
        let bounds = pose.bounds(&box_);
        for pick in picks {
            let point: [f32; 3] = core::array::from_fn(|i| {
                let inside = box_.min[i] + (box_.max[i] * shares[i] - box_.min[i] * shares[i]);
                [box_.min[i], box_.max[i], inside.clamp(box_.min[i], box_.max[i])][pick[i]]
            });
            let moved = pose.point(point);
            prop_assert!(
                bounds.min.cmple(moved).all() && moved.cmple(bounds.max).all(),
                "{point:?} goes to {moved}, out of {bounds:?}"
            );
        }
    }

    /// Also where every product is below the normal range, as with a minute sine and a body that is
    /// flat along the other axes.
    #[test]
    fn bounds_hold_every_point_below_the_normal_range(
        entries in [-9.0..9.0_f64, -9.0..9.0_f64, -9.0..9.0_f64],
        down in -926..-922_i32,
        p in [-4_i8..=4, -4_i8..=4, -4_i8..=4],
        q in [-4_i8..=4, -4_i8..=4, -4_i8..=4],
        pick in [any::<bool>(), any::<bool>(), any::<bool>()],
    ) {
        let row = entries.map(|x| libm::scalbn(x, down));
        let pose = RelativePose { rotation: [row; 3], translation: [0.0; 3] };
        let [p, q] = [p, q].map(|p| p.map(|n| f32::from(n) * f32::from_bits(1)));
        let mut box_ = Aabb::EMPTY;
        box_.grow(p);
        box_.grow(q);
        let corner = core::array::from_fn(|i| if pick[i] { box_.min[i] } else { box_.max[i] });
        let (bounds, moved) = (pose.bounds(&box_), pose.point(corner));
        prop_assert!(bounds.min.cmple(moved).all() && moved.cmple(bounds.max).all());
    }

    /// Rounding outward costs little: the box exceeds the true one by at most 10⁻¹⁴ of the
    /// magnitudes involved.
    #[test]
    fn bounds_are_tight(a in pose(), b in pose(), p in corner(), q in corner()) {
        let pose = RelativePose::between(&a, &b);
        let mut box_ = Aabb::EMPTY;
        box_.grow(p);
        box_.grow(q);
        let bounds = pose.bounds(&box_);
        let corners = (0..8).map(|k| {
            pose.point(core::array::from_fn(|i| if k >> i & 1 == 0 { p[i] } else { q[i] }))
        });
        let (low, high) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let reach = p.iter().chain(&q).map(|x| f64::from(x.abs())).fold(0.0, f64::max);
        let shift = pose.translation.iter().fold(0.0, |most, t| t.abs().max(most));
        let room = DVec3::splat(1e-14 * (4.0 * reach + shift) + 1e-300);
        prop_assert!((low - bounds.min).cmple(room).all() && (bounds.max - high).cmple(room).all());
    }

    /// B in A's frame, then A in the world, is B in the world: up to rounding.
    #[test]
    fn relative_pose_composes(
        angles in [angle(), angle(), angle(), angle(), angle(), angle()],
        at in [-100.0..100.0_f64, -100.0..100.0_f64, -100.0..100.0_f64],
        p in [-10.0..10.0_f32, -10.0..10.0_f32, -10.0..10.0_f32],
    ) {
        let a = Pose::from_degrees(angles[0], angles[1], angles[2], at);
        let b = Pose::from_degrees(angles[3], angles[4], angles[5], [at[1], at[2], at[0]]);
        let seen = RelativePose::between(&a, &b).point(p);
        let to_world = |pose: &Pose, x: [f64; 3]| -> [f64; 3] {
            core::array::from_fn(|i| {
                let r = pose.rotation[i];
                r[0] * x[0] + r[1] * x[1] + r[2] * x[2] + pose.translation[i]
            })
        };
        let through_a = to_world(&a, seen.to_array());
        let direct = to_world(&b, p.map(f64::from));
        for (x, y) in through_a.iter().zip(direct) {
            prop_assert!((x - y).abs() < 1e-11, "{through_a:?} {direct:?}");
        }
    }
}

#[test]
fn the_empty_box_stays_empty() {
    let pose =
        RelativePose::between(&Pose::IDENTITY, &Pose::from_degrees(30.0, 0.0, 0.0, [1.0; 3]));
    let nothing = pose.bounds(&Aabb::EMPTY);
    let all = Bounds { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
    assert!(!nothing.overlaps(&all) && !all.overlaps(&nothing));
}

#[test]
fn yaw_turns_left_pitch_turns_down_roll_turns_right() {
    let near = |pose: Pose, p: [f32; 3], expected: DVec3| {
        let point = RelativePose::between(&Pose::IDENTITY, &pose).point(p);
        assert!(point.distance(expected) < 1e-15, "{point} {expected}");
    };
    near(Pose::from_degrees(90.0, 0.0, 0.0, [0.0; 3]), [1.0, 0.0, 0.0], DVec3::Y);
    near(Pose::from_degrees(0.0, 90.0, 0.0, [0.0; 3]), [1.0, 0.0, 0.0], DVec3::NEG_Z);
    near(Pose::from_degrees(0.0, 0.0, 90.0, [0.0; 3]), [0.0, 1.0, 0.0], DVec3::Z);
    // Z·Y·X: roll first, about the body's own x, yaw last.
    near(Pose::from_degrees(90.0, 0.0, 90.0, [0.0; 3]), [0.0, 1.0, 0.0], DVec3::Z);
    near(Pose::from_degrees(90.0, 90.0, 0.0, [0.0; 3]), [0.0, 0.0, 1.0], DVec3::Y);
}
