//! What holds for every generated body, whatever its shape, count and seed.

use super::{Shape, TRIANGLES_MAX, TRIANGLES_MIN, call, generate};
use crate::body::Mesh;
use geometry::{Corners, DVec3};
use proptest::prelude::*;

type Point = [u32; 3];

/// A corner as its bits: welded corners must be identical, not near.
fn bits(p: [f32; 3]) -> Point {
    p.map(f32::to_bits)
}

/// Directed edges of the triangles, sorted.
fn edges(mesh: &Mesh) -> Vec<(Point, Point)> {
    let around = |c: &Corners| [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])];
    let all = mesh.corners.iter().flat_map(around);
    let mut edges: Vec<_> = all.map(|(a, b)| (bits(a), bits(b))).collect();
    edges.sort_unstable();
    edges
}

/// Each directed edge occurs once, and so does its reverse: closed, oriented, manifold. Components
/// share no edge, so the test of all is the test of each.
fn assert_closed(mesh: &Mesh, what: &str) {
    let edges = edges(mesh);
    if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
        let [a, b] = [pair[0].0, pair[0].1].map(|p| p.map(f32::from_bits));
        panic!("{what}: the edge from {a:?} to {b:?} runs twice one way");
    }
    for (a, b) in &edges {
        assert!(a != b, "{what}: an edge without length");
        assert!(edges.binary_search(&(*b, *a)).is_ok(), "{what}: an open edge");
    }
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))
}

/// Least area [m²] and volume [m³].
fn area_and_volume(mesh: &Mesh) -> (f64, f64) {
    mesh.corners.iter().fold((f64::INFINITY, 0.0), |(least, volume), c| {
        let [a, b, c] = c.map(wide);
        let area = 0.5 * (b - a).cross(c - a).length();
        (least.min(area), volume + a.dot(b.cross(c)) / 6.0)
    })
}

fn bounds(mesh: &Mesh) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let points = mesh.corners.iter().flatten().map(|p| wide(*p));
    points.fold(start, |(low, high), p| (low.min(p), high.max(p)))
}

fn assert_sound(shape: Shape, triangles: u32, seed: u64) {
    let what = call(shape, triangles, seed);
    let mesh = generate(shape, triangles, seed).unwrap();
    assert_eq!(mesh.corners.len() as u32, triangles / 2 * 2, "{what}");
    assert_eq!(mesh.part_of.len(), mesh.corners.len(), "{what}");
    assert!(mesh.source_ids.iter().copied().eq(0..mesh.corners.len() as u32), "{what}");
    assert!(mesh.part_of.iter().all(|part| usize::from(*part) < mesh.parts.len()), "{what}");
    assert!((0..mesh.parts.len()).all(|part| mesh.part_of.contains(&(part as u16))), "{what}");
    assert_closed(&mesh, &what);
    let (area, volume) = area_and_volume(&mesh);
    assert!(area > 1e-9, "{what}: a triangle of {area} m²");
    assert!(volume > 0.03, "{what}: {volume} m³");
    let mut faces: Vec<_> = mesh
        .corners
        .iter()
        .map(|c| {
            let mut face = c.map(bits);
            face.sort_unstable();
            face
        })
        .collect();
    faces.sort_unstable();
    assert!(faces.windows(2).all(|pair| pair[0] != pair[1]), "{what}: a face twice");
}

#[test]
fn every_shape_is_closed_and_has_the_count_asked_for() {
    for shape in Shape::ALL {
        for triangles in [500, 501, 502, 777, 1_000, 2_000, 7_000, 9_999, 25_000] {
            assert_sound(shape, triangles, 0);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn every_seed_and_count_gives_a_sound_body(
        shape in 0..Shape::ALL.len(),
        triangles in TRIANGLES_MIN..4_000,
        seed: u64,
    ) {
        assert_sound(Shape::ALL[shape], triangles, seed);
    }
}

#[test]
fn a_million_triangles_are_sound_too() {
    assert_sound(Shape::Pedestrian, TRIANGLES_MAX, 0);
}
