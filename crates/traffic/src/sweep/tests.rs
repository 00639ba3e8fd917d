//! Arcs stay within friction and end where integrals say; meetings are first overlaps.

use super::*;
use crate::outline::OutlinePart;
use proptest::prelude::*;

fn moment(x: f64, y: f64, yaw: f64, speed_m_s: f64) -> TimedState {
    TimedState { time_s: 0.0, place: Placed { at: [x, y], yaw }, speed_m_s, slip: 0.0 }
}

fn recording(ego: TimedState, others: Vec<Obstacle>) -> Recording {
    let ego = Ego { start: ego, outline: None, went: Vec::new() };
    Recording { name: "test".to_owned(), ego, others, notes: Vec::new() }
}

fn parked(id: &str, at: TimedState) -> Obstacle {
    let outline = Outline::rectangle(4.0, 2.0);
    Obstacle { id: id.to_owned(), kind: "car".to_owned(), outline, track: vec![at] }
}

proptest! {
    #[test]
    fn no_arc_asks_for_more_than_grip(
        speed in 0.0..60.0_f64, brake in 0.0..9.0_f64, lateral in -9.0..9.0_f64,
    ) {
        let sweep = ManoeuvreSweep::default();
        let start = moment(3.0, -2.0, 0.7, speed);
        let way = arc(&start, brake, lateral, &sweep, 150);
        let mut before = start;
        for now in way {
            let dt = sweep.step_s;
            let braked = (before.speed_m_s - now.speed_m_s) / dt;
            let middle = 0.5 * (before.speed_m_s + now.speed_m_s);
            let turned = (now.place.yaw - before.place.yaw) / dt * middle;
            prop_assert!(libm::hypot(braked, turned) <= sweep.grip_m_s2 + 1e-6);
            prop_assert!(now.speed_m_s >= 0.0 && turned * lateral >= -1e-9);
            before = now;
        }
    }

    /// Distance and heading against the integrals: s = vt − bt²/2, yaw = (a/b)·ln(v/(v − bt)).
    #[test]
    fn arcs_end_where_integrals_say(
        speed in 15.0..40.0_f64, brake in 1.0..8.0_f64, lateral in -4.0..4.0_f64,
    ) {
        let sweep = ManoeuvreSweep::default();
        let way = arc(&moment(0.0, 0.0, 0.0, speed), brake, lateral, &sweep, 50);
        let end = way[49];
        let run: f64 = [moment(0.0, 0.0, 0.0, speed)].iter().chain(&way).zip(&way)
            .map(|(a, b)| libm::hypot(b.place.at[0] - a.place.at[0], b.place.at[1] - a.place.at[1]))
            .sum();
        // Held through each step, the speed is half a step's braking higher.
        prop_assert!((run - (speed - 0.5 * brake * (1.0 - sweep.step_s))).abs() < 1e-6);
        let lateral = lateral * left_of_grip(brake, sweep.grip_m_s2);
        let turned = lateral / brake * libm::log(speed / (speed - brake));
        prop_assert!((end.place.yaw - turned).abs() < 1e-2, "{} {turned}", end.place.yaw);
    }
}

#[test]
fn the_first_overlap_is_the_meeting() {
    // Front bumper at 2.254 m, the other's rear at 20 − 2 m: 15.746 m at 10 m/s.
    let other = parked("7", moment(20.0, 0.0, 0.0, 0.0));
    let swept =
        recording(moment(0.0, 0.0, 0.0, 10.0), vec![other]).sweep(&ManoeuvreSweep::default());
    let straight = Manoeuvre::Arc { brake_m_s2: 0.0, lateral_m_s2: 0.0 };
    let meeting = swept.meetings.iter().find(|m| m.manoeuvre == straight).expect("it meets");
    assert!((meeting.ego.time_s - 1.58).abs() < 1e-9, "{}", meeting.ego.time_s);
    let braked = Manoeuvre::Arc { brake_m_s2: 8.0, lateral_m_s2: 0.0 };
    assert!(swept.free.contains(&braked), "it stands after 6.25 m");
    assert_eq!(swept.meetings.len() + swept.free.len(), 15);
}

#[test]
fn who_overlaps_at_the_start_is_named_and_nothing_is_tried() {
    let other = parked("7", moment(1.0, 0.5, 0.0, 0.0));
    let swept =
        recording(moment(0.0, 0.0, 0.0, 10.0), vec![other]).sweep(&ManoeuvreSweep::default());
    assert_eq!((swept.overlapped, swept.meetings.len(), swept.free.len()), (Some(0), 0, 0));
}

#[test]
fn what_is_gone_or_not_there_yet_is_not_met() {
    let mut other = parked("7", moment(10.0, 0.0, 0.0, 0.0));
    let parked_at = |time_s| TimedState { time_s, ..moment(10.0, 0.0, 0.0, 0.0) };
    other.track = vec![parked_at(0.0), parked_at(0.3)];
    let gone = recording(moment(0.0, 0.0, 0.0, 10.0), vec![other.clone()]);
    assert!(gone.sweep(&ManoeuvreSweep::default()).meetings.is_empty());
    other.track = vec![parked_at(0.3), parked_at(9.0)];
    let coming = recording(moment(0.0, 0.0, 0.0, 10.0), vec![other]);
    assert!(!coming.sweep(&ManoeuvreSweep::default()).meetings.is_empty());
}

#[test]
fn a_recorded_way_is_tried_and_left_where_manoeuvres_begin() {
    let moment_at =
        |n: u32| TimedState { time_s: f64::from(n), ..moment(10.0 * f64::from(n), 0.0, 0.0, 10.0) };
    let round = Outline { parts: vec![OutlinePart::Circle([0.0; 2], 0.3)] };
    let walker = Obstacle {
        id: "35".to_owned(),
        kind: "pedestrian".to_owned(),
        outline: round,
        track: vec![moment(50.0, 0.0, 0.0, 0.0)],
    };
    let mut recording = recording(moment_at(0), vec![walker]);
    recording.ego.went = (0..8).map(moment_at).collect();
    let meets_s = recording.recorded_meeting_s(0.02).expect("it meets");
    assert!((meets_s - 4.76).abs() < 1e-9, "{meets_s}");
    let late = recording.sweep(&ManoeuvreSweep { after_s: 4.0, ..ManoeuvreSweep::default() });
    assert_eq!(late.began_s, 4.0);
    assert_eq!(late.meetings[0].manoeuvre, Manoeuvre::Recorded);
    assert!((late.meetings[0].ego.time_s - 4.76).abs() < 1e-9);
    assert!(recording.sweep(&ManoeuvreSweep::default()).meetings.is_empty(), "too far within 3 s");
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
