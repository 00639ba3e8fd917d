//! Sections: what lies below a node, and its size in bytes.
//!
//! Nodes are stored in preorder and triangles in leaf order, so everything below a node is one
//! range of nodes and one range of triangles. A section is such a pair of ranges, named by its
//! node; match schemes count sections, and transfer volume is measured in them.

use body::{BodyView, Node, Zones};
use std::ops::Range;

/// Bytes of a triangle in a section: nine f32.
pub const TRIANGLE_BYTES: u64 = 36;

/// Bytes of a node in a section: the six f32 of its box. Links follow from preorder.
pub const NODE_BYTES: u64 = 24;

/// The triangles below `node`, in leaf order. Takes time proportional to the tree depth; empty if
/// the node does not exist.
#[must_use]
pub fn triangles(nodes: &[Node], node: u32) -> Range<u32> {
    let first = nodes[(node as usize).min(nodes.len())..].iter().find(|n| n.is_leaf());
    match (first, last_leaf(nodes, node)) {
        (Some(first), Some((_, last))) => first.link..last.link + last.count,
        _ => 0..0,
    }
}

/// The nodes of the subtree whose root is `node`, including the root. Takes time proportional to
/// the tree depth; empty if the node does not exist.
#[must_use]
pub fn nodes_of(nodes: &[Node], node: u32) -> Range<u32> {
    last_leaf(nodes, node).map_or(0..0, |(last, _)| node..last + 1)
}

/// Bytes of the section whose root is `node`: 36 per triangle and 24 per node of the binary tree.
#[must_use]
pub fn bytes(nodes: &[Node], node: u32) -> u64 {
    TRIANGLE_BYTES * triangles(nodes, node).len() as u64
        + NODE_BYTES * nodes_of(nodes, node).len() as u64
}

/// For every node of a body, all zones that triangles below it belong to.
#[must_use]
pub fn zones(body: &BodyView<'_>) -> Vec<Zones> {
    let mut all = vec![Zones(0); body.nodes.len()];
    // Children are stored after their parent.
    for (at, node) in body.nodes.iter().enumerate().rev() {
        let below = |child: usize| all.get(child).map_or(0, |zones| zones.0);
        let bits = if node.is_leaf() {
            let first = node.link as usize;
            let own = body.zones.get(first..first + node.count as usize).unwrap_or_default();
            own.iter().fold(0, |bits, zones| bits | zones.0)
        } else {
            below(at + 1) | below(node.link as usize)
        };
        all[at] = Zones(bits);
    }
    all
}

/// The last leaf below `node`, with its number.
fn last_leaf(nodes: &[Node], node: u32) -> Option<(u32, &Node)> {
    let mut at = node;
    loop {
        let node = nodes.get(at as usize)?;
        if node.is_leaf() {
            return Some((at, node));
        }
        // A child is stored after its parent: with a damaged tree this ends instead of looping.
        if node.link <= at {
            return None;
        }
        at = node.link;
    }
}

#[cfg(test)]
mod tests;
