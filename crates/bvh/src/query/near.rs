//! Which of many bodies are near enough to each other to be worth a query.

use body::BodyView;
use geometry::{Bounds, DVec3, Pose, RelativePose};

/// By how much a box grows, per metre of its distance from the origin of its body or of the world:
/// more than poses that are rigid to 10⁻⁶ and rounding move a corner.
const GROWTH: f64 = 8e-6;

/// Returns the pairs of bodies whose boxes in the world overlap: numbers, the lesser first, each
/// pair once, ascending. All pairs that [`super::touches`] at [`RelativePose::between`] their poses
/// are among them, if these are rigid: `RᵀR` differs from the identity by at most 10⁻⁶.
#[must_use]
pub fn near_pairs(bodies: &[(BodyView<'_>, Pose)]) -> Vec<(u32, u32)> {
    let boxes: Vec<Bounds> = bodies.iter().map(world_box).collect();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&i, &j| boxes[i].min.x.total_cmp(&boxes[j].min.x));
    let mut pairs = Vec::new();
    for (rank, &i) in order.iter().enumerate() {
        let later = order[rank + 1..].iter();
        for &j in later.take_while(|&&j| boxes[j].min.x <= boxes[i].max.x) {
            if boxes[i].overlaps(&boxes[j]) {
                pairs.push((i.min(j) as u32, i.max(j) as u32));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// A box in the world with room for what a relative pose does otherwise.
fn world_box((body, pose): &(BodyView<'_>, Pose)) -> Bounds {
    let local = body.bounds();
    let to_world = RelativePose { rotation: pose.rotation, translation: pose.translation };
    let bounds = to_world.bounds(&local);
    let b = local.bounds();
    let reach = b.min.abs().max(b.max.abs()).length();
    let far = DVec3::from_array(pose.translation).length();
    let room = DVec3::splat(GROWTH * reach + 64.0 * f64::EPSILON * far);
    Bounds { min: bounds.min - room, max: bounds.max + room }
}

#[cfg(test)]
mod tests {
    //! No pair that touches is missing.

    use super::*;
    use crate::fixtures::{options, soup};
    use crate::query::{Tree, Workspace, touches};
    use body::Build;

    #[test]
    fn all_that_touch_are_near() {
        let tree = Tree::build(&soup(12, 0.6, 3), &options(Build::Sah, 2)).unwrap();
        let place = |i: u32| f64::from(i * i % 17) * 0.35;
        let pose = |i: u32| {
            Pose::from_degrees(37.0 * f64::from(i), 0.0, 11.0, [place(i), place(i + 5), 0.0])
        };
        let bodies: Vec<(BodyView<'_>, Pose)> = (0..40).map(|i| (tree.view(), pose(i))).collect();
        let near = near_pairs(&bodies);
        let mut workspace = Workspace::new();
        let mut touching = 0;
        for i in 0..40_u32 {
            for j in i + 1..40 {
                let between = RelativePose::between(&bodies[i as usize].1, &bodies[j as usize].1);
                let hit = touches(&tree, &tree, &between, &mut workspace).unwrap();
                touching += usize::from(hit);
                assert!(!hit || near.binary_search(&(i, j)).is_ok(), "{i} and {j}");
            }
        }
        assert!(touching > 20 && near.len() < 780, "{touching} of {}", near.len());
    }

    #[test]
    fn nobody_is_near_nobody() {
        assert_eq!(near_pairs(&[]), []);
    }
}
