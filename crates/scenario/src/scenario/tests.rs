//! Every value made wrong is refused at its own line; what is accepted fits the schema; no text
//! makes the reader panic.

use super::*;
use crate::schema::tests::{assert_units_are_described, objects, values, violations};
use crate::testing::harm::{harmed, harms};
use crate::testing::{
    Setting, WrongValues, assert_reads_well, settings_in, told, with_line_in, wrong_values,
};
use proptest::prelude::*;
use serde_json::Value;

mod crossing;
mod rules;
mod texts;

/// Every key of the form stands here on a line of its own, and the whole is a valid scenario but
/// for the files that it names: [`csv`] gives their texts.
const FULL: &str = r#"schema = "trolley.scenario/2"
name = "Every key"
policy = "policies/board.toml"
curves = "curves/level3.toml"
parameters = "parameters/ours.toml"
deadline_ms = 50
horizon_s = 4
resolution_m = 0.002
members = 8
members_max = 64
ego = "car"
[engine]
workers = 2
cores = [0, 1]
coordinator_core = 3
depth = 6
scheme = "best-match-load"
alpha = 0.25
batch = 8
queue = 32
build = "sah"
leaf_size = 2
seed = 7
[parties.car]
mass_kg = 1500
responsibility = 0.5
[parties.car.generate]
shape = "sedan"
triangles = 2000
seed = 4
[[parties.car.persons]]
seat = "front-left"
[[parties.car.persons]]
count = 2
[parties.post]
size_m = [0.3, 0.25]
empty = true
[parties.post.generate]
shape = "pole"
triangles = 500
[parties.post.place]
position_m = [20, -3, 0]
yaw_deg = 15
pitch_deg = 1
roll_deg = -1

[parties.van]
file = "bodies/van.trolley"
[[parties.van.paths]]
probability = 0.25
csv = "van.csv"
[[parties.van.paths]]
probability = 0.75
[[parties.van.paths.states]]
t_s = -0.5
position_m = [40, 3, 0]
yaw_deg = 180
pitch_deg = 0.5
roll_deg = 0.25
velocity_m_s = [-10, 0]
[[parties.van.paths.states]]
t_s = 1.5
position_m = [20, 3, 0.5]
yaw_deg = 170
velocity_m_s = [-9, 1]

[parties.walker]
file = "bodies/walker.trolley"
kind = "unknown"
[parties.walker.crush]
a_n_m = 40000
b_n_m2 = 500000.5
[parties.walker.state]
position_m = [1, 5, 0]
yaw_deg = -90
pitch_deg = 1
roll_deg = 2
speed_m_s = 1.5
yaw_rate_deg_s = 10

[[candidates]]
name = "turn"
[candidates.state]
position_m = [0, 0, 0]
velocity_m_s = [12, 0]
yaw_rate_deg_s = -5
[candidates.reactions.van.path]
csv = "van-brakes.csv"
[candidates.reactions.walker.place]
position_m = [1, 5, 0]
yaw_deg = -90
pitch_deg = 1
roll_deg = 2

[[candidates]]
name = "follow"
[candidates.path]
csv = "ego.csv"
[candidates.reactions.van.state]
position_m = [35, 3, 0.125]
yaw_deg = 177.5
pitch_deg = 0.375
roll_deg = 0.188
speed_m_s = 0

[parties.car.errors]
lateral_m = 0.1
longitudinal_m = 0.2
correlation = -0.5
yaw_deg = 1
speed_share = 0.03
"#;

/// What only this form reads, or reads otherwise.
const OWN: &[WrongValues] = &[
    ("schema", &["\"trolley.scenario/1\"", "\"trolley.scenario/3\"", "2", "\"\""]),
    ("horizon_s", &["0", "-1", "30.5", "nan", "inf", "\"5\"", "[5]"]),
    ("resolution_m", &["0", "0.000009", "0.11", "nan", "\"1 mm\""]),
    ("seat", &["\"rider\"", "\"front\"", "\"\"", "0"]),
    ("count", &["0", "-1", "91", "1.5", "nan", "\"two\""]),
    ("empty", &["false", "1", "\"yes\"", "[]"]),
    ("t_s", &["nan", "inf", "3601", "-3601", "\"now\"", "[0]"]),
    ("speed_m_s", &["101", "-101", "nan", "inf", "\"fast\"", "[1, 2]"]),
    ("velocity_m_s", &["[101, 0]", "[0, -101]", "[80, 80]", "[nan, 0]", "[1]", "[1, 2, 3]", "5"]),
    ("yaw_rate_deg_s", &["721", "-721", "nan", "inf", "\"left\""]),
    ("csv", &["\"\"", "\"a\\u0000b\"", "3"]),
];

/// The texts of the files that [`FULL`] names.
fn csv(file: &FileRef) -> Result<String, ScenarioError> {
    Ok(match file.path.as_str() {
        // Where the states of the scenario have it at 0.
        "van.csv" => {
            "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg,roll_deg\n\
             0,35,3,0.125,177.5,0.375,0.188\n4,-5,3,0.125,180,0,0\n"
        }
        "van-brakes.csv" => {
            "t_s,x_m,y_m,z_m,yaw_deg,pitch_deg,roll_deg\n\
             0,35,3,0.125,177.5,0.375,0.188\n1,30,3,0.125,180,0,0\n"
        }
        "ego.csv" => "t_s,x_m,y_m,z_m,yaw_deg\n0,0,0,0,0\n5,60,0,0,0\n",
        other => panic!("{other}"),
    }
    .to_owned())
}

/// Reads a text that is called `f.toml`; a file that it names is that of [`FULL`].
fn parse(text: &str) -> Result<Scenario, ScenarioError> {
    ScenarioDraft::parse("f.toml", text)?.finish(|file| match file.path.as_str() {
        "van.csv" | "van-brakes.csv" | "ego.csv" => csv(file),
        _ => Ok(String::new()),
    })
}

fn settings() -> Vec<Setting> {
    settings_in(FULL)
}

fn with_line(number: usize, line: &str) -> String {
    with_line_in(FULL, number, line)
}

/// The full scenario with a piece of its text replaced, which must be there.
fn changed(from: &str, to: &str) -> String {
    assert!(FULL.contains(from), "{from}");
    FULL.replacen(from, to, 1)
}

fn refusal(from: &str, to: &str) -> String {
    told(parse(&changed(from, to)).expect_err(to))
}

/// A scenario with so many buses and walkers, so many persons to a bus.
fn city(buses: usize, persons: usize) -> String {
    let bus = |i: usize| {
        format!(
            "[parties.b{i}]\nfile = 'b'\npersons = [{{ count = {persons} }}]\n\
             place = {{ position_m = [{i}, 0, 0] }}\n"
        )
    };
    format!(
        "schema = 'trolley.scenario/2'\nname = 'n'\n[[candidates]]\nname = 'c'\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = 1 }}\n[parties.ego]\nfile = 'e'\n{}",
        (0..buses).map(bus).collect::<String>()
    )
}

fn the_schema() -> Value {
    serde_json::from_str(&crate::schema()).unwrap()
}

fn violated(text: &str) -> Vec<String> {
    let value: toml::Value = toml::from_str(text).unwrap();
    let schema = the_schema();
    violations(&schema, &schema, &serde_json::to_value(value).unwrap())
}

#[test]
fn the_full_scenario_reads_as_it_is_written() {
    let read = parse(FULL).unwrap();
    assert_eq!((read.ego, read.horizon_s, read.resolution_m), (PartyIndex(0), 4.0, 0.002));
    assert_eq!(read.deadline, Some(Duration::from_millis(50)));
    assert_eq!((read.engine.workers, read.engine.seed), (2, 7));
    let names: Vec<&str> = read.parties.iter().map(|party| party.name.as_str()).collect();
    assert_eq!(names, ["car", "post", "van", "walker"]);
    let [car, post, van, walker] = &read.parties[..] else { panic!() };

    let seated = OccupantGroup { seat: Some(Seat::FrontLeft), count: 1 };
    let somewhere = OccupantGroup { seat: None, count: 2 };
    assert_eq!(car.occupancy, Occupancy::Stated(vec![seated, somewhere]));
    assert_eq!(car.occupancy.count(), Some(3));
    assert_eq!((car.mass_kg, car.responsibility), (Some(1500.0), 0.5));
    assert!(car.predictions.is_empty());

    assert_eq!((post.occupancy.count(), post.size), (Some(0), Some(Fit::Plan([0.3, 0.25]))));
    let [still] = &post.predictions[..] else { panic!() };
    assert!(still.probability == 1.0 && !still.motion.moves() && still.motion.ends_s.is_none());
    assert_eq!(still.motion.path.pose_at(4.0).translation, [20.0, -3.0, 0.0]);

    assert_eq!((&van.occupancy, van.occupancy.count()), (&Occupancy::Default, None));
    let [from_file, inline] = &van.predictions[..] else { panic!() };
    assert_eq!((from_file.probability, inline.probability), (0.25, 0.75));
    assert_eq!((from_file.motion.ends_s, inline.motion.ends_s), (None, Some(1.5)));
    assert!(!from_file.motion.stands_at_end() && !inline.motion.stands_at_end());
    assert_eq!(from_file.motion.path.pose_at(1.0).translation, [25.0, 3.0, 0.125]);
    // Cut at 0, then on with the last state's velocity, rising as in the last piece.
    assert_eq!(inline.motion.path.pose_at(0.0).translation, [35.0, 3.0, 0.125]);
    let end = inline.motion.path.states().last().unwrap();
    assert_eq!((end.time_s, end.position_m), (4.0, [20.0 - 9.0 * 2.5, 3.0 + 2.5, 0.5 + 0.625]));

    assert!(walker.is_unknown && walker.crush == Some([40_000.0, 500_000.5]));
    assert!(walker.predictions[0].motion.moves());

    let [turn, follow] = &read.candidates[..] else { panic!() };
    assert_eq!((turn.name.as_str(), turn.reactions.len()), ("turn", 2));
    assert_eq!(turn.reactions[0].party, PartyIndex(2));
    assert_eq!(turn.reactions[0].motion.ends_s, Some(1.0));
    assert_eq!(turn.reactions[0].motion.path.pose_at(2.0).translation, [25.0, 3.0, 0.125]);
    assert!(turn.reactions[1].party == PartyIndex(3) && !turn.reactions[1].motion.moves());
    assert_eq!(follow.ego.path.pose_at(4.0).translation, [48.0, 0.0, 0.0]);
    assert!(!follow.reactions[0].motion.moves());
    for motion in motions(&read) {
        assert_eq!([motion.path.from_s(), motion.path.to_s()], [0.0, 4.0]);
    }
}

fn motions(scenario: &Scenario) -> impl Iterator<Item = &Motion> {
    let predictions = scenario.parties.iter().flat_map(|party| &party.predictions);
    let candidates = scenario.candidates.iter().flat_map(|candidate| {
        [&candidate.ego].into_iter().chain(candidate.reactions.iter().map(|r| &r.motion))
    });
    predictions.map(|prediction| &prediction.motion).chain(candidates)
}

#[test]
fn files_are_asked_for_in_the_order_in_which_they_are_told() {
    let draft = ScenarioDraft::parse("f.toml", FULL).unwrap();
    let told: Vec<FileRef> = draft.files().cloned().collect();
    let mut asked = Vec::new();
    draft
        .finish(|file| {
            asked.push(file.clone());
            csv(file)
        })
        .unwrap();
    assert_eq!(told, asked);
    let names: Vec<(&str, usize)> =
        told.iter().map(|file| (file.path.as_str(), file.place.line)).collect();
    assert_eq!(names, [("van.csv", 51), ("van-brakes.csv", 88), ("ego.csv", 98)]);
}

#[test]
fn errors_of_the_reader_stay_the_readers() {
    #[derive(Debug, PartialEq)]
    enum Broken {
        NotThere(String),
        Scenario,
    }
    impl From<ScenarioError> for Broken {
        fn from(_: ScenarioError) -> Self {
            Self::Scenario
        }
    }
    let draft = ScenarioDraft::parse("f.toml", FULL).unwrap();
    let not_there = |file: &FileRef| Err(Broken::NotThere(file.path.clone()));
    assert_eq!(draft.clone().finish(not_there), Err(Broken::NotThere("van.csv".to_owned())));
    assert_eq!(draft.finish(|_| Ok(String::new())), Err(Broken::Scenario));
    let error = Scenario::parse("f.toml", FULL).unwrap_err();
    assert_eq!(error.place, TextPosition { line: 51, column: 7 });
}

#[test]
fn every_wrong_value_is_refused_at_its_own_line() {
    for (number, section, key, _) in settings() {
        for wrong in wrong_values(key, OWN) {
            let text = with_line(number, &format!("{key} = {wrong}"));
            let error = parse(&text).expect_err(&format!("{section} {key} = {wrong}"));
            assert_eq!(error.place.line, number, "{section} {key} = {wrong}: {error}");
            let least = if number == 1 { 1 } else { key.len() + 4 };
            assert!(error.place.column >= least, "{section} {key} = {wrong}: {error}");
            assert_reads_well(&told(error));
        }
    }
}

#[test]
fn every_misspelt_key_is_refused_where_it_stands() {
    for (number, section, key, value) in settings().into_iter().skip(1) {
        let error = parse(&with_line(number, &format!("{key}x = {value}"))).expect_err(key);
        assert_eq!((error.place.line, error.place.column), (number, 1), "{section} {error}");
        let remedy = match section {
            "[[parties.car.persons]]" => "seat and count only".to_owned(),
            _ => format!("Did you mean {key:?}?"),
        };
        assert!(error.remedy.contains(&remedy), "{section} {key}: {error}");
        assert_reads_well(&told(error));
    }
}

#[test]
fn every_repeated_key_is_refused_where_it_is_repeated() {
    for (number, _, key, value) in settings() {
        let line = format!("{key} = {value}");
        let error = parse(&with_line(number, &format!("{line}\n{line}"))).expect_err(key);
        assert_eq!((error.place.line, error.place.column), (number + 1, 1), "{error}");
    }
}

#[test]
fn the_defaults_are_those_that_the_schema_describes() {
    let read = parse(&city(1, 1)).unwrap();
    assert_eq!((read.horizon_s, read.resolution_m), (5.0, 0.001));
    let schema = the_schema();
    for (key, default) in [("horizon_s", "5."), ("resolution_m", "0.001.")] {
        let description = schema["properties"][key]["description"].as_str().unwrap();
        assert!(description.ends_with(&format!("Default {default}")), "{key}");
    }
}

#[test]
fn a_list_is_not_taken_for_a_table() {
    for (table, list) in [
        ("[candidates.path]\ncsv = \"ego.csv\"", "path = [[]]"),
        ("[candidates.path]\ncsv = \"ego.csv\"", "path = { states = [[0, [0, 0, 0]]] }"),
        ("[parties.post.place]\nposition_m", "[parties]\npost.place = [[1, 2, 3], 4]\n[x]\np"),
        ("[parties.walker.state]\nposition_m", "[parties.walker]\nstate = [[1, 2, 3]]\n[x]\np"),
    ] {
        let error = parse(&changed(table, list)).expect_err(list);
        assert!(!error.remedy.is_empty(), "{list}: {error}");
    }
    let error = parse(&changed("[candidates.path]\ncsv = \"ego.csv\"", "path = [[]]")).unwrap_err();
    assert!(error.what.contains("found a list, expected a table"), "{error}");
}

#[test]
fn the_main_faults_read_like_this() {
    let cases = [
        (
            ("probability = 0.25", "probability = 0.2"),
            "f.toml:53:15: the probabilities sum to 0.95\n  help: what a party may do sums to 1: \
             add what is missing, or scale them",
        ),
        (
            ("t_s = 1.5", "t_s = -0.5"),
            "f.toml:62:7: t_s is -0.5, after -0.5 in the state before\n  help: times rise, by at \
             least 0.00001 s; a state that is repeated is the same in every number",
        ),
        (
            ("t_s = -0.5", "t_s = 0.5"),
            "f.toml:55:7: the path begins at 0.5 s\n  help: time 0 is now, and a path says where \
             the body is from then on: begin at t_s = 0 or before",
        ),
        (
            ("position_m = [40, 3, 0]", "position_m = [400, 3, 0]"),
            "f.toml:63:14: from -0.5 s to 1.5 s the body would move at 190 m/s\n  help: a body \
             moves by at most 100 m/s: are positions in metres and times in seconds?",
        ),
        (
            ("velocity_m_s = [-10, 0]", "velocity_m_s = [0, 60]"),
            "f.toml:60:16: the velocity is [0, 60] m/s, but from -0.5 s to 1.5 s the body moves at \
             [-10.0, 0.0] m/s\n  help: velocities are in the world, not along the heading, and in \
             m/s; or leave them out",
        ),
        (
            ("count = 2", "age = 2"),
            "f.toml:34:1: \"age\" of a person is not an input\n  help: persons carry seat and \
             count only: who somebody is never weighs in a ranking",
        ),
    ];
    for ((from, to), expected) in cases {
        assert_eq!(refusal(from, to), expected);
    }
}
