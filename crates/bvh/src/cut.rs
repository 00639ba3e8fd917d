//! The descent again at a pose near the last one: from where it ended, not from the roots.
//!
//! A *cut* keeps every pair of nodes at which a descent ended: those at the distribution depth whose
//! boxes overlap, and those above whose boxes are apart, with how far. Bodies that have moved less
//! than that are still apart, and need no test. Keeping the front between queries is due to Li and
//! Chen (1998, *Incremental 3D collision detection with hierarchical data structures*) and, for
//! several processors, to Tang, Manocha and Tong (2010, MCCD); the bound on motion is Mirtich's.
//!
//! The pairs are those that [`crate::front()`] finds, in its order: which side of a pair is opened
//! depends on the trees alone, so all poses share one tree of pairs.

use crate::descent::{Descent, side_to_open};
use crate::front::{NodePair, PAIRS_MAX};
use crate::{Counters, Side};
use geometry::{Aabb, DVec3, RelativePose};
use model::BodyView;

/// Added to every motion (m): far above what rounding does to it for bodies within 1000 km.
const ROUNDING_M: f64 = 1e-7;
/// A cut that has grown to so many times its first size is made anew.
const GROWTH_MAX: usize = 3;

/// Where a descent went no further.
#[derive(Clone, Copy, Debug)]
struct End {
    pair: NodePair,
    depth_a: u32,
    depth_b: u32,
    /// The boxes are at least so far apart (m); not above 0: they may overlap.
    gap_m: f64,
}

/// Where the last descent of two bodies ended. It knows neither bodies nor depth: whoever keeps it
/// asks always about the same.
#[derive(Clone, Debug, Default)]
pub struct Cut {
    ends: Vec<End>,
    next: Vec<End>,
    open: Vec<End>,
    pose: Option<RelativePose>,
    /// How many ends there were when it was made.
    first: usize,
}

impl Cut {
    /// Nothing known yet: the first descent begins at the roots.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`crate::front()`], with the tests that it took here.
    ///
    /// # Panics
    ///
    /// As [`crate::front()`].
    pub fn front(
        &mut self,
        (a, b): (&BodyView<'_>, &BodyView<'_>),
        pose: &RelativePose,
        depth: u32,
        out: &mut Vec<NodePair>,
        counters: &mut Counters,
    ) {
        if a.nodes.is_empty() || b.nodes.is_empty() {
            return;
        }
        let is_old = self.ends.len() > GROWTH_MAX * self.first + 64;
        let motion_m = match &self.pose {
            Some(last) if !is_old => motion(last, pose, (&a.bounds(), &b.bounds())),
            _ => {
                self.ends.clear();
                let (pair, gap_m) = (NodePair::ROOTS, 0.0);
                self.ends.push(End { pair, depth_a: 0, depth_b: 0, gap_m });
                f64::INFINITY
            }
        };
        let is_new = motion_m.is_infinite();
        let descent = Descent::new(a, b, pose);
        let from = out.len();
        self.next.clear();
        for end in &self.ends {
            let gap_m = end.gap_m - motion_m;
            if gap_m > 0.0 {
                self.next.push(End { gap_m, ..*end });
                continue;
            }
            let gap_m = descent.gap(end.pair, counters);
            self.open.push(End { gap_m, ..*end });
            while let Some(end) = self.open.pop() {
                let (node_a, node_b) = descent.nodes(end.pair);
                let ends = (
                    node_a.is_leaf() || end.depth_a == depth,
                    node_b.is_leaf() || end.depth_b == depth,
                );
                let side = side_to_open(node_a, ends.0, node_b, ends.1);
                let Some(side) = side.filter(|_| end.gap_m <= 0.0) else {
                    self.next.push(end);
                    if end.gap_m <= 0.0 {
                        out.push(end.pair);
                    }
                    continue;
                };
                let (depth_a, depth_b) = match side {
                    Side::A => (end.depth_a + 1, end.depth_b),
                    Side::B => (end.depth_a, end.depth_b + 1),
                };
                let open = &mut self.open;
                descent.open_with_gaps(end.pair, side, counters, |pair, gap_m| {
                    open.push(End { pair, depth_a, depth_b, gap_m });
                });
            }
            if out.len() - from > PAIRS_MAX {
                break;
            }
        }
        if out.len() - from > PAIRS_MAX {
            // Bodies whose boxes all overlap: the front stays shallower in places, and is not kept.
            out.truncate(from);
            *self = Self::new();
            return crate::front(a, b, pose, depth, out, counters);
        }
        std::mem::swap(&mut self.ends, &mut self.next);
        self.pose = Some(*pose);
        if is_new {
            self.first = self.ends.len();
        }
    }
}

/// How far (m) any point of one body can have moved, as the other one sees it.
fn motion(from: &RelativePose, to: &RelativePose, (a, b): (&Aabb, &Aabb)) -> f64 {
    let moved_b = |corner: DVec3| (at(to, corner) - at(from, corner)).length();
    let moved_a = |corner: DVec3| (back(to, corner) - back(from, corner)).length();
    // The distance between two images of a point is convex in the point: a corner moves most.
    let most = |bounds: &Aabb, moved: &dyn Fn(DVec3) -> f64| {
        let ends = [bounds.min, bounds.max];
        let corner = |k: usize| {
            let end = |axis: usize| f64::from(ends[k >> axis & 1][axis]);
            DVec3::new(end(0), end(1), end(2))
        };
        (0..8).map(|k| moved(corner(k))).fold(0.0, f64::max)
    };
    most(b, &moved_b).max(most(a, &moved_a)) * (1.0 + 1e-9) + ROUNDING_M
}

/// A point of B, seen from A.
fn at(pose: &RelativePose, x: DVec3) -> DVec3 {
    let row = |i: usize| DVec3::from_array(pose.rotation[i]).dot(x) + pose.translation[i];
    DVec3::new(row(0), row(1), row(2))
}

/// A point of A, seen from B.
fn back(pose: &RelativePose, y: DVec3) -> DVec3 {
    let y = y - DVec3::from_array(pose.translation);
    let column = |j: usize| {
        let r = &pose.rotation;
        DVec3::new(r[0][j], r[1][j], r[2][j]).dot(y)
    };
    DVec3::new(column(0), column(1), column(2))
}

#[cfg(test)]
mod tests;
