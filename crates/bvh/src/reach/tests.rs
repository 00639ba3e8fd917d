//! The invariant of reach: every contact point of every pair of triangles below lies within.

use super::*;
use crate::fixtures::{any_build, body_of, options, pose, triangles};
use crate::{Counters, front, section};
use geometry::{DVec3, triangle};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn no_contact_lies_outside(
        a in triangles(24), b in triangles(24), pose in pose(), build in any_build(),
        depth in 0_u32..6,
    ) {
        let options = options(build, 2);
        let (a, b) = (body_of(&a, &options), body_of(&b, &options));
        let views = (a.view(), b.view());
        let directions = Directions::around(DVec3::X, DVec3::Z);
        let mut pairs = Vec::new();
        front(&views.0, &views.1, &pose, depth, &mut pairs, &mut Counters::default());
        let identity = geometry::RelativePose::between(
            &geometry::Pose::IDENTITY, &geometry::Pose::IDENTITY,
        );
        for pair in pairs {
            let mut supports = Supports::EMPTY;
            let both = (&views.0, &views.1);
            reach(both, &pose, pair, &directions, 1e-7, &mut supports);
            for i in section::triangles(&a.nodes, pair.a) {
                for j in section::triangles(&b.nodes, pair.b) {
                    let one = identity.triangle(&a.corners[i as usize]);
                    let other = pose.triangle(&b.corners[j as usize]);
                    if !triangle::intersect(&one, &other) {
                        continue;
                    }
                    for point in triangle::contact(&one, &other).points() {
                        let mut found = Supports::EMPTY;
                        found.add(&directions, *point);
                        let within = found.0.iter().zip(&supports.0).all(|(x, most)| x <= most);
                        prop_assert!(within, "{i} and {j}: {point:?}");
                    }
                }
            }
        }
    }
}
