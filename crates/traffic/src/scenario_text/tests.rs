//! What is written is a scenario, in which everybody is where the recording says.

use super::*;
use crate::library::DEFAULT_LIBRARY;
use crate::outline::{OutlinePart, Placed, corners};
use crate::recording::{Ego, Obstacle};
use crate::write::middle;
use proptest::prelude::*;
use scenario::{Motion, Occupancy, Party};

mod shared_data;

pub(super) fn library() -> Library {
    Library::parse("default.toml", DEFAULT_LIBRARY).expect("shipped")
}

fn moment(time_s: f64, at: [f64; 2], yaw: f64, speed_m_s: f64) -> TimedState {
    TimedState { time_s, place: Placed { at, yaw }, speed_m_s, slip: 0.0 }
}

fn obstacle(id: &str, kind: &str, track: Vec<TimedState>) -> Obstacle {
    let outline = Outline::rectangle(4.0, 1.8);
    Obstacle {
        id: id.to_owned(),
        kind: kind.to_owned(),
        outline,
        track,
        spread: crate::StateSpread::default(),
    }
}

/// An ego that drives along x with 15 m/s from the origin, among these.
fn scene(others: Vec<Obstacle>) -> Recording {
    let start = moment(0.0, [0.0; 2], 0.0, 15.0);
    let ego = Ego { start, outline: None, went: Vec::new(), spread: crate::StateSpread::default() };
    Recording { name: "a \"name\"".to_owned(), ego, planned: Vec::new(), others, notes: Vec::new() }
}

fn parked(id: &str, at: [f64; 2]) -> Obstacle {
    obstacle(id, "car", vec![moment(0.0, at, 0.0, 0.0)])
}

/// A car that drives along x, with a state each 0.1 s between these times.
fn driving(id: &str, [from_s, to_s]: [f64; 2], speed_m_s: f64) -> Obstacle {
    let count = ((to_s - from_s) / 0.1).round() as u32;
    let states = (0..=count).map(|n| {
        let time_s = from_s + 0.1 * f64::from(n);
        // Not quite steadily, so that every state matters.
        let waves = 0.2 * libm::sin(3.0 * time_s);
        moment(time_s, [30.0 + speed_m_s * time_s, 4.0 + waves], waves, speed_m_s)
    });
    obstacle(id, "car", states.collect())
}

fn read_back(text: &str) -> Scenario {
    Scenario::parse("a.toml", text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn made(recording: &Recording, manoeuvres: &Manoeuvres) -> (Scenario, Vec<String>) {
    let (text, notes) =
        scenario_text("a.xml", recording, manoeuvres, &library()).unwrap_or_else(|e| panic!("{e}"));
    (read_back(&text), notes)
}

fn refused(recording: &Recording, manoeuvres: &Manoeuvres) -> ScenarioTextError {
    let made = scenario_text("a.xml", recording, manoeuvres, &library());
    made.map(|(_, notes)| notes).expect_err("a recording that gives no scenario")
}

fn party_of<'s>(scenario: &'s Scenario, name: &str) -> &'s Party {
    let found = scenario.parties.iter().find(|party| party.name.as_str() == name);
    found.unwrap_or_else(|| panic!("{name} is not there"))
}

fn motion<'s>(scenario: &'s Scenario, name: &str) -> &'s Motion {
    let [only] = &party_of(scenario, name).predictions[..] else { panic!("{name}") };
    assert_eq!(only.probability, 1.0);
    &only.motion
}

fn place(motion: &Motion, time_s: f64) -> [f64; 2] {
    let [x, y, z] = motion.path.pose_at(time_s).translation;
    assert_eq!(z, 0.0);
    [x, y]
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// How far a motion is from a track at all of its times until the horizon (m), but for those within
/// 0.1 ms of an end, which are one with it: there a body that turns sharply cuts the corner.
pub(super) fn off_m(motion: &Motion, obstacle: &Obstacle, began_s: f64, by: [f64; 2]) -> f64 {
    let to_s = motion.path.to_s();
    let is_own =
        |time_s: f64| (1e-4..=to_s - 1e-4).contains(&time_s) || time_s == 0.0 || time_s == to_s;
    let within = obstacle.track.iter().filter(|moment| is_own(moment.time_s - began_s));
    let off = within.map(|moment| {
        let [x, y] = middle(moment, &obstacle.outline).at;
        apart(place(motion, moment.time_s - began_s), [x - by[0], y - by[1]])
    });
    off.fold(0.0, f64::max)
}

/// Half of the last digit in x and y, and as much where a state was left out between others.
pub(super) const WRITTEN_M: f64 = 1.3e-4;

#[test]
fn every_type_becomes_a_party_and_every_manoeuvre_a_candidate() {
    for kind in crate::commonroad::TYPES {
        let recording = scene(vec![obstacle("4\"2", kind, parked("", [20.0, 0.0]).track)]);
        let manoeuvres = Manoeuvres::default();
        let (text, notes) = match scenario_text("a.xml", &recording, &manoeuvres, &library()) {
            Ok(written) => written,
            Err(error) => {
                assert!(kind == "train" && error.what.contains("no body for \"train\""), "{error}");
                assert!(error.remedy.contains("--bodies"), "{error:?}");
                continue;
            }
        };
        assert_eq!(notes, [""; 0]);
        let read = read_back(&text);
        assert_eq!((read.name.as_str(), read.horizon_s), ("a \"name\"", 3.0));
        assert_eq!((read.parties.len(), read.candidates.len()), (2, 15));
        assert_eq!(read.parties[read.ego.0].name.as_str(), "ego");
        let party = party_of(&read, &format!("{kind} 4_2"));
        assert!(!party.predictions[0].motion.moves() && text.contains("place = {"), "{text}");
        assert_eq!(place(&party.predictions[0].motion, 3.0), [20.0, 0.0]);
        let is_empty = kind == "parkedVehicle";
        let expected = if is_empty { Occupancy::Empty } else { Occupancy::Default };
        assert_eq!(party.occupancy, expected, "{kind}");
        assert_eq!(party.is_unknown, ["unknown", "constructionZone"].contains(&kind), "{kind}");
        assert_eq!(read.parties[read.ego.0].occupancy, Occupancy::Default);
    }
}

#[test]
fn manoeuvres_that_meet_nobody_are_candidates_too() {
    let recording = scene(vec![parked("7", [900.0, 0.0])]);
    let manoeuvres = Manoeuvres::default();
    let arc = |[brake_m_s2, lateral_m_s2]: [f64; 2]| Manoeuvre::Arc { brake_m_s2, lateral_m_s2 };
    let names: Vec<String> = manoeuvres.arcs().map(|of| arc(of).name()).collect();
    let (read, _) = made(&recording, &manoeuvres);
    let written: Vec<&str> = read.candidates.iter().map(|way| way.name.as_str()).collect();
    assert_eq!(written, names);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Arcs are followed at each of their steps, but for chords between those written.
    #[test]
    fn manoeuvres_go_where_the_sweep_drives(
        speed in -20.0..45.0_f64, yaw in -3.0..3.0_f64, horizon_s in 0.5..6.0_f64,
    ) {
        let mut recording = scene(vec![parked("7", [300.0, 0.0])]);
        recording.ego.start = moment(2.0, [7.0, -3.0], yaw, speed);
        let manoeuvres = Manoeuvres { horizon_s, ..Manoeuvres::default() };
        let (read, _) = made(&recording, &manoeuvres);
        let steps = (horizon_s / manoeuvres.step_s).floor() as u32;
        for ([brake, lateral], candidate) in manoeuvres.arcs().zip(&read.candidates) {
            for moment in arc(&recording.ego.start, brake, lateral, &manoeuvres, steps) {
                let is_at = place(&candidate.ego, moment.time_s - 2.0);
                // A chord of 0.1 s on a curve of 9 m/s², and a step of speed.
                let off_m = apart(is_at, moment.place.at);
                prop_assert!(off_m < 0.0125, "{} {off_m} after {}", candidate.name, moment.time_s);
            }
        }
    }

    /// At recorded times everybody is where the recording says, wherever the outline is, whenever
    /// the manoeuvres begin.
    #[test]
    fn motions_equal_the_track_at_recorded_times(
        speeds in prop::collection::vec((-30.0..30.0_f64, -30.0..30.0_f64, -8.0..8.0_f64), 40..60),
        after_s in 0.0..1.0_f64, at in prop::array::uniform2(-900.0..900.0_f64),
        step_s in prop::sample::select(vec![0.1, 1.0 / 30.0, 0.04]),
        middle_m in -2.0..2.0_f64,
    ) {
        let mut place = Placed { at, yaw: 1.0 };
        let track = (0..).zip(&speeds).map(|(n, (x, y, turn))| {
            place.at = [place.at[0] + x * step_s, place.at[1] + y * step_s];
            place.yaw += turn * step_s;
            moment(f64::from(n) * step_s, place.at, place.yaw, 5.0)
        });
        let mut other = obstacle("7", "car", track.collect());
        let part = OutlinePart::Polygon(corners(4.0, 2.0, [middle_m, 0.25], 0.0));
        other.outline = Outline { parts: vec![part] };
        let recording = scene(vec![other]);
        // Until its end at most, so that no velocity must fit the track.
        let horizon_s = 39.0 * step_s - after_s;
        let manoeuvres = Manoeuvres { after_s, horizon_s, ..Manoeuvres::default() };
        let (read, notes) = made(&recording, &manoeuvres);
        let off_m = off_m(motion(&read, "car 7"), &recording.others[0], after_s, [0.0; 2]);
        prop_assert!(off_m < WRITTEN_M && notes.is_empty(), "{off_m} {notes:?}");
    }
}

#[test]
fn who_leaves_goes_on_and_who_comes_later_came_straight() {
    let leaving = driving("7", [0.0, 1.0], 20.0);
    let coming = driving("8", [1.2, 9.0], 10.0);
    let (last, first) = (leaving.track[10], coming.track[0]);
    let (read, notes) = made(&scene(vec![leaving, coming]), &Manoeuvres::default());
    let went = motion(&read, "car 7");
    assert!(went.ends_s.is_some_and(|ends_s| (ends_s - 1.0).abs() < 1e-6), "{:?}", went.ends_s);
    let then = |moment: &TimedState, time_s: f64| {
        [0, 1].map(|i| moment.place.at[i] + moment.velocity_m_s()[i] * (time_s - moment.time_s))
    };
    assert!(apart(place(went, 3.0), then(&last, 3.0)) < 1e-3);
    let came = motion(&read, "car 8");
    assert_eq!(came.ends_s, None);
    for time_s in [0.0, 0.7, 1.2] {
        assert!(apart(place(came, time_s), then(&first, time_s)) < WRITTEN_M, "{time_s}");
    }
    assert_eq!(
        notes,
        [
            "obstacle 8 comes into the recording after 1.20 s: until then it is taken to go \
             straight, as fast as then",
            "obstacle 7: gone from the recording before the horizon, going on as in the last state",
        ]
    );
}

#[test]
fn who_is_there_only_at_other_times_is_left_out_and_named() {
    let others = vec![
        driving("7", [0.0, 1.0], 20.0),
        driving("8", [5.1, 9.0], 10.0),
        driving("9", [0.0, 9.0], 10.0),
    ];
    let manoeuvres = Manoeuvres { after_s: 2.0, ..Manoeuvres::default() };
    let (read, notes) = made(&scene(others.clone()), &manoeuvres);
    assert_eq!(read.parties.len(), 2);
    assert!(off_m(motion(&read, "car 9"), &others[2], 2.0, [0.0; 2]) < WRITTEN_M);
    assert_eq!(
        notes,
        [
            "obstacle 7: gone from the recording when manoeuvres begin: left out",
            "obstacle 8: not in the recording before the horizon: left out",
        ]
    );
    let alone = scene(others[..2].to_vec());
    let error = refused(&alone, &manoeuvres);
    assert!(error.what.starts_with("nobody is there") && error.remedy.contains("--at"), "{error}");
}

#[test]
fn who_would_come_from_inside_the_ego_is_noted() {
    let mut other = driving("7", [1.0, 9.0], 10.0);
    other.track.iter_mut().for_each(|moment| moment.place.at = [10.0 * moment.time_s, 0.0]);
    let (_, notes) = made(&scene(vec![other]), &Manoeuvres::default());
    assert!(notes[0].contains("inside the ego: --without 7"), "{notes:?}");
}

#[test]
fn what_the_ego_did_is_the_first_candidate() {
    let mut recording = scene(vec![parked("7", [60.0, 0.0])]);
    recording.ego.went = driving("", [0.0, 2.0], 15.0).track;
    recording.ego.start = recording.ego.went[0];
    let manoeuvres = Manoeuvres { after_s: 0.5, ..Manoeuvres::default() };
    let (read, notes) = made(&recording, &manoeuvres);
    assert_eq!((read.candidates.len(), read.candidates[0].name.as_str()), (16, "as recorded"));
    let way = &read.candidates[0].ego;
    assert!(way.ends_s.is_some_and(|ends_s| (ends_s - 1.5).abs() < 1e-6));
    let ego = Obstacle { track: recording.ego.went.clone(), ..parked("", [0.0; 2]) };
    assert!(off_m(way, &ego, 0.5, [0.0; 2]) < WRITTEN_M);
    assert!(notes[0].starts_with("the recording of the ego ends after 1.50 s"), "{notes:?}");
    for candidate in &read.candidates {
        let begins = apart(place(&candidate.ego, 0.0), place(way, 0.0));
        assert!(begins < WRITTEN_M, "{}", candidate.name);
    }
    let late = Manoeuvres { after_s: 2.5, ..Manoeuvres::default() };
    let (read, notes) = made(&recording, &late);
    assert_eq!(read.candidates.len(), 15);
    assert!(notes[0].contains("\"as recorded\" is left out"), "{notes:?}");
}

#[test]
fn more_candidates_than_fit_and_twins_are_noted() {
    let recording = scene(vec![parked("7", [60.0, 0.0])]);
    let brakes_m_s2 = vec![0.0, 2.0, 4.0, 8.0, 8.0];
    let manoeuvres = Manoeuvres { brakes_m_s2, ..Manoeuvres::default() };
    let (read, notes) = made(&recording, &manoeuvres);
    assert_eq!(read.candidates.len(), CANDIDATES_MAX);
    assert_eq!(notes[0], "the manoeuvre \"brake 8, straight\" is asked for twice: it stands once");
    assert_eq!(notes.last().unwrap(), "a request ranks 16 candidates: 4 more are left out");
}

#[test]
fn more_states_than_a_path_holds_are_thinned_evenly() {
    let other = driving("7", [0.0, 20.0], 10.0);
    let manoeuvres = Manoeuvres { horizon_s: 20.0, ..Manoeuvres::default() };
    let (read, notes) = made(&scene(vec![other.clone()]), &manoeuvres);
    assert_eq!(motion(&read, "car 7").path.states().len(), PATH_STATES_MAX);
    // Chords of 0.4 s on a wave of 0.2 m at 3 rad/s: 0.2·9·0.4²/8.
    assert!(off_m(motion(&read, "car 7"), &other, 0.0, [0.0; 2]) < 0.04);
    assert!(notes[0].starts_with("every manoeuvre of the ego has more states"), "{notes:?}");
    assert!(notes[1].starts_with("obstacle 7 has more states than the 64"), "{notes:?}");
    assert!(notes[1].ends_with("up to 0.40 s apart"), "{notes:?}");
}

#[test]
fn states_on_a_straight_way_are_not_written() {
    let steady = |n: u32| moment(0.1 * f64::from(n), [f64::from(n), 5.0], 0.0, 10.0);
    let other = obstacle("7", "car", (0..200).map(steady).collect());
    let waits = |n: u32| moment(0.1 * f64::from(n), [9.0, -5.0], 0.0, 0.0);
    let waiting = obstacle("8", "car", (0..200).map(waits).collect());
    let (read, _) = made(&scene(vec![other, waiting]), &Manoeuvres::default());
    assert_eq!(motion(&read, "car 7").path.states().len(), 2);
    assert!(!motion(&read, "car 8").moves());
    let straight = read.candidates.iter().find(|way| way.name.as_str() == "go on, straight");
    assert_eq!(straight.expect("a manoeuvre").ego.path.states().len(), 2);
}

#[test]
fn of_many_obstacles_those_out_of_reach_are_left_out() {
    let near = |n: u32| parked(&format!("near{n}"), [f64::from(n), 20.0]);
    let far = |n: u32| parked(&format!("far{n}"), [f64::from(n), 200.0]);
    let mut others: Vec<Obstacle> = (0..20).map(far).collect();
    others.extend((0..20).map(near));
    // One that is far and comes near: 45 m/s towards a braking ego.
    let oncoming = vec![
        moment(0.0, [170.0, 4.0], core::f64::consts::PI, 45.0),
        moment(4.0, [-10.0, 4.0], core::f64::consts::PI, 45.0),
    ];
    others.insert(0, obstacle("oncoming", "car", oncoming));
    let (read, notes) = made(&scene(others), &Manoeuvres::default());
    assert_eq!(read.parties.len(), PARTIES_MAX);
    let names: Vec<&str> = read.parties.iter().map(|party| party.name.as_str()).collect();
    assert!((0..20).all(|n| names.contains(&format!("car near{n}").as_str())), "{names:?}");
    assert!(names.contains(&"car oncoming"));
    let left_out = "a scenario holds 32 obstacles: 9 more, which no manoeuvre can reach, are left";
    assert_eq!(notes, [format!("{left_out} out")]);
}

#[test]
fn more_obstacles_in_reach_than_fit_are_an_error_that_names_the_farthest() {
    let others = (0..35).map(|n: u32| parked(&n.to_string(), [10.0 + f64::from(n), 3.0])).collect();
    let error = refused(&scene(others), &Manoeuvres::default());
    assert_eq!(
        error.what,
        "the ego can come near 35 obstacles within 3 s, and a scenario holds 32"
    );
    assert!(error.remedy.contains("--without ID, of which farthest is obstacles"), "{error:?}");
    assert!(error.remedy.ends_with("--horizon"), "{error:?}");
}

#[test]
fn what_a_scenario_may_not_say_is_refused_by_the_name_of_who_does_it() {
    let jump = vec![moment(0.0, [20.0, 5.0], 0.0, 9.0), moment(0.1, [60.0, 5.0], 0.0, 9.0)];
    let slides = vec![moment(0.0, [20.0, 5.0], 0.0, 9.0), moment(9.0, [60.0, 5.0], 0.0, 9.0)];
    for (kind, track, says) in [
        ("car", jump, "obstacle 7: from 0 s to 0.1 s the body would move at 400 m/s"),
        ("unknown", slides, "obstacle 7: a wall is fixed to the ground and cannot move"),
    ] {
        let recording = scene(vec![parked("6", [30.0, 0.0]), obstacle("7", kind, track)]);
        let error = refused(&recording, &Manoeuvres::default());
        assert_eq!(error.what, says);
        assert!(error.remedy.starts_with("leave it out: --without 7"), "{error:?}");
    }
    let mut fast = scene(vec![parked("6", [30.0, 0.0])]);
    fast.ego.start.speed_m_s = 120.0;
    let what = refused(&fast, &Manoeuvres::default()).what;
    assert!(what.starts_with("the ego's manoeuvre \"brake 8, straight\": from 0 s"), "{what}");
    let manoeuvres = Manoeuvres { horizon_s: 60.0, ..Manoeuvres::default() };
    assert_eq!(
        refused(&scene(vec![parked("6", [30.0, 0.0])]), &manoeuvres).what,
        "horizon_s is 60"
    );
}

#[test]
fn maps_far_from_the_origin_are_moved_and_outlines_have_their_middle() {
    let far = 5_300_000.0;
    let mut other = parked("7", [far + 20.0, far]);
    let part = OutlinePart::Polygon(corners(2.0, 1.0, [1.5, 0.25], 0.0));
    other.outline = Outline { parts: vec![part] };
    let mut recording = scene(vec![other]);
    recording.ego.start.place.at = [far; 2];
    let (text, _) =
        scenario_text("a\n.xml", &recording, &Manoeuvres::default(), &library()).expect("made");
    assert!(text.starts_with("# From a .xml: ") && text.contains("\n# Moved by ["), "{text}");
    assert_eq!(place(motion(&read_back(&text), "car 7"), 1.0), [21.5, 0.25]);
}

#[test]
fn names_are_unique_and_short_enough() {
    let parked =
        [("a/b", 20.0), ("a:b", 30.0), ("car_x", 40.0)].map(|(id, x)| parked(id, [x, 0.0]));
    let mut recording = scene(parked.into());
    recording.name = format!(" {}", "x".repeat(80));
    let (read, _) = made(&recording, &Manoeuvres::default());
    let names: Vec<&str> = read.parties.iter().map(|party| party.name.as_str()).collect();
    assert_eq!(names, ["car a_b", "car a_b (1)", "car_x", "ego"]);
    assert_eq!(read.name, "x".repeat(60));
}
