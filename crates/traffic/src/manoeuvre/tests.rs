//! Arcs stay within friction and end where integrals say.

use super::*;
use crate::outline::OutlinePart;
use proptest::prelude::*;

fn moment(x: f64, y: f64, yaw: f64, speed_m_s: f64) -> TimedState {
    TimedState { time_s: 0.0, place: Placed { at: [x, y], yaw }, speed_m_s, slip: 0.0 }
}

fn recording(ego: TimedState, others: Vec<Obstacle>) -> Recording {
    let ego =
        Ego { start: ego, outline: None, went: Vec::new(), spread: crate::StateSpread::default() };
    Recording { name: "test".to_owned(), ego, planned: Vec::new(), others, notes: Vec::new() }
}

proptest! {
    #[test]
    fn no_arc_asks_for_more_than_grip(
        speed in 0.0..60.0_f64, brake in 0.0..9.0_f64, lateral in -9.0..9.0_f64,
    ) {
        let manoeuvres = Manoeuvres::default();
        let start = moment(3.0, -2.0, 0.7, speed);
        let way = arc(&start, brake, lateral, &manoeuvres, 150);
        let mut before = start;
        for now in way {
            let dt = manoeuvres.step_s;
            let braked = (before.speed_m_s - now.speed_m_s) / dt;
            let middle = 0.5 * (before.speed_m_s + now.speed_m_s);
            let turned = (now.place.yaw - before.place.yaw) / dt * middle;
            prop_assert!(libm::hypot(braked, turned) <= manoeuvres.grip_m_s2 + 1e-6);
            prop_assert!(now.speed_m_s >= 0.0 && turned * lateral >= -1e-9);
            before = now;
        }
    }

    /// Distance and heading against the integrals: s = vt − bt²/2, yaw = (a/b)·ln(v/(v − bt)).
    #[test]
    fn arcs_end_where_integrals_say(
        speed in 15.0..40.0_f64, brake in 1.0..8.0_f64, lateral in -4.0..4.0_f64,
    ) {
        let manoeuvres = Manoeuvres::default();
        let way = arc(&moment(0.0, 0.0, 0.0, speed), brake, lateral, &manoeuvres, 50);
        let end = way[49];
        let run: f64 = [moment(0.0, 0.0, 0.0, speed)].iter().chain(&way).zip(&way)
            .map(|(a, b)| libm::hypot(b.place.at[0] - a.place.at[0], b.place.at[1] - a.place.at[1]))
            .sum();
        // Held through each step, the speed is half a step's braking higher.
        prop_assert!((run - (speed - 0.5 * brake * (1.0 - manoeuvres.step_s))).abs() < 1e-6);
        let lateral = lateral * left_of_grip(brake, manoeuvres.grip_m_s2);
        let turned = lateral / brake * libm::log(speed / (speed - brake));
        prop_assert!((end.place.yaw - turned).abs() < 1e-2, "{} {turned}", end.place.yaw);
    }
}

#[test]
fn a_recording_says_when_its_ego_meets_somebody() {
    let moment_at =
        |n: u32| TimedState { time_s: f64::from(n), ..moment(10.0 * f64::from(n), 0.0, 0.0, 10.0) };
    let round = Outline { parts: vec![OutlinePart::Circle([0.0; 2], 0.3)] };
    let walker = Obstacle {
        spread: crate::StateSpread::default(),
        id: "35".to_owned(),
        kind: "pedestrian".to_owned(),
        outline: round,
        track: vec![moment(50.0, 0.0, 0.0, 0.0)],
    };
    let mut recording = recording(moment_at(0), vec![walker]);
    recording.ego.went = (0..8).map(moment_at).collect();
    let meets_s = recording.recorded_meeting_s(0.02).expect("it meets");
    assert!((meets_s - 4.76).abs() < 1e-9, "{meets_s}");
}

#[test]
fn after_its_recording_the_ego_goes_on_from_where_it_was() {
    let turned = std::f64::consts::FRAC_PI_2;
    let mut recording = recording(moment(0.0, 0.0, 0.0, 10.0), Vec::new());
    let last = TimedState { time_s: 2.0, ..moment(12.0, 8.0, turned, 5.0) };
    recording.ego.went = vec![recording.ego.start, last];
    let start = began(&recording.ego, 3.0);
    assert!(libm::hypot(start.place.at[0] - 12.0, start.place.at[1] - 13.0) < 1e-9, "{start:?}");
    assert_eq!((start.time_s, start.place.yaw, start.speed_m_s), (3.0, turned, 5.0));
}
