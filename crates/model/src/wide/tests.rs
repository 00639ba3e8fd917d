//! Laws of the wide tree: it holds what the binary one holds, each triangle once, in exact boxes.

use super::*;
use crate::Body;
use crate::testing::{body_of, mesh_of, strip};

/// All triangles below a wide node, in the order of its lanes.
fn triangles(wide: &[WideNode], at: u32) -> Vec<u32> {
    let node = &wide[at as usize];
    let lanes = (0..LANES).filter(|lane| !node.is_empty(*lane));
    if node.is_leaf() {
        let mut all: Vec<u32> = lanes.map(|lane| node.triangle(lane)).collect();
        assert_eq!(all.len(), LANES.min(node.count as usize));
        if node.count as usize > LANES {
            assert_eq!(wide[at as usize + 1].root, node.root);
            all.extend(triangles(wide, at + 1));
        }
        return all;
    }
    lanes.flat_map(|lane| triangles(wide, node.child(lane))).collect()
}

/// No corner lies outside of the slab of its leaf, and the slab is no thicker than it must be.
fn check_slab(slab: &Slab, body: &Body, root: usize) {
    let [x, y, z] = slab.normal.map(f64::from);
    let corners = range(body, root).into_iter().flat_map(|i| body.corners[i as usize]);
    let along = corners.map(|p| {
        let [u, v, w] = p.map(f64::from);
        x * u + y * v + z * w
    });
    let (low, high) = along.fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(d), high.max(d)));
    let slack = 1e-6 * (1.0 + low.abs().max(high.abs()));
    assert!(f64::from(slab.low) <= low && low <= f64::from(slab.low) + slack);
    assert!(f64::from(slab.high) >= high && high >= f64::from(slab.high) - slack);
    assert!((x * x + y * y + z * z - 1.0).abs() < 1e-6);
}

/// A flat patch, and both sides of a thin sheet, lie in thin slabs however they are turned.
#[test]
fn slabs_of_flat_patches_are_thin() {
    let sheet = |thickness: f32| -> Vec<Corners> {
        let point = |i: usize, j: usize, up: f32| {
            let (x, y) = (i as f32 * 0.1, j as f32 * 0.1);
            [0.6 * x - 0.8 * up, y, 0.8 * x + 0.6 * up]
        };
        let square = |i, j, up| [point(i, j, up), point(i + 1, j, up), point(i, j + 1, up)];
        let both = |i, j| {
            let [a, b, c] = square(i, j, thickness);
            [square(i, j, 0.0), [a, c, b]]
        };
        (0..4).flat_map(|i| (0..4).flat_map(move |j| both(i, j))).collect()
    };
    for thickness in [0.0, 0.01] {
        let slab = Slab::around(&sheet(thickness));
        assert!(slab.high - slab.low < thickness + 1e-5, "{slab:?}");
    }
    let point = Slab::around(&[[[1.0, 2.0, 3.0]; 3]]);
    assert!(point.low <= 3.0 && point.high >= 3.0, "{point:?}");
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
            let exact = if node.is_leaf() {
                Aabb::of(&body.corners[node.triangle(lane) as usize])
            } else {
                let child = node.child(lane) as usize;
                assert!(child > at);
                wide.nodes[child].bounds
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
            if node.is_leaf() {
                check_slab(&node.slab(), body, root);
            }
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
fn shares_do_not_change_it() {
    for count in [1, 60, 200, 5000] {
        let body = body_of(&mesh_of(strip(count)));
        for shares in [0, 2, 3, 9] {
            let wide = Wide::shared(&body.nodes, &body.corners, shares, |cut| {
                assert!(cut.len() <= shares.max(1));
                cut.into_iter().rev().for_each(Share::fill);
            });
            assert!(wide == body.wide, "{count} triangles, {shares} shares");
        }
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
