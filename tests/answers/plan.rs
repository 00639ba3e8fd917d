//! What is left to the program: a small request goes uncut to one worker, a large one is spread, by
//! predictions that the report shows; and the answer is the same bytes whatever was chosen.

use crate::support::{self, Place, answer, json, run, six, text, trolley};
use serde_json::Value;

/// A crash of two small bodies: hardly any work.
const TINY: &str = r#"
schema = "trolley.scenario/1"
name = "tiny"
[parties]
ego = { generate = { shape = "sedan", triangles = 500 } }
pole = { generate = { shape = "pole", triangles = 500 } }
[[candidates]]
name = "pole"
ego = { position_m = [0, 0, 0], speed_m_s = 9 }
other = { party = "pole", position_m = [2.4, 0.3, 0], speed_m_s = 0 }
"#;

/// Rounds of questions for one candidate: the grid, at most eight halvings of its step of 0.1 m
/// down to 1 mm, the survey.
const ROUNDS: u64 = 10;

/// The answer's bytes, and what is said of the run.
fn ranked(path: &str, args: &[&str]) -> (String, Value) {
    let output = run(&[&["rank", path, "--json"], args].concat());
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    (answer(&output), json(&output)["run"].clone())
}

#[test]
fn a_small_request_goes_to_one_worker_in_a_batch_per_round() {
    let place = Place::new();
    let path = place.write("tiny.toml", TINY);
    let path = path.to_str().expect("a path of letters");
    let (reference, plain) = ranked(path, &["--in-process"]);
    assert_eq!(plain.get("choice"), None);
    for args in [&["--distribute", "auto"][..], &["--distribute", "auto", "--depth", "auto"]] {
        let (answer, run) = ranked(path, args);
        assert_eq!(answer, reference, "{args:?}");
        assert_eq!(run["choice"]["distributed"], false, "{run}");
        assert_eq!(run["workers"].as_array().map(Vec::len), Some(1), "{run}");
        let (jobs, batches) = (run["jobs"].as_u64(), run["workers"][0]["batches"].as_u64());
        assert!(batches.is_some_and(|n| n <= ROUNDS) && batches < jobs, "{run}");
        // Uncut: one job for each question.
        assert!(run["depth"] == 0 && jobs <= run["tasks"].as_u64(), "{run}");
    }
    let (answer, run) = ranked(path, &["--depth", "auto", "--workers", "2"]);
    assert_eq!(answer, reference);
    assert_eq!(run["choice"]["distributed"], true, "it is distributed where nobody asks: {run}");
    let output = support::run(&["rank", path, "--distribute", "auto"]);
    assert!(
        text(&output.stdout).contains("Not distributed: in one piece"),
        "{}",
        text(&output.stdout)
    );
}

#[test]
fn a_large_request_is_spread_and_its_depth_chosen() {
    let place = Place::new();
    let scenario = six(20_000);
    let path = place.write("six.toml", &scenario);
    let chosen = place.write("auto.toml", &format!("{scenario}\n[engine]\ndepth = \"auto\"\n"));
    let (path, chosen) = (path.to_str().expect("letters"), chosen.to_str().expect("letters"));
    let (reference, _) = ranked(path, &["--in-process"]);
    let args = ["--distribute", "auto", "--workers", "2"];
    for path in [path, chosen] {
        let (answer, run) = ranked(path, &args);
        assert_eq!(answer, reference, "{path}");
        // One core has nothing to gain from it.
        let cores = run["cores_granted"].as_array().map_or(0, Vec::len);
        assert_eq!(run["choice"]["distributed"], cores > 1, "{run}");
        let busy = run["workers"].as_array().expect("a list");
        for worker in busy {
            let hardware = &worker["hardware"];
            let counted = hardware["instructions"].as_u64().is_some_and(|n| n > 0);
            let says_why = hardware.as_str().is_some_and(|why| why.starts_with("not available: "));
            assert!(counted || says_why, "{worker}");
        }
        assert_eq!(busy.iter().filter(|worker| worker["jobs"] != 0).count(), cores.min(2), "{run}");
        assert_eq!(run["choice"]["depth"], run["depth"]);
        assert_eq!(run["choice"]["depth_is_chosen"], path == chosen);
        let ms = |name: &str| run["choice"][name].as_f64().expect("a time");
        assert!(
            ms("predicted_ms") > 0.0 && ms("predicted_ms") <= ms("predicted_whole_ms"),
            "{run}"
        );
    }
    let table = text(&run(&["rank", chosen, "--workers", "2"]).stdout);
    assert!(table.contains("(chosen): ") && table.contains("(costs: built in)"), "{table}");
}

#[test]
fn what_was_chosen_is_recorded_and_replayed() {
    let place = Place::new();
    let path = place.write("tiny.toml", TINY);
    let folder = place.path().join("records");
    let folder = folder.to_str().expect("letters");
    let asked = ["--depth", "auto", "--distribute", "auto", "--record", folder];
    let (_, run) = ranked(path.to_str().expect("letters"), &asked);
    assert!(run["choice"].is_object(), "{run}");
    let record = format!("{folder}/000000.record");
    let output = trolley().args(["record", "replay", &record]).output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn calibrated_costs_are_written_and_used() {
    let place = Place::new();
    let path = place.write("tiny.toml", TINY);
    let costs = place.path().join("costs.json");
    let costs = costs.to_str().expect("letters");
    let pair = ["calibrate", "--pair", "sedan:900,suv:900,deep", "--repeat", "1", "--out", costs];
    let output = trolley().args(pair).output().expect("it can be started");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let args = ["--depth", "auto", "--costs", costs];
    let (_, run) = ranked(path.to_str().expect("letters"), &args);
    assert_eq!(run["choice"]["costs"], costs);
}

#[test]
fn bad_settings_are_refused_with_their_reason() {
    let place = Place::new();
    let path = place.write("tiny.toml", TINY);
    let deep = place.write("deep.toml", &format!("{TINY}\n[engine]\ndepth = \"deep\"\n"));
    let broken = place.write("broken.json", "{ \"job_ns\": 1 }");
    let written: String = [
        "job",
        "box",
        "triangle",
        "hit",
        "leaves",
        "send",
        "section_byte",
        "ship_byte",
        "task",
        "descent",
        "batch",
        "place",
        "take",
        "fold_hit",
        "flight",
    ]
    .map(|name| format!("\"{name}_ns\": -1.0"))
    .join(", ");
    let below = place.write("below.json", &format!("{{ {written} }}"));
    let [path, deep, broken, below] =
        [&path, &deep, &broken, &below].map(|path| path.to_str().expect("letters"));
    for (args, code, says) in [
        (&[path, "--depth", "foo"][..], 2, "levels, or auto"),
        (&[path, "--depth", "99"], 78, "0 to 20"),
        (&[path, "--distribute", "never"], 2, "always, auto"),
        (&[path, "--distribute", "auto", "--in-process"], 2, "--in-process"),
        (&[path, "--costs", below], 78, "--depth auto or --distribute auto"),
        (&[path, "--depth", "auto", "--costs", "no.json"], 65, "no.json"),
        (&[path, "--depth", "auto", "--costs", broken], 65, "missing field"),
        (&[path, "--depth", "auto", "--costs", below], 65, "below 0"),
        (&[path, "--depth", "auto", "--transfer", "copy"], 78, "name a depth"),
        (&[path, "--distribute", "auto", "--cache-bytes", "9000000"], 78, "--cache-bytes"),
        (&[deep], 65, "depth may be 0 to 20, or \"auto\""),
    ] {
        let output = run(&[&["rank"], args].concat());
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {error}");
        assert!(error.contains(says) && output.stdout.is_empty(), "{args:?}: {error}");
    }
    let out = format!("{broken}/costs.json");
    let output = trolley().args(["calibrate", "--out", &out]).output().expect("it can be started");
    assert_eq!(output.status.code(), Some(71), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("broken.json/costs.json"));
}
