//! Where two bodies cross: for each pair of triangles that intersect, the points of its contact.

use super::{PoseError, Workspace, task};
use crate::{Question, Side, Sink};
use body::BodyView;
use geometry::RelativePose;
use geometry::triangle::{self, ContactPoints, Triangle};
use std::ops::ControlFlow;

/// Two triangles that intersect, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairContact {
    /// Ids of A's triangle and of B's.
    pub ids: [u32; 2],
    /// Where they touch, in A's frame: one point, the two ends of a segment, or the corners of the
    /// overlap of triangles in one plane, in no particular order. Which edges a point lies on is
    /// exact; its coordinates are rounded.
    pub points: ContactPoints,
}

/// Returns all pairs of [`super::pairs`] in the same order, each with the points of its contact.
/// Where neither body has triangles in a plane of the other, the segments make up the curve in
/// which the bodies cross.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`super::POSE_MAX`].
pub fn contacts<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    workspace: &mut Workspace,
) -> Result<Vec<PairContact>, PoseError> {
    let task = task(a.into(), b.into(), pose, Question::Pairs);
    let mut found = Located { a: &task.a, b: &task.b, pose, contacts: Vec::new() };
    workspace.run(&task, &mut found)?;
    let mut contacts = found.contacts;
    contacts.sort_unstable_by_key(|contact| contact.ids);
    Ok(contacts)
}

/// Locates the contact of each pair.
struct Located<'l, 't> {
    a: &'l BodyView<'t>,
    b: &'l BodyView<'t>,
    pose: &'l RelativePose,
    contacts: Vec<PairContact>,
}

impl Sink for Located<'_, '_> {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn pairs(&mut self, a: &[u32], b: &[u32]) -> ControlFlow<()> {
        for (&a, &b) in a.iter().zip(b) {
            let (a, b) = (a as usize, b as usize);
            let of_a = Triangle::stored(&self.a.corners[a]);
            let of_b = self.pose.triangle(&self.b.corners[b]);
            self.contacts.push(PairContact {
                ids: [self.a.source_ids[a], self.b.source_ids[b]],
                points: triangle::contact(&of_a, &of_b),
            });
        }
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

#[cfg(test)]
mod tests {
    //! The contacts are those of the pairs, and lie on both triangles.

    use super::*;
    use crate::fixtures::{options, pose, soup, torus};
    use crate::query::{Tree, pairs};
    use body::Build;
    use proptest::prelude::*;

    #[test]
    fn a_blade_cuts_a_floor_in_a_segment() {
        let built = options(Build::Sah, 4);
        let floor = Tree::build(&[[[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]], &built).unwrap();
        let blade = [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]];
        let blade = Tree::build(&[blade], &built).unwrap();
        let pose = RelativePose::between(&geometry::Pose::IDENTITY, &geometry::Pose::IDENTITY);
        let found = contacts(&floor, &blade, &pose, &mut Workspace::new()).unwrap();
        let mut points: Vec<[f64; 3]> =
            found[0].points.points().iter().map(|point| point.to_array()).collect();
        points.sort_by(|p, q| p[1].total_cmp(&q[1]));
        assert_eq!((found.len(), points), (1, vec![[1.0, 1.0, 0.0], [1.0, 2.0, 0.0]]));
    }

    proptest! {
        #[test]
        fn contacts_belong_to_the_pairs(pose in pose(), seed in 0_u64..99) {
            let built = options(Build::Sah, 4);
            let a = Tree::build(&soup(60, 0.8, seed), &built).unwrap();
            let b = Tree::build(&torus(12, 6, 0.3), &built).unwrap();
            let mut workspace = Workspace::new();
            let found = contacts(&a, &b, &pose, &mut workspace).unwrap();
            let listed: Vec<_> = found.iter().map(|it| (it.ids[0], it.ids[1])).collect();
            prop_assert_eq!(listed, pairs(&a, &b, &pose, &mut workspace).unwrap());
            for contact in &found {
                prop_assert!(!contact.points.points().is_empty());
                let number = a.ids().iter().position(|id| *id == contact.ids[0]).unwrap();
                let bounds = Triangle::stored(&a.corners()[number]).bounds();
                for point in contact.points.points() {
                    prop_assert!(bounds.min.cmple(*point).all() && point.cmple(bounds.max).all());
                }
            }
        }
    }
}
