//! Thin things that pass each other between any two poses: mirrors of cars.

use super::{ego, go_on, met, only, party, ranked};
use crate::course::CourseRow;
use crate::fixtures::{AHEAD_M, HALF, mirrored};
use body::Body;
use bvh::kernel::sweep::{SweepTask, Witness};
use geometry::rng::Rng;
use geometry::{DVec3, Pose, RelativePose, Sweep};
use proptest::prelude::*;

/// How long the mirrors are (m).
const MIRROR_M: f64 = 0.2;

#[test]
fn mirrors_meet_whenever_the_scene_begins() {
    let mut rng = Rng::new(32);
    for thickness_m in [0.002, 0.01, 0.02, 0.06] {
        let car = mirrored(MIRROR_M, thickness_m);
        let mut harm: Option<f64> = None;
        for _ in 0..60 {
            let before_m = rng.between(0.1, 20.0);
            // They close at 20 m/s, and their mirrors meet where they are as far apart as this.
            let meet_m = 2.0 * AHEAD_M + f64::from(thickness_m as f32);
            let x = meet_m + before_m;
            let state = format!(
                "state = {{ position_m = [{x:?}, 2.02, 0], yaw_deg = 180, speed_m_s = 10 }}"
            );
            let text = format!("{}{}{}", ego(), party("other", "sedan", &state), go_on(10.0));
            let answer = ranked(&text, &[&car, &car]);
            let row = only(&answer);
            assert_eq!(met(row), ["other"], "{thickness_m} m, {before_m} m before");
            let contact = &row.contacts[0];
            let off_s = contact.time_s - before_m / 20.0;
            assert!(off_s.abs() < 1e-6, "{thickness_m} m, {before_m} m before: {off_s} s off");
            assert!(contact.is_certain);
            let now = contact.persons.iter().map(|person| person.work.hi()).sum::<f64>();
            let first = *harm.get_or_insert(now);
            assert!((now - first).abs() <= 1e-3 * first, "{first} and {now}");
        }
    }
}

/// Two cars that go straight on, so that their mirrors would be at the same height at some time.
#[derive(Clone, Copy, Debug)]
struct Passing {
    /// By how much the mirrors overlap (m).
    overlap_m: f64,
    own_m_s: f64,
    other_m_s: f64,
    /// How far the other one is turned from oncoming, to its left (degrees).
    turn_deg: f64,
}

impl Passing {
    /// Where the other car is `before_s` before that, and which way.
    fn other_at(&self, before_s: f64) -> (DVec3, f64) {
        let at = DVec3::new(2.0 * AHEAD_M, 2.0 * (HALF[1] + MIRROR_M) - self.overlap_m, 0.0);
        (at - self.closing() * before_s, 180.0 + self.turn_deg)
    }

    /// The velocity of the other car, seen from the ego (m/s).
    fn closing(&self) -> DVec3 {
        let yaw = (180.0 + self.turn_deg).to_radians();
        DVec3::new(yaw.cos() * self.other_m_s - self.own_m_s, yaw.sin() * self.other_m_s, 0.0)
    }

    /// When they touch first, by every triangle against every other one.
    fn by_brute_force(&self, car: &Body, before_s: f64) -> Option<f64> {
        let (at, yaw_deg) = self.other_at(before_s);
        let other = Pose::from_degrees(yaw_deg, 0.0, 0.0, at.to_array());
        let (closing, pose) = (self.closing(), RelativePose::between(&Pose::IDENTITY, &other));
        let speed_m_s = closing.dot(closing).sqrt();
        let sweep = Sweep::new(closing, 0.0, 3.0 * speed_m_s).unwrap();
        let task = SweepTask { a: car.view(), b: car.view(), pose, sweep };
        let numbers = 0..car.view().corners.len() as u32;
        let pairs = numbers.clone().flat_map(|a| numbers.clone().map(move |b| [a, b]));
        let travels = pairs.filter_map(|pair| Witness::of(&task, pair));
        travels.map(|witness| witness.travel_m / speed_m_s).reduce(f64::min)
    }

    /// When they touch first, by a ranking of the scene.
    fn ranked(&self, car: &Body, before_s: f64) -> Option<f64> {
        let (at, yaw_deg) = self.other_at(before_s);
        let state = format!(
            "state = {{ position_m = {:?}, yaw_deg = {yaw_deg:?}, speed_m_s = {:?} }}",
            at.to_array(),
            self.other_m_s
        );
        let text = format!("{}{}{}", ego(), party("other", "sedan", &state), go_on(self.own_m_s));
        let answer = ranked(&text, &[car, car]);
        let row: &CourseRow = only(&answer);
        row.contacts.first().map(|contact| contact.time_s)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_024, ..ProptestConfig::default() })]

    /// Two scenes a case: the same cars, that begin earlier and later.
    #[test]
    fn mirrors_meet_where_brute_force_has_them(
        thickness_m in prop_oneof![Just(2e-3), 2e-3..6e-2],
        overlap_m in prop_oneof![1e-4..1e-3, 1e-3..0.2],
        own_m_s in 2.0..20.0,
        other_m_s in 2.0..20.0,
        turn_deg in prop_oneof![Just(0.0), -3.0..3.0],
        begins_s in [0.1..0.5, 0.5..1.5],
    ) {
        let passing = Passing { overlap_m, own_m_s, other_m_s, turn_deg };
        let car = mirrored(MIRROR_M, thickness_m);
        let closing = passing.closing();
        let speed_m_s = closing.dot(closing).sqrt();
        let mut met_at = [None; 2];
        for (met_at, before_s) in met_at.iter_mut().zip(begins_s) {
            let time_s = passing.by_brute_force(&car, before_s);
            prop_assume!(time_s != Some(0.0));
            prop_assert!(time_s.is_some() || turn_deg != 0.0);
            let found_s = passing.ranked(&car, before_s);
            prop_assert_eq!(found_s.is_some(), time_s.is_some());
            if let (Some(found_s), Some(time_s)) = (found_s, time_s) {
                let off_m = (found_s - time_s) * speed_m_s;
                prop_assert!(off_m.abs() < 1e-6, "{off_m} m off, {before_s} s before");
            }
            *met_at = found_s.map(|found_s| (found_s - before_s) * speed_m_s);
        }
        // Unless they touch before the later scene begins, they touch at the same relative pose.
        if let [Some(later_m), Some(earlier_m)] = met_at
            && earlier_m > -begins_s[0] * speed_m_s
        {
            prop_assert!((later_m - earlier_m).abs() < 1e-6, "{later_m} m and {earlier_m} m");
        }
    }
}
