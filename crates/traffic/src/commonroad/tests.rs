//! A small file by hand, each of its lines made wrong, and the recordings of others.

mod shared_data;

use crate::{ReadOptions, Recording, TrafficError, read};
use proptest::prelude::*;

/// One of everything, a line each: what is replaced in a test is a line of it.
const SMALL: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<commonRoad commonRoadVersion="2020a" timeStepSize="0.1" benchmarkID="Small">
<staticObstacle id="1"><type>parkedVehicle</type>
<shape><rectangle><length>4.5</length><width>2.0</width></rectangle></shape>
<initialState><position><point><x>30</x><y>0</y></point></position>
<orientation><exact>0.1</exact></orientation><time><exact>0</exact></time></initialState>
</staticObstacle>
<dynamicObstacle id="2"><type>pedestrian</type>
<shape><circle><radius>0.3</radius></circle></shape>
<initialState><position><point><x>20</x><y>-5</y></point></position>
<orientation><intervalStart>1.4</intervalStart><intervalEnd>1.6</intervalEnd></orientation>
<time><exact>0</exact></time><velocity><exact>1.5</exact></velocity></initialState>
<trajectory>
<state><position><rectangle><length>1</length><width>1</width><center><x>20</x><y>-2</y></center>
</rectangle></position><orientation><exact>1.5</exact></orientation><time><exact>20</exact></time>
<velocity><exact>1.5</exact></velocity></state>
</trajectory>
</dynamicObstacle>
<planningProblem id="100"><initialState>
<position><point><x>0</x><y>0</y></point></position>
<orientation><exact>0</exact></orientation><time><exact>0</exact></time>
<velocity><exact>12</exact></velocity></initialState></planningProblem>
</commonRoad>
"#;

fn small(old: &str, new: &str) -> Result<Recording, TrafficError> {
    assert!(old.is_empty() || SMALL.contains(old), "{old}");
    read("s.xml", &SMALL.replacen(old, new, 1), &ReadOptions::default())
}

#[test]
fn the_small_file_reads_as_it_is_written() {
    let read = small("", "").expect("valid");
    assert_eq!(read.name, "Small");
    assert_eq!(read.ego.start.speed_m_s, 12.0);
    let [parked, walker] = read.others.as_slice() else { panic!("two") };
    assert!(
        parked.is_static() && parked.kind == "parkedVehicle" && parked.outline.size() == [4.5, 2.0]
    );
    assert!(walker.outline.is_round());
    let middle = walker.at(1.0).expect("there");
    assert_eq!(middle.place.at, [20.0, -3.5]);
    assert!((middle.place.yaw - 1.5).abs() < 1e-12 && middle.speed_m_s == 1.5);
    assert!(walker.at(2.01).is_none(), "it went");
    assert_eq!(
        read.notes,
        ["obstacle 2: 2 of its states are intervals; their middles are taken; of the first: as \
          likely anywhere in them, standard deviations 3.308 ° of heading"]
    );
}

/// What is replaced, by what, the line of the fault, and its text.
const WRONG: &[(&str, &str, u32, &str)] = &[
    ("2020a", "2017a", 2, "version \"2017a\" is not known"),
    (" commonRoadVersion=\"2020a\"", "", 2, "attribute commonRoadVersion is missing"),
    ("timeStepSize=\"0.1\"", "timeStepSize=\"0\"", 2, "timeStepSize"),
    ("timeStepSize=\"0.1\"", "timeStepSize=\"fast\"", 2, "timeStepSize"),
    ("<type>pedestrian</type>", "<type>dragon</type>", 8, "obstacle type \"dragon\""),
    ("<type>pedestrian</type>", "", 8, "<type> is missing"),
    ("<circle><radius>0.3</radius></circle>", "<blob/>", 9, "shape <blob> is not known"),
    ("<circle><radius>0.3</radius></circle>", "", 9, "it has no shape"),
    ("<radius>0.3</radius>", "<radius>0</radius>", 9, "a radius of 0 m"),
    ("<radius>0.3</radius>", "", 9, "<radius> is missing"),
    ("<length>4.5</length>", "<length>4500</length>", 4, "a length of 4500 m"),
    ("<length>4.5</length>", "<length>NaN</length>", 4, "not a finite number"),
    ("<length>4.5</length>", "<length>long</length>", 4, "not a finite number"),
    ("<x>30</x>", "<x>1e300</x>", 5, "x is 1"),
    ("<x>30</x>", "", 5, "<x> is missing"),
    ("<orientation><exact>0.1</exact></orientation>", "", 5, "<orientation> is missing"),
    ("<exact>0.1</exact>", "<intervalStart>0</intervalStart>", 6, "neither an exact value"),
    ("<time><exact>20</exact></time>", "", 14, "<time> is missing"),
    ("<exact>20</exact>", "<exact>0</exact>", 14, "its time is not after"),
    ("<velocity><exact>12</exact></velocity>", "", 19, "<velocity> is missing"),
    ("<velocity><exact>12</exact>", "<velocity><exact>1200</exact>", 19, "1200 m/s"),
    ("<staticObstacle id=\"1\">", "<staticObstacle id=\"2\">", 8, "two obstacles have this id"),
    ("<staticObstacle id=\"1\">", "<staticObstacle>", 3, "attribute id is missing"),
    ("<trajectory>", "<occupancySet/><trajectory>", 13, "an occupancy set"),
    ("</trajectory>\n</dynamic", "</trajectorie>\n</dynamic", 17, "not readable as XML"),
    ("<commonRoad", "<!DOCTYPE x [<!ENTITY a \"&b;&b;\">]>\n<commonRoad", 2, "not readable as XML"),
];

#[test]
fn each_fault_is_named_at_its_line_with_a_remedy() {
    for (old, new, line, says) in WRONG {
        let error = small(old, new).expect_err(new);
        assert_eq!(error.place.line(), *line, "{new}: {error}");
        assert!(error.what.contains(says), "{new}: {error}");
        assert!(error.remedy.len() > 8, "{new}: {}", error.remedy);
    }
}

#[test]
fn what_is_not_xml_or_another_xml_is_named() {
    let read = |text: &str| read("a.xml", text, &ReadOptions::default()).expect_err("refused");
    assert!(read("schema = 1").what.contains("not XML: it begins with \"schema = 1\""));
    assert!(read("").what.contains("not XML"));
    assert!(read("<svg/>").what.contains("<svg>: not CommonRoad"));
    let deep = format!("<commonRoad>{}", "<a>".repeat(1_000_000));
    assert!(read(&deep).what.contains("more than 512 elements are nested"));
}

#[test]
fn an_element_of_very_many_attributes_is_refused_and_of_some_is_read() {
    let with = |count: usize| {
        let all: String = (0..count).map(|i| format!(" a{i}=\"\"")).collect();
        SMALL.replacen("<type>pedestrian</type>", &format!("<type>pedestrian</type><x{all}/>"), 1)
    };
    let read = |count| read("a.xml", &with(count), &ReadOptions::default());
    read(64).expect("as many as may be");
    // The parser would take minutes for these.
    let error = read(300_000).expect_err("too many");
    assert_eq!(error.place.line(), 8, "{error}");
    assert!(error.what.contains("more than 64 attributes") && !error.remedy.is_empty(), "{error}");
}

#[test]
fn obstacles_can_be_left_out_and_named_as_the_ego() {
    let without = ["2".to_owned()];
    let options = ReadOptions { without: &without, ..ReadOptions::default() };
    assert_eq!(read("s.xml", SMALL, &options).expect("valid").others.len(), 1);
    let without = ["9".to_owned()];
    let options = ReadOptions { without: &without, ..ReadOptions::default() };
    let error = read("s.xml", SMALL, &options).expect_err("unknown");
    assert!(error.what.contains("no obstacle \"9\"") && error.remedy.contains("1, 2"), "{error}");
    let options = ReadOptions { ego: Some("2"), ..ReadOptions::default() };
    let recording = read("s.xml", SMALL, &options).expect("valid");
    assert_eq!((recording.ego.went.len(), recording.others.len()), (2, 1));
    let nobody = SMALL.replace("planningProblem", "something");
    let error = read("s.xml", &nobody, &ReadOptions::default()).expect_err("no ego");
    assert!(error.remedy.contains("--ego"), "{error}");
}

#[test]
fn speeds_that_are_not_stated_follow_from_places() {
    let text = SMALL.replace("<velocity><exact>1.5</exact></velocity>", "");
    let recording = read("s.xml", &text, &ReadOptions::default()).expect("valid");
    let walker = &recording.others[1];
    assert_eq!(walker.track.iter().map(|m| m.speed_m_s).collect::<Vec<_>>(), [1.5, 1.5]);
    assert!(recording.notes.iter().any(|note| note.contains("speeds are not stated")));
}

/// The walker's states as text, between those of its first one and its end.
fn walked(states: &str) -> Result<Recording, TrafficError> {
    let from = SMALL.find("<trajectory>").expect("there");
    let to = SMALL.find("</trajectory>").expect("there");
    let text = [&SMALL[..from + 12], states, &SMALL[to..]].concat();
    read("s.xml", &text, &ReadOptions::default())
}

fn state(step: u32, [x, y]: [f64; 2], more: &str) -> String {
    format!(
        "<state><position><point><x>{x}</x><y>{y}</y></point></position><time><exact>{step}\
         </exact></time>{more}</state>"
    )
}

const HEADING: &str = "<orientation><exact>1.5</exact></orientation>";
const SPEED: &str = "<velocity><exact>1.5</exact></velocity>";

#[test]
fn a_state_that_stands_twice_counts_once() {
    let at_2 = state(2, [20.0, -4.7], &[HEADING, SPEED].concat());
    let at_4 = state(4, [20.0, -4.4], &[HEADING, SPEED].concat());
    let recording = walked(&[&*at_2, &at_2, &at_4].concat()).expect("valid");
    assert_eq!(recording.others[1].track.len(), 3);
    assert!(recording.notes.iter().any(|note| note.ends_with("1 of its states stand twice")));
    let other = state(2, [20.0, -4.6], &[HEADING, SPEED].concat());
    let error = walked(&[at_2, other].concat()).expect_err("two places at one time");
    assert!(error.what.contains("not after"), "{error}");
}

#[test]
fn a_heading_that_is_exchanged_with_the_rear_is_kept() {
    let reversed = "<orientation><exact>-1.6416</exact></orientation>";
    let states: String = (1..6)
        .map(|k| {
            let heading = if k == 3 || k == 4 { reversed } else { HEADING };
            state(k, [20.0, -5.0 + 0.15 * f64::from(k)], &[heading, SPEED].concat())
        })
        .collect();
    let recording = walked(&states).expect("valid");
    let walker = &recording.others[1];
    assert!(walker.track.iter().all(|state| (state.place.yaw - 1.5).abs() < 1e-4));
    assert!(recording.notes.iter().any(|note| note.contains("exchanged 2 times")));
}

#[test]
fn headings_that_are_not_stated_follow_from_places_or_velocities() {
    let states: String =
        (1..4).map(|k| state(k, [20.0 + 0.15 * f64::from(k), -5.0], SPEED)).collect();
    let recording = walked(&states).expect("valid");
    let yaws: Vec<f64> =
        recording.others[1].track.iter().skip(1).map(|state| state.place.yaw).collect();
    assert_eq!(yaws, [0.0; 3]);
    assert!(recording.notes.iter().any(|note| note.contains("orientations are not stated")));
    // A point mass.
    let masses = "<velocity><exact>3</exact></velocity><velocityY><exact>4</exact></velocityY>";
    let recording = walked(&state(1, [20.3, -4.6], masses)).expect("valid");
    let last = recording.others[1].track[1];
    assert!((last.speed_m_s - 5.0).abs() < 1e-12);
    assert!((last.place.yaw - libm::atan2(4.0, 3.0)).abs() < 1e-12);
}

#[test]
fn who_has_one_state_goes_straight_on() {
    let text = SMALL.replace("<trajectory>", "<x>").replace("</trajectory>", "</x>");
    let recording = read("s.xml", &text, &ReadOptions::default()).expect("valid");
    let walker = &recording.others[1];
    assert_eq!((walker.track.len(), walker.is_static()), (2, false));
    let [first, next] = [0, 1].map(|k| walker.track[k].place.at);
    assert!((libm::hypot(next[0] - first[0], next[1] - first[1]) - 0.15).abs() < 1e-12);
    assert!(recording.notes.iter().any(|note| note.contains("straight on")));
    let text = text.replace("<velocity><exact>1.5</exact></velocity>", "");
    let error = read("s.xml", &text, &ReadOptions::default()).expect_err("no speed");
    assert!(error.what.contains("only its first state"), "{error}");
}

/// A uniform distribution over 2 h has the standard deviation h / √3.
#[test]
fn intervals_of_a_first_state_say_how_well_it_is_known() {
    let region = "<position><rectangle><length>4</length><width>1</width><orientation>0\
                  </orientation><center><x>0</x><y>0</y></center></rectangle></position>";
    let text =
        SMALL.replace("<position><point><x>0</x><y>0</y></point></position>", region).replace(
            "<velocity><exact>12</exact>",
            "<velocity><intervalStart>9</intervalStart><intervalEnd>15</intervalEnd>",
        );
    let recording = read("s.xml", &text, &ReadOptions::default()).expect("valid");
    let (start, spread) = (recording.ego.start, recording.ego.spread);
    assert_eq!((start.place.at, start.speed_m_s), ([0.0; 2], 12.0));
    let known = [spread.longitudinal_m, spread.lateral_m, spread.yaw, spread.speed_m_s];
    let half = [2.0, 0.5, 0.0, 3.0];
    for (known, half) in known.iter().zip(half) {
        assert!((known - half / 3.0_f64.sqrt()).abs() < 1e-12, "{spread:?}");
    }
    assert!(recording.notes.iter().any(|note| note.contains("as likely anywhere")));
    // They are those of the members that are drawn.
    let library = crate::Library::parse("default.toml", crate::DEFAULT_LIBRARY).expect("valid");
    let manoeuvres = crate::Manoeuvres::default();
    let (text, _) =
        crate::scenario_text("s.xml", &recording, &manoeuvres, &library).expect("a scenario");
    let ego = text.find("[parties.\"ego\"]").expect("there");
    let errors = "errors = { longitudinal_m = 1.1547, lateral_m = 0.2887, speed_share = 0.1443 }";
    assert!(text[ego..].contains(errors), "{text}");
    assert!(text.contains("errors = { yaw_deg = 3.308 }"), "{text}");
}

#[test]
fn all_that_cannot_be_read_is_named_at_once() {
    let error = small("<trajectory>", "<occupancySet/><trajectory>").expect_err("a set");
    assert!(error.remedy.ends_with("leave them out: --without 2"), "{error:?}");
    let read = |text: &str| read("a.xml", text, &ReadOptions::default()).expect_err("refused");
    let solution = read("<CommonRoadSolution benchmark_id=\"KS2:SA1:Small:2020a\"/>");
    assert!(solution.what.contains("a planner's solution"), "{solution}");
    assert!(solution.remedy.contains("--solution"), "{solution:?}");
    let map = read("<commonRoad commonRoadVersion='2020a' timeStepSize='0.1'/>");
    assert!(map.what.contains("a map alone"), "{map}");
    let pointer = read("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n");
    assert!(pointer.remedy.contains("git lfs pull"), "{pointer:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn no_bent_file_makes_it_panic(
        bends in prop::collection::vec((any::<prop::sample::Index>(), 32_u8..127), 1..8),
        cut in any::<Option<prop::sample::Index>>(),
    ) {
        let mut bytes = SMALL.as_bytes().to_vec();
        for (at, byte) in bends {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let text = String::from_utf8(bytes).expect("ASCII");
        match read("s.xml", &text, &ReadOptions::default()) {
            Ok(recording) => drop(recording.recorded_meeting_s(0.1)),
            Err(error) => prop_assert!(error.place.line() >= 1 && !error.remedy.is_empty()),
        }
    }
}
