//! Smooth surfaces from nets of control points.
//!
//! A net is a grid of control points. Along each of its two axes the surface follows the polygon of
//! the points, with every corner cut by one quadratic Bézier arc: `round[i]` = 1 cuts from the
//! middle of one leg to the middle of the next (the uniform quadratic B-spline, which is Chaikin's
//! limit curve: G. Chaikin, An algorithm for high speed curve generation, 1974), 0 leaves corner
//! `i` sharp. The surface is the tensor product of both.
//!
//! Invariants: weights are never negative and sum to one, so the surface stays inside the convex
//! hull of its points; only sums, products and square roots are used.

use geometry::DVec3;

#[cfg(test)]
mod tests;

/// One direction of a net: the number of control points, the roundness of each, and whether it
/// closes.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    round: Vec<f64>,
    closed: bool,
}

/// The location of a parameter on an axis: three control points, their weights and the weights'
/// slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    at: [usize; 3],
    value: [f64; 3],
    slope: [f64; 3],
}

impl Axis {
    /// An axis from the roundness of its corners, each in [0, 1].
    pub(super) fn new(round: Vec<f64>, closed: bool) -> Self {
        Self { round, closed }
    }

    /// Length of the parameter range: from 0 to this.
    pub(super) fn end(&self) -> f64 {
        (if self.closed { self.round.len() } else { self.round.len() - 1 }) as f64
    }

    /// Whether the axis closes on itself.
    pub(super) fn is_closed(&self) -> bool {
        self.closed
    }

    /// The weights at parameter `p`; a closed axis repeats, an open one is clamped.
    pub(super) fn weights(&self, p: f64) -> Weights {
        let count = self.round.len();
        let p = if self.closed { p } else { p.clamp(0.0, self.end()) };
        let near = (p + 0.5).floor();
        let d = p - near;
        let wrap = |offset: i64| {
            let i = near as i64 + offset;
            let last = count as i64 - 1;
            (if self.closed { i.rem_euclid(count as i64) } else { i.clamp(0, last) }) as usize
        };
        let at = [wrap(-1), wrap(0), wrap(1)];
        let is_end = !self.closed && (at[1] == 0 || at[1] == count - 1);
        let h = if is_end { 0.0 } else { self.round[at[1]] / 2.0 };
        if d.abs() >= h {
            if d < 0.0 {
                return Weights { at, value: [-d, 1.0 + d, 0.0], slope: [-1.0, 1.0, 0.0] };
            }
            return Weights { at, value: [0.0, 1.0 - d, d], slope: [0.0, -1.0, 1.0] };
        }
        let t = (d + h) / (2.0 * h);
        let (before, after) = (h * (1.0 - t) * (1.0 - t), h * t * t);
        Weights {
            at,
            value: [before, 1.0 - before - after, after],
            slope: [t - 1.0, 1.0 - 2.0 * t, t],
        }
    }
}

/// A grid of control points and the surface it defines.
#[derive(Clone, Debug)]
pub(super) struct Net {
    /// The slow axis.
    pub(super) rows: Axis,
    /// The fast axis.
    pub(super) cols: Axis,
    points: Vec<DVec3>,
}

impl Net {
    /// A net of equally long rows. Rows may be open or closed, columns always close: a tube, or a
    /// torus.
    pub(super) fn new(points: &[Vec<DVec3>], rows: Axis, col_round: Vec<f64>) -> Self {
        debug_assert!(points.iter().all(|row| row.len() == col_round.len()));
        debug_assert!(points.len() == rows.round.len());
        Self { rows, cols: Axis::new(col_round, true), points: points.concat() }
    }

    fn blend(&self, s: &[usize; 3], u: &[f64; 3], t: &[usize; 3], v: &[f64; 3]) -> DVec3 {
        let width = self.cols.round.len();
        let mut sum = DVec3::ZERO;
        for (row, weight) in s.iter().zip(u) {
            let line = &self.points[row * width..(row + 1) * width];
            let across = line[t[0]] * v[0] + line[t[1]] * v[1] + line[t[2]] * v[2];
            sum += across * *weight;
        }
        sum
    }

    /// The point at these weights.
    pub(super) fn point(&self, s: &Weights, t: &Weights) -> DVec3 {
        self.blend(&s.at, &s.value, &t.at, &t.value)
    }

    /// The point at these parameters.
    pub(super) fn at(&self, s: f64, t: f64) -> DVec3 {
        self.point(&self.rows.weights(s), &self.cols.weights(t))
    }

    /// The point at these parameters and the unit normal there, ∂t × ∂s:
    /// outward where columns run counter-clockwise seen against the rows, as those of a hull do.
    pub(super) fn frame(&self, s: f64, t: f64) -> (DVec3, DVec3) {
        let (s, t) = (self.rows.weights(s), self.cols.weights(t));
        let along = self.blend(&s.at, &s.slope, &t.at, &t.value);
        let across = self.blend(&s.at, &s.value, &t.at, &t.slope);
        (self.point(&s, &t), across.cross(along).normalize_or_zero())
    }

    /// Returns the net with every control point moved.
    pub(super) fn map(&self, move_to: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|p| move_to(*p)).collect();
        Self { rows: self.rows.clone(), cols: self.cols.clone(), points }
    }

    /// Middle of the box of the control points, and the length of its diagonal (m).
    pub(super) fn extent(&self) -> (DVec3, f64) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) =
            self.points.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
        ((low + high) * 0.5, (high - low).length())
    }
}
