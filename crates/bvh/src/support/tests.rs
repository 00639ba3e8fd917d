//! The invariant of supports: branch and bound gives the brute-force maximum, bit for bit.

use super::*;
use crate::fixtures::{any_build, body_of, directions, options, torus, triangles};
use body::Build;
use geometry::Corners;
use proptest::prelude::*;

fn brute_force(corners: &[Corners], d: DVec3) -> f64 {
    let along = corners.iter().flatten().map(|p| {
        let [x, y, z] = p.map(f64::from);
        (x * d.x + y * d.y) + z * d.z
    });
    along.fold(f64::NEG_INFINITY, f64::max) + 0.0
}

proptest! {
    #[test]
    fn equals_the_greatest_of_all_corners(
        corners in triangles(80), build in any_build(), leaf_size in 1_u32..9,
        d in prop::array::uniform3(-2.0..2.0), axis in 0_usize..4,
    ) {
        let body = body_of(&corners, &options(build, leaf_size));
        let mut d = DVec3::from_array(d);
        // Directions along an axis have zeros in them, where signs of zero matter.
        if axis < 3 {
            d = DVec3::AXES[axis] * d[axis];
        }
        let found = support(&body.view(), d);
        prop_assert_eq!(found.to_bits(), brute_force(&corners, d).to_bits());
    }
}

#[test]
fn all_directions_of_measurement_at_once() {
    let corners = torus(60, 30, 0.3);
    let body = body_of(&corners, &options(Build::Paper, 4));
    let d = directions().d;
    assert_eq!(supports(&body.view(), &d), d.map(|d| brute_force(&corners, d)));
}

#[test]
fn nothing_reaches_nowhere() {
    let mut body = body_of(&torus(3, 3, 0.3), &options(Build::Paper, 4));
    body.nodes.clear();
    assert_eq!(support(&body.view(), DVec3::X), f64::NEG_INFINITY);
}
