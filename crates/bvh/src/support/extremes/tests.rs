//! The invariant of extremes: they equal branch and bound, bit for bit, in every direction.

use super::*;
use crate::fixtures::{any_build, body_of, directions, options, torus, triangles};
use crate::support::support;
use body::Build;
use proptest::prelude::*;

proptest! {
    #[test]
    fn equal_the_support_in_every_direction(
        corners in triangles(80), build in any_build(),
        d in prop::array::uniform3(-2.0..2.0), zeroed in 0_usize..8, even in any::<bool>(),
    ) {
        let body = body_of(&corners, &options(build, 4));
        let view = body.view();
        let (extremes, empty) = (Extremes::of(&view), Extremes::new(&view));
        let mut d = DVec3::from_array(d);
        for axis in 0..3 {
            // Along axes and in their planes directions lie between cells, and zeros have signs.
            d[axis] *= if zeroed >> axis & 1 == 1 { 0.0 } else { 1.0 };
        }
        if even {
            d = (d * 8.0).round();
        }
        let found = extremes.support_near(&view, d, &mut None);
        prop_assert_eq!(found.to_bits(), support(&view, d).to_bits());
        prop_assert_eq!(found.to_bits(), empty.support_near(&view, d, &mut None).to_bits());
    }
}

/// Thousands of corners, most cells with lists of few, and flat sides that have none.
#[test]
fn a_finer_body_is_asked_in_thousands_of_directions() {
    for corners in [torus(60, 30, 0.3), torus(90, 4, 0.4)] {
        let body = body_of(&corners, &options(Build::Paper, 4));
        let view = body.view();
        let extremes = Extremes::of(&view);
        let listed = extremes
            .cells
            .iter()
            .filter(|cell| cell.get().is_some_and(|of| !of.is_empty()))
            .count();
        assert!(listed * 10 > extremes.cells.len() * 9, "{listed}");
        let measured = directions().d;
        let mut near = None;
        for step in 0..4_000 {
            let turn = f64::from(step) * 0.1;
            let (sin, cos) = libm_free_turn(turn);
            let d = measured[step as usize % measured.len()];
            let d = DVec3::new(d.x * cos - d.z * sin, d.y, d.x * sin + d.z * cos);
            let expected = support(&view, d).to_bits();
            assert_eq!(extremes.support_near(&view, d, &mut None).to_bits(), expected, "{d}");
            assert_eq!(extremes.support_near(&view, d, &mut near).to_bits(), expected, "{d}");
        }
    }
}

/// Some point of the unit circle; which one does not matter.
fn libm_free_turn(t: f64) -> (f64, f64) {
    let square = 1.0 + t * t;
    (2.0 * t / square, (1.0 - t * t) / square)
}

#[test]
fn what_is_no_direction_is_left_to_the_tree() {
    let mut body = body_of(&torus(3, 3, 0.3), &options(Build::Paper, 4));
    let extremes = Extremes::of(&body.view());
    for d in [DVec3::ZERO, DVec3::NAN, DVec3::splat(f64::INFINITY)] {
        let (found, expected) =
            (extremes.support_near(&body.view(), d, &mut None), support(&body.view(), d));
        assert_eq!(found.to_bits(), expected.to_bits());
    }
    body.nodes.clear();
    let empty = Extremes::of(&body.view());
    assert_eq!(empty.support_near(&body.view(), DVec3::X, &mut None), f64::NEG_INFINITY);
}
