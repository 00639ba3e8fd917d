//! Invariants of trees: they partition, their boxes are exact, and they depend only on the
//! triangles.

use super::*;
use crate::fixtures::{any_build, body_of, meta, options, soup, torus, triangles};
use crate::section;
use geometry::Aabb;
use proptest::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

fn grown(corners: &[Corners], options: &BuildOptions) -> Hierarchy {
    build(corners, options, &|_| ()).unwrap()
}

/// Checks what every walk relies on: preorder, partition, exact boxes, depth.
fn check(tree: &Hierarchy, corners: &[Corners], leaf_size: u32) {
    let nodes = &tree.nodes;
    let mut order = tree.order.clone();
    order.sort_unstable();
    assert!(order.iter().copied().eq(0..corners.len() as u32), "not a permutation");
    let (mut placed, mut deepest) = (0, 0);
    // The number that the next node must have, walking in preorder.
    let mut next = 0;
    let mut open = vec![(0_u32, 1)];
    while let Some((at, depth)) = open.pop() {
        assert_eq!(at, next, "not in preorder");
        next += 1;
        deepest = deepest.max(depth);
        let node = &nodes[at as usize];
        let below = section::triangles(nodes, at);
        let exact = below
            .clone()
            .map(|i| Aabb::of(&corners[tree.order[i as usize] as usize]))
            .fold(Aabb::EMPTY, |sum, box_| sum.union(&box_));
        assert_eq!(node.bounds, exact, "node {at}");
        if node.is_leaf() {
            assert!(node.count <= leaf_size);
            assert_eq!(node.link, placed, "leaves are not in order");
            let ids = &tree.order[below.start as usize..below.end as usize];
            assert!(ids.is_sorted(), "a leaf is not in ascending order");
            placed += node.count;
        } else {
            open.extend([(node.link, depth + 1), (at + 1, depth + 1)]);
        }
    }
    assert_eq!(next as usize, nodes.len());
    assert_eq!(placed as usize, corners.len());
    assert_eq!(deepest, tree.depth);
}

/// The paper's rule at one node, taken literally: all k of all axes, with the sets recomputed for
/// each.
fn naive_cut(corners: &[Corners], cuts: std::ops::RangeInclusive<usize>) -> (usize, Vec<u32>) {
    let extent = |ids: &[u32], axis: usize| {
        let along = ids.iter().flat_map(|&i| corners[i as usize]).map(|p| f64::from(p[axis]));
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    let n = corners.len();
    let mut best = (f64::INFINITY, usize::MAX, 0);
    let mut left = Vec::new();
    for axis in 0..3 {
        let high = |i: u32| corners[i as usize].iter().map(|p| p[axis]).fold(f32::MIN, f32::max);
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by(|&i, &j| high(i).partial_cmp(&high(j)).unwrap().then(i.cmp(&j)));
        for k in cuts.clone() {
            let (l, r) = order.split_at(k);
            let whole = extent(&order, axis);
            let ratio = (extent(l, axis) + extent(r, axis)) / whole;
            let ratio = if whole > 0.0 { ratio } else { f64::INFINITY };
            let key = (ratio, (2 * k).abs_diff(n), axis);
            if left.is_empty() || key < best {
                (best, left) = (key, l.to_vec());
            }
        }
    }
    left.sort_unstable();
    (best.2, left)
}

/// Triangle numbers below the left child of the root.
fn left_of_root(tree: &Hierarchy) -> Vec<u32> {
    let below = section::triangles(&tree.nodes, 1);
    let mut left = tree.order[below.start as usize..below.end as usize].to_vec();
    left.sort_unstable();
    left
}

/// Checks the first cut of both builds that follow the paper against the naive one.
fn check_root(corners: &[Corners]) {
    let n = corners.len();
    let balanced = (1..n).filter(|k| 8 * k >= n && 8 * k <= 7 * n);
    let balanced = balanced.clone().min().unwrap()..=balanced.max().unwrap();
    for (build, cuts) in [(Build::Paper, balanced), (Build::Literal, 1..=n - 1)] {
        let tree = grown(corners, &options(build, 1));
        assert_eq!(left_of_root(&tree), naive_cut(corners, cuts).1, "{build:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn every_tree_partitions_its_triangles(
        corners in triangles(80), build in any_build(), leaf_size in 1_u32..9,
    ) {
        check(&grown(&corners, &options(build, leaf_size)), &corners, leaf_size);
    }

    #[test]
    fn the_root_is_cut_as_the_paper_says(corners in triangles(40)) {
        prop_assume!(corners.len() > 1);
        check_root(&corners);
    }

    #[test]
    fn another_build_is_as_if_it_had_been_the_first(
        corners in triangles(40), from in any_build(), to in any_build(), leaf_size in 1_u32..5,
    ) {
        // Source ids of a mesh ascend; those of the fixture descend, so reverse the triangles.
        let corners: Vec<Corners> = corners.into_iter().rev().collect();
        let first = body_of(&corners, &options(from, 2));
        let (ids, mesh_order): (Vec<u32>, Vec<Corners>) = {
            let count = corners.len() as u32;
            let ids = (0..count).map(|i| 3 * (count - i) + 7);
            ids.rev().zip(corners.iter().rev()).unzip()
        };
        let again = rebuild(first.view(), &first.meta, &options(to, leaf_size), &|_| ()).unwrap();
        let fresh = grown(&mesh_order, &options(to, leaf_size));
        prop_assert_eq!(&again.nodes, &fresh.nodes);
        let expected: Vec<u32> = fresh.order.iter().map(|&i| ids[i as usize]).collect();
        prop_assert_eq!(&again.source_ids, &expected);
        prop_assert_eq!((again.meta.build, again.meta.depth), (to, fresh.depth));
        prop_assert_eq!(&again.dropped, &first.dropped);
    }
}

#[test]
fn threads_do_not_change_a_tree() {
    let on_a_grid = |corner: [f32; 3]| corner.map(|x| (x * 16.0).round() / 16.0 - 0.5);
    // An odd number, with many of equal height.
    let odd = soup(9_999, 0.1, 3).into_iter().map(|corners| corners.map(on_a_grid)).collect();
    let same = vec![soup(1, 1.0, 2)[0]; 20_000];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    for corners in [soup(60_000, 0.02, 1), torus(200, 100, 0.3), same, odd] {
        for build in [Build::Paper, Build::Sah] {
            let alone = grown(&corners, &options(build, 2));
            check(&alone, &corners, 2);
            for threads in [0, 2, 3, 8] {
                let options = BuildOptions { build, leaf_size: 2, threads };
                let grow = || grown(&corners, &options);
                for together in [grow(), pool.install(grow)] {
                    assert!(together == alone, "{build:?} with {threads} threads");
                }
            }
        }
    }
}

#[test]
fn the_balance_rule_keeps_trees_shallow() {
    // Each one inside the one before: the literal rule peels off slivers one by one.
    let nested: Vec<Corners> = (0..3000)
        .map(|i| {
            let r = 1.0 / (1.0 + i as f32);
            [[-r, -r, -r], [r, r, r], [r, -r, r]]
        })
        .collect();
    let depth = |build| grown(&nested, &options(build, 1)).depth;
    // log 3000 / log (8/7) = 60.
    assert!(depth(Build::Paper) <= 62, "{}", depth(Build::Paper));
    assert!(depth(Build::Literal) > 1000, "{}", depth(Build::Literal));
    let line: Vec<Corners> = (0..3000).map(|i| [[i as f32, 0.0, 0.0]; 3]).collect();
    let flat = grown(&line, &options(Build::Sah, 1)).depth;
    assert!(flat <= 14, "triangles without area: {flat}");
}

#[test]
fn identical_triangles_are_halved() {
    let same = vec![[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]; 1000];
    for build in [Build::Paper, Build::Literal, Build::Sah] {
        let tree = grown(&same, &options(build, 1));
        check(&tree, &same, 1);
        assert_eq!(tree.depth, 11, "{build:?}");
    }
}

#[test]
fn coordinates_at_the_ends_of_f32_build() {
    let ends = [f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-45, -1e-45, -0.0, 0.0];
    let corners: Vec<Corners> = (0..343)
        .map(|i| [[ends[i % 7], ends[i / 7 % 7], ends[i / 49]], [0.0; 3], [ends[i % 7]; 3]])
        .collect();
    for build in [Build::Paper, Build::Literal, Build::Sah] {
        let tree = grown(&corners, &options(build, 3));
        check(&tree, &corners, 3);
        let zeros = tree.nodes.iter().flat_map(|n| [n.bounds.min, n.bounds.max]).flatten();
        assert!(zeros.filter(|x| *x == 0.0).all(f32::is_sign_positive));
    }
    check_root(&corners);
}

#[test]
fn no_unit_makes_a_tree_deep() {
    // Centres overflow, areas overflow, areas vanish, extents are subnormal.
    for scale in [2.7e38, 1e25, 1e-25, 1e-42] {
        let corners: Vec<Corners> =
            soup(5000, 0.5, 8).iter().map(|t| t.map(|p| p.map(|x| x * scale))).collect();
        let tree = grown(&corners, &options(Build::Sah, 2));
        check(&tree, &corners, 2);
        assert!(tree.depth <= 20, "{scale}: {}", tree.depth);
    }
}

#[test]
fn progress_adds_up_to_all_triangles() {
    let corners = soup(30_000, 0.02, 3);
    for threads in [1, 4] {
        let (sum, calls) = (AtomicU64::new(0), AtomicU64::new(0));
        let options = BuildOptions { threads, ..BuildOptions::default() };
        build(&corners, &options, &|placed| {
            sum.fetch_add(placed, Ordering::Relaxed);
            calls.fetch_add(1, Ordering::Relaxed);
        })
        .unwrap();
        assert_eq!(sum.into_inner(), 30_000);
        assert!((2..=64).contains(&calls.into_inner()));
    }
}

#[test]
fn a_body_keeps_what_belongs_to_its_triangles() {
    let corners = soup(50, 0.5, 4);
    let body = body_of(&corners, &options(Build::Paper, 4));
    for (i, id) in body.source_ids.iter().enumerate() {
        let source = 50 - (id - 7) / 3;
        assert_eq!(body.corners[i], corners[source as usize]);
        assert_eq!(body.part_of[i], (source % 3) as u16);
        assert_eq!(body.zones[i].0, 1 << (source % 16));
    }
    assert_eq!((body.meta.leaf_size, body.meta.parts.len()), (4, 3));
    assert_eq!(body.dropped, [[4, 7]]);
}

#[test]
fn what_cannot_be_built_is_refused() {
    let refused = |corners: &[Corners], options: &BuildOptions| {
        build(corners, options, &|_| ()).expect_err("must not build")
    };
    let (one, seed) = (soup(1, 1.0, 5), BuildOptions::default());
    assert_eq!(refused(&[], &seed), BuildError::Empty);
    for leaf_size in [0, LEAF_SIZE_MAX + 1] {
        let error = refused(&one, &options(Build::Sah, leaf_size));
        assert_eq!(error, BuildError::LeafSize { leaf_size });
    }
    let many = vec![one[0]; LITERAL_MAX + 1];
    let error = refused(&many, &options(Build::Literal, 1));
    assert!(error.to_string().contains("use the build 'paper'"), "{error}");
    for bad in [f32::NAN, f32::INFINITY] {
        let mut corners = soup(9, 1.0, 6);
        corners[7][1][2] = bad;
        assert_eq!(refused(&corners, &seed), BuildError::NotFinite { triangle: 7 });
    }
    // If several are wrong, the first one is named, regardless of the thread that finds it.
    let mut corners = soup(20_000, 0.1, 7);
    for bad in [19_999, 13_000, 12_000] {
        corners[bad][2][0] = f32::NAN;
        let options = BuildOptions { threads: 4, ..seed };
        assert_eq!(refused(&corners, &options), BuildError::NotFinite { triangle: bad });
    }
    let mesh =
        body::Mesh { corners: one, source_ids: vec![0], part_of: vec![], ..Default::default() };
    let error = body(mesh, meta(), vec![body::Zones(0)], &seed, &|_| ()).expect_err("no parts");
    assert_eq!(error, BuildError::Lengths { triangles: 1, array: "part numbers", entries: 0 });
}
