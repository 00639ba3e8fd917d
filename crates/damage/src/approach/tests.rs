//! Laws of hulls along a path, against prisms whose supports are summed up point by point.

use super::*;
use crate::scene::{Prism, Scene, car, head_on};
use proptest::prelude::*;

fn scenes() -> impl Strategy<Value = Scene> {
    let place = (-6.0..6.0, -4.0..4.0, -180.0..180.0_f64, 0.0..360.0_f64, 0.5..40.0_f64);
    place.prop_map(|(x, y, turned, towards, speed)| {
        let (sin, cos) = libm::sincos(towards.to_radians());
        Scene {
            b: Prism::cuboid(4.0, 1.7, [x, y], turned),
            velocity: [speed * cos, speed * sin],
            party_b: car(1, 1500.0, [x, y], turned),
            ..head_on(0.0)
        }
    })
}

#[test]
fn cosines_are_the_same_on_both_sides_of_u() {
    for i in 1..HORIZONTAL {
        assert_eq!(cosine(i).to_bits(), cosine(HORIZONTAL - i).to_bits());
        assert_eq!(cosine(i), -cosine(opposite(i)));
        assert!((cosine(i) - libm::cos((5.0 * i as f64).to_radians())).abs() < 1e-15);
    }
    assert_eq!(cosine(QUARTER).to_bits(), 0.0_f64.to_bits());
}

#[test]
fn a_heading_is_horizontal_and_of_length_one_whatever_comes_in() {
    let tilted = DVec3::new(0.1, 0.0, 0.995);
    let up = tilted * (1.0 / tilted.length());
    let awkward = [DVec3::ZERO, DVec3::Z, DVec3::NAN, DVec3::INFINITY, DVec3::new(3.0, 4.0, 1.0)];
    for v in awkward {
        for between in awkward {
            let u = heading(v, between, up);
            assert!((u.length() - 1.0).abs() < 1e-12 && u.dot(up).abs() < 1e-12, "{v} {between}");
        }
    }
    assert_eq!(heading(DVec3::new(0.05, 0.0, 0.0), DVec3::Y, DVec3::Z), DVec3::Y);
}

#[test]
fn what_is_not_finite_is_refused() {
    let sound = head_on(0.0).approach();
    assert_eq!(sound.check(), Ok(()));
    for closing_m_s in [-1.0, f64::NAN, f64::INFINITY] {
        let unsound = Approach { closing_m_s, ..sound.clone() };
        assert_eq!(unsound.check(), Err(ApproachError::Speed));
    }
    let unsound = Approach { yaw_rad_s: [0.0, f64::NAN], ..sound.clone() };
    assert_eq!(unsound.check(), Err(ApproachError::Speed));
    let unsound = Approach { supports_b: Supports::EMPTY, ..sound };
    assert_eq!(unsound.check(), Err(ApproachError::Extent('B')));
}

proptest! {
    #[test]
    fn penetration_is_that_of_the_moved_body(
        scene in scenes(),
        s in -10.0..10.0_f64,
        i in 0..72_usize,
    ) {
        let approach = scene.approach();
        let moved = scene.b_at(s, &approach);
        let d = approach.directions.d[i];
        let most = scene.a.points().iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max);
        let least = moved.points().iter().map(|p| p.dot(d)).fold(f64::INFINITY, f64::min);
        prop_assert!((approach.penetration(i, s) - (most - least)).abs() < 1e-12);
    }

    /// Whatever crosses within an interval of travel lies within its reach, in the half-way frame.
    #[test]
    fn reach_holds_every_hit(
        scene in scenes(),
        from in -3.0..3.0_f64,
        length in 0.0..2.0_f64,
        part in 0.0..1.0_f64,
    ) {
        let approach = scene.approach();
        let s = from + part * length;
        let reach = approach.reach(from, from + length);
        for point in scene.hits(s, &approach) {
            for (i, d) in approach.directions.d.iter().enumerate() {
                let half_way = point + approach.directions.d[0] * (0.5 * s);
                prop_assert!(half_way.dot(*d) <= reach.0[i] + 1e-12);
            }
        }
    }
}
