//! The sign of an orientation determinant: in f64 where that is certain, else exactly.
//!
//! One error bound serves all determinants of a pair: coordinate differences are at most the
//! extents E of the box around both triangles, so the six products of a determinant sum up to at
//! most 6·Ex·Ey·Ez. In `n·w` with `n = u × v`, each product passes at most 8 roundings (three
//! differences, two products, one difference, two sums), so the error is below 49 u·Ex·Ey·Ez with
//! u = 2⁻⁵³; 64 u also covers the rounding of the bound itself. (The idea is that of CGAL's static
//! filters: A. Meyer, S. Pion, *FPG: A code generator for fast and certified geometric
//! predicates*, 2008.)

use super::exact::Exact;
use super::{A, B, Corner, Sign, Triangle};
use crate::{Bounds, DVec3};
use core::cell::OnceCell;

/// Beyond these extents (m), a product of three could overflow: all signs are computed exactly.
const EXTENT_MAX: f64 = f64::from_bits((1023 + 300) << 52); // 2^300

/// More than all underflow errors together, which are below 2⁻⁷⁷⁰ with extents up to 2³⁰⁰.
const UNDERFLOW: f64 = f64::from_bits((1023 - 700) << 52); // 2^-700

/// 64 u = 2⁻⁴⁷.
const ERROR: f64 = f64::from_bits((1023 - 47) << 52);

/// Signs of determinants of the corners of one pair of triangles.
pub(super) struct Orient<'t> {
    corners: [&'t DVec3; 6],
    /// The greatest extent (m) of the box around both.
    extent: f64,
    /// Values beyond this have the sign of the true value.
    bound: f64,
    /// Created on first use, which is rare.
    exact: OnceCell<Exact<'t>>,
}

impl<'t> Orient<'t> {
    /// Creates the predicate for the corners of two triangles with these boxes.
    #[inline]
    pub(super) fn of([a, b]: [&'t Triangle; 2], [box_a, box_b]: [&Bounds; 2]) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (&a.0, &b.0);
        let extent = box_a.max.max(box_b.max) - box_a.min.min(box_b.min);
        let sound = extent.x <= EXTENT_MAX && extent.y <= EXTENT_MAX && extent.z <= EXTENT_MAX;
        let bound = ERROR * extent.x * extent.y * extent.z + UNDERFLOW;
        Self {
            corners: [a0, a1, a2, b0, b1, b2],
            extent: extent.max_element(),
            bound: if sound { bound } else { f64::INFINITY },
            exact: OnceCell::new(),
        }
    }

    /// The position of a corner.
    pub(super) fn at(&self, corner: Corner) -> DVec3 {
        *self.corners[corner]
    }

    /// The exact predicate.
    pub(super) fn exact(&self) -> &Exact<'t> {
        self.exact.get_or_init(|| Exact::of(self.corners, self.extent))
    }

    /// Six times the volume of the tetrahedron abcd, rounded: positive if d lies on the side of
    /// the normal (b − a) × (c − a).
    fn value(&self, [a, b, c, d]: [Corner; 4]) -> f64 {
        let a = self.at(a);
        (self.at(b) - a).cross(self.at(c) - a).dot(self.at(d) - a)
    }

    /// The sign of the exact value of [`Orient::value`].
    #[inline]
    pub(super) fn sign(&self, corners: [Corner; 4]) -> Sign {
        match self.certain(self.value(corners)) {
            0 => {
                let [a, b, c, d] = corners;
                self.exact().side([a, b, c], d)
            }
            sign => sign,
        }
    }

    /// The sign of the true value, 0 if rounding hides it.
    fn certain(&self, value: f64) -> Sign {
        Sign::from(value > self.bound) - Sign::from(value < -self.bound)
    }

    /// On which side of `plane` the points lie; 0 where rounding hides it.
    #[inline]
    pub(super) fn certain_sides(&self, [a, b, c]: [Corner; 3], points: [Corner; 3]) -> [Sign; 3] {
        let a = self.at(a);
        let normal = (self.at(b) - a).cross(self.at(c) - a);
        let side = |point: Corner| self.certain(normal.dot(self.at(point) - a));
        [side(points[0]), side(points[1]), side(points[2])]
    }

    /// Whether some corner of A equals one of B.
    pub(super) fn share_a_corner(&self) -> bool {
        A.iter().any(|i| B.iter().any(|k| self.corners[*i] == self.corners[*k]))
    }

    /// Where the segment pq meets the plane, p and q being on different sides of it or one of them
    /// on it, not both.
    pub(super) fn cut(&self, plane: [Corner; 3], p: Corner, q: Corner) -> DVec3 {
        // The fraction's error is about the bound over this sum: below 2^-33, else compute it
        // exactly.
        const WELL_CONDITIONED: f64 = (1_u64 << 33) as f64;
        let [a, b, c] = plane;
        let (side_p, side_q) = (self.value([a, b, c, p]), self.value([a, b, c, q]));
        let fraction = if side_p.abs() + side_q.abs() > WELL_CONDITIONED * self.bound {
            side_p / (side_p - side_q)
        } else {
            self.exact().cut_fraction(plane, p, q)
        };
        along(self.at(p), self.at(q), fraction)
    }
}

/// The point at `fraction` of the way from p to q; the ends are exact.
pub(super) fn along(p: DVec3, q: DVec3, fraction: f64) -> DVec3 {
    if fraction >= 1.0 { q } else { p + (q - p) * fraction }
}
