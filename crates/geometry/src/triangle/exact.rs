//! Exact orientation signs of f64 points.
//!
//! The adaptive predicates of crate `robust` (J. R. Shewchuk, *Adaptive Precision Floating-Point
//! Arithmetic and Fast Robust Geometric Predicates*, Discrete & Computational Geometry 18, 1997)
//! are exact as long as nothing over- or underflows. With every coordinate 0 or of magnitude in
//! [2⁻²⁴⁸, 2²⁴⁸], all coordinates, their differences and the tails of these are multiples of 2⁻³⁰⁰,
//! all products of three multiples of 2⁻⁹⁰⁰ and below 2⁷⁵⁰, and the smallest error bound, 2⁻¹⁰¹
//! of such a product, is a normal number: nothing does. Other coordinates do occur, where a
//! rotation by a minute angle meets a zero; [`Wide`] takes them.

use super::wide::Wide;
use crate::DVec3;
use robust::{Coord, Coord3D};

/// −1, 0 or 1.
pub(super) type Sign = i8;

/// A point of a plane projection: two of the three coordinates.
pub(super) type Point2 = [f64; 2];

/// Magnitudes for which crate `robust` is exact, beside 0.
const ROBUST: core::ops::RangeInclusive<f64> =
    f64::from_bits((1023 - 248) << 52)..=f64::from_bits((1023 + 248) << 52);

fn in_range(coordinate: f64) -> bool {
    coordinate == 0.0 || ROBUST.contains(&coordinate.abs())
}

fn sign(value: f64) -> Sign {
    Sign::from(value > 0.0) - Sign::from(value < 0.0)
}

/// The sign of det(b − a, c − a, d − a): 1 if d lies on the side of the normal (b − a) × (c − a)
/// of the plane abc, 0 if it lies in that plane or a, b, c on one line.
pub(super) fn orient3d(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Sign {
    // The zeros that do occur, shared corners and axis-aligned faces, without any arithmetic.
    let level = |i: usize| a[i] == b[i] && a[i] == c[i] && a[i] == d[i];
    if a == d || b == d || c == d || a == b || a == c || b == c || level(0) || level(1) || level(2)
    {
        return 0;
    }
    if [a, b, c, d].iter().all(|p| in_range(p.x) && in_range(p.y) && in_range(p.z)) {
        let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
        // There, positive is below: the other way round.
        -sign(robust::orient3d(a, b, c, d))
    } else {
        Wide::orient3d(a, b, c, d).sign()
    }
}

/// The sign of det(b − a, c − a): 1 if a, b, c turn counter-clockwise, 0 if they are on one line.
pub(super) fn orient2d(a: Point2, b: Point2, c: Point2) -> Sign {
    if [a, b, c].iter().all(|p| in_range(p[0]) && in_range(p[1])) {
        let [a, b, c] = [a, b, c].map(|p| Coord { x: p[0], y: p[1] });
        sign(robust::orient2d(a, b, c))
    } else {
        Wide::orient2d(a, b, c).sign()
    }
}

/// How far along pq its cut with the plane lies, in [0, 1]: the exact fraction, rounded.
///
/// p and q must not be both in the plane, nor on the same side of it.
pub(super) fn cut_fraction3d(plane: &[DVec3; 3], p: DVec3, q: DVec3) -> f64 {
    let [a, b, c] = *plane;
    Wide::share(&Wide::orient3d(a, b, c, p), &Wide::orient3d(a, b, c, q))
}

/// How far along pq its cut with the line ab lies: see [`cut_fraction3d`].
pub(super) fn cut_fraction2d(a: Point2, b: Point2, p: Point2, q: Point2) -> f64 {
    Wide::share(&Wide::orient2d(a, b, p), &Wide::orient2d(a, b, q))
}
