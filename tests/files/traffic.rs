//! `trolley scenario import` and `trolley rank FILE.xml` as a user runs them, on third-party files
//! and on invalid ones.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, text, trolley};
use serde_json::Value;
use std::process::Output;

fn asked(args: &[&str]) -> Output {
    trolley().args(args).output().unwrap()
}

/// A car stands in the ego's path, or far beside it.
pub(crate) fn crossing(y_m: f64, kind: &str) -> String {
    let state = |x: f64, y: f64, more: &str| {
        format!(
            "<initialState><position><point><x>{x}</x><y>{y}</y></point></position>\
             <orientation><exact>0</exact></orientation><time><exact>0</exact></time>{more}\
             </initialState>"
        )
    };
    format!(
        "<commonRoad commonRoadVersion=\"2020a\" timeStepSize=\"0.1\" benchmarkID=\"Test\">\
         <staticObstacle id=\"7\"><type>{kind}</type><shape><rectangle><length>4</length>\
         <width>1.8</width></rectangle></shape>{}</staticObstacle>\
         <planningProblem id=\"1\">{}</planningProblem></commonRoad>",
        state(25.0, y_m, ""),
        state(0.0, 0.0, "<velocity><exact>15</exact></velocity>")
    )
}

#[test]
fn a_traffic_file_is_ranked_as_it_is_and_as_the_scenario_made_from_it() {
    let place = Place::new();
    let file = place.write("a.xml", &crossing(0.5, "parkedVehicle"));
    let (file, out) = (file.to_str().unwrap(), place.path().join("a.toml"));
    let made = asked(&["scenario", "import", file, "-o", out.to_str().unwrap()]);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let answer = |path: &str| -> Value {
        let output = asked(&["rank", path, "--json", "--in-process"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        document["answer"].clone()
    };
    let direct = answer(file);
    assert!(!direct["ranking"].as_array().unwrap().is_empty());
    assert_eq!(direct, answer(out.to_str().unwrap()));
}

#[test]
fn manoeuvres_that_meet_nobody_are_ranked_too() {
    let place = Place::new();
    let file = place.write("a.xml", &crossing(400.0, "car"));
    let output = asked(&["rank", file.to_str().unwrap(), "--json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["schema"], "trolley.rank/2");
    assert_eq!(document["answer"]["state"], "complete");
    let ranking = document["answer"]["ranking"].as_array().unwrap();
    assert_eq!(ranking.len(), 15);
    for row in ranking {
        assert_eq!(row["contacts"], serde_json::json!([]), "{row}");
        assert!(row["nearest"]["gap_m"].as_f64().is_some_and(|gap| gap > 300.0), "{row}");
    }
}

#[test]
fn what_is_unknown_is_refused_unless_something_is_assumed() {
    let place = Place::new();
    let file = place.write("a.xml", &crossing(0.0, "unknown"));
    let file = file.to_str().unwrap();
    let output = asked(&["rank", file, "--in-process"]);
    assert_eq!(output.status.code(), Some(4), "{}", text(&output.stderr));
    let output = asked(&["rank", file, "--in-process", "--assume", "unknown=fixed"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn what_is_no_traffic_file_is_refused_with_place_and_remedy() {
    let place = Place::new();
    let bomb = "<!DOCTYPE a [<!ENTITY b \"bbbbbbbb\"><!ENTITY c \"&b;&b;&b;&b;\">]>\
                <commonRoad>&c;</commonRoad>";
    let files = [
        ("bomb.xml", bomb.to_owned(), 65, "DTD"),
        ("json.xml", "{\"a\": 1}".to_owned(), 65, "not XML: it begins with"),
        ("toml.xml", "schema = \"trolley.scenario/1\"".to_owned(), 65, "not XML"),
        ("other.xml", "<svg/>".to_owned(), 65, "not CommonRoad"),
        ("train.xml", crossing(0.0, "train"), 65, "no body for \"train\""),
        ("type.xml", crossing(0.0, "ufo"), 65, "obstacle type \"ufo\""),
        ("big.xml", crossing(0.0, "car").replace("<length>4", "<length>4000"), 65, "4000 m"),
    ];
    for (name, content, code, says) in files {
        let file = place.write(name, &content);
        let output = asked(&["rank", file.to_str().unwrap()]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{name}: {said}");
        assert!(said.contains(name) && said.contains(says), "{name}: {said}");
        assert!(said.contains("help: "), "{name}: {said}");
    }
    let binary = place.path().join("b.xml");
    std::fs::write(&binary, b"<\xff\xfe\x00").unwrap();
    let output = asked(&["rank", binary.to_str().unwrap()]);
    assert!(text(&output.stderr).contains("not UTF-8"), "{}", text(&output.stderr));
}

mod shared_data {
    use super::asked;
    use crate::support::{shared, text};
    use serde_json::Value;

    /// Every third-party file gives a ranking, or a reason for none.
    #[test]
    #[ignore = "needs ../shared/data: recorded traffic"]
    fn recorded_traffic_gives_rankings_or_reasons() {
        let entries = std::fs::read_dir(shared("scenarios/commonroad")).unwrap();
        let mut ranked = 0;
        for entry in entries {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|end| end != "xml") {
                continue;
            }
            let file = path.to_str().unwrap();
            let output =
                asked(&["rank", file, "--json", "--in-process", "--assume", "unknown=fixed"]);
            assert!(output.status.success(), "{file}: {}", text(&output.stderr));
            let document: Value = serde_json::from_slice(&output.stdout).unwrap();
            assert!(!document["answer"]["ranking"].as_array().unwrap().is_empty(), "{file}");
            ranked += 1;
        }
        assert!(ranked >= 7, "{ranked}");
    }
}

/// The ways that two planners chose: one stops before the car that stands in the way.
#[test]
fn solutions_of_planners_are_ranked_beside_the_manoeuvres() {
    let place = Place::new();
    let file = place.write("a.xml", &crossing(0.0, "parkedVehicle"));
    let solution = |name: &str, brake: f64, problem: &str| {
        let mut states = String::new();
        for step in 0..=30 {
            let t = f64::from(step) * 0.1;
            let t_stop = if brake > 0.0 { (15.0 / brake).min(t) } else { t };
            let (x, v) = (15.0 * t_stop - 0.5 * brake * t_stop * t_stop, 15.0 - brake * t_stop);
            states += &format!(
                "<ksState><x>{x}</x><y>0</y><steeringAngle>0</steeringAngle>\
                 <velocity>{v}</velocity><orientation>0</orientation><time>{step}</time></ksState>"
            );
        }
        let text = format!(
            "<CommonRoadSolution benchmark_id=\"KS2:SM1:Test:2020a\"><ksTrajectory \
             planningProblem=\"{problem}\">{states}</ksTrajectory></CommonRoadSolution>"
        );
        place.write(name, &text)
    };
    let (hits, stops) = (solution("hits.xml", 0.0, "1"), solution("stops.xml", 7.5, "1"));
    let args = |more: &[&str]| {
        let mut args = vec!["rank", file.to_str().unwrap(), "--json", "--in-process"];
        args.extend(["--solution", hits.to_str().unwrap()]);
        let mut all: Vec<String> = args.into_iter().map(str::to_owned).collect();
        all.extend(more.iter().map(|more| (*more).to_owned()));
        trolley().args(all).output().unwrap()
    };
    let output = args(&["--solution", stops.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = answer["answer"]["ranking"].as_array().unwrap();
    let row = |name: &str| rows.iter().find(|row| row["name"] == name).unwrap();
    assert_eq!(row("stops")["contacts"].as_array().unwrap().len(), 0);
    assert_eq!(row("hits")["contacts"][0]["party"], row("go on, straight")["contacts"][0]["party"]);
    let time = |name: &str| row(name)["contacts"][0]["time_s"].as_f64().unwrap();
    assert!((time("hits") - time("go on, straight")).abs() < 1e-6);

    let late = args(&["--at", "1"]);
    assert_eq!(late.status.code(), Some(78), "{}", text(&late.stderr));
    let other = solution("other.xml", 0.0, "5");
    let other = args(&["--solution", other.to_str().unwrap()]);
    assert_eq!(other.status.code(), Some(65), "{}", text(&other.stderr));
    assert!(text(&other.stderr).contains("other.xml:1:"), "{}", text(&other.stderr));
}
