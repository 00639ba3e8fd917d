//! Shells do not depend on the order of triangles or corners, and equal those found by comparing
//! every edge with every other.

use super::*;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// The faces of a cube between two corners, counter-clockwise from outside.
fn cube(low: f32, high: f32) -> Vec<Corners> {
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high } else { low });
    const FACES: [[usize; 4]; 6] =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let split = |[a, b, c, d]: [usize; 4]| [[a, b, c], [a, c, d]];
    FACES.into_iter().flat_map(split).map(|face| face.map(corner)).collect()
}

/// Per triangle the first one of its shell; and the open edges: everything compared with
/// everything.
fn compared(corners: &[Corners]) -> (Vec<usize>, usize) {
    let sides = |it: &Corners| [(it[0], it[1]), (it[1], it[2]), (it[2], it[0])];
    // −0 == 0 here.
    let is_same = |(a, b): ([f32; 3], [f32; 3]), (c, d): ([f32; 3], [f32; 3])| {
        (a == c && b == d) || (a == d && b == c)
    };
    let is_edge = |(a, b): &([f32; 3], [f32; 3])| a != b;
    let edges: Vec<_> = corners.iter().flat_map(sides).enumerate().collect();
    let edges: Vec<_> = edges.into_iter().filter(|(_, side)| is_edge(side)).collect();
    let mut first: Vec<usize> = (0..corners.len()).collect();
    // As often as a name can travel.
    for _ in corners {
        for (i, side) in &edges {
            for (k, other) in &edges {
                if is_same(*side, *other) {
                    let least = first[i / 3].min(first[k / 3]);
                    (first[i / 3], first[k / 3]) = (least, least);
                }
            }
        }
    }
    let twins =
        |side| edges.iter().filter(|(_, other)| is_same(side, *other)).map(|(i, _)| *i).collect();
    let odd: BTreeSet<Vec<usize>> = edges.iter().map(|(_, side)| twins(*side)).collect();
    (first, odd.iter().filter(|twins| twins.len() % 2 == 1).count())
}

fn lattice() -> impl Strategy<Value = Vec<Corners>> {
    let coordinate = prop::sample::select(vec![0.0_f32, -0.0, 1.0, 2.0]);
    let corner = prop::array::uniform3(coordinate);
    prop::collection::vec(prop::array::uniform3(corner), 0..14)
}

proptest! {
    #[test]
    fn shells_are_those_of_all_comparisons(corners in lattice()) {
        let shells = Shells::of(&corners);
        let (first, open_edges) = compared(&corners);
        prop_assert_eq!(shells.open_edges(), open_edges);
        let of_triangles = shells.of_triangles().iter();
        let found: Vec<usize> =
            of_triangles.map(|shell| shells.first_triangles()[*shell as usize] as usize).collect();
        prop_assert_eq!(found, first);
        let open = shells.kinds().iter().filter(|kind| **kind == ShellKind::Open).count();
        prop_assert_eq!(shells.is_watertight(), open == 0);
    }

    /// Shells are numbered by their first triangles; beyond that no order matters.
    #[test]
    fn the_order_of_triangles_and_corners_does_not_matter(
        (corners, shuffled) in lattice().prop_flat_map(|it| {
            let numbered: Vec<(usize, Corners)> = it.iter().copied().enumerate().collect();
            (Just(it), Just(numbered).prop_shuffle())
        }),
    ) {
        let turned: Vec<Corners> =
            shuffled.iter().map(|(_, [a, b, c])| [*b, *c, *a]).collect();
        let (one, other) = (Shells::of(&corners), Shells::of(&turned));
        prop_assert_eq!(one.open_edges(), other.open_edges());
        let mut partner = BTreeMap::new();
        for (place, (number, _)) in shuffled.iter().enumerate() {
            let [a, b] = [one.of_triangles()[*number], other.of_triangles()[place]];
            prop_assert_eq!(*partner.entry(a).or_insert(b), b);
            prop_assert_eq!(one.kinds()[a as usize], other.kinds()[b as usize]);
        }
        prop_assert_eq!(partner.len(), other.kinds().len());
    }
}

#[test]
fn a_cube_is_oriented_until_a_face_is_turned_or_missing() {
    let mut faces = cube(-0.0, 1.0);
    faces.extend(cube(3.0, 4.0));
    let shells = Shells::of(&faces);
    assert_eq!(shells.kinds(), [ShellKind::Oriented; 2]);
    assert_eq!((shells.first_triangles(), shells.open_edges()), (&[0, 12][..], 0));
    // The corners of both cubes are written with either zero.
    for corner in faces.as_flattened_mut() {
        *corner = corner.map(|x| if x == 0.0 { 0.0 } else { x });
    }
    faces[3].swap(0, 1);
    assert_eq!(Shells::of(&faces).kinds(), [ShellKind::Closed, ShellKind::Oriented]);
    faces.pop();
    let shells = Shells::of(&faces);
    assert_eq!(shells.kinds(), [ShellKind::Closed, ShellKind::Open]);
    assert!(!shells.is_watertight() && shells.open_edges() == 3);
}

#[test]
fn degenerate_triangles_open_nothing_and_close_gaps() {
    let [a, b] = [[0.0; 3], [1.0, 0.0, 0.0]];
    assert!(Shells::of(&[[a, a, b], [b, b, b]]).is_watertight());
    // An edge of the cube is split on one of its sides only.
    let mut faces = cube(0.0, 1.0);
    let [p, q, r] = faces[0];
    let middle = [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    faces.splice(0..1, [[p, middle, r], [middle, q, r]]);
    assert_eq!(Shells::of(&faces).open_edges(), 3);
    faces.push([p, q, middle]);
    assert_eq!(Shells::of(&faces).kinds(), [ShellKind::Oriented]);
}

#[test]
fn cubes_that_share_an_edge_are_one_closed_shell() {
    let mut faces = cube(0.0, 1.0);
    // Moved along x and y, so that they share an edge along z.
    faces.extend(cube(0.0, 1.0).iter().map(|face| face.map(|[x, y, z]| [x + 1.0, y + 1.0, z])));
    assert_eq!(Shells::of(&faces).kinds(), [ShellKind::Oriented]);
    assert_eq!(Shells::of(&[]).kinds(), []);
    assert!(Shells::of(&[]).is_watertight());
}
