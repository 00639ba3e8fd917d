//! The coordinator's descent: both trees down to the distribution depth.
//!
//! The result is the pairs of nodes whose boxes overlap, one job each: expanding the pair tree
//! first and walking below it later is due to Le Garrec, Acquaviva and Merlhiot (CEA), cutting at
//! one depth of both trees to Wiseman and Grinberg.

use crate::descent::{Descent, side_to_open};
use crate::{Counters, Side};
use body::BodyView;
use geometry::RelativePose;
use smallvec::SmallVec;

/// A node of A and a node of B.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct NodePair {
    /// Number of the node in A's tree.
    pub a: u32,
    /// Number of the node in B's tree.
    pub b: u32,
}

impl NodePair {
    /// Both roots: all of both bodies.
    pub const ROOTS: Self = Self { a: 0, b: 0 };
}

/// Maximum number of pairs in a front: where more would overlap, it stays shallower in places.
///
/// It bounds memory for bodies whose boxes all overlap, 4ᵈ pairs at depth d, and equals the number
/// of job slots of a request.
pub const PAIRS_MAX: usize = 1 << 16;

/// A pair during the descent, with the depths of its nodes; the roots have depth 0.
#[derive(Clone, Copy)]
struct Open {
    pair: NodePair,
    depth_a: u32,
    depth_b: u32,
}

/// Appends to `out` all pairs of nodes at `depth` (or shallower leaves) whose boxes overlap under
/// `pose`, at most [`PAIRS_MAX`] of them.
///
/// Depth 0 is the pair of roots. The pairs are disjoint and cover every intersecting pair of
/// triangles. They come in depth-first order, A's and B's left children first, the same on every
/// machine. The boxes of the roots are tested too, so `out` may stay unchanged; it does so for a
/// body without a tree.
///
/// # Panics
///
/// A node number is out of range; the builder and the reader of model files rule this out.
pub fn front(
    a: &BodyView<'_>,
    b: &BodyView<'_>,
    pose: &RelativePose,
    depth: u32,
    out: &mut Vec<NodePair>,
    counters: &mut Counters,
) {
    front_where((a, b), pose, depth, &mut |_| true, out, counters);
}

/// [`front`] without the pairs that `counts` does not hold for, nor what is below them.
///
/// # Panics
///
/// As [`front`].
pub fn front_where(
    (a, b): (&BodyView<'_>, &BodyView<'_>),
    pose: &RelativePose,
    depth: u32,
    counts: &mut dyn FnMut(NodePair) -> bool,
    out: &mut Vec<NodePair>,
    counters: &mut Counters,
) {
    if a.nodes.is_empty() || b.nodes.is_empty() || !counts(NodePair::ROOTS) {
        return;
    }
    let descent = Descent::new(a, b, pose);
    if descent.apart(NodePair::ROOTS, counters) {
        return;
    }
    let limit = out.len() + PAIRS_MAX;
    // At most one pair waits per level of both trees, and a tree has no more levels than nodes.
    let mut open = SmallVec::<[Open; 64]>::new();
    open.push(Open { pair: NodePair::ROOTS, depth_a: 0, depth_b: 0 });
    while let Some(Open { pair, depth_a, depth_b }) = open.pop() {
        let (node_a, node_b) = descent.nodes(pair);
        let ends_a = node_a.is_leaf() || depth_a == depth;
        let ends_b = node_b.is_leaf() || depth_b == depth;
        let full = out.len() + open.len() + 2 > limit;
        let Some(side) = side_to_open(node_a, ends_a || full, node_b, ends_b || full) else {
            out.push(pair);
            continue;
        };
        let (deeper_a, deeper_b) = match side {
            Side::A => (depth_a + 1, depth_b),
            Side::B => (depth_a, depth_b + 1),
        };
        descent.open(pair, side, counters, |pair| {
            if counts(pair) {
                open.push(Open { pair, depth_a: deeper_a, depth_b: deeper_b });
            }
        });
    }
}

#[cfg(test)]
mod tests;
