//! Bodies and poses that make the tests of boxes and triangles as dear as they get.

use body::{BodyView, Build};
use bvh::{BuildError, BuildOptions, Tree};
use geometry::rng::Rng;
use geometry::{Corners, Pose, RelativePose};

/// Bodies of one kind, and how they are laid into each other.
#[derive(Debug)]
pub(super) struct Family<'b> {
    /// What makes them dear.
    pub(super) name: &'static str,
    pub(super) pairs: Vec<[TestBody<'b>; 2]>,
    /// Farthest that bodies are moved against each other along an axis (m), in steps or freely.
    reach: f64,
    poses: Poses,
}

/// How B lies to A.
#[derive(Clone, Copy, Debug)]
enum Poses {
    /// In the same plane or lattice: moved by quarters, turned by quarters of a turn.
    Lattice,
    /// Anyhow.
    Free,
}

/// A tree of this module, or a body of a deployment.
#[derive(Debug)]
pub(super) enum TestBody<'b> {
    Made(Tree),
    Given(BodyView<'b>),
}

impl TestBody<'_> {
    pub(super) fn view(&self) -> BodyView<'_> {
        match self {
            Self::Made(tree) => tree.view(),
            Self::Given(view) => *view,
        }
    }
}

impl Family<'_> {
    /// A pose of B in A's frame.
    pub(super) fn pose(&self, rng: &mut Rng) -> RelativePose {
        let reach = self.reach;
        let (turn, mut place) = match self.poses {
            Poses::Lattice => {
                let mut step = || 0.25 * rng.below((8.0 * reach) as u64 + 1) as f64 - reach;
                let place = [step(), step(), 0.0];
                ([90.0 * rng.below(4) as f64, 0.0, 0.0], place)
            }
            Poses::Free => {
                let turn = [0; 3].map(|_| rng.between(-180.0, 180.0));
                (turn, [0; 3].map(|_| rng.between(-reach, reach)))
            }
        };
        // Sometimes by less than f32 resolves: nothing is coplanar then, and all is nearly so.
        if rng.below(4) == 0 {
            place[2] += rng.between(-1e-9, 1e-9);
        }
        let b = Pose::from_degrees(turn[0], turn[1], turn[2], place);
        RelativePose::between(&Pose::IDENTITY, &b)
    }
}

/// All kinds; `given` are bodies of a deployment.
///
/// Sizes are such that the nodes of some lie in the nearest cache, of others in none.
pub(super) fn families<'b>(given: &[BodyView<'b>]) -> Result<Vec<Family<'b>>, BuildError> {
    let mut rng = Rng::new(0x5eed);
    let paper = |leaf_size| BuildOptions { build: Build::Paper, leaf_size, threads: 1 };
    let literal = BuildOptions { build: Build::Literal, leaf_size: 1, threads: 1 };
    let made = |corners: &[Corners], options: &BuildOptions| {
        Tree::build(corners, options).map(TestBody::Made)
    };
    let twice = |corners: &[Corners], options: &BuildOptions| {
        Ok::<_, BuildError>([made(corners, options)?, made(corners, options)?])
    };
    let two = |a: &[Corners], b: &[Corners], options: &BuildOptions| {
        Ok::<_, BuildError>([made(a, options)?, made(b, options)?])
    };
    let mut families = vec![
        Family {
            name: "one plane",
            pairs: vec![twice(&plane(16), &paper(4))?, twice(&plane(150), &paper(4))?],
            reach: 2.0,
            poses: Poses::Lattice,
        },
        Family {
            name: "degenerate",
            pairs: vec![
                twice(&lattice(400, &mut rng), &paper(4))?,
                twice(&lattice(20_000, &mut rng), &paper(1))?,
            ],
            reach: 2.0,
            poses: Poses::Lattice,
        },
        Family {
            name: "all overlap",
            pairs: vec![
                two(&soup(500, 2.0, &mut rng), &soup(500, 2.0, &mut rng), &paper(4))?,
                two(&soup(8_000, 1.0, &mut rng), &soup(8_000, 1.0, &mut rng), &paper(64))?,
            ],
            reach: 0.5,
            poses: Poses::Free,
        },
        Family {
            name: "needles",
            pairs: vec![
                two(&needles(2_000, &mut rng), &needles(2_000, &mut rng), &paper(4))?,
                two(&needles(60_000, &mut rng), &needles(60_000, &mut rng), &paper(4))?,
            ],
            reach: 0.5,
            poses: Poses::Free,
        },
        Family {
            name: "deep and thin",
            pairs: vec![
                twice(&shrinking(100), &literal)?,
                two(&shrinking(3_000), &soup(3_000, 0.5, &mut rng), &literal)?,
            ],
            reach: 0.2,
            poses: Poses::Free,
        },
        Family {
            name: "caches cold",
            pairs: vec![two(
                &soup(200_000, 0.05, &mut rng),
                &soup(200_000, 0.05, &mut rng),
                &paper(4),
            )?],
            reach: 1.0,
            poses: Poses::Free,
        },
    ];
    if let Some(first) = given.first() {
        let pairs = given.iter().map(|other| [TestBody::Given(*first), TestBody::Given(*other)]);
        families.push(Family {
            name: "of the deployment",
            pairs: pairs.collect(),
            reach: 1.5,
            poses: Poses::Free,
        });
    }
    Ok(families)
}

/// A square of 4 m, in the plane z = 0: 2 n² triangles that touch their neighbours.
fn plane(n: u32) -> Vec<Corners> {
    let at =
        |i: u32, j: u32| [i, j].map(|k| 4.0 * f64::from(k) / f64::from(n) - 2.0).map(|x| x as f32);
    let corner = |i, j| {
        let [x, y] = at(i, j);
        [x, y, 0.0]
    };
    let cell = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).flat_map(cell).collect()
}

/// Triangles on a coarse lattice: many touch, lie in one plane, are equal, segments or points.
fn lattice(count: usize, rng: &mut Rng) -> Vec<Corners> {
    let mut triangle = || [0; 3].map(|_| [0; 3].map(|_| 0.5 * (rng.below(9) as f32 - 4.0)));
    (0..count).map(|_| triangle()).collect()
}

/// Triangles of a size (m), scattered over a cube of 2 m.
fn soup(count: usize, size: f64, rng: &mut Rng) -> Vec<Corners> {
    let mut triangle = || {
        let centre = [0; 3].map(|_| rng.between(-1.0, 1.0));
        [0; 3].map(|_| centre.map(|x| (x + size * rng.between(-0.5, 0.5)) as f32))
    };
    (0..count).map(|_| triangle()).collect()
}

/// Triangles 2 m long and a tenth of a millimetre wide, in all directions: their boxes say little.
fn needles(count: usize, rng: &mut Rng) -> Vec<Corners> {
    let mut triangle = || {
        let from = [0; 3].map(|_| rng.between(-1.0, 1.0));
        let to = [0; 3].map(|_| rng.between(-1.0, 1.0));
        let beside = from.map(|x| x + rng.between(-5e-5, 5e-5));
        [from, to, beside].map(|corner| corner.map(|x| x as f32))
    };
    (0..count).map(|_| triangle()).collect()
}

/// Triangles within each other, each smaller by a hundredth: a tree as deep as there are triangles.
fn shrinking(count: usize) -> Vec<Corners> {
    let size = |i: usize| libm::pow(0.99, i as f64 % 1_400.0) as f32;
    let triangle = |i| {
        let s = size(i);
        [[0.0, 0.0, 0.0], [s, 0.1 * s, 0.0], [0.1 * s, s, 0.3 * s]]
    };
    (0..count).map(triangle).collect()
}

#[cfg(test)]
mod tests {
    //! The kinds are what they are called.
    use super::*;
    use bvh::query::{Workspace, pairs};

    #[test]
    fn pairs_of_one_plane_and_of_a_lattice_intersect_much() {
        let families = families(&[]).unwrap();
        let mut rng = Rng::new(1);
        for name in ["one plane", "degenerate", "all overlap"] {
            let family = families.iter().find(|family| family.name == name).unwrap();
            let [TestBody::Made(a), TestBody::Made(b)] = &family.pairs[0] else { panic!() };
            let found = (0..8).map(|_| {
                let pose = family.pose(&mut rng);
                pairs(a, b, &pose, &mut Workspace::new()).unwrap().len()
            });
            assert!(found.max().unwrap() > 200, "{name}");
        }
    }

    #[test]
    fn deep_trees_are_deep() {
        let families = families(&[]).unwrap();
        let family = families.iter().find(|family| family.name == "deep and thin").unwrap();
        let [TestBody::Made(tree), _] = &family.pairs[0] else { panic!() };
        assert!(tree.depth() > 30, "{}", tree.depth());
    }
}
