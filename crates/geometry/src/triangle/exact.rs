//! Exact orientation signs of the corners of a pair.
//!
//! Computed on a [`Lattice`] if one exists, else by the adaptive predicates of crate `robust` (J.
//! R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates*, Discrete & Computational Geometry 18, 1997), which are exact as long as nothing
//! over- or underflows. With every coordinate 0 or of magnitude in [2⁻²⁴⁸, 2²⁴⁸], all coordinates,
//! their differences and the tails of these are multiples of 2⁻³⁰⁰, all products of three multiples
//! of 2⁻⁹⁰⁰ and below 2⁷⁵⁰, and the smallest error bound, 2⁻¹⁰¹ of such a product, is a normal
//! number: nothing over- or underflows. Other coordinates do occur, where a rotation by a minute
//! angle meets a zero; [`Wide`] handles them.

use super::lattice::{Lattice, area};
use super::wide::{Magnitude, Wide};
use super::{Corner, Sign};
use crate::DVec3;
use robust::{Coord, Coord3D};

/// A point of a plane projection: two of the three coordinates.
pub(super) type Point2 = [f64; 2];

/// Magnitudes, besides 0, for which crate `robust` is exact.
const ROBUST: core::ops::RangeInclusive<f64> =
    f64::from_bits((1023 - 248) << 52)..=f64::from_bits((1023 + 248) << 52);

/// The corners of a pair, for exact signs.
pub(super) struct Exact<'t> {
    corners: [&'t DVec3; 6],
    lattice: Option<Lattice>,
}

/// The corners of a pair projected along one axis, for exact signs.
pub(super) enum Projection {
    /// On the lattice.
    Whole([[i64; 2]; 6]),
    /// As given.
    Float([Point2; 6]),
}

impl<'t> Exact<'t> {
    /// `extent` (m) bounds all differences of coordinates.
    pub(super) fn of(corners: [&'t DVec3; 6], extent: f64) -> Self {
        Self { corners, lattice: Lattice::of(&corners, extent) }
    }

    /// The sign of det(b − a, c − a, d − a): 1 if d lies on the side of the normal
    /// (b − a) × (c − a) of the plane abc, 0 if it lies in that plane or a, b, c on one line.
    pub(super) fn side(&self, plane: [Corner; 3], d: Corner) -> Sign {
        self.sides(plane, [d])[0]
    }

    /// [`Exact::side`] of several corners.
    pub(super) fn sides<const N: usize>(
        &self,
        plane: [Corner; 3],
        corners: [Corner; N],
    ) -> [Sign; N] {
        let [a, b, c] = plane;
        match &self.lattice {
            Some(lattice) => {
                let normal = lattice.normal(plane);
                let mut sides = [0; N];
                for (side, d) in sides.iter_mut().zip(corners) {
                    *side = lattice.height(&normal, a, d).sign();
                }
                sides
            }
            None => corners.map(|d| orient3d([a, b, c, d].map(|i| *self.corners[i]))),
        }
    }

    /// The signs of the normal (b − a) × (c − a), i.e. of the areas projected along each axis.
    pub(super) fn normal_signs(&self, plane: [Corner; 3]) -> [Sign; 3] {
        match &self.lattice {
            Some(lattice) => lattice.normal(plane).map(|n| n.signum() as Sign),
            None => [0, 1, 2].map(|drop| self.without(drop).turn(plane)),
        }
    }

    /// Projects along the axis `drop`.
    pub(super) fn without(&self, drop: usize) -> Projection {
        let (x, y) = kept(drop);
        match &self.lattice {
            Some(lattice) => Projection::Whole(lattice.without(drop)),
            None => Projection::Float(self.corners.map(|corner| [corner[x], corner[y]])),
        }
    }

    /// The position along pq, in [0, 1], of its intersection with the plane: the exact fraction,
    /// rounded.
    ///
    /// p and q must not be both in the plane, nor on the same side of it.
    pub(super) fn cut_fraction(&self, plane: [Corner; 3], p: Corner, q: Corner) -> f64 {
        let [a, b, c] = plane;
        let [p, q] = [p, q].map(|end| match &self.lattice {
            Some(lattice) => lattice.height(&lattice.normal(plane), a, end).magnitude(),
            None => Wide::orient3d([a, b, c, end].map(|i| *self.corners[i])).magnitude(),
        });
        Magnitude::share(p, q)
    }
}

impl Projection {
    /// The sign of det(b − a, c − a): 1 if a, b, c turn counter-clockwise, 0 if they are on one
    /// line.
    #[inline]
    pub(super) fn turn(&self, corners: [Corner; 3]) -> Sign {
        match self {
            Self::Whole(points) => {
                let [a, b, c] = corners;
                area([points[a], points[b], points[c]]).signum() as Sign
            }
            Self::Float(points) => orient2d(corners.map(|i| points[i])),
        }
    }

    /// The position along pq of its intersection with the line ab: see [`Exact::cut_fraction`].
    pub(super) fn cut_fraction(&self, [a, b]: [Corner; 2], p: Corner, q: Corner) -> f64 {
        let [p, q] = [p, q].map(|end| match self {
            Self::Whole(points) => {
                Magnitude::of(area([a, b, end].map(|i| points[i])).unsigned_abs(), 0)
            }
            Self::Float(points) => Wide::orient2d([a, b, end].map(|i| points[i])).magnitude(),
        });
        Magnitude::share(p, q)
    }
}

/// The two coordinates that remain without `drop`; either handedness works, if used consistently.
pub(super) fn kept(drop: usize) -> (usize, usize) {
    [(1, 2), (2, 0), (0, 1)][drop]
}

fn in_range(coordinate: f64) -> bool {
    coordinate == 0.0 || ROBUST.contains(&coordinate.abs())
}

fn sign(value: f64) -> Sign {
    Sign::from(value > 0.0) - Sign::from(value < 0.0)
}

/// [`Exact::side`] without a lattice.
pub(super) fn orient3d(points: [DVec3; 4]) -> Sign {
    if points.iter().all(|p| in_range(p.x) && in_range(p.y) && in_range(p.z)) {
        let [a, b, c, d] = points.map(|p| Coord3D { x: p.x, y: p.y, z: p.z });
        // There, positive means below: the opposite sign.
        -sign(robust::orient3d(a, b, c, d))
    } else {
        Wide::orient3d(points).sign()
    }
}

/// [`Projection::turn`] without a lattice.
pub(super) fn orient2d(points: [Point2; 3]) -> Sign {
    if points.iter().all(|p| in_range(p[0]) && in_range(p[1])) {
        let [a, b, c] = points.map(|p| Coord { x: p[0], y: p[1] });
        sign(robust::orient2d(a, b, c))
    } else {
        Wide::orient2d(points).sign()
    }
}
