//! Two triangles projected along the motion, in f64: whether they are certainly apart, and when
//! they touch where all signs are certain.
//!
//! # Errors
//!
//! Let ε = 2⁻⁵², all corners be seen from A's first, and M bound the sum of the magnitudes of a
//! corner's coordinates.
//!
//! - Two coordinates across the motion and one along it, products with rows of a matrix, are each
//!   off by at most 2εM: a difference, three products, two sums. The rows are only nearly
//!   perpendicular, and d is only nearly of length 1: 8εM. E = 16εM covers both.
//! - An orientation in the plane across the motion is off by 9EW + 8E², where W ≤ 2M bounds all
//!   differences of coordinates: 16E(W + E) are allowed (`Projected::error`).
//! - Where a corner lies inside the other triangle, its height there is a mean of three heights
//!   with weights that are off by that error each: 3·error·H/(|Σw| − 3·error), H being the extent
//!   of the triangle along d. Where two edges cross, each height is off by error·H/(|Δ| − 2·error),
//!   Δ being the difference of the two orientations that the fraction comes from; for A's edge, H
//!   is its length, so that the point is as certain as the travel. Heights add 8E.

use super::{Feature, Interval, Sweep, TOLERANCE_M};
use crate::DVec3;
use crate::triangle::Triangle;

/// 16 ε.
const ERROR: f64 = 16.0 * f64::EPSILON;

/// More than all underflow errors of a product of two: 2⁻⁹⁰⁰.
const UNDERFLOW: f64 = f64::from_bits((1023 - 900) << 52);

/// From this M (m) on, a product of three lengths could overflow: all signs are doubtful. 2³⁰⁰.
const MAGNITUDE_MAX: f64 = f64::from_bits((1023 + 300) << 52);

/// f64 does not decide.
pub(super) struct Doubt;

/// Both triangles along and across the motion, seen from A's first corner, at travel 0.
pub(super) struct Projected {
    a: [[f64; 3]; 3],
    b: [[f64; 3]; 3],
    /// E (m).
    coordinate_error: f64,
    /// The error of an orientation (m²).
    error: f64,
    /// Least and greatest x, y and height of each (m).
    box_a: [[f64; 2]; 3],
    box_b: [[f64; 2]; 3],
}

/// On which sides of each other's edges the corners of both lie.
pub(super) struct Sides<'p> {
    of: &'p Projected,
    /// `[i][k]`: on which side of A's edge i B's corner k lies; twice an area (m²).
    b_to_a: [[f64; 3]; 3],
    /// `[k][i]`: on which side of B's edge k A's corner i lies.
    a_to_b: [[f64; 3]; 3],
    /// Twice the area of each, signed.
    areas: [f64; 2],
}

impl Projected {
    pub(super) fn of(a: &Triangle, b: &Triangle, sweep: &Sweep) -> Self {
        let [u, v, d] = sweep.axes();
        let origin = a.0[0];
        let mut magnitude = 0.0_f64;
        let mut seen = |p: DVec3| {
            let p = p - origin;
            magnitude = magnitude.max(p.x.abs() + p.y.abs() + p.z.abs());
            let along = |w: DVec3| (w.x * p.x + w.y * p.y) + w.z * p.z;
            [along(u), along(v), along(d)]
        };
        // Written out: `map` over closures is not always inlined, and then slow.
        let a = [seen(a.0[0]), seen(a.0[1]), seen(a.0[2])];
        let b = [seen(b.0[0]), seen(b.0[1]), seen(b.0[2])];
        let (box_a, box_b) = (bounds(&a), bounds(&b));
        let extent = |k: usize| box_a[k][1].max(box_b[k][1]) - box_a[k][0].min(box_b[k][0]);
        // Below the normal range, errors are not relative.
        let coordinate_error = ERROR * magnitude + f64::MIN_POSITIVE;
        let width = extent(0).max(extent(1));
        let error = 16.0 * coordinate_error * (width + coordinate_error) + UNDERFLOW;
        let error = if magnitude < MAGNITUDE_MAX { error } else { f64::INFINITY };
        Self { a, b, coordinate_error, error, box_a, box_b }
    }

    /// What heights may be off by together (m).
    fn height_error(&self) -> f64 {
        8.0 * self.coordinate_error
    }

    /// Whether all contact certainly ends before this travel (m).
    pub(super) fn is_early(&self, from_m: f64) -> bool {
        self.box_a[2][1] - self.box_b[2][0] + self.height_error() < from_m
    }

    /// Whether all contact certainly begins after this travel (m).
    pub(super) fn is_late(&self, to_m: f64) -> bool {
        self.box_a[2][0] - self.box_b[2][1] - self.height_error() > to_m
    }

    /// Whether the bounds of the projections are certainly apart.
    pub(super) fn are_beyond(&self) -> bool {
        let margin = 2.0 * self.coordinate_error;
        let is_beyond = |p: &[f64; 2], q: &[f64; 2]| p[0] > q[1] + margin || q[0] > p[1] + margin;
        (0..2).any(|k| is_beyond(&self.box_a[k], &self.box_b[k]))
    }
}

impl<'p> Sides<'p> {
    pub(super) fn of(of: &'p Projected) -> Self {
        let Projected { a, b, .. } = of;
        Self {
            of,
            b_to_a: sides(a, b),
            a_to_b: sides(b, a),
            areas: [side(&a[0], &a[1], &a[2]), side(&b[0], &b[1], &b[2])],
        }
    }

    /// Whether the projections are certainly apart: one lies beyond an edge of the other.
    pub(super) fn are_apart(&self) -> bool {
        let separates = |sides: &[f64; 3], area: f64| {
            let [p, q, r] = *sides;
            let margin = 2.0 * self.of.error;
            p.min(q).min(r) > area.max(0.0) + margin || p.max(q).max(r) < area.min(0.0) - margin
        };
        self.b_to_a.iter().any(|sides| separates(sides, self.areas[0]))
            || self.a_to_b.iter().any(|sides| separates(sides, self.areas[1]))
    }

    /// The travels of contact, if f64 decides them within the tolerance.
    pub(super) fn interval(&self, sweep: &Sweep) -> Result<Option<Interval>, Doubt> {
        let Projected { a, b, box_a, box_b, error, .. } = self.of;
        let is_certain = |side: &f64| side.abs() > *error;
        let mut signs = self.b_to_a.as_flattened().iter().chain(self.a_to_b.as_flattened());
        if !signs.all(is_certain) {
            return Err(Doubt);
        }
        let mut found = Found::NOTHING;
        for k in 0..3 {
            let of_b = [self.b_to_a[0][k], self.b_to_a[1][k], self.b_to_a[2][k]];
            if let Some((height, error)) = self.height_inside(a, box_a, of_b) {
                found.add(Feature::CornerOfB(k), height - b[k][2], error);
            }
            let of_a = [self.a_to_b[0][k], self.a_to_b[1][k], self.a_to_b[2][k]];
            if let Some((height, error)) = self.height_inside(b, box_b, of_a) {
                found.add(Feature::CornerOfA(k), a[k][2] - height, error);
            }
        }
        for i in 0..3 {
            for k in 0..3 {
                let (next_i, next_k) = ((i + 1) % 3, (k + 1) % 3);
                let of_a = [self.a_to_b[k][i], self.a_to_b[k][next_i]];
                let of_b = [self.b_to_a[i][k], self.b_to_a[i][next_k]];
                if (of_a[0] > 0.0) == (of_a[1] > 0.0) || (of_b[0] > 0.0) == (of_b[1] > 0.0) {
                    continue;
                }
                let ((share_a, error_a), (share_b, error_b)) = (self.share(of_a), self.share(of_b));
                let [x, y, rise_a] = [0, 1, 2].map(|c| a[next_i][c] - a[i][c]);
                let rise_b = b[next_k][2] - b[k][2];
                let travel = (a[i][2] + rise_a * share_a) - (b[k][2] + rise_b * share_b);
                // The place on A's edge is to be as certain as the travel.
                let length = (x.abs() + y.abs()) + rise_a.abs();
                let error = length * error_a + rise_b.abs() * error_b;
                found.add(Feature::EdgeOfA(i, share_a), travel, error);
            }
        }
        found.interval(sweep, self.of.height_error())
    }

    /// The height of a triangle at a point with these sides to its edges, and its error (m), if the
    /// point lies inside.
    fn height_inside(
        &self,
        of: &[[f64; 3]; 3],
        box_: &[[f64; 2]; 3],
        sides: [f64; 3],
    ) -> Option<(f64, f64)> {
        // The weight of a corner is the side to the edge opposite.
        let [of_last, of_first, of_second] = sides;
        let is_inside = (of_last > 0.0) == (of_first > 0.0) && (of_last > 0.0) == (of_second > 0.0);
        is_inside.then(|| {
            let [low, second, last] = [of[0][2], of[1][2], of[2][2]];
            let sum = (of_last + of_first) + of_second;
            let rise = (second - low) * of_second + (last - low) * of_last;
            let error = 3.0 * self.of.error * (box_[2][1] - box_[2][0]);
            (low + rise / sum, error / (sum.abs() - 3.0 * self.of.error))
        })
    }

    /// The share of an edge, whose ends lie on these sides of a line, that lies before the line;
    /// and its error.
    fn share(&self, [p, q]: [f64; 2]) -> (f64, f64) {
        let between = p - q;
        (p / between, self.of.error / (between.abs() - 2.0 * self.of.error))
    }
}

/// Candidates for the ends of the interval.
struct Found {
    start: f64,
    /// The true start lies between these, but for the error of heights.
    start_within: [f64; 2],
    end: f64,
    end_within: [f64; 2],
    first: Feature,
    last: Feature,
}

impl Found {
    const NOTHING: Self = Self {
        start: f64::INFINITY,
        start_within: [f64::INFINITY; 2],
        end: f64::NEG_INFINITY,
        end_within: [f64::NEG_INFINITY; 2],
        first: Feature::CornerOfA(0),
        last: Feature::CornerOfA(0),
    };

    fn add(&mut self, feature: Feature, travel_m: f64, error_m: f64) {
        // Its divisor may have been rounded down to 0.
        let error_m = if error_m >= 0.0 { error_m } else { f64::INFINITY };
        if travel_m < self.start {
            (self.start, self.first) = (travel_m, feature);
        }
        if travel_m > self.end {
            (self.end, self.last) = (travel_m, feature);
        }
        let [low, high] = [travel_m - error_m, travel_m + error_m];
        self.start_within = [self.start_within[0].min(low), self.start_within[1].min(high)];
        self.end_within = [self.end_within[0].max(low), self.end_within[1].max(high)];
    }

    /// The interval, if its start is known well enough, and its end where that matters.
    fn interval(&self, sweep: &Sweep, height_error: f64) -> Result<Option<Interval>, Doubt> {
        if self.start > self.end {
            return Ok(None);
        }
        let [low, high] = self.start_within;
        if low - height_error > sweep.to_m {
            return Ok(None);
        }
        let [end_low, end_high] = self.end_within;
        if end_high + height_error < sweep.from_m {
            return Ok(None);
        }
        let is_wide = |low: f64, high: f64| !(high - low + 2.0 * height_error <= TOLERANCE_M);
        // Where contact is under way at the begin, the end tells how far.
        let matters = low.min(end_low) - height_error < sweep.from_m;
        if is_wide(low, high) || (matters && is_wide(end_low, end_high)) {
            return Err(Doubt);
        }
        Ok(Some(Interval { start: self.start, end: self.end, first: self.first, last: self.last }))
    }
}

/// Least and greatest x, y and height.
fn bounds(of: &[[f64; 3]; 3]) -> [[f64; 2]; 3] {
    let [p, q, r] = of;
    [0, 1, 2].map(|k| [p[k].min(q[k]).min(r[k]), p[k].max(q[k]).max(r[k])])
}

/// On which side of the line pq, in the plane across the motion, r lies: twice the area of pqr,
/// positive if they turn counter-clockwise.
#[inline]
fn side(p: &[f64; 3], q: &[f64; 3], r: &[f64; 3]) -> f64 {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// `[i][k]`: on which side of edge i of one triangle corner k of the other lies.
#[inline]
fn sides(of: &[[f64; 3]; 3], other: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let to = |i: usize| [0, 1, 2].map(|k| side(&of[i], &of[(i + 1) % 3], &other[k]));
    [to(0), to(1), to(2)]
}
