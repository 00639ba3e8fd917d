//! The sign of an orientation determinant: in f64 where that is certain, else exactly.
//!
//! One error bound serves all determinants of a pair: coordinate differences are at most the
//! extents E of the box around both triangles, so the six products of a determinant sum up to at
//! most 6·Ex·Ey·Ez. In `n·w` with `n = u × v`, each product passes at most 8 roundings (three
//! differences, two products, one difference, two sums), so the error is below 49 u·Ex·Ey·Ez with
//! u = 2⁻⁵³; 64 u also covers the rounding of the bound itself. (The idea is that of CGAL's static
//! filters: A. Meyer, S. Pion, *FPG: A code generator for fast and certified geometric
//! predicates*, 2008.)

use super::exact::{self, Sign};
use crate::{Bounds, DVec3};

/// Beyond these extents (m), a product of three could overflow: all signs are taken exactly.
const EXTENT_MAX: f64 = f64::from_bits((1023 + 300) << 52); // 2^300

/// More than all errors of underflow together: below 2⁻⁷⁷⁰, with extents up to 2³⁰⁰.
const UNDERFLOW: f64 = f64::from_bits((1023 - 700) << 52); // 2^-700

/// 64 u = 2⁻⁴⁷.
const ERROR: f64 = f64::from_bits((1023 - 47) << 52);

/// Signs of determinants of the corners of one pair of triangles.
pub(super) struct Orient {
    /// Values beyond this have the sign of the true value.
    bound: f64,
}

/// On which side of `plane` the points lie, given the sides that are certain.
pub(super) fn sides(certain: [Sign; 3], plane: &[DVec3; 3], points: &[DVec3; 3]) -> [Sign; 3] {
    let [a, b, c] = *plane;
    let mut sides = certain;
    for (side, point) in sides.iter_mut().zip(points) {
        if *side == 0 {
            *side = exact::orient3d(a, b, c, *point);
        }
    }
    sides
}

impl Orient {
    /// For points in these two boxes.
    pub(super) fn within(a: &Bounds, b: &Bounds) -> Self {
        let extent = a.max.max(b.max) - a.min.min(b.min);
        let sound = extent.x <= EXTENT_MAX && extent.y <= EXTENT_MAX && extent.z <= EXTENT_MAX;
        let bound = ERROR * extent.x * extent.y * extent.z + UNDERFLOW;
        Self { bound: if sound { bound } else { f64::INFINITY } }
    }

    /// Six times the volume of the tetrahedron abcd, rounded: positive if d lies on the side of
    /// the normal (b − a) × (c − a).
    fn value(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
        (b - a).cross(c - a).dot(d - a)
    }

    /// The sign of [`Orient::value`] without rounding.
    pub(super) fn sign(&self, a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> Sign {
        match self.certain(Self::value(a, b, c, d)) {
            0 => exact::orient3d(a, b, c, d),
            sign => sign,
        }
    }

    /// The sign of the true value, 0 if rounding hides it.
    fn certain(&self, value: f64) -> Sign {
        Sign::from(value > self.bound) - Sign::from(value < -self.bound)
    }

    /// On which side of `plane` the points lie; 0 where rounding hides it.
    pub(super) fn certain_sides(&self, plane: &[DVec3; 3], points: &[DVec3; 3]) -> [Sign; 3] {
        let normal = (plane[1] - plane[0]).cross(plane[2] - plane[0]);
        let side = |point: DVec3| self.certain(normal.dot(point - plane[0]));
        [side(points[0]), side(points[1]), side(points[2])]
    }

    /// Where the segment pq meets the plane, p and q being on different sides of it or one of them
    /// on it, not both.
    pub(super) fn cut(&self, plane: &[DVec3; 3], p: DVec3, q: DVec3) -> DVec3 {
        // The fraction's error is about the bound over this sum: below 2^-33, else take it exactly.
        const WELL_CONDITIONED: f64 = (1_u64 << 33) as f64;
        let [a, b, c] = *plane;
        let (side_p, side_q) = (Self::value(a, b, c, p), Self::value(a, b, c, q));
        let fraction = if side_p.abs() + side_q.abs() > WELL_CONDITIONED * self.bound {
            side_p / (side_p - side_q)
        } else {
            exact::cut_fraction3d(plane, p, q)
        };
        along(p, q, fraction)
    }
}

/// The point at `fraction` of the way from p to q; the ends are exact.
pub(super) fn along(p: DVec3, q: DVec3, fraction: f64) -> DVec3 {
    if fraction >= 1.0 { q } else { p + (q - p) * fraction }
}
