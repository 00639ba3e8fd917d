//! The support of a body in a direction: the maximum over all its corners.
//!
//! Branch and bound over the tree. A box is never pruned wrongly: its bound is the same sum of
//! three products, taken at the farthest corner of the box, and products and sums of floats are
//! monotone even when rounded. So the result is the brute-force maximum, bit for bit.

use body::BodyView;
use geometry::{Aabb, DVec3};
use smallvec::SmallVec;

mod extremes;

pub use extremes::Extremes;

/// The greatest `x·d`, in metres, over all corners of the body, in its own frame; negative infinity
/// for a body without a tree.
///
/// `x·d` is `(x d_x + y d_y) + z d_z` in f64 from the stored f32. A zero is +0.
#[must_use]
pub fn support(view: &BodyView<'_>, direction: DVec3) -> f64 {
    support_near(view, direction, &mut None)
}

/// [`support`] where a corner of the body is known that is far in a direction near by, such as the
/// one that the last call left: most of the tree is then left out. Leaves a corner that is farthest
/// in this direction.
#[must_use]
pub fn support_near(view: &BodyView<'_>, direction: DVec3, near: &mut Option<[f32; 3]>) -> f64 {
    let mut greatest = near.map_or(f64::NEG_INFINITY, |corner| along(corner, direction));
    for_each_rising(view, direction, greatest, |corner, value| {
        greatest = value;
        *near = Some(corner);
    });
    greatest + 0.0
}

/// [`support_near`] from the extremes of the body, where they are kept, or else from its tree: the
/// same bits.
#[must_use]
pub fn support_from(
    extremes: Option<&Extremes>,
    view: &BodyView<'_>,
    direction: DVec3,
    near: &mut Option<[f32; 3]>,
) -> f64 {
    match extremes {
        Some(extremes) => extremes.support_near(view, direction, near),
        None => support_near(view, direction, near),
    }
}

/// A corner with the greatest `x·d`; the origin for a body without a tree.
fn farthest(view: &BodyView<'_>, direction: DVec3) -> [f32; 3] {
    let mut farthest = [0.0; 3];
    for_each_rising(view, direction, f64::NEG_INFINITY, |corner, _| farthest = corner);
    farthest
}

/// Calls `take` with every corner that lies farther than all before and than `greatest` (m), and
/// its distance; the last is the farthest.
fn for_each_rising(
    view: &BodyView<'_>,
    direction: DVec3,
    mut greatest: f64,
    mut take: impl FnMut([f32; 3], f64),
) {
    let bound = |node: u32| reach(&view.nodes[node as usize].bounds, direction);
    // At most one node waits per level of the tree.
    let mut open = SmallVec::<[(u32, f64); 64]>::new();
    if !view.nodes.is_empty() {
        open.push((0, bound(0)));
    }
    while let Some((at, most)) = open.pop() {
        if most <= greatest {
            continue;
        }
        let node = &view.nodes[at as usize];
        if node.is_leaf() {
            let first = node.link as usize;
            for corner in view.corners[first..first + node.count as usize].iter().flatten() {
                let value = along(*corner, direction);
                if value > greatest {
                    greatest = value;
                    take(*corner, value);
                }
            }
        } else {
            let (left, right) = ((at + 1, bound(at + 1)), (node.link, bound(node.link)));
            // The farther child first: it raises the bound for the other.
            for child in if left.1 > right.1 { [right, left] } else { [left, right] } {
                if child.1 > greatest {
                    open.push(child);
                }
            }
        }
    }
}

/// [`support`] in each of the directions, given in the body's own frame.
#[must_use]
pub fn supports<const N: usize>(view: &BodyView<'_>, directions: &[DVec3; N]) -> [f64; N] {
    let mut near = None;
    directions.map(|direction| support_near(view, direction, &mut near))
}

fn along(point: [f32; 3], d: DVec3) -> f64 {
    let [x, y, z] = point.map(f64::from);
    (x * d.x + y * d.y) + z * d.z
}

/// [`along`] at the farthest corner of the box in direction `d`.
fn reach(box_: &Aabb, d: DVec3) -> f64 {
    let farthest = |i: usize| if d[i] < 0.0 { box_.min[i] } else { box_.max[i] };
    along([farthest(0), farthest(1), farthest(2)], d)
}

#[cfg(test)]
mod tests;
