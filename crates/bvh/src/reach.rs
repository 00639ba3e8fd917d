//! What contact below a pair of nodes can reach at most: the bound for an unfinished job.
//!
//! Contact points of two triangles lie in both, and so in both nodes' boxes.

use crate::NodePair;
use body::BodyView;
use geometry::{Directions, RelativePose, Supports};

/// Adds to `supports` everything that contact below `pair` can reach, in A's frame.
///
/// Both boxes are enlarged by `margin` (m) on all sides, to cover the rounding of contact points.
/// If they are still disjoint, nothing is added.
///
/// # Panics
///
/// A node number is out of range.
pub fn reach(
    (a, b): (&BodyView<'_>, &BodyView<'_>),
    pose: &RelativePose,
    pair: NodePair,
    directions: &Directions,
    margin: f64,
    supports: &mut Supports,
) {
    let box_a = a.nodes[pair.a as usize].bounds.bounds();
    let box_b = pose.bounds(&b.nodes[pair.b as usize].bounds);
    let min = box_a.min.max(box_b.min) - margin;
    let max = box_a.max.min(box_b.max) + margin;
    if min.cmpgt(max).any() {
        return;
    }
    let (centre, half) = ((min + max) * 0.5, (max - min) * 0.5);
    for (support, d) in supports.0.iter_mut().zip(&directions.d) {
        *support = support.max(centre.dot(*d) + half.dot(d.abs()));
    }
}

#[cfg(test)]
mod tests;
