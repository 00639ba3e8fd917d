//! Traces of simulators, as `tools/traces/write.py` has a library of others write them and as
//! esmini wrote them, beside twins of the same scenes that are written by hand or converted by
//! others: the same contacts, within 20 ms. And what is no trace, as a user meets it.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, text, trolley};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// Contacts may be so far apart (s).
const APART_S: f64 = 0.02;

fn example(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/examples").join(name);
    path.to_str().unwrap().to_owned()
}

/// The contacts of every candidate: whom, by the first word of its name, and when.
fn contacts(args: &[&str]) -> Vec<(String, Vec<(String, f64)>)> {
    let output = trolley().args(["rank", "--json", "--in-process"]).args(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut all = Vec::new();
    for row in document["answer"]["ranking"].as_array().unwrap() {
        let contact = |contact: &Value| {
            let party = contact["party"].as_str().unwrap();
            let kind = party.split([' ', '_']).next().unwrap().to_owned();
            (kind, contact["first_touch_s"].as_f64().unwrap())
        };
        let found = row["contacts"].as_array().unwrap().iter().map(contact).collect();
        all.push((row["name"].as_str().unwrap().to_owned(), found));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// Compares a trace with its twin, which has some of its candidates; returns the number of
/// contacts.
fn compare(trace: &[&str], twin: &[&str]) -> usize {
    let (found, right) = (contacts(trace), contacts(twin));
    let mut count = 0;
    for (name, right) in &right {
        let (_, found) = found.iter().find(|(known, _)| known == name).expect(name);
        let parties = |all: &[(String, f64)]| -> Vec<String> {
            all.iter().map(|(party, _)| party.clone()).collect()
        };
        assert_eq!(parties(found), parties(right), "{name}: {found:?} {right:?}");
        for ((party, found_s), (_, right_s)) in found.iter().zip(right) {
            let apart_s = (found_s - right_s).abs();
            assert!(apart_s < APART_S, "{name}, {party}: {found_s} s, by hand {right_s} s");
            count += 1;
        }
    }
    count
}

/// States of a path by a formula: time to x, y, yaw (rad).
fn states(step_s: f64, count: u32, way: impl Fn(f64) -> [f64; 3]) -> String {
    let mut text = String::from("{ states = [\n");
    for index in 0..=count {
        let t = f64::from(index) * step_s;
        let [x, y, yaw] = way(t);
        let yaw = yaw.to_degrees();
        let _w = writeln!(
            text,
            "  {{ t_s = {t:?}, position_m = [{x:?}, {y:?}, 0.0], yaw_deg = {yaw:?} }},"
        );
    }
    text + "] }"
}

#[test]
fn a_trace_of_osi_meets_whom_its_twin_meets() {
    let braking = states(0.2, 15, |t| {
        let late = (t - 1.0).max(0.0);
        [12.0 * t - 1.5 * late * late, 0.0, 0.0]
    });
    let twin = format!(
        "schema = \"trolley.scenario/2\"\nname = \"Twin\"\nhorizon_s = 3\n\
         [parties.ego]\ngenerate = {{ shape = \"sedan\", triangles = 20000 }}\n\
         size_m = [4.8, 1.9]\n\
         [parties.\"pedestrian by hand\"]\n\
         generate = {{ shape = \"pedestrian\", triangles = 16000 }}\nsize_m = [0.4, 0.6]\n\
         state = {{ position_m = [26, -4, 0], yaw_deg = 90, speed_m_s = 1.4 }}\n\
         [parties.\"suv by hand\"]\n\
         generate = {{ shape = \"suv\", triangles = 20000, seed = 1 }}\nsize_m = [5.2, 2.0]\n\
         state = {{ position_m = [70, 3.5, 0], yaw_deg = 180, speed_m_s = 10 }}\n\
         [parties.\"pillar by hand\"]\ngenerate = {{ shape = \"pole\", triangles = 4000 }}\n\
         size_m = [0.3, 0.3]\nplace = {{ position_m = [30, -3, 0] }}\n\
         [[candidates]]\nname = \"as recorded\"\npath = {braking}\n\
         [[candidates]]\nname = \"go on, straight\"\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = 12 }}\n"
    );
    let place = Place::new();
    let twin = place.write("twin.toml", &twin);
    let trace = [&example("crossing.osi")[..], "--at", "0", "--brakes", "0,6", "--laterals=-4,0"];
    let count = compare(&trace, &[twin.to_str().unwrap()]);
    assert!(count >= 3, "{count} contacts");
}

#[test]
fn a_trace_in_a_container_meets_whom_its_twin_meets() {
    let changing = states(0.1, 30, |t| {
        let share = (t / 2.0).min(1.0);
        let along = 3.5 * 6.0 * (share - share * share) / 2.0;
        [15.0 * t, 3.5 * (3.0 - 2.0 * share) * share * share, along.atan2(15.0)]
    });
    let stopping = states(0.2, 15, |t| {
        let t = t.min(2.6);
        [22.0 + 13.0 * t - 2.5 * t * t, 3.5, 0.0]
    });
    let twin = format!(
        "schema = \"trolley.scenario/2\"\nname = \"Twin\"\nhorizon_s = 3\n\
         [parties.ego]\ngenerate = {{ shape = \"sedan\", triangles = 20000 }}\n\
         size_m = [4.5, 1.85]\n\
         [parties.\"suv by hand\"]\n\
         generate = {{ shape = \"suv\", triangles = 20000, seed = 1 }}\nsize_m = [4.6, 1.8]\n\
         [[parties.\"suv by hand\".paths]]\n{}\n\
         [parties.\"motorcycle by hand\"]\n\
         generate = {{ shape = \"motorcycle\", triangles = 16000 }}\nsize_m = [2.2, 0.8]\n\
         state = {{ position_m = [-12, -0.5, 0], yaw_deg = 0, speed_m_s = 14 }}\n\
         [[candidates]]\nname = \"as recorded\"\npath = {changing}\n",
        stopping.trim_start_matches("{ ").trim_end_matches(" }")
    );
    let place = Place::new();
    let twin = place.write("twin.toml", &twin);
    let trace = [&example("merge.mcap")[..], "--at", "0", "--horizon", "3"];
    let count = compare(&trace, &[twin.to_str().unwrap()]);
    assert!(count >= 1, "{count} contacts");
}

#[test]
fn what_esmini_writes_meets_whom_a_twin_in_commonroad_meets() {
    let moment = |tag: &str, step: u32, [x, y, yaw, speed]: [f64; 4]| {
        format!(
            "<{tag}><position><point><x>{x}</x><y>{y}</y></point></position><orientation><exact>\
             {yaw}</exact></orientation><time><exact>{step}</exact></time><velocity><exact>{speed}\
             </exact></velocity></{tag}>"
        )
    };
    let shape = |length: f64, width: f64| {
        format!(
            "<shape><rectangle><length>{length}</length><width>{width}</width></rectangle></shape>"
        )
    };
    let turning = |t: f64| {
        let yaw = 0.5 * t;
        [12.0 * yaw.sin(), 12.0 - 12.0 * yaw.cos(), yaw, 6.0]
    };
    let coming = |t: f64| [28.0 - 8.0 * t, 3.0, std::f64::consts::PI, 8.0];
    let mut text = String::from(
        "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.05\" benchmarkID=\"Twin\">",
    );
    let mut moving = |id: u32, kind: &str, shape: String, way: &dyn Fn(f64) -> [f64; 4]| {
        let start = moment("initialState", 0, way(0.0));
        let states = (1..=60).map(|step| moment("state", step, way(0.05 * f64::from(step))));
        let _w = write!(
            text,
            "<dynamicObstacle id=\"{id}\"><type>{kind}</type>{shape}{start}<trajectory>{}\
             </trajectory></dynamicObstacle>",
            states.collect::<String>()
        );
    };
    moving(1, "car", shape(5.04, 2.0), &turning);
    moving(2, "car", shape(4.5, 1.8), &coming);
    let waiting = [12.0, 13.0, -std::f64::consts::FRAC_PI_2, 0.0];
    moving(3, "bicycle", shape(1.8, 0.6), &|_| waiting);
    text += "</commonRoad>";
    let place = Place::new();
    let twin = place.write("twin.xml", &text);
    let same = ["--at", "0", "--horizon", "3"];
    let trace = example("junction.csv");
    let trace = [&[&trace[..]], &same[..]].concat();
    let twin = [&[twin.to_str().unwrap(), "--ego", "1"], &same[..]].concat();
    let count = compare(&trace, &twin);
    assert!(count >= 6, "{count} contacts");
}

/// What esmini wrote when it played a test of Euro NCAP, from a moment on, beside its twin by hand:
/// the ego at 50 km/h, whose middle is the origin, and another party.
fn ncap(trace: &str, at_s: &str, other: &str) {
    let twin = format!(
        "schema = \"trolley.scenario/2\"\nname = \"Twin\"\nhorizon_s = 2\n\
         [parties.ego]\ngenerate = {{ shape = \"sedan\", triangles = 20000 }}\n\
         size_m = [4.358, 1.815]\n{other}\
         [[candidates]]\nname = \"as recorded\"\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = {V_M_S:?} }}\n\
         [[candidates]]\nname = \"go on, straight\"\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = {V_M_S:?} }}\n"
    );
    let place = Place::new();
    let twin = place.write("twin.toml", &twin);
    let trace = format!("{}/../../tests/data/traces/{trace}", env!("CARGO_MANIFEST_DIR"));
    let trace = [&trace[..], "--at", at_s, "--horizon", "2", "--laterals", "0"];
    let count = compare(&trace, &[twin.to_str().unwrap()]);
    assert_eq!(count, 2, "contacts");
}

/// 50 km/h.
const V_M_S: f64 = 50.0 / 3.6;
/// How far the middle of the ego is ahead of what its scripts place, its rear axle; and that of the
/// target vehicle (m).
const MIDDLE_M: [f64; 2] = [1.349, 1.328];
/// Half the lengths of both (m).
const HALF_M: [f64; 2] = [4.358 / 2.0, 4.023 / 2.0];

#[test]
fn a_test_against_a_standing_car_as_esmini_plays_it() {
    // Five seconds ahead at the start, one after four of them.
    let x = V_M_S + MIDDLE_M[1] - MIDDLE_M[0];
    let other = format!(
        "[parties.\"car by hand\"]\ngenerate = {{ shape = \"sedan\", triangles = 20000 }}\n\
         size_m = [4.023, 1.712]\nstate = {{ position_m = [{x:?}, 0, 0], speed_m_s = 0 }}\n"
    );
    ncap("ccrs.csv", "4", &other);
}

#[test]
fn a_test_against_a_braking_car_as_esmini_plays_it() {
    // 40 m ahead and as fast, it brakes with 2 m/s² until it creeps with 2 km/h: from 3 s after
    // the distance is made, which takes the first step of 50 ms. In each step it moves with the
    // speed of the step's end, as if it had begun half a step before.
    const CREEPS_M_S: f64 = 2.0 / 3.6;
    let braked_s = 8.5 - (3.05 - 0.025);
    let (gap_m, speed_m_s) = (40.0 - braked_s * braked_s, V_M_S - 2.0 * braked_s);
    let creeps_s = (speed_m_s - CREEPS_M_S) / 2.0;
    let braking = states(0.1, 20, |t| {
        let braked = t.min(creeps_s);
        let along = speed_m_s * braked - braked * braked + CREEPS_M_S * (t - braked);
        [gap_m + HALF_M[0] + HALF_M[1] + along, 0.0, 0.0]
    });
    let other = format!(
        "[parties.\"car by hand\"]\ngenerate = {{ shape = \"sedan\", triangles = 20000 }}\n\
         size_m = [4.023, 1.712]\n[[parties.\"car by hand\".paths]]\n{}\n",
        braking.trim_start_matches("{ ").trim_end_matches(" }")
    );
    ncap("ccrb.csv", "8.5", &other);
}

#[test]
fn a_test_against_a_pedestrian_as_esmini_plays_it() {
    // At 5 km/h from the right, who is struck a quarter of the width from the right side.
    const WALKS_M_S: f64 = 5.0 / 3.6;
    let (width_m, depth_m) = (1.815, 0.5);
    // Six seconds ahead of the rear axle at the start, one after five of them.
    let x = V_M_S - MIDDLE_M[0];
    let struck_s = (x - HALF_M[0] - 0.5 * depth_m) / V_M_S;
    let y = -0.25 * width_m - WALKS_M_S * struck_s;
    let other = format!(
        "[parties.\"pedestrian by hand\"]\n\
         generate = {{ shape = \"pedestrian\", triangles = 16000 }}\n\
         size_m = [0.6, {depth_m:?}]\n\
         state = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = 90, speed_m_s = {WALKS_M_S:?} }}\n"
    );
    ncap("cpna.csv", "5", &other);
}

#[test]
fn a_later_moment_is_another_scenario() {
    let trace = example("crossing.osi");
    let early = contacts(&[&trace, "--at", "0", "--brakes", "0", "--laterals", "0"]);
    let late = contacts(&[&trace, "--at", "1", "--brakes", "0", "--laterals", "0"]);
    let first = |all: &[(String, Vec<(String, f64)>)]| {
        let (_, met) = all.iter().find(|(name, _)| name == "as recorded").unwrap();
        met[0].clone()
    };
    let ((before, before_s), (after, after_s)) = (first(&early), first(&late));
    assert_eq!(before, after);
    assert!((before_s - after_s - 1.0).abs() < APART_S, "{before_s} {after_s}");
}

#[test]
fn a_script_is_refused_with_the_way_to_go() {
    let place = Place::new();
    let script = "<OpenSCENARIO><Entities/></OpenSCENARIO>";
    let path = place.write("a.xosc", script);
    let output = trolley().args(["rank", path.to_str().unwrap()]).output().unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{said}");
    assert!(said.contains("a.xosc:1:1: <OpenSCENARIO>: a script"), "{said}");
    assert!(said.contains("help: play it in esmini") && said.contains("--csv_logger"), "{said}");
}

#[test]
fn what_is_no_trace_is_refused_with_place_and_remedy() {
    let place = Place::new();
    let whole = std::fs::read(example("crossing.osi")).unwrap();
    let container = std::fs::read(example("merge.mcap")).unwrap();
    let files: [(&str, &[u8], &str); 6] = [
        ("empty.osi", b"", "it has no message of OSI"),
        ("cut.osi", &whole[..1_500], "message 3: "),
        ("text.osi", b"schema = 1", "message 1: it has 1701340019 bytes"),
        ("cut.mcap", &container[..3_000], "not readable as MCAP"),
        ("text.mcap", b"schema = \"trolley.scenario/2\"", "not readable as MCAP: Bad magic"),
        ("text.csv", b"t_s,x_m\n0,1\n", "no line of names"),
    ];
    for (name, bytes, says) in files {
        let path = place.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let output = trolley().args(["rank", path.to_str().unwrap()]).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{name}: {said}");
        assert!(said.contains(name) && said.contains(says), "{name}: {said}");
        assert!(said.contains("help: "), "{name}: {said}");
    }
}

mod shared_data {
    use super::*;
    use crate::support::shared;

    #[test]
    #[ignore = "needs ../shared/data: recorded traffic"]
    fn what_esmini_plays_is_what_others_made_of_the_same_script() {
        let trace =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/traces/fabriksgatan.csv");
        let twin = shared("scenarios/commonroad/OSC_PedestrianCollision-1_1_T-1.xml");
        let count = compare(&[trace], &[twin.to_str().unwrap()]);
        assert_eq!(count, 3, "contacts");
    }
}
