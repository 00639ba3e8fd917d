//! Invariants of merging, bit for bit, and the directions against their definition.

use super::*;
use crate::simd;
use fearless_simd::dispatch;
use proptest::prelude::*;

fn point() -> impl Strategy<Value = DVec3> {
    let coordinate = prop_oneof![
        (-2_i8..=2).prop_map(f64::from),
        Just(-0.0),
        -10.0..10.0_f64,
        Just(f64::from_bits(1)),
        Just(-f64::from_bits(1)),
    ];
    [coordinate.clone(), coordinate.clone(), coordinate].prop_map(DVec3::from_array)
}

fn points() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(point(), 0..6)
}

/// Directions with many zeros among their coordinates, or any.
fn directions() -> impl Strategy<Value = Directions> {
    prop_oneof![Just(0.0), Just(90.0), -180.0..180.0_f64].prop_map(|yaw: f64| {
        let (sin, cos) = libm::sincos(yaw.to_radians());
        Directions::around(DVec3::new(cos, sin, 0.0), DVec3::Z)
    })
}

fn of(directions: &Directions, points: &[DVec3]) -> Supports {
    let mut supports = Supports::EMPTY;
    for point in points {
        supports.add(directions, *point);
    }
    supports
}

fn merged(a: &Supports, b: &Supports) -> Supports {
    let mut sum = *a;
    sum.merge(b);
    sum
}

/// `==` treats +0 and −0 as equal; the bytes of an answer differ.
fn bits(supports: &Supports) -> [u64; DIRECTIONS] {
    supports.0.map(f64::to_bits)
}

proptest! {
    /// The greatest product, computed one direction at a time.
    #[test]
    fn is_the_greatest_product(d in directions(), points in points()) {
        let supports = of(&d, &points);
        for (support, d) in supports.0.iter().zip(&d.d) {
            let greatest = points.iter().map(|p| p.dot(*d)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert_eq!(*support, greatest);
            prop_assert_ne!(support.to_bits(), (-0.0_f64).to_bits());
        }
    }

    /// At every width, also with NaN coordinates.
    #[test]
    fn all_at_once_is_one_by_one(
        d in directions(),
        a in points(),
        b in points(),
        nan in 0_usize..9,
    ) {
        let mut more = b;
        if let Some(point) = more.get_mut(nan) {
            point.y = f64::NAN;
        }
        let whole = bits(&of(&d, &[a.clone(), more.clone()].concat()));
        for level in simd::levels() {
            let mut supports = of(&d, &a);
            dispatch!(level, simd => supports.add_all(simd, &d, &more));
            prop_assert_eq!(bits(&supports), whole, "at {}", simd::name(level));
        }
    }

    /// The order, the grouping and the number of times that points are added affect no bit.
    #[test]
    fn merges_are_order_free(d in directions(), a in points(), b in points(), c in points()) {
        let whole = bits(&of(&d, &[a.clone(), b.clone(), c.clone()].concat()));
        let back: Vec<DVec3> =
            [a.clone(), b.clone(), c.clone()].concat().into_iter().rev().collect();
        prop_assert_eq!(bits(&of(&d, &back)), whole);

        let [a, b, c] = [a, b, c].map(|points| of(&d, &points));
        prop_assert_eq!(bits(&merged(&merged(&a, &b), &c)), whole);
        prop_assert_eq!(bits(&merged(&a, &merged(&b, &c))), whole);
        prop_assert_eq!(bits(&merged(&c, &merged(&b, &a))), whole);
        prop_assert_eq!(bits(&merged(&a, &a)), bits(&a));
        prop_assert_eq!(bits(&merged(&a, &Supports::EMPTY)), bits(&a));
        prop_assert_eq!(bits(&merged(&Supports::EMPTY, &a)), bits(&a));
    }

    /// A zero from elsewhere, with the other sign, leaves no trace either.
    #[test]
    fn a_negative_zero_does_not_survive(
        d in directions(),
        at in 0..DIRECTIONS,
        points in points(),
    ) {
        let mut odd = Supports::EMPTY;
        odd.0[at] = -0.0;
        let rest = of(&d, &points);
        prop_assert_eq!(bits(&merged(&rest, &odd)), bits(&merged(&merged(&rest, &odd), &odd)));
        prop_assert_ne!(merged(&rest, &odd).0[at].to_bits(), (-0.0_f64).to_bits());
    }
}

#[test]
fn directions_stand_every_five_degrees_with_exact_opposites() {
    let (sin, cos) = libm::sincos(0.3);
    let (u, z) = (DVec3::new(cos, sin, 0.0), DVec3::Z);
    let d = Directions::around(u, z).d;
    for i in 0..72 {
        let angle = (5.0 * i as f64).to_radians();
        let expected = DVec3::new(libm::cos(0.3 + angle), libm::sin(0.3 + angle), 0.0);
        assert!(d[i].distance(expected) < 1e-15, "{i}: {} {expected}", d[i]);
        assert_eq!(d[(i + 36) % 72], -d[i]);
    }
    assert_eq!((d[0], d[72], d[73]), (u, z, -z));
}

#[test]
fn what_is_not_a_number_changes_nothing() {
    let d = Directions::around(DVec3::X, DVec3::Z);
    let before = of(&d, &[DVec3::ONE]);
    let mut after = before;
    after.add(&d, DVec3::NAN);
    after.merge(&Supports([f64::NAN; DIRECTIONS]));
    assert_eq!(bits(&after), bits(&before));
}
