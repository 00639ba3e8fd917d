//! Expected harm by the program: the same answer however the work is done, records that replay, a
//! page and a table that tell it, and bad input that is refused.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, answer, json, run, text, trolley, ways};
use serde_json::Value;
use std::path::Path;

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn ranked(args: &[&str]) -> std::process::Output {
    let output = run(args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    output
}

#[test]
fn expected_harm_does_not_depend_on_how_the_work_was_done() {
    let place = Place::new();
    let scene = place.write("ways.toml", &ways(900));
    let all = |more: &[&str]| {
        let with = ["rank", path(&scene), "--json", "--members", "4", "--members-max", "8"];
        ranked(&[&with[..], more].concat())
    };
    let reference = all(&["--in-process"]);
    let document = json(&reference);
    let reference = answer(&reference);
    let rows = document["answer"]["ranking"].as_array().unwrap().clone();
    assert!(rows.iter().all(|row| row["expected"]["spread"]["best"].is_number()));
    assert_eq!(document["answer"]["worlds"]["count"], 200);
    let sum: f64 = rows.iter().map(|row| row["expected"]["worlds"].as_f64().unwrap()).sum();
    assert!((sum - 1.0).abs() < 1e-9, "somebody wins in every world: {sum}");
    let options: &[&[&str]] = &[
        &["--workers", "1"],
        &["--workers", "2"],
        &["--workers", "4", "--batch", "1", "--queue", "1"],
        &["--depth", "0"],
        &["--depth", "9", "--build", "sah"],
        &["--leaf-size", "1", "--in-process"],
        &["--deadline-ms", "60000"],
    ];
    for options in options {
        assert_eq!(answer(&all(options)), reference, "{options:?}");
    }
}

#[test]
fn a_record_of_members_replays_bit_for_bit() {
    let place = Place::new();
    let scene = place.write("ways.toml", &ways(900).replacen("members = 1\n", "members = 8\n", 1));
    let records = place.path().join("records");
    let sets: [&[&str]; 4] = [
        &["--workers", "2"],
        &["--in-process", "--members", "3"],
        &["--in-process", "--members", "1"],
        &["--in-process", "--deadline-ms", "20"],
    ];
    for more in sets {
        let with = ["rank", path(&scene), "--json", "--record", path(&records)];
        // What is late is an answer, too.
        let output = run(&[&with[..], more].concat());
        let is_stated = more.contains(&"1") || more.contains(&"--deadline-ms");
        assert!(json(&output)["answer"]["members"].is_object() || is_stated, "{more:?}");
    }
    let mut counts = Vec::new();
    for number in 0..sets.len() {
        let record = records.join(format!("{number:06}.record"));
        let output =
            trolley().args(["record", "replay", path(&record), "--json"]).output().unwrap();
        let document = json(&output);
        assert_eq!(document["same"], true, "record {number}: {}", text(&output.stderr));
        let shown = trolley().args(["record", "show", path(&record), "--json"]).output().unwrap();
        counts.push(json(&shown)["settings"]["members"].clone());
    }
    assert_eq!(counts, [8, 3, 1, 8].map(Value::from));
}

#[test]
fn table_explanation_and_page_tell_it() {
    let place = Place::new();
    let scene = place.write("ways.toml", &ways(900));
    let page = place.path().join("page.html");
    let with = ["rank", path(&scene), "--in-process", "--members", "4", "--members-max", "4"];
    let output = ranked(&[&with[..], &["--explain", "--report", path(&page)]].concat());
    let told = text(&output.stdout);
    for words in [
        "best in",
        "worlds",
        "Harm is the mean over 4 members",
        "Of 200 worlds that the model allows it wins",
        "Risks that are compared are means over 4 members",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let page = std::fs::read_to_string(page).unwrap();
    for words in ["harm in each member", "Harm is the mean over members", "best in", "worlds"] {
        assert!(page.contains(words), "{words}");
    }
}

#[test]
fn numbers_that_make_no_sense_are_refused() {
    let place = Place::new();
    let scene = place.write("ways.toml", &ways(900));
    for (options, code, words) in [
        (&["--members", "0"][..], 78, "members"),
        (&["--members", "2000"][..], 78, "1 to 1024"),
        (&["--members", "8", "--members-max", "4"][..], 78, "members-max"),
        (&["--members", "1", "--members-max", "4"][..], 78, "members-max"),
        (&["--members", "many"][..], 2, "invalid value"),
        (&["--members-max", "8"][..], 2, "--members"),
    ] {
        let output = run(&[&["rank", path(&scene), "--in-process"], options].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{options:?}: {message}");
        assert!(message.contains(words), "{options:?}: {message}");
    }
}
