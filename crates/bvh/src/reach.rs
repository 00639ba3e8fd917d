//! What contact below a pair of nodes can reach at most: the bound of a job that is not done.
//!
//! Two triangles meet where both are, so all points of their contact lie in both nodes' boxes.

use crate::NodePair;
use body::BodyView;
use geometry::{Directions, RelativePose, Supports};

/// Adds to `supports` those of everything that contact below `pair` can reach, in A's frame.
///
/// Both boxes are larger by `margin` (m) all round, for what rounding does to points of contact. If
/// they still share nothing, nothing is added.
///
/// # Panics
///
/// If a node's number is out of range.
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
