//! Laws of the wide tree: it holds what the binary one holds, each triangle once, in exact boxes.

use super::*;
use crate::Body;
use crate::testing::{body_of, mesh_of, strip};

/// All triangles below a wide node, in the order of its lanes.
fn triangles(wide: &[WideNode], at: u32) -> Vec<u32> {
    let node = &wide[at as usize];
    let lanes = (0..LANES).filter(|lane| !node.is_empty(*lane));
    if node.is_leaf() {
        let mut all: Vec<u32> = lanes.map(|lane| node.link[lane]).collect();
        assert_eq!(all.len(), LANES.min(node.count as usize));
        if node.count as usize > LANES {
            assert_eq!(wide[at as usize + 1].root, node.root);
            all.extend(triangles(wide, at + 1));
        }
        return all;
    }
    lanes.flat_map(|lane| triangles(wide, node.link[lane])).collect()
}

fn range(body: &Body, node: usize) -> Vec<u32> {
    let below = below(&body.nodes);
    (below[node].first..below[node].first + below[node].triangles).collect()
}

fn check(body: &Body) {
    let wide = &body.wide;
    assert_eq!((wide.nodes[0].root, wide.of.len()), (0, body.nodes.len()));
    for (at, node) in wide.nodes.iter().enumerate() {
        let root = node.root as usize;
        assert_eq!(node.bounds, body.nodes[root].bounds);
        for lane in (0..LANES).filter(|lane| !node.is_empty(*lane)) {
            let link = node.link[lane] as usize;
            let exact = if node.is_leaf() {
                Aabb::of(&body.corners[link])
            } else {
                assert!(link > at);
                wide.nodes[link].bounds
            };
            for axis in 0..3 {
                assert_eq!(node.min[axis][lane], exact.min[axis]);
                assert_eq!(node.max[axis][lane], exact.max[axis]);
            }
        }
        let goes_on = at > 0 && wide.nodes[at - 1].count as usize > LANES;
        if !goes_on {
            assert_eq!(triangles(&wide.nodes, at as u32), range(body, root));
            assert_eq!(wide.of[root], at as u32);
        }
    }
    for (node, &at) in wide.of.iter().enumerate() {
        let (inner, outer) =
            (range(body, node), range(body, wide.nodes[at as usize].root as usize));
        assert!(outer.contains(&inner[0]) && outer.contains(&inner[inner.len() - 1]));
    }
}

#[test]
fn it_holds_what_the_binary_tree_holds() {
    for count in (1..40).chain([63, 64, 65, 200, 1000]) {
        check(&body_of(&mesh_of(strip(count))));
    }
}

/// A leaf of more triangles than lanes goes on in the nodes that follow.
#[test]
fn a_large_leaf_takes_several_nodes() {
    for count in [8, 9, 16, 17, 64] {
        let mut body = body_of(&mesh_of(strip(count)));
        body.nodes = vec![Node { bounds: body.nodes[0].bounds, link: 0, count: count as u32 }];
        body.wide = Wide::of(&body.nodes, &body.corners);
        assert_eq!(body.wide.nodes.len(), count.div_ceil(LANES));
        check(&body);
    }
}

#[test]
fn lanes_are_well_filled() {
    let body = body_of(&mesh_of(strip(4096)));
    let used: usize = body
        .wide
        .nodes
        .iter()
        .map(|node| (0..LANES).filter(|lane| !node.is_empty(*lane)).count())
        .sum();
    assert!(used * 10 > body.wide.nodes.len() * LANES * 9, "{used}");
}

#[test]
fn nothing_has_no_wide_nodes() {
    assert_eq!(Wide::of(&[], &[]), Wide::default());
}
