//! The invariants of a body, checked before it is traversed.
//!
//! One pass in preorder with a stack of open right children; no recursion. This check ensures that
//! every later index is in range and that every box is the exact box of its contents, so that no
//! intersecting pair can hide behind a wrong one.

use super::{FileError, malformed};
use crate::{BodyView, LEAF_SIZE_MAX, Meta, Wide};
use geometry::Aabb;

/// Greatest distance of a coordinate from its body's origin, in metres.
pub const COORDINATE_MAX_M: f32 = 1.0e6;

/// Checks a body against all invariants that its readers rely on.
///
/// Takes O(n log n) time in the number of triangles, for the source ids; the rest is linear.
///
/// # Errors
///
/// An array has the wrong length, a coordinate is not finite or beyond [`COORDINATE_MAX_M`], the
/// nodes are not one tree in preorder whose leaves partition the triangles, a box is not the box of
/// its contents, the wide tree does not match the binary one, a part or source id does not exist,
/// or the metadata contradicts the content.
pub fn check_body(meta: &Meta, body: &BodyView<'_>) -> Result<(), FileError> {
    check_lengths(body)?;
    check_corners(body)?;
    let tree = check_tree(body)?;
    check_boxes(body)?;
    check_wide(body)?;
    check_ids(meta, body)?;
    check_meta(meta, body, tree)
}

struct Tree {
    depth: usize,
    leaf_max: u32,
}

fn check_lengths(body: &BodyView<'_>) -> Result<(), FileError> {
    let count = body.corners.len();
    if count == 0 {
        return Err(malformed("corners", "there is no triangle"));
    }
    if count > u32::MAX as usize / 2 {
        return Err(malformed("corners", format!("{count} triangles are too many")));
    }
    for (place, found) in [
        ("source ids", body.source_ids.len()),
        ("parts", body.part_of.len()),
        ("zones", body.zones.len()),
    ] {
        if found != count {
            return Err(malformed(place, format!("{found} for {count} triangles")));
        }
    }
    if body.nodes.is_empty() || body.nodes.len() > 2 * count - 1 {
        let found = body.nodes.len();
        return Err(malformed("nodes", format!("{found} for {count} triangles")));
    }
    Ok(())
}

fn check_corners(body: &BodyView<'_>) -> Result<(), FileError> {
    let bad = |x: &f32| !(x.abs() <= COORDINATE_MAX_M);
    match body.corners.iter().position(|corners| corners.as_flattened().iter().any(bad)) {
        Some(at) => Err(malformed("corners", format!("triangle {at} is not within 10^6 m"))),
        None => Ok(()),
    }
}

/// Traverses the nodes in storage order, which must be preorder.
fn check_tree(body: &BodyView<'_>) -> Result<Tree, FileError> {
    let fault = |at: usize, what: &str| Err(malformed("nodes", format!("node {at} {what}")));
    let nodes = body.nodes;
    // Right children still to come, each with its depth; initially the root.
    let mut open = vec![(0_usize, 1_usize)];
    let mut next_triangle = 0_usize;
    let mut tree = Tree { depth: 0, leaf_max: 0 };
    let mut depth_here = 0;
    for (at, node) in nodes.iter().enumerate() {
        let after_leaf = at == 0 || nodes[at - 1].is_leaf();
        if after_leaf {
            match open.pop() {
                Some((expected, depth)) if expected == at => depth_here = depth,
                _ => return fault(at, "is not where its parent says"),
            }
        } else {
            depth_here += 1;
        }
        tree.depth = tree.depth.max(depth_here);
        let link = node.link as usize;
        if node.is_leaf() {
            if link != next_triangle {
                return fault(at, "does not go on where the leaf before it ends");
            }
            next_triangle += node.count as usize;
            if next_triangle > body.corners.len() {
                return fault(at, "reaches past the last triangle");
            }
            tree.leaf_max = tree.leaf_max.max(node.count);
        } else {
            if link <= at + 1 || link >= nodes.len() {
                return fault(at, "has no such right child");
            }
            open.push((link, depth_here + 1));
        }
    }
    let ends_in_leaf = nodes.last().is_some_and(crate::Node::is_leaf);
    if !open.is_empty() || !ends_in_leaf || next_triangle != body.corners.len() {
        return Err(malformed("nodes", "the leaves do not hold all triangles"));
    }
    Ok(tree)
}

/// Links are in range, since [`check_tree`] ran first.
fn check_boxes(body: &BodyView<'_>) -> Result<(), FileError> {
    for (at, node) in body.nodes.iter().enumerate() {
        let first = node.link as usize;
        let exact = if node.is_leaf() {
            body.corners[first..first + node.count as usize]
                .iter()
                .fold(Aabb::EMPTY, |sum, corners| sum.union(&Aabb::of(corners)))
        } else {
            body.nodes[at + 1].bounds.union(&body.nodes[first].bounds)
        };
        if node.bounds != exact {
            return Err(malformed("nodes", format!("node {at} has a wrong box")));
        }
    }
    Ok(())
}

/// The binary tree is valid here, so the wide one can be recomputed from it.
fn check_wide(body: &BodyView<'_>) -> Result<(), FileError> {
    let wide = Wide::of(body.nodes, body.corners);
    if body.wide != wide.nodes || body.wide_of != wide.of {
        return Err(malformed("wide nodes", "they do not follow from the nodes"));
    }
    Ok(())
}

fn check_ids(meta: &Meta, body: &BodyView<'_>) -> Result<(), FileError> {
    if body.part_of.iter().any(|part| usize::from(*part) >= meta.parts.len()) {
        return Err(malformed("parts", "a triangle is of a part that has no name"));
    }
    let mut ids = body.source_ids.to_vec();
    ids.sort_unstable();
    if ids.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err(malformed("source ids", "an id occurs twice"));
    }
    let known = |id: u32| ids.binary_search(&id).is_ok();
    let ascends = body.dropped.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    if !ascends || body.dropped.iter().any(|[gone, kept]| known(*gone) || !known(*kept)) {
        return Err(malformed("dropped", "not an ascending table of dropped and kept ids"));
    }
    Ok(())
}

fn check_meta(meta: &Meta, body: &BodyView<'_>, tree: Tree) -> Result<(), FileError> {
    let fault = |what: String| Err(malformed("metadata", what));
    if let Err(what) = meta.check() {
        return fault(what);
    }
    if meta.depth as usize != tree.depth {
        return fault(format!("it states depth {}, the tree has {}", meta.depth, tree.depth));
    }
    if meta.leaf_size > LEAF_SIZE_MAX {
        return fault(format!("leaf size {}, beyond {LEAF_SIZE_MAX}", meta.leaf_size));
    }
    if meta.leaf_size < tree.leaf_max {
        return fault(format!("leaf size {}, but a leaf has {}", meta.leaf_size, tree.leaf_max));
    }
    if meta.degenerate as usize > body.corners.len() {
        return fault(format!("{} degenerate triangles are too many", meta.degenerate));
    }
    Ok(())
}
