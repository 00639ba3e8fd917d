//! Invariants of sections: two siblings together hold what their parent holds.

use super::*;
use crate::fixtures::{self, any_build, body_of, options, soup};
use body::Build;
use proptest::prelude::*;

proptest! {
    #[test]
    fn siblings_share_out_what_their_parent_holds(
        corners in fixtures::triangles(60), build in any_build(), leaf_size in 1_u32..6,
    ) {
        let body = body_of(&corners, &options(build, leaf_size));
        let nodes = &body.nodes;
        prop_assert_eq!(triangles_of_all(nodes), 0..corners.len() as u32);
        for (at, node) in (0..).zip(nodes) {
            let (own, below) = (triangles(nodes, at), nodes_of(nodes, at));
            prop_assert_eq!(bytes(nodes, at), 36 * own.len() as u64 + 24 * below.len() as u64);
            if node.is_leaf() {
                prop_assert_eq!(own, node.link..node.link + node.count);
                prop_assert_eq!(below, at..at + 1);
                continue;
            }
            let (left, right) = (at + 1, node.link);
            let (l, r) = (triangles(nodes, left), triangles(nodes, right));
            prop_assert_eq!((own.start, l.end, own.end), (l.start, r.start, r.end));
            let (l, r) = (nodes_of(nodes, left), nodes_of(nodes, right));
            prop_assert_eq!((l.start, l.end, below.end), (at + 1, r.start, r.end));
        }
    }
}

fn triangles_of_all(nodes: &[Node]) -> std::ops::Range<u32> {
    super::triangles(nodes, 0)
}

#[test]
fn no_node_is_an_empty_section() {
    assert_eq!((triangles(&[], 0), nodes_of(&[], 0), bytes(&[], 0)), (0..0, 0..0, 0));
    let body = body_of(&soup(8, 0.1, 1), &options(Build::Paper, 1));
    let beyond = body.nodes.len() as u32;
    assert_eq!((triangles(&body.nodes, beyond), bytes(&body.nodes, u32::MAX)), (0..0, 0));
}

#[test]
fn a_damaged_tree_does_not_go_round() {
    let mut nodes = body_of(&soup(8, 0.1, 1), &options(Build::Paper, 1)).nodes;
    nodes[0].link = 0;
    assert_eq!((triangles(&nodes, 0), nodes_of(&nodes, 0)), (0..0, 0..0));
}
