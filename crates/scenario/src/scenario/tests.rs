//! What is written is what is read, no text makes the reader panic, and the demo is what it says.

use super::*;
use crate::engine::{Cores, EngineSettings, Overrides};
use crate::testing::harm::{harmed, harms};
use crate::testing::{FULL, parse, told};
use body::Seat;
use proptest::prelude::*;

#[test]
fn the_full_scenario_reads_as_it_is_written() {
    let read = parse(FULL).unwrap();
    let position = |line, column| TextPosition { line, column };
    let file =
        |path: &str, line, column| FileRef { path: path.to_owned(), place: position(line, column) };
    let state = |yaw, pitch, roll, position, x, y| MotionState {
        angles_deg: [yaw, pitch, roll],
        pose: Pose::from_degrees(yaw, pitch, roll, position),
        velocity_m_s: DVec3::new(x, y, 0.0),
    };
    let heading = Pose::from_degrees(90.0, 0.0, 0.0, [0.0; 3]).rotation;
    let party = |name: &str, place, source| Party {
        name: name.into(),
        place,
        source,
        size: None,
        mass_kg: None,
        persons: None,
        responsibility: 0.0,
        is_unknown: false,
        crush: None,
    };
    let seat = |seat| Occupant { seat: Some(seat) };
    let expected = Scenario {
        name: "Every key".to_owned(),
        policy: Some(file("policies/board.toml", 3, 10)),
        curves: Some(file("curves/level3.toml", 4, 10)),
        deadline: Some(Duration::from_millis(50)),
        engine: EngineSettings {
            workers: 2,
            cores: Cores::Listed(vec![0, 1]),
            coordinator_core: Some(3),
            depth: 6,
            scheme: crate::Scheme::BestMatchLoad,
            alpha: 0.25,
            batch: 8,
            queue: 32,
            build: body::Build::Sah,
            leaf_size: 2,
            seed: 7,
        },
        ego: PartyIndex(0),
        parties: vec![
            Party {
                mass_kg: Some(1500.0),
                persons: Some([Seat::FrontLeft, Seat::RearRight].into_iter().map(seat).collect()),
                responsibility: 0.5,
                ..party(
                    "car",
                    position(21, 1),
                    Source::Generate { shape: Shape::Sedan, triangles: 2000, seed: 4 },
                )
            },
            Party {
                size: Some(Fit::Plan([0.3, 0.25])),
                ..party(
                    "post",
                    position(71, 1),
                    Source::Generate { shape: Shape::Pole, triangles: 500, seed: 0 },
                )
            },
            Party {
                is_unknown: true,
                crush: Some([40_000.0, 500_000.5]),
                ..party(
                    "walker",
                    position(33, 1),
                    Source::File(file("bodies/walker.trolley", 34, 8)),
                )
            },
        ],
        candidates: vec![
            Candidate {
                name: "walker".into(),
                place: position(44, 1),
                probability: 0.75,
                ego: state(
                    90.0,
                    -1.5,
                    0.5,
                    [1.0, 2.5, 0.0],
                    12.0 * heading[0][0],
                    12.0 * heading[1][0],
                ),
                other: Opponent {
                    party: PartyIndex(2),
                    state: state(180.0, 1.0, 2.0, [1.0, 5.0, 0.0], -1.5, 0.25),
                },
            },
            Candidate {
                name: "post".into(),
                place: position(61, 1),
                probability: 1.0,
                ego: state(0.0, 0.0, 0.0, [0.0; 3], 3.0, 4.0),
                other: Opponent {
                    party: PartyIndex(1),
                    state: state(0.0, 0.0, 0.0, [2.4, 0.0, 0.0], 0.0, 0.0),
                },
            },
        ],
    };
    assert_eq!(read, expected);
}

/// Numbers of one collision as a file holds them.
#[derive(Clone, Debug)]
struct Written {
    position_m: [f64; 3],
    angles_deg: [f64; 3],
    speed_m_s: f64,
    deadline_ms: f64,
    mass_kg: f64,
    share: f64,
}

fn written() -> impl Strategy<Value = Written> {
    (
        [-1e6..=1e6, -1e3..=1e3, -10.0..=10.0],
        [-360.0..=360.0, -90.0..=90.0, -180.0..=180.0],
        prop_oneof![-150.0..=150.0, Just(-0.0), Just(150.0)],
        0.001..=3.6e6,
        0.1..=1e6,
        0.0..=1.0,
    )
        .prop_map(|(position_m, angles_deg, speed_m_s, deadline_ms, mass_kg, share)| Written {
            position_m,
            angles_deg,
            speed_m_s,
            deadline_ms,
            mass_kg,
            share,
        })
}

proptest! {
    #[test]
    fn numbers_are_read_as_they_are_written(w in written()) {
        let [yaw, pitch, roll] = w.angles_deg;
        let text = format!(
            "schema = 'trolley.scenario/1'\nname = 'n'\ndeadline_ms = {:?}\n[parties]\n\
             ego = {{ file = 'a', mass_kg = {:?}, responsibility = {:?} }}\nb = {{ file = 'b' }}\n\
             [[candidates]]\nname = 'c'\nprobability = {:?}\n\
             ego = {{ position_m = {:?}, yaw_deg = {yaw:?}, pitch_deg = {pitch:?}, \
             roll_deg = {roll:?}, speed_m_s = {:?} }}\n\
             other = {{ party = 'b', position_m = [0, 0, 0], velocity_m_s = [{:?}, 0] }}",
            w.deadline_ms, w.mass_kg, w.share, w.share, w.position_m, w.speed_m_s, w.speed_m_s,
        );
        let read = parse(&text).map_err(|error| TestCaseError::fail(error.to_string()))?;
        let ms = read.deadline.unwrap().as_secs_f64() * 1e3;
        prop_assert!((ms - w.deadline_ms).abs() <= 1e-6 + 1e-12 * ms);
        let ego = read.parties.iter().find(|party| party.name == "ego").unwrap();
        prop_assert_eq!(ego.mass_kg, Some(w.mass_kg));
        prop_assert_eq!(ego.responsibility, w.share);
        let candidate = &read.candidates[0];
        prop_assert_eq!(candidate.probability, w.share);
        prop_assert_eq!(candidate.ego.pose, Pose::from_degrees(yaw, pitch, roll, w.position_m));
        let v = candidate.ego.velocity_m_s;
        let (sin, cos) = yaw.to_radians().sin_cos();
        prop_assert!((v.x - w.speed_m_s * cos).abs() < 1e-12 * 150.0, "{v:?}");
        prop_assert!((v.y - w.speed_m_s * sin).abs() < 1e-12 * 150.0, "{v:?}");
        let across = candidate.other.state.velocity_m_s;
        prop_assert_eq!(across, DVec3::new(w.speed_m_s, 0.0, 0.0));
        for zero in [v.x, v.y, v.z, across.x, across.y, across.z] {
            prop_assert!(zero != 0.0 || zero.is_sign_positive());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn no_text_makes_it_panic_and_every_fault_has_a_place_in_the_text(harms in harms()) {
        let text = harmed(FULL, &harms);
        match parse(&text) {
            Err(error) => {
                let lines: Vec<&str> = text.split('\n').collect();
                let line = lines.get(error.place.line.wrapping_sub(1));
                let end = line.map_or(0, |line| line.chars().count() + 1);
                prop_assert!((1..=end).contains(&error.place.column), "{error}\n{text}");
                prop_assert!(!error.remedy.is_empty());
                prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error);
            }
            Ok(scenario) => {
                prop_assert!((1..=16).contains(&scenario.candidates.len()));
                prop_assert!(scenario.ego.0 < scenario.parties.len());
                for candidate in &scenario.candidates {
                    let other = candidate.other.party;
                    prop_assert!(other != scenario.ego && other.0 < scenario.parties.len());
                    prop_assert!(candidate.ego.velocity_m_s.is_finite());
                }
            }
        }
    }

    #[test]
    fn no_string_at_all_makes_it_panic(text in any::<String>()) {
        prop_assert!(parse(&text).is_err());
    }
}

#[test]
fn equal_scenarios_in_another_order_are_equal_but_for_places() {
    let moved = {
        let start = FULL.find("[parties.walker]").unwrap();
        let end = FULL.find("[parties.post").unwrap();
        let car = FULL.find("[parties.car]").unwrap();
        let (head, walker) = (&FULL[..car], &FULL[start..end]);
        format!("{head}{walker}{}{}", &FULL[car..start], &FULL[end..])
    };
    let (a, b) = (parse(FULL).unwrap(), parse(&moved).unwrap());
    assert_eq!((a.ego, &a.candidates), (b.ego, &b.candidates));
    let names = |s: &Scenario| s.parties.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&a), names(&b));
}

#[test]
fn kinds_are_checked_again_when_the_files_are_open() {
    let scenario = parse(FULL).unwrap();
    let kinds = |walker| [BodyKind::Sedan, BodyKind::Pole, walker];
    scenario.check_kinds("f.toml", &kinds(BodyKind::Pedestrian)).unwrap();
    let refused = |kinds: &[BodyKind]| told(scenario.check_kinds("f.toml", kinds).unwrap_err());
    assert_eq!(
        refused(&kinds(BodyKind::Building)),
        "f.toml:44:1: a building is fixed to the ground and cannot move\n  help: write \
         speed_m_s = 0"
    );
    assert_eq!(
        refused(&[BodyKind::Cyclist, BodyKind::Pole, BodyKind::Suv]),
        "f.toml:21:1: a cyclist cannot be the ego\n  help: the ego is a vehicle: sedan, suv, \
         truck, bus or motorcycle"
    );
    assert_eq!(
        refused(&[BodyKind::Truck, BodyKind::Pole, BodyKind::Suv]),
        "f.toml:21:1: a truck has no seat \"rear-right\"\n  help: seats of a truck: front-left, \
         front-right"
    );
    let text = FULL.replace("kind = \"unknown\"", "mass_kg = 90");
    let heavy = parse(&text).unwrap();
    let error = heavy.check_kinds("f.toml", &kinds(BodyKind::Wall)).unwrap_err();
    assert_eq!(error.place, TextPosition { line: 33, column: 1 });
    assert_eq!(error.what, "a wall is fixed to the ground and has no mass");
}

#[test]
fn what_parse_accepts_check_kinds_accepts_for_generated_bodies() {
    for text in [DEMO, include_str!("../../config/scenarios/minimal.toml")] {
        let scenario = parse(text).unwrap();
        let kinds: Vec<BodyKind> = (scenario.parties.iter())
            .map(|party| match party.source {
                Source::Generate { shape, .. } => shape.kind(),
                Source::File(_) => panic!("examples need no files"),
            })
            .collect();
        scenario.check_kinds("f.toml", &kinds).unwrap();
        assert_eq!(scenario.engine.apply(&Overrides::default()), Ok(EngineSettings::DEFAULT));
    }
}

const DEMO: &str = include_str!("../../config/scenarios/demo.toml");

mod demo;

#[test]
fn deep_and_long_texts_get_short_answers() {
    let head = "schema = \"trolley.scenario/1\"\n";
    let deep = |open: &str, middle: &str, close: &str| {
        let count = (TEXT_BYTES_MAX - 100) / (open.len() + close.len());
        format!("{head}{}{middle}{}", open.repeat(count), close.repeat(count))
    };
    for text in [
        deep("a.", "a = 1", ""),
        format!("{head}[{}a]\n", "a.".repeat(500_000)),
        format!("{head}x = {}", "[".repeat(1_000_000)),
        format!("{head}x = {}", "{ a = ".repeat(160_000)),
        format!("{head}x = {{ {}a = 1 }}", "a.".repeat(500_000)),
        format!("{head}[{}parties]\n", "parties.".repeat(100_000)),
        format!("{head}{} = 1", "x".repeat(900_000)),
        format!("{head}name = [{:?}]", "x".repeat(900_000)),
        format!("{head}deadline_ms = {:?}", "\u{1}".repeat(100_000)),
        format!("{head}name = 'n'\ncandidates = []\n[parties.{}]\nq = 1", "x".repeat(900_000)),
    ] {
        let error = parse(&text).unwrap_err();
        assert!(error.to_string().len() < 1000, "{}", error.to_string().len());
    }
}
