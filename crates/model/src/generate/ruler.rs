//! Where mesh lines go: close together where the surface is long or bends, apart where it is flat.
//!
//! The cost of a stretch of an axis is its length, averaged over several lines across, plus a share
//! of the angle by which it turns. A ruler cuts its range into cells of equal cost. It depends on
//! the surface alone, so finer meshes of a surface are finer everywhere.

use super::net::{Net, Weights};
use geometry::DVec3;

/// Fine steps per control point.
const STEPS: usize = 12;
/// What one radian of turning costs, in diagonals of the net's box.
const BEND: f64 = 0.09;

/// The running cost along a range of an axis.
#[derive(Clone, Debug)]
pub(super) struct Ruler {
    marks: Vec<(f64, f64)>,
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
        let bend = BEND * net.extent().1;
        let mut cost = vec![0.0; steps];
        for line in 0..lines {
            let cross = other.weights((line as f64 + 0.5) / 2.0);
            let points: Vec<DVec3> = own
                .iter()
                .map(|w| match along {
                    Along::Rows => net.point(w, &cross),
                    Along::Cols => net.point(&cross, w),
                })
                .collect();
            let mut before = DVec3::ZERO;
            for (k, pair) in points.windows(2).enumerate() {
                let step = pair[1] - pair[0];
                let length = step.length();
                let heading = step.normalize_or_zero();
                let turned = if before == DVec3::ZERO { 0.0 } else { (heading - before).length() };
                cost[k] += length + bend * turned;
                before = heading;
            }
        }
        let mut marks = vec![(from, 0.0)];
        let mut sum = 0.0;
        for (k, cost) in cost.iter().enumerate() {
            sum += cost / lines as f64;
            marks.push((parameter(k + 1), sum));
        }
        Self { marks }
    }

    /// Cost of the whole range [m].
    pub(super) fn total(&self) -> f64 {
        self.marks.last().map_or(0.0, |mark| mark.1)
    }

    /// The parameter at a fraction of the cost, for fractions that ascend from call to call is not
    /// needed: a binary search.
    fn parameter(&self, cost: f64) -> f64 {
        let k = self.marks.partition_point(|mark| mark.1 < cost).clamp(1, self.marks.len() - 1);
        let ((p0, c0), (p1, c1)) = (self.marks[k - 1], self.marks[k]);
        if c1 > c0 { p0 + (p1 - p0) * (cost - c0) / (c1 - c0) } else { p0 }
    }

    /// The ends of `cells` cells of equal cost: `cells + 1` parameters, both ends exact.
    pub(super) fn ends(&self, cells: usize) -> Vec<f64> {
        let (first, last) = (self.marks[0].0, self.marks[self.marks.len() - 1].0);
        (0..=cells)
            .map(|k| match k {
                0 => first,
                k if k == cells => last,
                k => self.parameter(self.total() * k as f64 / cells as f64),
            })
            .collect()
    }
}
