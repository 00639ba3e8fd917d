//! Exact orientation signs of the corners of a pair.
//!
//! On a [`Lattice`] where there is one. Else by the adaptive predicates of crate `robust` (J. R.
//! Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*,
//! Discrete & Computational Geometry 18, 1997), which are exact as long as nothing over- or
//! underflows. With every coordinate 0 or of magnitude in [2⁻²⁴⁸, 2²⁴⁸], all coordinates, their
//! differences and the tails of these are multiples of 2⁻³⁰⁰, all products of three multiples of
//! 2⁻⁹⁰⁰ and below 2⁷⁵⁰, and the smallest error bound, 2⁻¹⁰¹ of such a product, is a normal number:
//! nothing does. Other coordinates do occur, where a rotation by a minute angle meets a zero;
//! [`Wide`] takes them.

use super::lattice::Lattice;
use super::wide::{Magnitude, Wide};
use super::{Corner, Sign};
use crate::DVec3;
use robust::{Coord, Coord3D};

/// A point of a plane projection: two of the three coordinates.
pub(super) type Point2 = [f64; 2];

/// Magnitudes for which crate `robust` is exact, beside 0.
const ROBUST: core::ops::RangeInclusive<f64> =
    f64::from_bits((1023 - 248) << 52)..=f64::from_bits((1023 + 248) << 52);

/// The corners of a pair, for exact signs.
pub(super) struct Exact {
    corners: [DVec3; 6],
    lattice: Option<Lattice>,
}

impl Exact {
    /// `extent` (m) bounds all differences of coordinates.
    pub(super) fn of(corners: [DVec3; 6], extent: f64) -> Self {
        let lattice = Lattice::of(&corners, extent);
        Self { corners, lattice }
    }

    /// The sign of det(b − a, c − a, d − a): 1 if d lies on the side of the normal
    /// (b − a) × (c − a) of the plane abc, 0 if it lies in that plane or a, b, c on one line.
    pub(super) fn orient3d(&self, corners: [Corner; 4]) -> Sign {
        match &self.lattice {
            Some(lattice) => lattice.volume(corners).sign(),
            None => orient3d(corners.map(|i| self.corners[i])),
        }
    }

    /// The sign of det(b − a, c − a) without the coordinate `drop`: 1 if a, b, c turn
    /// counter-clockwise, 0 if they are on one line.
    pub(super) fn orient2d(&self, drop: usize, corners: [Corner; 3]) -> Sign {
        match &self.lattice {
            Some(lattice) => lattice.area(drop, corners).signum() as Sign,
            None => orient2d(corners.map(|i| flat(self.corners[i], drop))),
        }
    }

    /// How far along pq its cut with the plane lies, in [0, 1]: the exact fraction, rounded.
    ///
    /// p and q must not be both in the plane, nor on the same side of it.
    pub(super) fn cut_fraction3d(&self, [a, b, c]: [Corner; 3], p: Corner, q: Corner) -> f64 {
        let [p, q] = [p, q].map(|end| match &self.lattice {
            Some(lattice) => lattice.volume([a, b, c, end]).magnitude(),
            None => Wide::orient3d([a, b, c, end].map(|i| self.corners[i])).magnitude(),
        });
        Magnitude::share(p, q)
    }

    /// How far along pq its cut with the line ab lies: see [`Exact::cut_fraction3d`].
    pub(super) fn cut_fraction2d(
        &self,
        drop: usize,
        [a, b]: [Corner; 2],
        p: Corner,
        q: Corner,
    ) -> f64 {
        let [p, q] = [p, q].map(|end| match &self.lattice {
            Some(lattice) => Magnitude::of(lattice.area(drop, [a, b, end]).unsigned_abs(), 0),
            None => Wide::orient2d([a, b, end].map(|i| flat(self.corners[i], drop))).magnitude(),
        });
        Magnitude::share(p, q)
    }
}

/// Drops a coordinate; the handedness does not matter, as long as it is one and the same.
fn flat(point: DVec3, drop: usize) -> Point2 {
    [point[(drop + 1) % 3], point[(drop + 2) % 3]]
}

fn in_range(coordinate: f64) -> bool {
    coordinate == 0.0 || ROBUST.contains(&coordinate.abs())
}

fn sign(value: f64) -> Sign {
    Sign::from(value > 0.0) - Sign::from(value < 0.0)
}

/// [`Exact::orient3d`] without a lattice.
pub(super) fn orient3d(points: [DVec3; 4]) -> Sign {
    if points.iter().all(|p| in_range(p.x) && in_range(p.y) && in_range(p.z)) {
        let [a, b, c, d] = points.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
        // There, positive is below: the other way round.
        -sign(robust::orient3d(a, b, c, d))
    } else {
        Wide::orient3d(points).sign()
    }
}

/// [`Exact::orient2d`] without a lattice.
pub(super) fn orient2d(points: [Point2; 3]) -> Sign {
    if points.iter().all(|p| in_range(p[0]) && in_range(p[1])) {
        let [a, b, c] = points.map(|p| Coord { x: p[0], y: p[1] });
        sign(robust::orient2d(a, b, c))
    } else {
        Wide::orient2d(points).sign()
    }
}
