//! Decision records: replayed in another place they give the same bytes,
//! finished or not; what was changed or exchanged is refused by name.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::keys::Keys;
use crate::support::{Place, builder, json, run, text, trolley};
use std::path::{Path, PathBuf};
use std::process::Output;
use trolley::record::RecordContent;
use trolley::{AnswerState, Engine, Limits, Record, Scenario, bodies::SILENT};

const CROSSING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/scenarios/crossing.toml");

/// Two cars from one model file, a wall; two motions in files of their own. The ego meets the other
/// car, runs out, and meets the wall, or nobody.
const PATHS: &str = r#"
schema = "trolley.scenario/2"
name = "Paths from elsewhere"
horizon_s = 4
[parties]
ego = { file = "car.trolley", persons = [{ seat = "front-left" }] }
[parties.other]
file = "car.trolley"
paths = [{ probability = 1, csv = "other.csv" }]
[parties.wall]
generate = { shape = "wall", triangles = 600 }
place = { position_m = [21.5, 0, 0], yaw_deg = 90 }
[[candidates]]
name = "go on"
state = { position_m = [0, 0, 0], speed_m_s = 14 }
[[candidates]]
name = "stop"
path = { csv = "paths/stop.csv" }
"#;
const OTHER: &str = "t_s,x_m,y_m,yaw_deg\n0,18,-9,90\n4,18,27,90\n";
const STOP: &str = "t_s,x_m,y_m,yaw_deg\n0,0,0,0\n0.5,5,0,0\n1,8,0,0\n1.5,9,0,0\n2,9,0,0\n";

/// Something of unknown kind, which may be taken as fixed.
const UNKNOWN: &str = r#"
schema = "trolley.scenario/2"
name = "Something ahead"
[parties]
ego = { generate = { shape = "sedan", triangles = 900 } }
[parties.thing]
kind = "unknown"
generate = { shape = "wall", triangles = 900 }
place = { position_m = [20, 0, 0], yaw_deg = 90 }
[[candidates]]
name = "go on"
state = { position_m = [0, 0, 0], speed_m_s = 15 }
"#;

/// A parked car on the ego's lane.
const TRAFFIC: &str = "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" \
    benchmarkID=\"Test\"><staticObstacle id=\"7\"><type>parkedVehicle</type>\
    <shape><rectangle><length>4</length><width>1.8</width></rectangle></shape>\
    <initialState><position><point><x>25</x><y>0.5</y></point></position>\
    <orientation><exact>0</exact></orientation><time><exact>0</exact></time></initialState>\
    </staticObstacle><planningProblem id=\"1\">\
    <initialState><position><point><x>0</x><y>0</y></point></position>\
    <orientation><exact>0</exact></orientation><time><exact>0</exact></time>\
    <velocity><exact>15</exact></velocity></initialState></planningProblem>\
    </commonRoad>";

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn command(args: &[&str]) -> Output {
    trolley().args(args).output().unwrap()
}

fn succeeded(output: &Output) {
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
}

/// A model of a car with about so many triangles.
fn car(place: &Place, triangles: &str) -> PathBuf {
    let model = place.path().join("car.trolley");
    let made = ["model", "generate", "sedan", "--triangles", triangles, "-o", path(&model)];
    succeeded(&command(&made));
    model
}

/// [`PATHS`] with its files.
fn with_paths(place: &Place) -> PathBuf {
    car(place, "900");
    std::fs::create_dir(place.path().join("paths")).unwrap();
    place.write("other.csv", OTHER);
    place.write("paths/stop.csv", STOP);
    place.write("paths.toml", PATHS)
}

/// Whatever the form of the input, its record is enough: the scenario and its paths are gone.
#[test]
fn a_record_of_every_input_is_replayed_bit_for_bit_in_another_place() {
    let place = Place::new();
    let keys = Keys::new(&place);
    let inputs = [
        PathBuf::from(CROSSING),
        with_paths(&place),
        place.write("parked.xml", TRAFFIC),
        place.write("unknown.toml", UNKNOWN),
    ];
    let records = place.path().join("records");
    let mut answers = Vec::new();
    for input in &inputs {
        for way in [&["--in-process"][..], &["--workers", "2"], &["--in-process", "--depth", "2"]] {
            let args = ["rank", path(input), "--json", "--record", path(&records)];
            let sign = ["--sign", path(&keys.secret), "--assume", "unknown=fixed"];
            let output = run(&[&args[..], &sign, way].concat());
            succeeded(&output);
            answers.push(json(&output)["answer"].clone());
        }
    }
    let verified = command(&["record", "verify", path(&records), "--key", path(&keys.public)]);
    succeeded(&verified);
    assert!(text(&verified.stdout).contains("12 records"), "{}", text(&verified.stdout));
    let elsewhere = Place::new();
    let models = elsewhere.path().join("x.trolley");
    std::fs::copy(place.path().join("car.trolley"), models).unwrap();
    let copies = elsewhere.path().join("copies");
    std::fs::rename(&records, &copies).unwrap();
    drop(place);
    for (number, answer) in answers.iter().enumerate() {
        let copy = copies.join(format!("{number:06}.record"));
        let args = ["record", "replay", path(&copy), "--models", path(elsewhere.path()), "--json"];
        let output = command(&args);
        succeeded(&output);
        let document = json(&output);
        assert_eq!((&document["same"], &document["same_build"]), (&true.into(), &true.into()));
        let shown = json(&command(&["record", "show", path(&copy), "--json"]));
        assert_eq!(shown["answer"], *answer);
        let chains = shown["explanation"]["chains"].as_array().unwrap();
        assert_eq!(chains.len(), answer["ranking"].as_array().unwrap().len());
        let jobs = shown["rounds"].as_array().unwrap().iter();
        let jobs: usize = jobs.map(|round| round["jobs"].as_array().unwrap().len()).sum();
        assert!(jobs > 3 && document["jobs"].as_u64().unwrap() as usize >= jobs, "{document}");
    }
    // Contacts one after the other are several rounds.
    let shown = json(&command(&["record", "show", path(&copies.join("000003.record")), "--json"]));
    assert!(shown["rounds"].as_array().unwrap().len() >= 2, "{:#}", shown["answer"]);
    assert_eq!(shown["files"][1]["name"], "paths/stop.csv");
    let without = command(&["record", "replay", path(&copies.join("000003.record"))]);
    let error = text(&without.stderr);
    assert_eq!(without.status.code(), Some(65), "{error}");
    assert!(error.contains("\"ego\" is missing") && error.contains("--models"), "{error}");
}

/// Wherever the deadline strikes, in the search or in a survey, the record says how far work came.
#[test]
fn a_late_answer_is_replayed_as_far_as_it_had_come() {
    let scenario = Scenario::open(CROSSING).unwrap();
    for engine in [Engine::builder().in_process(), builder().workers(2)] {
        replayed_when_late(&scenario, &mut engine.build().unwrap());
    }
}

fn replayed_when_late(scenario: &Scenario, engine: &mut Engine) {
    let place = Place::new();
    let (mut late, mut done) = (std::collections::BTreeSet::new(), 0);
    // However busy the machine is, the first is too short, and the last is enough.
    let dues_ms = (0..30).map(|step| 0.01 * 1.36_f64.powi(step)).chain([60_000.0]);
    for due_ms in dues_ms {
        let limits = Limits::default().with_deadline_ms(due_ms).unwrap().with_record();
        let ranking = engine.rank(scenario, &limits).unwrap();
        let file = Record::write(place.path(), &ranking).unwrap();
        let mut record = Record::read(&file).unwrap();
        let replay = record.replay(&file, None, SILENT).unwrap();
        assert_eq!(replay.json, record.content.answer, "{due_ms} ms");
        assert_eq!(replay.explanation, ranking.explanation, "{due_ms} ms");
        if ranking.answer.state == AnswerState::Complete {
            done += 1;
            // Had the first look not been done, less would be known.
            record.content.open_steps.resize_with(1, Default::default);
            let less = record.replay(&file, None, SILENT).unwrap().answer;
            assert_ne!(less.state, AnswerState::Complete, "{due_ms} ms");
        } else {
            late.insert(record.content.answer);
        }
    }
    assert!(done >= 1 && late.len() >= 2, "{done} are complete, {} are late", late.len());
}

/// A record that was changed and hashed again is intact as a file: its inputs are compared, too.
#[test]
fn what_was_changed_or_exchanged_is_refused_by_name() {
    let place = Place::new();
    let scenario = with_paths(&place);
    let records = place.path().join("records");
    succeeded(&run(&["rank", path(&scenario), "--in-process", "--record", path(&records)]));
    let file = records.join("000000.record");
    // On the disk.
    let bytes = std::fs::read(&file).unwrap();
    for at in [0, 8, 70, 96, bytes.len() / 2, bytes.len() - 1] {
        let mut bad = bytes.clone();
        bad[at] ^= 4;
        std::fs::write(&file, bad).unwrap();
        for verb in ["verify", "show", "replay"] {
            let output = command(&["record", verb, path(&file)]);
            let error = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{verb}, byte {at}: {error}");
            assert!(error.contains("000000.record") && error.contains("help: "), "{error}");
        }
    }
    std::fs::write(&file, &bytes).unwrap();
    // In what it holds.
    let good = Record::read(&file).unwrap();
    let replayed = |record: &Record| record.replay(&file, Some(place.path()), SILENT);
    assert_eq!(replayed(&good).unwrap().json, good.content.answer);
    type Change<'c> = (&'c str, &'c dyn Fn(&mut RecordContent));
    let changes: [Change<'_>; 7] = [
        ("the scenario in it is not the one", &|content| content.scenario.text.push('\n')),
        ("the policy in it is not the one", &|content| content.policy.text.push('\n')),
        ("the path in it is not the one", &|content| content.files[0].text.push('\n')),
        ("\"paths/stop.csv\" is missing", &|content| drop(content.files.pop())),
        ("it holds the bodies of", &|content| drop(content.bodies.pop())),
        ("the body of \"wall\" is", &|content| content.bodies[2].hash = "00".repeat(32)),
        ("the body of \"other\" is", &|content| content.bodies[1].hash = "00".repeat(32)),
    ];
    for (says, change) in changes {
        let mut changed = good.clone();
        change(&mut changed.content);
        let failure = replayed(&changed).unwrap_err();
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
    }
    // Work that was not done gives another answer, never the recorded one or a panic.
    let less: [&dyn Fn(&mut RecordContent); 3] = [
        &|content| content.rounds.clear(),
        &|content| content.rounds[0].jobs.clear(),
        &|content| content.rounds[0].jobs.iter_mut().for_each(|job| job.place = u32::MAX),
    ];
    for change in less {
        let mut changed = good.clone();
        change(&mut changed.content);
        assert_ne!(replayed(&changed).unwrap().json, good.content.answer);
    }
    // In the files beside it.
    let replay = |of: &Path| {
        let models = path(place.path());
        command(&["record", "replay", path(&file), "--models", models, "--scenario", path(of)])
    };
    succeeded(&replay(&scenario));
    let refused = |of: &Path, says: &str| {
        let output = replay(of);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{error}");
        assert!(error.contains(says) && error.contains("help: "), "{error}");
    };
    refused(&place.write("parked.xml", TRAFFIC), "options that no record holds");
    refused(Path::new(CROSSING), "crossing.toml is not the one of");
    let other = place.write("other.csv", &OTHER.replace("18", "17"));
    refused(&scenario, "the path other.csv is not the one of");
    std::fs::write(other, OTHER).unwrap();
    std::fs::remove_file(place.path().join("car.trolley")).unwrap();
    car(&place, "600");
    let output = command(&["record", "replay", path(&file), "--models", path(place.path())]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{error}");
    assert!(error.contains("\"ego\" is missing") && error.contains("has this hash"), "{error}");
}

mod shared_data {
    use super::{command, path, run, succeeded};
    use crate::support::{Place, shared};
    use std::path::{Path, PathBuf};

    #[test]
    #[ignore = "needs ../shared/data: recorded traffic"]
    fn recordings_of_traffic_are_replayed() {
        let folder = shared("scenarios/commonroad");
        let mut files: Vec<PathBuf> = walk(&folder);
        files.sort();
        let place = Place::new();
        let records = place.path().join("records");
        let mut count = 0;
        for file in files.iter().step_by(files.len().div_ceil(6)) {
            let output = run(&["rank", path(file), "--workers", "2", "--record", path(&records)]);
            count += u32::from(output.status.success());
        }
        assert!(count >= 2, "{count} of {}", files.len());
        for number in 0..count {
            let record = records.join(format!("{number:06}.record"));
            succeeded(&command(&["record", "replay", path(&record)]));
        }
    }

    /// All XML files in a folder and below.
    fn walk(folder: &Path) -> Vec<PathBuf> {
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                found.extend(walk(&path));
            } else if path.extension().is_some_and(|end| end == "xml") {
                found.push(path);
            }
        }
        found
    }
}
