//! Laws of the cut: whatever way the bodies go, it finds what a descent from the roots finds.

use super::*;
use crate::fixtures::{any_build, body_of, options, pose, soup, triangles};
use body::Build;
use geometry::Pose;
use proptest::prelude::*;

/// Steps of a way: where to, and how much turned.
fn way() -> impl Strategy<Value = Vec<([f64; 3], f64)>> {
    let step = (prop::array::uniform3(-0.2..0.2_f64), -20.0..20.0_f64);
    prop::collection::vec(step, 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, ..ProptestConfig::default() })]

    #[test]
    fn it_finds_what_a_descent_from_the_roots_finds(
        a in triangles(40), b in triangles(40), start in pose(), way in way(),
        build in any_build(), depth in 0_u32..9, scale in prop_oneof![Just(1.0), Just(0.01)],
    ) {
        let options = options(build, 1);
        let (a, b) = (body_of(&a, &options), body_of(&b, &options));
        let (a, b) = (a.view(), b.view());
        let mut cut = Cut::new();
        let (mut at, mut turned) = ([0.0; 3], 0.0);
        for (by, degrees) in way {
            at = core::array::from_fn(|i| at[i] + scale * by[i]);
            turned += scale * degrees;
            let moved = Pose::from_degrees(turned, 0.0, 0.0, at);
            let step = RelativePose::between(&Pose::IDENTITY, &moved);
            let pose = RelativePose {
                rotation: step.rotation,
                translation: core::array::from_fn(|i| step.translation[i] + start.translation[i]),
            };
            let (mut cold, mut warm) = (Vec::new(), Vec::new());
            crate::front(&a, &b, &pose, depth, &mut cold, &mut Counters::default());
            cut.front((&a, &b), &pose, depth, &mut warm, &mut Counters::default());
            prop_assert_eq!(cold, warm);
        }
    }
}

#[test]
fn a_short_way_takes_fewer_tests() {
    let options = options(Build::Seed, 1);
    let (a, b) = (body_of(&soup(400, 0.3, 1), &options), body_of(&soup(400, 0.3, 2), &options));
    let (a, b) = (a.view(), b.view());
    let mut cut = Cut::new();
    let (mut cold, mut warm) = (Counters::default(), Counters::default());
    for k in 0..16 {
        let moved = Pose::from_degrees(0.0, 0.0, 0.0, [0.5 + 0.001 * f64::from(k), 0.0, 0.0]);
        let pose = RelativePose::between(&Pose::IDENTITY, &moved);
        let (mut one, mut other) = (Vec::new(), Vec::new());
        crate::front(&a, &b, &pose, 8, &mut one, &mut cold);
        cut.front((&a, &b), &pose, 8, &mut other, &mut warm);
        assert_eq!(one, other);
    }
    assert!(2 * warm.nb < cold.nb, "{} of {}", warm.nb, cold.nb);
}
