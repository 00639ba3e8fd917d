//! The coordinator's descent: both trees down to the distribution depth.
//!
//! What is left are pairs of nodes whose boxes overlap, each a job of its own: expanding the pair
//! tree first and walking below it later is due to Le Garrec, Acquaviva and Merlhiot (CEA), cutting
//! at one depth of both trees to Wiseman and Grinberg.

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

/// Most pairs that one front holds: where more would overlap, it stays shallower in places.
///
/// It bounds memory against bodies whose boxes all overlap, 4ᵈ pairs at depth d, and is as many
/// jobs as one request has slots for.
pub const PAIRS_MAX: usize = 1 << 16;

/// A pair on the way down, with the depths that its nodes have reached; the roots' is 0.
#[derive(Clone, Copy)]
struct Open {
    pair: NodePair,
    depth_a: u32,
    depth_b: u32,
}

/// Appends to `out` all pairs of nodes at `depth` (or shallower leaves) whose boxes overlap under
/// `pose`, at most [`PAIRS_MAX`] of them.
///
/// Depth 0 is the pair of roots. The pairs are disjoint, and no intersecting pair of triangles lies
/// outside of them. They come in depth-first order, A's and B's left children first, the same on
/// every machine. The boxes of the roots are tested too, so `out` may stay empty; and it stays
/// empty for a body without a tree.
///
/// # Panics
///
/// If a node's number is out of range; the builder and the reader of model files rule it out.
pub fn front(
    a: &BodyView<'_>,
    b: &BodyView<'_>,
    pose: &RelativePose,
    depth: u32,
    out: &mut Vec<NodePair>,
    counters: &mut Counters,
) {
    if a.nodes.is_empty() || b.nodes.is_empty() {
        return;
    }
    let descent = Descent::new(a, b, pose);
    if descent.apart(NodePair::ROOTS, counters) {
        return;
    }
    let limit = out.len() + PAIRS_MAX;
    // One pair waits per level of both trees at most, and a tree has no more levels than nodes.
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
            open.push(Open { pair, depth_a: deeper_a, depth_b: deeper_b });
        });
    }
}

#[cfg(test)]
mod tests;
