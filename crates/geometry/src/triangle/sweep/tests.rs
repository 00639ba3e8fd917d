//! Laws of first contact that need no oracle; the oracle is in `tests/oracle`.

use super::*;
use crate::triangle::intersect;
use proptest::prelude::*;

/// Coordinates that often coincide or line up.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        3 => (-2_i8..=2).prop_map(f64::from),
        3 => -2.0..2.0_f64,
    ]
}

fn point() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

fn triangle() -> impl Strategy<Value = Triangle> {
    [point(), point(), point()].prop_map(Triangle)
}

fn whole() -> impl Strategy<Value = Triangle> {
    let point = || [-4_i8..=4, -4..=4, -4..=4].prop_map(|p| DVec3::from_array(p.map(f64::from)));
    [point(), point(), point()].prop_map(Triangle)
}

fn direction() -> impl Strategy<Value = DVec3> {
    point().prop_filter("it has a length", |d| *d != DVec3::ZERO)
}

fn moved(t: &Triangle, by: DVec3) -> Triangle {
    Triangle(t.0.map(|p| p + by))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5_000))]

    /// A rounded pose shortly before first contact does not touch; where contact lasts, one shortly
    /// after it does.
    #[test]
    fn is_where_intersection_begins(a in triangle(), b in triangle(), d in direction()) {
        let sweep = Sweep::new(d, -20.0, 20.0).unwrap();
        let touch_at = |s: f64| intersect(&a, &moved(&b, sweep.direction() * s));
        match first_contact(&a, &b, &sweep) {
            Some(touch) => {
                for k in 1..20 {
                    prop_assert!(!touch_at(touch.travel_m - 1e-6 * f64::from(k * k * k * k)));
                }
                // The least travel at which they touch may lie a rounding after the one found.
                let near = [touch.travel_m - TOLERANCE_M, touch.travel_m + TOLERANCE_M];
                let alone = sweep.between(near[0], near[1]).unwrap();
                prop_assert!(first_contact(&a, &b, &alone).is_some());
            }
            None => for k in -200..=200 {
                prop_assert!(!touch_at(0.05 * f64::from(k) + 1e-3));
            }
        }
    }

    /// Down to the least number and up to where squares overflow: what touches at rest is found,
    /// what never touches is not.
    #[test]
    fn is_the_same_at_any_scale(a in whole(), b in whole(), d in direction()) {
        let sweep = Sweep::new(d, -TRAVEL_MAX, TRAVEL_MAX).unwrap();
        let (touches, at_rest) = (first_contact(&a, &b, &sweep).is_some(), intersect(&a, &b));
        for exponent in [-1074, -1060, -500, -30, 30, 300, 450, 1000] {
            let scaled = |t: &Triangle| {
                Triangle(t.0.map(|p| {
                    DVec3::from_array(p.to_array().map(|x| libm::scalbn(x, exponent)))
                }))
            };
            let found = first_contact(&scaled(&a), &scaled(&b), &sweep).is_some();
            prop_assert!(found || !at_rest, "missed at 2^{exponent}");
            prop_assert!(touches || !found, "reported at 2^{exponent}");
        }
    }

    /// f64 and whole numbers agree wherever both answer.
    #[test]
    fn is_the_same_by_f64_and_exactly(a in triangle(), b in triangle(), d in direction()) {
        let sweep = Sweep::new(d, -20.0, 20.0).unwrap();
        let projected = Projected::of(&a, &b, &sweep);
        let sides = Sides::of(&projected);
        let exact = exact::interval(&a, &b, sweep.direction);
        if projected.are_beyond() || sides.are_apart() {
            prop_assert!(exact.is_none());
        } else if let Ok(interval) = sides.interval(&sweep) {
            prop_assert_eq!(interval.is_some(), exact.is_some());
            if let (Some(f64), Some(exact)) = (interval, exact) {
                prop_assert!((f64.start - exact.start).abs() <= TOLERANCE_M);
                prop_assert!((f64.end - exact.end).abs() <= 1e-3);
            }
        }
    }
}

fn assert_near(point: DVec3, expected: DVec3) {
    assert!((point - expected).abs().max_element() < 1e-8, "{point} instead of {expected}");
}

/// A rod that passes through a plate: where it is, not where it came in.
#[test]
fn the_point_is_common_to_both_while_contact_lasts() {
    let plate = Triangle([DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0]);
    let (low, high) = (DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, 1.0, 1.0));
    let rod = Triangle([low, high, high]);
    let sweep = Sweep::new(DVec3::X, -9.0, 9.0).unwrap();
    for (from_m, x) in [(-9.0, 0.0), (1.0, 0.0), (2.0, 1.0), (3.5, 2.5), (4.0, 3.0)] {
        let touch = first_contact(&plate, &rod, &sweep.between(from_m, 9.0).unwrap()).unwrap();
        assert_near(touch.point, DVec3::new(x, 1.0, 0.0));
    }
}

/// Edges that seem parallel to f64, seen along the motion, and cross at an end of B's.
#[test]
fn the_point_is_common_to_both_where_edges_are_nearly_parallel() {
    let a = [[-1.0, -3.0, -2.0], [0.0, 1.0, 0.0], [0.0, 3.0, 1.0]];
    let b = [
        [-0.75, -1.500_000_000_000_021_5, -1.250_000_000_000_010_9],
        [-1.681_922_192_505_741_3, -2.953_290_311_862_346_6, -1.976_645_155_931_173_5],
        [0.018_773_550_188_220_69, -2.598_110_667_570_580_1, -1.799_055_333_785_290_1],
    ];
    let [a, b] = [a, b].map(|corners| Triangle(corners.map(DVec3::from_array)));
    let sweep = Sweep::new(DVec3::X, -9.0, 9.0).unwrap();
    let touch = first_contact(&a, &b, &sweep).unwrap();
    // A corner of B, on the edge of A.
    assert_near(touch.point, b.0[2] + sweep.direction() * touch.travel_m);
}
