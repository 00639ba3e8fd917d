//! Which triangles of one body intersect each other: where its surface passes through itself.

use super::{PoseError, Workspace, task};
use crate::{Question, Side, Sink};
use body::BodyView;
use geometry::triangle::{self, Triangle};
use geometry::{Corners, DVec3, Pose, RelativePose};
use std::ops::ControlFlow;

/// Returns the pairs of triangles of a body that have more in common than corners and edges of
/// both: ids, the lesser first, each pair once, ascending.
///
/// Corners are the same if their coordinates are equal, so a surface need not have its corners
/// stored once. Neighbours along an edge are a pair if they lie upon each other, neighbours at a
/// corner if they meet anywhere else, equal triangles always. A triangle without area is never a
/// pair with one that has a corner of it. All of this is exact, but that area is: see
/// [`body::is_degenerate`].
///
/// # Errors
///
/// Never for a body: its coordinates are finite.
pub fn self_pairs<'t>(
    body: impl Into<BodyView<'t>>,
    workspace: &mut Workspace,
) -> Result<Vec<(u32, u32)>, PoseError> {
    let body = body.into();
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    let task = task(body, body, &pose, Question::Pairs);
    let mut folds = Folds { body: &body, pairs: Vec::new() };
    workspace.run(&task, &mut folds)?;
    let mut pairs = folds.pairs;
    pairs.sort_unstable();
    Ok(pairs)
}

/// Keeps pairs of triangles that are no mere neighbours.
struct Folds<'f, 't> {
    body: &'f BodyView<'t>,
    pairs: Vec<(u32, u32)>,
}

impl Sink for Folds<'_, '_> {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn pairs(&mut self, a: &[u32], b: &[u32]) -> ControlFlow<()> {
        for (&a, &b) in a.iter().zip(b) {
            let ids = [a, b].map(|triangle| self.body.source_ids[triangle as usize]);
            let corners = [a, b].map(|triangle| &self.body.corners[triangle as usize]);
            if ids[0] < ids[1] && !is_neighbour(corners) {
                self.pairs.push((ids[0], ids[1]));
            }
        }
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Whether two triangles that intersect have only corners or an edge of both in common.
fn is_neighbour(both: [&Corners; 2]) -> bool {
    let [a, b] = both.map(|corners| Triangle::stored(corners).0);
    let shared: Vec<DVec3> = a.iter().copied().filter(|corner| b.contains(corner)).collect();
    if shared.is_empty() {
        return false;
    }
    if both.into_iter().any(body::is_degenerate) {
        return true;
    }
    let unshared = |corners: &[DVec3; 3]| -> Vec<DVec3> {
        corners.iter().copied().filter(|corner| !shared.contains(corner)).collect()
    };
    let meet = |p: [DVec3; 3], q: [DVec3; 3]| triangle::intersect(&Triangle(p), &Triangle(q));
    match (shared.as_slice(), unshared(&a).as_slice(), unshared(&b).as_slice()) {
        // What they share is convex and has this corner: more of it ends at an edge opposite.
        ([_], &[p, q], &[r, s]) => !meet([p, q, q], b) && !meet([r, s, s], a),
        // In two planes, they have the edge alone in common. In one, both on the same side of it,
        // either corner lies in the other triangle, or edges cross.
        (&[v, w], &[p], &[q]) => {
            !meet([p; 3], b)
                && !meet([q; 3], a)
                && !meet([p, w, w], [v, q, q])
                && !meet([p, v, v], [w, q, q])
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    //! Neighbours are no pair, folds and passages are, whatever the tree.

    use super::*;
    use crate::fixtures::{options, soup, torus};
    use crate::query::Tree;
    use body::Build;

    fn found(corners: &[Corners]) -> Vec<(u32, u32)> {
        let tree = Tree::build(corners, &options(Build::Sah, 2)).unwrap();
        self_pairs(&tree, &mut Workspace::new()).unwrap()
    }

    const BASE: Corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    #[test]
    fn a_closed_surface_has_none() {
        assert_eq!(found(&torus(24, 12, 0.3)), []);
    }

    #[test]
    fn neighbours_along_an_edge_are_a_pair_only_if_they_lie_upon_each_other() {
        let with = |third: [f32; 3]| found(&[BASE, [BASE[0], BASE[1], third]]);
        assert_eq!(with([1.0, -1.0, 0.0]), [], "flat, on the other side");
        assert_eq!(with([1.0, 1.0, 1e-30]), [], "nearly folded");
        assert_eq!(with([1.0, 1.0, 0.0]), [(0, 1)], "folded, within");
        assert_eq!(with([0.0, 5.0, 0.0]), [(0, 1)], "folded, beyond");
        assert_eq!(with([5.0, 5.0, 0.0]), [(0, 1)], "folded, edges cross");
        assert_eq!(with(BASE[2]), [(0, 1)], "equal");
        assert_eq!(with([1.0, 0.0, 0.0]), [], "without area");
    }

    #[test]
    fn neighbours_at_a_corner_are_a_pair_if_they_meet_elsewhere() {
        let with = |two: [[f32; 3]; 2]| found(&[BASE, [BASE[0], two[0], two[1]]]);
        assert_eq!(with([[-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]]), [], "away");
        assert_eq!(with([[0.5, 0.5, 1.0], [0.5, 0.5, -1.0]]), [(0, 1)], "through");
        assert_eq!(with([[3.0, 3.0, 1.0], [3.0, 3.0, -1.0]]), [(0, 1)], "through, and beyond");
        assert_eq!(with([[4.0, 0.0, 0.0], [4.0, -1.0, 0.0]]), [(0, 1)], "along an edge");
        assert_eq!(with([[-1.0, -1.0, 0.0], [1.0, -2.0, 0.0]]), [], "in one plane, beside");
    }

    #[test]
    fn triangles_without_a_common_corner_are_those_that_intersect() {
        let corners = soup(80, 0.9, 5);
        let stored: Vec<Triangle> = corners.iter().map(Triangle::stored).collect();
        let pair = |i: usize, j: usize| triangle::intersect(&stored[i], &stored[j]);
        let all = (0..80).flat_map(|i| (i + 1..80).map(move |j| (i, j)));
        let all: Vec<(u32, u32)> =
            all.filter(|&(i, j)| pair(i, j)).map(|(i, j)| (i as u32, j as u32)).collect();
        assert!(all.len() > 20);
        assert_eq!(found(&corners), all);
    }
}
