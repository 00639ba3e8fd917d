//! The descent again at a pose near the last one: from where it ended, not from the roots.
//!
//! A *cut* keeps every pair of nodes at which a descent ended: those at the distribution depth
//! whose boxes overlap, and those above whose boxes are apart, with how far. Bodies that have moved
//! less than that are still apart, and need no test. Keeping the front between queries is due to Li
//! and Chen (1998, *Incremental 3D collision detection with hierarchical data structures*) and, for
//! several processors, to Tang, Manocha and Tong (2010, MCCD); the bound on motion is Mirtich's.
//!
//! The pairs are those that [`crate::front()`] finds, in its order: which side of a pair is opened
//! depends on the trees alone, so all poses share one tree of pairs.

use crate::descent::{Descent, side_to_open};
use crate::front::{NodePair, PAIRS_MAX};
use crate::{Counters, Side};
use body::BodyView;
use geometry::{Aabb, DVec3, RelativePose};

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
    /// The boxes all overlap: there is nothing to be kept.
    is_full: bool,
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
        if self.is_full {
            return crate::front(a, b, pose, depth, out, counters);
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
        // Made when the first test is: bodies far apart need none.
        let mut made = None;
        let from = out.len();
        self.next.clear();
        for end in &self.ends {
            let gap_m = end.gap_m - motion_m;
            if gap_m > 0.0 {
                self.next.push(End { gap_m, ..*end });
                continue;
            }
            let descent = made.get_or_insert_with(|| Descent::new(a, b, pose));
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
            *self = Self { is_full: true, ..Self::default() };
            return crate::front(a, b, pose, depth, out, counters);
        }
        std::mem::swap(&mut self.ends, &mut self.next);
        self.pose = Some(*pose);
        if is_new {
            self.first = self.ends.len();
        }
    }
}

/// How far (m) any point of one body can have moved at most, as the other one sees it.
///
/// With R and t of x_A = R x_B + t, a point x of B has moved by ΔR x + Δt in A's frame, and a point
/// y of A by ΔRᵀ(y − t) − RᵀΔt in B's.
fn motion(from: &RelativePose, to: &RelativePose, (a, b): (&Aabb, &Aabb)) -> f64 {
    let shift = DVec3::from_array(to.translation) - DVec3::from_array(from.translation);
    let mut turned = 0.0;
    for (row, last) in to.rotation.iter().zip(&from.rotation) {
        turned += (DVec3::from_array(*row) - DVec3::from_array(*last)).length_squared();
    }
    let mut most = shift.length();
    if turned > 0.0 {
        // The Frobenius norm bounds how far a matrix carries a vector.
        let apart = DVec3::from_array(to.translation).length();
        most += turned.sqrt() * radius(b).max(radius(a) + apart);
    }
    // Stored rotations are rounded, and so is this.
    most * (1.0 + 1e-9) + ROUNDING_M
}

/// How far (m) a body reaches from its origin.
fn radius(bounds: &Aabb) -> f64 {
    let [least, most] = [bounds.min, bounds.max].map(|p| DVec3::from_array(p.map(f64::from)).abs());
    least.max(most).length()
}

#[cfg(test)]
mod tests;
