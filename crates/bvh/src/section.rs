//! Sections: what lies below a node, and what it weighs.
//!
//! Nodes are stored in preorder and triangles in leaf order, so everything below a node is one
//! range of nodes and one range of triangles. A section is such a pair of ranges, named by its
//! node; it is what the match schemes count and what the transfer ledger weighs.

use body::Node;
use std::ops::Range;

/// Bytes of a triangle in a section: nine f32.
pub const TRIANGLE_BYTES: u64 = 36;

/// Bytes of a node in a section: the six f32 of its box. What links nodes follows from preorder.
pub const NODE_BYTES: u64 = 24;

/// The triangles below `node`, in leaf order. Takes as many steps as the tree is deep; empty where
/// there is no such node.
#[must_use]
pub fn triangles(nodes: &[Node], node: u32) -> Range<u32> {
    let first = nodes[(node as usize).min(nodes.len())..].iter().find(|n| n.is_leaf());
    match (first, last_leaf(nodes, node)) {
        (Some(first), Some((_, last))) => first.link..last.link + last.count,
        _ => 0..0,
    }
}

/// The nodes of the subtree whose root is `node`, itself included. Takes as many steps as the tree
/// is deep; empty where there is no such node.
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

/// The leaf that stands last below `node`, and its number.
fn last_leaf(nodes: &[Node], node: u32) -> Option<(u32, &Node)> {
    let mut at = node;
    loop {
        let node = nodes.get(at as usize)?;
        if node.is_leaf() {
            return Some((at, node));
        }
        // A child stands behind its parent: a damaged tree ends here instead of going round.
        if node.link <= at {
            return None;
        }
        at = node.link;
    }
}

#[cfg(test)]
mod tests;
