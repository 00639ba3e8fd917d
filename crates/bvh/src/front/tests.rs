//! Invariants of the front: disjoint pairs that cover every intersecting pair of triangles once.

use super::*;
use crate::fixtures::{any_build, body_of, options, pose, soup, triangles};
use crate::section;
use body::{Body, Build, Node};
use geometry::{Pose, triangle};
use proptest::prelude::*;
use std::collections::BTreeSet;

fn front_of(a: &Body, b: &Body, pose: &RelativePose, depth: u32) -> Vec<NodePair> {
    let mut out = Vec::new();
    front(&a.view(), &b.view(), pose, depth, &mut out, &mut Counters::default());
    out
}

/// Depth of every node, the root's being 0.
fn depths(nodes: &[Node]) -> Vec<u32> {
    let mut depths = vec![0; nodes.len()];
    for (i, node) in nodes.iter().enumerate().filter(|(_, node)| !node.is_leaf()) {
        depths[i + 1] = depths[i] + 1;
        depths[node.link as usize] = depths[i] + 1;
    }
    depths
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn every_hit_lies_in_one_pair_and_no_pair_of_triangles_in_two(
        a in triangles(24), b in triangles(24), pose in pose(), build in any_build(),
        leaf_size in 1_u32..5, depth in 0_u32..13,
    ) {
        let options = options(build, leaf_size);
        let (a, b) = (body_of(&a, &options), body_of(&b, &options));
        let mut covered = BTreeSet::new();
        for pair in front_of(&a, &b, &pose, depth) {
            for i in section::triangles(&a.nodes, pair.a) {
                for j in section::triangles(&b.nodes, pair.b) {
                    prop_assert!(covered.insert((i, j)), "{i} and {j} are in two jobs");
                }
            }
        }
        let identity = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
        for (i, of_a) in (0..).zip(&a.corners) {
            for (j, of_b) in (0..).zip(&b.corners) {
                if triangle::intersect(&identity.triangle(of_a), &pose.triangle(of_b)) {
                    prop_assert!(covered.contains(&(i, j)), "{i} and {j} are in no job");
                }
            }
        }
    }

    #[test]
    fn its_nodes_lie_at_the_depth_or_are_leaves_above(
        a in triangles(40), b in triangles(40), pose in pose(), depth in 0_u32..8,
    ) {
        let options = options(Build::Paper, 1);
        let (a, b) = (body_of(&a, &options), body_of(&b, &options));
        let (depths_a, depths_b) = (depths(&a.nodes), depths(&b.nodes));
        for NodePair { a: i, b: j } in front_of(&a, &b, &pose, depth) {
            for (at, nodes, depths) in [(i, &a.nodes, &depths_a), (j, &b.nodes, &depths_b)] {
                let at = at as usize;
                let leaf_above = nodes[at].is_leaf() && depths[at] < depth;
                prop_assert!(depths[at] == depth || leaf_above);
            }
        }
    }
}

#[test]
fn bodies_apart_have_no_front() {
    let options = options(Build::Paper, 1);
    let (a, b) = (body_of(&soup(50, 0.3, 1), &options), body_of(&soup(50, 0.3, 2), &options));
    let there = Pose::from_degrees(30.0, 0.0, 0.0, [9.0, 0.0, 0.0]);
    let pose = RelativePose::between(&Pose::IDENTITY, &there);
    let (mut out, mut counters) = (Vec::new(), Counters::default());
    front(&a.view(), &b.view(), &pose, 6, &mut out, &mut counters);
    assert_eq!((out, counters), (Vec::new(), Counters { nb: 1, np: 0 }));
}

#[test]
fn a_front_has_room_for_bodies_whose_boxes_all_overlap() {
    let same = vec![soup(1, 1.0, 3)[0]; 1024];
    let options = options(Build::Paper, 1);
    let (a, b) = (body_of(&same, &options), body_of(&same, &options));
    let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
    let pairs = front_of(&a, &b, &pose, 12);
    assert!((PAIRS_MAX - 1..=PAIRS_MAX).contains(&pairs.len()), "{}", pairs.len());
    let covered: usize = pairs
        .iter()
        .map(|p| section::triangles(&a.nodes, p.a).len() * section::triangles(&b.nodes, p.b).len())
        .sum();
    assert_eq!(covered, 1024 * 1024);
}
