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
        let at = |s: f64| intersect(&a, &moved(&b, sweep.direction() * s));
        match first_contact(&a, &b, &sweep) {
            Some(touch) => {
                for k in 1..20 {
                    prop_assert!(!at(touch.travel_m - 1e-6 * f64::from(k * k * k * k)));
                }
                let alone = sweep.between(touch.travel_m, touch.travel_m).unwrap();
                prop_assert!(first_contact(&a, &b, &alone).is_some());
            }
            None => for k in -200..=200 {
                prop_assert!(!at(0.05 * f64::from(k) + 1e-3));
            }
        }
    }

    /// f64 and whole numbers agree wherever both answer.
    #[test]
    fn is_the_same_by_f64_and_exactly(a in triangle(), b in triangle(), d in direction()) {
        let sweep = Sweep::new(d, -20.0, 20.0).unwrap();
        let projected = Projected::of(&a, &b, &sweep);
        let exact = exact::interval(&a, &b, sweep.direction);
        if projected.are_apart() {
            prop_assert!(exact.is_none());
        } else if let Ok(interval) = projected.interval(&sweep) {
            prop_assert_eq!(interval.is_some(), exact.is_some());
            if let (Some(f64), Some(exact)) = (interval, exact) {
                prop_assert!((f64.start - exact.start).abs() <= TOLERANCE_M);
                prop_assert!((f64.end - exact.end).abs() <= 1e-3);
            }
        }
    }
}
