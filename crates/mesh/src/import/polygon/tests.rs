//! Triangles cover the polygon once: their areas add up to its own, whatever its shape and plane.

use super::*;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// Corners round a centre at rising angles with any radii: simple, mostly concave.
fn star(radii: &[f64]) -> Vec<[f64; 2]> {
    let count = radii.len() as f64;
    let corner = |(i, radius): (usize, &f64)| {
        let (sin, cos) = libm::sincos(i as f64 / count * TAU);
        [radius * cos, radius * sin]
    };
    radii.iter().enumerate().map(corner).collect()
}

fn doubled_area(ring: &[[f64; 2]]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
}

/// Puts a flat figure onto a slanted plane; dropping the axis again gives the figure back.
fn lift(flat: &[[f64; 2]], axis: usize, slant: [f64; 2]) -> Vec<[f64; 3]> {
    let lifted = |p: &[f64; 2]| {
        let mut point = [0.0; 3];
        point[(axis + 1) % 3] = p[0];
        point[(axis + 2) % 3] = p[1];
        point[axis] = slant[0] * p[0] + slant[1] * p[1];
        point
    };
    flat.iter().map(lifted).collect()
}

proptest! {
    #[test]
    fn a_polygon_is_covered_exactly_once(
        radii in prop::collection::vec(0.2_f64..2.0, 5..40),
        axis in 0_usize..3,
        slant in [-0.9_f64..0.9, -0.9..0.9],
        turn in any::<prop::sample::Index>(),
        reversed in any::<bool>(),
    ) {
        let mut ring = star(&radii);
        let start = turn.index(ring.len());
        ring.rotate_left(start);
        if reversed {
            ring.reverse();
        }
        let mut triangulator = Triangulator::new();
        let triangles = triangulator.cut(&lift(&ring, axis, slant));
        prop_assert!(triangles.len() <= ring.len() - 2);
        let whole = doubled_area(&ring);
        let areas: Vec<f64> =
            triangles.iter().map(|t| doubled_area(&t.map(|corner| ring[corner]))).collect();
        let (sum, sizes) = areas.iter().fold((0.0, 0.0), |s, a| (s.0 + a, s.1 + a.abs()));
        prop_assert!((sizes - whole.abs()).abs() < 1e-9, "{} of {}", sizes, whole);
        prop_assert!((sum.abs() - whole.abs()).abs() < 1e-9);
    }

    /// Whatever a ring does, each corner is one of a triangle, or lies on a side of one.
    #[test]
    fn every_corner_of_any_ring_is_kept(
        ring in prop::collection::vec([-3_i8..=3, -3_i8..=3], 4..14),
        axis in 0_usize..3,
    ) {
        let ring: Vec<[f64; 2]> = ring.iter().map(|p| p.map(f64::from)).collect();
        let corners = lift(&ring, axis, [0.5, 0.25]);
        let mut triangulator = Triangulator::new();
        let triangles = triangulator.cut(&corners);
        prop_assert!(triangles.len() <= ring.len());
        for (at, corner) in corners.iter().enumerate() {
            let is_of = |t: &[usize; 3]| {
                let sides = [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
                t.contains(&at) || sides.iter().any(|s| is_between(*corner, s.map(|i| corners[i])))
            };
            prop_assert!(triangles.iter().any(is_of), "corner {at} of {ring:?}: {triangles:?}");
        }
    }

    /// What every other reader makes of a convex face.
    #[test]
    fn a_convex_polygon_is_a_fan(count in 4_usize..30, axis in 0_usize..3) {
        let ring = star(&vec![1.0; count]);
        let fan: Vec<[usize; 3]> = (2..count).map(|i| [0, i - 1, i]).collect();
        let mut triangulator = Triangulator::new();
        prop_assert_eq!(triangulator.cut(&lift(&ring, axis, [0.3, 0.1])), fan);
    }
}

#[test]
fn a_concave_quad_is_not_folded_over() {
    // The fan from corner 0 would give areas 2 and −1.
    let arrow = [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let dart = [[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-0.5, 0.0, 0.0], [-1.0, -1.0, 0.0]];
    let mut triangulator = Triangulator::new();
    for start in 0..4 {
        let mut corners = dart;
        corners.rotate_left(start);
        let flat = corners.map(|c| [c[0], c[1]]);
        let areas: f64 = triangulator
            .cut(&corners)
            .iter()
            .map(|t| doubled_area(&t.map(|i| flat[i])).abs())
            .sum();
        assert!((areas - doubled_area(&flat).abs()).abs() < 1e-12, "start {start}");
    }
    // Without area: still there, as the segment that it is.
    assert_eq!(triangulator.cut(&arrow), [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn a_ring_that_crosses_itself_hides_nothing() {
    let bow = [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut triangulator = Triangulator::new();
    let triangles = triangulator.cut(&bow);
    let mut seen = [false; 4];
    triangles.iter().flatten().for_each(|corner| seen[*corner] = true);
    assert_eq!((triangles.len(), seen), (2, [true; 4]));
}

/// Regression: of two corners in one place each was taken to lie beside the other.
#[test]
fn corners_in_one_place_are_not_lost_together() {
    let ring =
        [[2.0, 3.0], [1.0, 1.0], [1.0, 3.0], [1.0, 3.0], [1.0, 0.0], [-1.0, -1.0], [-1.0, 0.0]];
    let corners = lift(&ring, 2, [0.0, 0.0]);
    let mut triangulator = Triangulator::new();
    let triangles = triangulator.cut(&corners);
    assert!(triangles.iter().flatten().any(|corner| ring[*corner] == [1.0, 3.0]), "{triangles:?}");
}

/// Regression: ears left out the tip of a spike, since it has no area.
#[test]
fn the_tip_of_a_spike_is_kept() {
    let ring = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 1.0], [2.0, 9.0], [2.0, 1.0], [0.0, 2.0]];
    let mut triangulator = Triangulator::new();
    let triangles = triangulator.cut(&lift(&ring, 2, [0.0, 0.0]));
    assert!(triangles.iter().flatten().any(|corner| *corner == 4), "{triangles:?}");
}

#[test]
fn corners_in_a_row_lose_no_area() {
    let ring = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]];
    let mut triangulator = Triangulator::new();
    for start in 0..ring.len() {
        let mut turned = ring;
        turned.rotate_left(start);
        let triangles = triangulator.cut(&lift(&turned, 1, [0.5, 0.25]));
        let areas: f64 = triangles.iter().map(|t| doubled_area(&t.map(|i| turned[i])).abs()).sum();
        assert!((areas - 6.0).abs() < 1e-12, "start {start}: {areas}");
    }
}
