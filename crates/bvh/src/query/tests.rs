//! Invariants of queries: they list what brute force lists, whatever the tree and the walk, and
//! rejections are explained in plain words.

use super::*;
use crate::fixtures::{
    Listener, Way, any_build, any_way, body_of, lattice, options, pose, soup, torus, triangles,
};
use crate::{Outcome, build};
use body::Shape;
use diagnostic::Failure;
use geometry::{Triangle, hash, triangle};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};

const SAME: RelativePose =
    RelativePose { rotation: Pose::IDENTITY.rotation, translation: Pose::IDENTITY.translation };

fn tree(corners: &[Corners], built: &BuildOptions) -> Tree {
    Tree::build(corners, built).unwrap()
}

/// Every triangle against every other, by their numbers, ascending.
fn brute_force(a: &[Corners], b: &[Corners], pose: &RelativePose) -> Vec<(u32, u32)> {
    let b: Vec<Triangle> = b.iter().map(|corners| pose.triangle(corners)).collect();
    let mut pairs = Vec::new();
    for (i, corners) in (0..).zip(a) {
        let of_a = Triangle::stored(corners);
        let hit = (0..).zip(&b).filter(|(_, of_b)| triangle::intersect(&of_a, of_b));
        pairs.extend(hit.map(|(j, _)| (i, j)));
    }
    pairs
}

/// The triangles of all pairs.
fn sets_of(pairs: &[(u32, u32)]) -> HitSets {
    let ids_by = |id: fn(&(u32, u32)) -> u32| {
        pairs.iter().map(id).collect::<BTreeSet<u32>>().into_iter().collect()
    };
    HitSets { of_a: ids_by(|pair| pair.0), of_b: ids_by(|pair| pair.1) }
}

/// What the kernel sums up in one job over all.
fn outcome(a: &Tree, b: &Tree, pose: &RelativePose) -> Outcome {
    let mut kernel = Kernel::with_room(a.depth(), b.depth(), a.ids().len(), b.ids().len());
    let task = task(a.view(), b.view(), pose, Question::Pairs);
    kernel.run(&task, NodePair::ROOTS, u64::MAX, &mut Listener::new())
}

fn hash_of(pairs: &[(u32, u32)]) -> u64 {
    pairs.iter().fold(0, |sum, pair| sum.wrapping_add(hash::pair_term(pair.0, pair.1)))
}

/// Compares all queries with the brute-force result.
#[track_caller]
fn check(a: &Tree, b: &Tree, pose: &RelativePose, workspace: &mut Workspace, all: &[(u32, u32)]) {
    let listed = pairs(a, b, pose, workspace).unwrap();
    assert!(listed == all, "{} pairs listed, not {}", listed.len(), all.len());
    assert_eq!(touches(a, b, pose, workspace), Ok(!all.is_empty()));
    let least = all.first().map(|&(a, b)| [a, b]);
    assert_eq!(least_pair(a, b, pose, u64::MAX, workspace), Ok(ControlFlow::Continue(least)));
    assert_eq!(sets(a, b, pose, workspace), Ok(sets_of(all)));
    let outcome = outcome(a, b, pose);
    assert_eq!((outcome.pairs, outcome.hash), (all.len() as u64, hash_of(all)));
    assert_eq!((outcome.zones_a, outcome.zones_b), (0, 0));
}

fn built_options() -> impl Strategy<Value = BuildOptions> {
    (any_build(), 1_u32..9).prop_map(|(build, leaf_size)| options(build, leaf_size))
}

/// Rigid poses, and matrices that stretch, mirror or flatten.
fn any_matrix() -> impl Strategy<Value = RelativePose> {
    let row = || prop::array::uniform3(prop_oneof![Just(0.0), Just(1.0), -2.0..2.0_f64]);
    let bent = (prop::array::uniform3(row()), row())
        .prop_map(|(rotation, translation)| RelativePose { rotation, translation });
    prop_oneof![3 => pose(), 1 => bent]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn queries_answer_as_brute_force_does(
        of_a in triangles(32), of_b in triangles(32), pose in any_matrix(),
        (built_a, built_b) in (built_options(), built_options()), way in any_way(),
    ) {
        let (a, b) = (tree(&of_a, &built_a), tree(&of_b, &built_b));
        check(&a, &b, &pose, &mut way.workspace(), &brute_force(&of_a, &of_b, &pose));
    }

    /// Equal, touching, coplanar and degenerate triangles: a body against itself.
    #[test]
    fn a_body_meets_itself(
        corners in lattice(40), built in built_options(), turned in pose(), way in any_way(),
    ) {
        let tree = tree(&corners, &built);
        for pose in [SAME, turned] {
            let all = brute_force(&corners, &corners, &pose);
            check(&tree, &tree, &pose, &mut way.workspace(), &all);
        }
    }

    /// Results do not depend on earlier queries, on any bodies, however they ended.
    #[test]
    fn a_workspace_remembers_nothing(
        bodies in prop::collection::vec((triangles(40), built_options()), 3),
        asked in prop::collection::vec((0..3_usize, 0..3_usize, pose(), 0..30_usize), 1..12),
        way in any_way(),
    ) {
        let trees: Vec<Tree> = bodies.iter().map(|(corners, built)| tree(corners, built)).collect();
        let mut workspace = way.workspace();
        for (i, j, pose, most) in asked {
            let (a, b) = (&trees[i], &trees[j]);
            let all = brute_force(&bodies[i].0, &bodies[j].0, &pose);
            let mut listed = Vec::new();
            let ended = for_each_pair(a, b, &pose, &mut workspace, |a, b| {
                listed.push((a, b));
                if listed.len() > most { ControlFlow::Break(listed.len()) } else {
                    ControlFlow::Continue(())
                }
            });
            let stops = all.len() > most;
            prop_assert_eq!(listed.len(), all.len().min(most + 1));
            prop_assert_eq!(ended.unwrap().break_value(), stops.then_some(most + 1));
            let once: BTreeSet<_> = listed.iter().copied().collect();
            prop_assert_eq!(once.len(), listed.len());
            prop_assert!(listed.iter().all(|pair| all.binary_search(pair).is_ok()));
            check(a, b, &pose, &mut workspace, &all);
        }
    }

    #[test]
    fn ids_of_a_body_are_its_source_ids(
        of_a in triangles(20), of_b in triangles(20), pose in pose(), built in built_options(),
    ) {
        let (a, b) = (body_of(&of_a, &built), tree(&of_b, &built));
        // As `body_of` numbers them.
        let id = |number: u32| 3 * (of_a.len() as u32 - number) + 7;
        let all = brute_force(&of_a, &of_b, &pose).into_iter().map(|(a, b)| (id(a), b));
        let mut all: Vec<_> = all.collect();
        all.sort_unstable();
        prop_assert_eq!(pairs(&a, &b, &pose, &mut Workspace::new()), Ok(all.clone()));
        let turned: Vec<_> = pairs(a.view(), b.view(), &pose, &mut Workspace::new()).unwrap();
        prop_assert_eq!(turned, all);
    }
}

/// Thousands of pairs, many of them of coplanar neighbours, at every build and leaf size.
#[test]
fn surfaces_that_share_faces_list_the_same_pairs_whatever_the_tree() {
    let (ring, fat) = (torus(24, 12, 0.3), torus(18, 10, 0.5));
    let turned = RelativePose::between(
        &Pose::IDENTITY,
        &Pose::from_degrees(40.0, 12.0, 5.0, [0.9, 0.1, 0.2]),
    );
    let aside = RelativePose { translation: [1.0, 0.0, 0.0], ..SAME };
    for (pose, other) in [(turned, &fat), (aside, &fat), (SAME, &ring)] {
        let all = brute_force(&ring, other, &pose);
        assert!(all.len() > 100, "{}", all.len());
        for build in [Build::Paper, Build::Literal, Build::Sah] {
            for leaf_size in [1, 2, 4, 8, 64] {
                let built = options(build, leaf_size);
                let (a, b) = (tree(&ring, &built), tree(other, &built));
                for way in Way::all() {
                    check(&a, &b, &pose, &mut way.workspace(), &all);
                }
            }
        }
    }
}

#[test]
fn generated_bodies_list_the_pairs_of_brute_force() {
    let corners_of =
        |shape| shapes::generate(shape, 500, 0).expect("500 triangles are possible").corners;
    let (sedan, wall) = (corners_of(Shape::Sedan), corners_of(Shape::Wall));
    let turned = RelativePose::between(
        &Pose::IDENTITY,
        &Pose::from_degrees(170.0, 0.0, 0.0, [3.9, 0.3, 0.2]),
    );
    let before = RelativePose { translation: [2.3, 0.0, -0.1], ..SAME };
    let mut workspace = Workspace::new();
    for (a, b, pose) in [(&sedan, &sedan, turned), (&sedan, &wall, before), (&sedan, &sedan, SAME)]
    {
        let all = brute_force(a, b, &pose);
        assert!(all.len() > 10, "{} pairs", all.len());
        for build in [Build::Paper, Build::Literal, Build::Sah] {
            let built = options(build, 4);
            check(&tree(a, &built), &tree(b, &built), &pose, &mut workspace, &all);
        }
    }
}

/// Trees much deeper than the initial capacity, where nearly all boxes overlap: a workspace grows,
/// and where it cannot, what remains open is still done.
#[test]
fn no_tree_is_too_deep() {
    let chain: Vec<Corners> = (0..250)
        .map(|i| {
            let r = 1.0 / (1.0 + i as f32);
            [[-r, -r, -r], [r, r, r], [r, -r, r]]
        })
        .collect();
    let deep = tree(&chain, &options(Build::Literal, 1));
    assert!(deep.depth() > 100);
    let all = brute_force(&chain, &chain, &SAME);
    for walk in [Walk::Wide, Walk::Plain] {
        for levels in [0, 1] {
            let mut small = Workspace { levels, ..Workspace::new() };
            small.kernel = Kernel::with_room(0, 0, 0, 0);
            small.set_walk(walk);
            check(&deep, &deep, &SAME, &mut small, &all);
            // The plain walk needs little capacity.
            assert_eq!(small.levels > 1, levels == 1 && walk == Walk::Wide, "{levels} {walk:?}");
        }
        let mut usual = Workspace::new();
        usual.set_walk(walk);
        check(&deep, &deep, &SAME, &mut usual, &all);
    }
}

/// A workspace remains usable after a panic in a callback.
#[test]
fn a_panic_of_the_callback_leaves_nothing_behind() {
    let (of_a, of_b) = (soup(300, 0.6, 3), soup(300, 0.6, 4));
    let built = BuildOptions::default();
    let (a, b) = (tree(&of_a, &built), tree(&of_b, &built));
    let all = brute_force(&of_a, &of_b, &SAME);
    for way in Way::all() {
        let mut workspace = way.workspace();
        let mut left = all.len() / 2;
        let panicked = catch_unwind(AssertUnwindSafe(|| {
            for_each_pair::<()>(&a, &b, &SAME, &mut workspace, |_, _| {
                left = left.checked_sub(1).expect("half of them are enough");
                ControlFlow::Continue(())
            })
        }));
        assert!(panicked.is_err());
        check(&a, &b, &SAME, &mut workspace, &all);
    }
}

/// After the first query of a kind, the next one allocates nothing.
#[test]
fn a_workspace_has_room_for_what_it_had_room_for() {
    let built = BuildOptions::default();
    let [large, small] = [soup(3_000, 0.2, 5), soup(40, 0.4, 6)].map(|it| tree(&it, &built));
    let mut workspace = Workspace::new();
    let first = pairs(&large, &small, &SAME, &mut workspace).unwrap();
    let place = |it: &Workspace| (it.open.as_ptr(), it.open.capacity(), it.levels);
    let before = place(&workspace);
    assert!(touches(&small, &small, &SAME, &mut workspace).unwrap());
    assert_eq!(pairs(&large, &small, &SAME, &mut workspace).unwrap(), first);
    assert_eq!(place(&workspace), before);
}

#[test]
fn threads_share_trees() {
    let (of_a, of_b) = (soup(200, 0.4, 7), soup(200, 0.4, 8));
    let built = BuildOptions::default();
    let (a, b) = (tree(&of_a, &built), tree(&of_b, &built));
    let all = brute_force(&of_a, &of_b, &SAME);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| check(&a, &b, &SAME, &mut Workspace::new(), &all));
        }
    });
}

#[test]
fn what_cannot_be_built_is_refused_in_plain_words() {
    let [fine, mut bad] = [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 2];
    bad[2][1] = f32::NAN;
    let said = |corners: &[Corners], built: &BuildOptions| {
        let error = Tree::build(corners, built).unwrap_err();
        let failure = Failure::from(error.clone());
        assert_eq!(failure.kind(), FailureKind::Input);
        // One text holds both, for single-line output.
        assert_eq!(error.to_string(), failure.to_string().replace("\n  help", ""));
        failure.to_string()
    };
    let usual = BuildOptions::default();
    assert_eq!(
        said(&[], &usual),
        "the body has no triangles\n  help: import a mesh with faces, or select another group"
    );
    assert_eq!(
        said(&[fine, fine, bad], &usual),
        "triangle 2 has a coordinate that is not finite\n  help: repair the mesh"
    );
    bad[2][1] = f32::INFINITY;
    assert_eq!(Tree::build(&[bad], &usual), Err(BuildError::NotFinite { triangle: 0 }));
    assert_eq!(
        said(&[fine], &options(Build::Sah, 0)),
        "a leaf size of 0 is not possible\n  help: use 1 to 64"
    );
    assert_eq!(
        said(&vec![fine; build::LITERAL_MAX + 1], &options(Build::Literal, 4)),
        "the literal build takes at most 50000 triangles, the body has 50001\n  help: use the \
         build 'paper', which is the same split with a balance rule"
    );
    // Allocating this many is infeasible.
    assert_eq!(
        BuildError::TooMany { triangles: 3_000_000_000 }.to_string(),
        "the body has 3000000000 triangles, at most 2147483648 are possible: simplify it"
    );
}

#[test]
fn a_pose_that_is_not_finite_is_refused() {
    let tree = tree(&soup(5, 0.5, 9), &BuildOptions::default());
    let mut workspace = Workspace::new();
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0 * POSE_MAX] {
        for place in 0..12 {
            let mut pose = SAME;
            match place {
                0..9 => pose.rotation[place / 3][place % 3] = number,
                _ => pose.translation[place - 9] = number,
            }
            assert_eq!(touches(&tree, &tree, &pose, &mut workspace), Err(PoseError));
            assert_eq!(sets(&tree, &tree, &pose, &mut workspace), Err(PoseError));
            assert_eq!(pairs(&tree, &tree, &pose, &mut workspace), Err(PoseError));
        }
    }
    let far = RelativePose { translation: [POSE_MAX; 3], ..SAME };
    assert_eq!(touches(&tree, &tree, &far, &mut workspace), Ok(false));
    assert_eq!(
        Failure::from(PoseError).to_string(),
        "the pose has a number that is not finite, or beyond 1e100\n  help: check the values from \
         which the pose is computed"
    );
}

/// A body without a tree hits nothing.
#[test]
fn an_empty_view_hits_nothing() {
    let tree = tree(&soup(5, 0.5, 9), &BuildOptions::default());
    let nothing = BodyView {
        nodes: &[],
        wide: &[],
        wide_of: &[],
        corners: &[],
        source_ids: &[],
        zones: &[],
        ..tree.view()
    };
    let mut workspace = Workspace::new();
    assert_eq!(pairs(nothing, tree.view(), &SAME, &mut workspace), Ok(vec![]));
    assert_eq!(touches(tree.view(), nothing, &SAME, &mut workspace), Ok(false));
}
