//! Written scenarios can be read back, and state what was met.

use super::*;
use crate::library::DEFAULT_LIBRARY;
use crate::outline::OutlinePart;
use crate::recording::{Ego, Obstacle};
use crate::sweep::ManoeuvreSweep;
use scenario::Scenario;

fn moment(x: f64, y: f64, speed_m_s: f64) -> TimedState {
    TimedState { time_s: 0.0, place: Placed { at: [x, y], yaw: 0.0 }, speed_m_s, slip: 0.0 }
}

fn scene(kind: &str, outline: Outline, offset: f64) -> Recording {
    let obstacle = Obstacle {
        id: "4\"2".to_owned(),
        kind: kind.to_owned(),
        outline,
        track: vec![moment(offset + 20.0, offset, 0.0)],
    };
    let ego = Ego { start: moment(offset, offset, 15.0), outline: None, went: Vec::new() };
    Recording { name: "a \"name\"".to_owned(), ego, others: vec![obstacle], notes: Vec::new() }
}

fn library() -> Library {
    Library::parse("default.toml", DEFAULT_LIBRARY).expect("shipped")
}

#[test]
fn what_is_written_is_a_scenario_with_a_candidate_for_each_meeting() {
    for kind in crate::commonroad::TYPES {
        let recording = scene(kind, Outline::rectangle(4.0, 1.8), 0.0);
        let swept = recording.sweep(&ManoeuvreSweep::default());
        let text = match scenario_text("a.xml", &recording, &swept, &library()) {
            Ok((text, _)) => text,
            Err(fault) => {
                assert!(kind == "train" && fault.contains("no body for \"train\""), "{fault}");
                continue;
            }
        };
        let read =
            Scenario::parse("a.toml", &text).unwrap_or_else(|e| panic!("{kind}: {e}\n{text}"));
        assert_eq!(read.candidates.len(), swept.meetings.len());
        assert_eq!(read.parties[read.candidates[0].other.party.0].name, format!("{kind} 4_2"));
    }
}

#[test]
fn bodies_stand_in_the_middle_of_their_outlines() {
    let ahead = OutlinePart::Polygon(crate::outline::corners(2.0, 1.0, [1.5, 0.25], 0.0));
    let recording = scene("car", Outline { parts: vec![ahead] }, 0.0);
    let swept = recording.sweep(&ManoeuvreSweep::default());
    let (text, _) = scenario_text("a.xml", &recording, &swept, &library()).expect("written");
    let read = Scenario::parse("a.toml", &text).expect("a scenario");
    let at = read.candidates[0].other.state.pose.translation;
    assert_eq!(at[..2], [21.5, 0.25]);
    assert!(text.contains("size_m = [2.0, 1.0]"), "{text}");
}

#[test]
fn a_circle_gives_its_longest_side() {
    let round = Outline { parts: vec![OutlinePart::Circle([0.0; 2], 0.3)] };
    let recording = scene("pedestrian", round, 0.0);
    let swept = recording.sweep(&ManoeuvreSweep::default());
    let (text, _) = scenario_text("a.xml", &recording, &swept, &library()).expect("written");
    assert!(text.contains("size_m = [0.6]"), "{text}");
}

#[test]
fn maps_far_from_the_origin_are_moved() {
    let recording = scene("car", Outline::rectangle(4.0, 2.0), 5_300_000.0);
    let swept = recording.sweep(&ManoeuvreSweep::default());
    let (text, _) = scenario_text("a.xml", &recording, &swept, &library()).expect("written");
    let read = Scenario::parse("a.toml", &text).expect("a scenario");
    assert!(read.candidates[0].ego.pose.translation[0].abs() < 30.0, "{text}");
}

#[test]
fn nothing_met_is_nothing_to_rank() {
    let mut recording = scene("car", Outline::rectangle(4.0, 2.0), 0.0);
    recording.others.clear();
    let swept = recording.sweep(&ManoeuvreSweep::default());
    let fault = scenario_text("a.xml", &recording, &swept, &library()).expect_err("nothing");
    assert!(fault.contains("nothing to rank"));
}
