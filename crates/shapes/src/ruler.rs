//! Placement of mesh lines: close together where the surface is long or bends, apart where it is
//! flat.
//!
//! Sharp edges get a mesh line of their own as soon as there are enough cells, since a block whose
//! edges are missed becomes smaller.
//!
//! The cost of a stretch of an axis is its length plus √(length × angle it turns by), as the
//! quadratic mean over several lines across. A chord over a stretch of length h that turns by θ
//! misses the surface by hθ/8, so cells of equal √(hθ) miss it by equally much, on a mirror and on
//! a roof: that is what makes a coarse mesh the same body as a fine one. A ruler cuts its range
//! into cells of equal cost. It depends on the surface alone, so finer meshes of a surface are
//! finer everywhere.

use super::net::{Net, Weights};
use geometry::DVec3;

#[cfg(test)]
mod tests;

/// Fine steps per control point.
const STEPS: usize = 12;
/// The cost of turning relative to length [√m]. At 3, flat faces keep enough triangles to be
/// distinguishable, and the worst support error of 25,000 triangles is a third of that at 1.
const BEND: f64 = 3.0;

/// From this angle `[rad]`, a corner of the net is an edge that a mesh line must follow.
const EDGE: f64 = 0.5;

/// The running cost along a range of an axis.
#[derive(Clone, Debug)]
pub(super) struct Ruler {
    /// Parameter and cumulative cost.
    marks: Vec<(f64, f64)>,
    /// Marks of edges inside the range, sharpest first.
    edges: Vec<usize>,
}

/// Cost of a stretch of this length (m) that turns by this angle `[rad]`.
pub(super) fn stretch(length: f64, turned: f64) -> f64 {
    length + BEND * (length * turned).sqrt()
}

/// Which axis of a net a ruler lies along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Along {
    /// From row to row.
    Rows,
    /// From column to column.
    Cols,
}

impl Ruler {
    /// A ruler from parameter `from` to `to` of one axis of `net`.
    pub(super) fn new(net: &Net, along: Along, from: f64, to: f64) -> Self {
        let (axis, other) = match along {
            Along::Rows => (&net.rows, &net.cols),
            Along::Cols => (&net.cols, &net.rows),
        };
        let steps = STEPS * (to - from).ceil().max(1.0) as usize;
        let parameter = |k: usize| from + (to - from) * k as f64 / steps as f64;
        let own: Vec<Weights> = (0..=steps).map(|k| axis.weights(parameter(k))).collect();
        let lines = (2.0 * other.end()) as usize;
        let mut squares = vec![0.0; steps];
        let mut turns = vec![0.0_f64; steps / STEPS + 1];
        let mut sums = turns.clone();
        for line in 0..lines {
            let cross = other.weights((line as f64 + 0.5) / 2.0);
            let points: Vec<DVec3> = own
                .iter()
                .map(|w| match along {
                    Along::Rows => net.point(w, &cross),
                    Along::Cols => net.point(&cross, w),
                })
                .collect();
            let legs: Vec<DVec3> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let heading = |k: usize| legs[k].normalize_or_zero();
            // How the line turns at the start of a leg; half of it belongs to each neighbour.
            let turn: Vec<f64> = (0..=steps)
                .map(|k| match k {
                    0 => 0.0,
                    k if k == steps => 0.0,
                    k => (heading(k) - heading(k - 1)).length(),
                })
                .collect();
            for (k, leg) in legs.iter().enumerate() {
                let cost = stretch(leg.length(), 0.5 * (turn[k] + turn[k + 1]));
                squares[k] += cost * cost / lines as f64;
            }
            for corner in 1..steps / STEPS {
                let near = STEPS * corner - STEPS / 2 + 1..STEPS * corner + STEPS / 2;
                let turned: f64 = turn[near].iter().sum();
                turns[corner] = turns[corner].max(turned);
                sums[corner] += turned;
            }
        }
        let mut marks = vec![(from, 0.0)];
        let mut sum = 0.0;
        for (k, square) in squares.iter().enumerate() {
            sum += square.sqrt();
            marks.push((parameter(k + 1), sum));
        }
        let corners = (1..steps / STEPS).filter(|corner| turns[*corner] >= EDGE);
        let mut sharp: Vec<usize> = corners.collect();
        sharp.sort_by(|a, b| sums[*b].total_cmp(&sums[*a]).then(a.cmp(b)));
        Self { marks, edges: sharp.into_iter().map(|corner| corner * STEPS).collect() }
    }

    /// Cost of the whole range (m).
    pub(super) fn total(&self) -> f64 {
        self.marks.last().map_or(0.0, |mark| mark.1)
    }

    /// The parameter where the cost is reached.
    fn parameter(&self, cost: f64) -> f64 {
        let k = self.marks.partition_point(|mark| mark.1 < cost).clamp(1, self.marks.len() - 1);
        let ((p0, c0), (p1, c1)) = (self.marks[k - 1], self.marks[k]);
        if c1 > c0 { p0 + (p1 - p0) * (cost - c0) / (c1 - c0) } else { p0 }
    }

    /// The ends of `cells` cells: `cells + 1` parameters, ends and edges exact, the cells between
    /// two edges of equal cost.
    pub(super) fn ends(&self, cells: usize) -> Vec<f64> {
        let edges = self.edges.len().min(cells - 1);
        let mut stops = self.edges[..edges].to_vec();
        stops.extend([0, self.marks.len() - 1]);
        stops.sort_unstable();
        let spans: Vec<_> =
            stops.windows(2).map(|pair| (self.marks[pair[0]], self.marks[pair[1]])).collect();
        // One cell each, and every further one for the span whose cells cost most.
        let mut shares = vec![1_usize; spans.len()];
        for _ in spans.len()..cells {
            let cost = |k: usize| (spans[k].1.1 - spans[k].0.1) / shares[k] as f64;
            let most =
                (0..spans.len()).fold(0, |most, k| if cost(k) > cost(most) { k } else { most });
            shares[most] += 1;
        }
        let mut ends = vec![self.marks[0].0];
        for ((first, last), share) in spans.iter().zip(shares) {
            let step = (last.1 - first.1) / share as f64;
            ends.extend((1..share).map(|k| self.parameter(first.1 + step * k as f64)));
            ends.push(last.0);
        }
        ends
    }
}
