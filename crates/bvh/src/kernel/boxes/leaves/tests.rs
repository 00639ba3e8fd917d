//! The invariants: lanes agree with the scalar model, and omit no triangle that overlaps a slab.

use super::super::ROUNDING;
use super::*;
use body::{Node, wide::Wide};
use fearless_simd::dispatch;
use geometry::{Aabb, simd};
use geometry::{Corners, DVec3};
use proptest::prelude::*;

/// Small numbers, some of them equal, and some outside any body.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![-2.0..2.0_f32, (-2_i8..=2).prop_map(f32::from), -1e30..1e30_f32, 0.0..1e-30_f32]
}

fn a_box() -> impl Strategy<Value = Aabb> {
    let corner = || prop::array::uniform3(coordinate());
    (corner(), corner()).prop_map(|(p, q)| Aabb::of(&[p, q, p]))
}

proptest! {
    #[test]
    fn cells_are_those_of_the_grid(over in a_box(), of in a_box()) {
        let expected = Grid::over(&over).cells(&of);
        for level in simd::levels() {
            let found = dispatch!(level, simd => {
                cells_of(&OneBox::of(simd, &of), &OneBox::of(simd, &over))
            });
            prop_assert_eq!(found, expected, "{:?} at {}", over, simd::name(level));
        }
    }

    #[test]
    fn triangles_that_meet_a_slab_are_beside_it_and_those_far_from_it_are_not(
        (corners, size) in leaf(),
        toward in [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64],
        at in -0.7..0.7_f64,
        thick in 0.0..0.2_f64,
    ) {
        let normal = DVec3::from_array(toward).try_normalize().unwrap_or(DVec3::X);
        let normal = normal.to_array().map(|x| x as f32);
        let (low, high) = ((at * size) as f32, ((at + thick) * size) as f32);
        let bounds = corners.iter().fold(Aabb::EMPTY, |all, one| all.union(&Aabb::of(one)));
        let leaf = Node { bounds, link: 0, count: corners.len() as u32 };
        let wide = Wide::of(&[leaf], &corners);
        let reach = [0, 1, 2].map(|axis| f64::from(bounds.extent(axis) * normal[axis].abs()));
        let (reach, slack) = (reach.iter().sum::<f64>(), size * ROUNDING);
        for level in simd::levels() {
            let found = dispatch!(level, simd => {
                let layer = Layer { normal: side_by_side(simd, normal), low, high };
                beside(simd, WideLeaf::all(&wide.nodes), &layer, slack)
            });
            for (i, triangle) in corners.iter().enumerate() {
                let along = |p: &[f32; 3]| {
                    (0..3).map(|axis| f64::from(p[axis]) * f64::from(normal[axis])).sum::<f64>()
                };
                let least = triangle.iter().map(along).fold(f64::INFINITY, f64::min);
                let most = triangle.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
                let is_beside = Places::first(i + 1).and(&found) != Places::first(i).and(&found);
                if least <= f64::from(high) && most >= f64::from(low) {
                    prop_assert!(is_beside, "{i} at {}", simd::name(level));
                }
                // Its box instead of the triangle, a cell on each side, and the truncated part.
                let box_ = Aabb::of(triangle);
                let ends = [box_.min, box_.max].map(|p| [0, 1, 2].map(|axis| {
                    f64::from(p[axis]) * f64::from(normal[axis])
                }));
                let least: f64 = (0..3).map(|axis| ends[0][axis].min(ends[1][axis])).sum();
                let most: f64 = (0..3).map(|axis| ends[0][axis].max(ends[1][axis])).sum();
                let wide = reach * (2.0 / 254.0 + 4.0 / 256.0) + 8.0 * slack;
                if least > f64::from(high) + wide || most < f64::from(low) - wide {
                    prop_assert!(!is_beside, "{i} at {}", simd::name(level));
                }
            }
        }
    }
}

/// A leaf of small triangles about the origin, some of it flat, and its size (m).
fn leaf() -> impl Strategy<Value = (Vec<Corners>, f64)> {
    let point = || prop::array::uniform3(-1.0..1.0_f32);
    let triangle = (point(), point(), point());
    let sizes = prop_oneof![Just(1e-9_f32), Just(1.0), Just(1e9)];
    let flat = prop::array::uniform3(prop_oneof![Just(0.0_f32), Just(1e-6), Just(1.0)]);
    (prop::collection::vec(triangle, 1..=LEAF_MAX), sizes, flat).prop_map(
        |(triangles, size, flat)| {
            let place = |p: [f32; 3], q: [f32; 3]| {
                [0, 1, 2].map(|axis| (0.8 * p[axis] + 0.2 * q[axis]) * flat[axis] * size)
            };
            let corners =
                triangles.into_iter().map(|(p, q, r)| [place(p, p), place(p, q), place(p, r)]);
            (corners.collect(), f64::from(size))
        },
    )
}
