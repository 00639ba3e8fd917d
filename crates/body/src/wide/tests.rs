//! Invariants of the wide tree: it holds what the binary one holds, each triangle once, in exact
//! boxes.

use super::*;
use crate::Body;
use crate::testing::{body_of, mesh_of, strip};

/// All triangles below a wide node, in the order of its lanes.
fn triangles(wide: &[WideNode], at: u32) -> Vec<u32> {
    let node = &wide[at as usize];
    if let Some(leaf) = node.leaf() {
        let lanes = (0..LEAF_LANES).filter(|lane| !leaf.is_empty(*lane));
        let mut all: Vec<u32> = lanes.map(|lane| leaf.first + lane as u32).collect();
        assert_eq!(all.len(), LEAF_LANES.min(leaf.count as usize));
        if leaf.count as usize > LEAF_LANES {
            assert_eq!(wide[at as usize + 1].root, leaf.root);
            all.extend(triangles(wide, at + 1));
        }
        return all;
    }
    let lanes = (0..LANES).filter(|lane| !node.is_empty(*lane));
    lanes.flat_map(|lane| triangles(wide, node.child(lane))).collect()
}

/// No corner lies outside the slab of its leaf, and the slab is no thicker than necessary.
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

/// A flat patch, and both sides of a thin sheet, lie in thin slabs in any orientation.
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
        let goes_on = at > 0 && wide.nodes[at - 1].leaf().is_some_and(|l| l.count as usize > 32);
        if !goes_on {
            assert_eq!(triangles(&wide.nodes, at as u32), range(body, root));
            assert_eq!(wide.of[root], at as u32);
        }
        if let Some(leaf) = node.leaf() {
            check_slab(&leaf.slab, body, root);
            let grid = Grid::over(&leaf.bounds);
            for lane in (0..LEAF_LANES).filter(|lane| !leaf.is_empty(*lane)) {
                let exact = Aabb::of(&body.corners[leaf.first as usize + lane]);
                let stored = [leaf.min, leaf.max].map(|of| of.map(|axis| axis[lane]));
                assert_eq!(stored, grid.cells(&exact));
            }
            continue;
        }
        for lane in (0..LANES).filter(|lane| !node.is_empty(*lane)) {
            let child = node.child(lane) as usize;
            assert!(child > at);
            let exact = wide.nodes[child].bounds;
            for axis in 0..3 {
                assert_eq!(node.min[axis][lane], exact.min[axis]);
                assert_eq!(node.max[axis][lane], exact.max[axis]);
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

/// A leaf of more triangles than lanes continues in the following nodes.
#[test]
fn a_large_leaf_takes_several_nodes() {
    for count in [31, 32, 33, 64, 65] {
        let mut body = body_of(&mesh_of(strip(count)));
        body.nodes = vec![Node { bounds: body.nodes[0].bounds, link: 0, count: count as u32 }];
        body.wide = Wide::of(&body.nodes, &body.corners);
        assert_eq!(body.wide.nodes.len(), count.div_ceil(LEAF_LANES));
        check(&body);
    }
}

#[test]
fn shares_do_not_change_it() {
    for count in [1, 60, 200, 5000] {
        let body = body_of(&mesh_of(strip(count)));
        for shares in [0, 2, 3, 9] {
            let wide = Laid::out(&body.nodes).filled(&body.corners, shares, |cut| {
                assert!(cut.len() <= shares.max(1));
                cut.into_iter().rev().for_each(LeafRun::fill);
            });
            assert!(wide == body.wide, "{count} triangles, {shares} shares");
        }
    }
}

/// The corners of a triangle take 36 bytes.
#[test]
fn it_is_smaller_than_the_triangles() {
    let body = body_of(&mesh_of(strip(4096)));
    let bytes = size_of_val(&body.wide.nodes[..]);
    assert!(bytes < 30 * body.corners.len(), "{bytes} bytes");
}

/// Cell numbers never fall as a coordinate grows, wherever the grid is: so boxes that overlap also
/// overlap in cells. And cells are no larger than necessary.
#[test]
fn cells_do_not_fall_along_an_axis() {
    let boxes = [[-0.7, 0.1], [3.0, 3.0], [0.0, 1e-42], [-1e30, 1e30], [1e7, 1e7 + 1.0]];
    for [low, high] in boxes {
        let cell = |x: f32| {
            let grid = Grid::over(&Aabb { min: [low; 3], max: [high; 3] });
            grid.cells(&Aabb { min: [x; 3], max: [x; 3] })[0][0]
        };
        let steps = (-2000..=2000).map(|i| low + (high - low) * (i as f32 / 1000.0));
        let around = [low, high].into_iter().flat_map(|x| [x.next_down(), x, x.next_up()]);
        let far = [f32::MIN, -1.0, 0.0, 1.0, f32::MAX];
        let mut all: Vec<f32> = steps.chain(around).chain(far).collect();
        all.sort_by(f32::total_cmp);
        assert!(all.is_sorted_by_key(|x| cell(*x)), "{low} to {high}");
        assert_eq!((cell(low), cell(f32::MAX)), (0, u8::MAX - 1));
        if high - low > 1e-30 {
            assert!(cell(low + (high - low) * 0.49) < 126 && cell(low + (high - low) * 0.51) > 128);
        }
    }
}

#[test]
fn nothing_has_no_wide_nodes() {
    assert_eq!(Wide::of(&[], &[]), Wide::default());
}
