//! Deadlines and early stops with real workers: the four states, their exit codes, what is missing,
//! and that certain statements agree with the finished run.

use crate::support::{
    self, Place, answer, builder, instance, json, left_in_shm, library_answer, run, text, trolley,
    ways,
};
use ::trolley::{Engine, EngineBuilder, Limits, Scenario, SearchOrder};

/// Work that no machine finishes within a few milliseconds: a dense body inside an identical one.
fn heavy() -> String {
    support::heavy(60_000)
}

#[test]
fn a_deadline_far_away_changes_nothing_in_the_answer() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(1500));
    let path = path.to_str().unwrap();
    let reference = answer(&run(&["rank", path, "--json", "--in-process"]));
    let ways: &[&[&str]] = &[
        &["--deadline-ms", "600000"],
        &["--deadline-ms", "600000", "--in-process", "--budget", "38000"],
    ];
    for way in ways {
        let mut args = vec!["rank", path, "--json"];
        args.extend(*way);
        let output = run(&args);
        assert_eq!(output.status.code(), Some(0), "{way:?}: {}", text(&output.stderr));
        assert_eq!(answer(&output), reference, "{way:?}");
    }
}

#[test]
fn whose_job_goes_first_changes_nothing_in_the_answer() {
    let place = Place::new();
    let scenario = Scenario::open(place.write("ways.toml", &ways(1500))).unwrap();
    let here = || Engine::builder().in_process();
    let answer_of = |builder: EngineBuilder, limits: &Limits| {
        library_answer(&mut builder.build().unwrap(), &scenario, limits)
    };
    let reference = answer_of(here(), &Limits::default());
    let limits = |order| Limits::default().with_search_order(order);
    let small = |order, tests| limits(order).with_budget(tests).unwrap();
    for (builder, limits) in [
        (builder().workers(2), limits(SearchOrder::Deciding)),
        (here(), limits(SearchOrder::Alternating)),
        (builder().depth(3), small(SearchOrder::RoundRobin, 40_000)),
        (builder().workers(1).depth(0), small(SearchOrder::Sequential, 38_000)),
    ] {
        assert_eq!(answer_of(builder, &limits), reference, "{limits:?}");
    }
}

#[test]
fn the_winner_is_certified_before_all_work_is_done() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(4000));
    let path = path.to_str().unwrap();
    let whole = json(&run(&["rank", path, "--json"]));
    assert_eq!(whole["answer"]["state"], "complete");
    assert_eq!(whole["answer"]["settled_places"], 6);
    for way in [&["--until", "certified"][..], &["--until", "certified", "--in-process"]] {
        let mut args = vec!["rank", path, "--json"];
        args.extend(way);
        let output = run(&args);
        assert_eq!(output.status.code(), Some(0));
        let early = json(&output);
        assert_eq!(early["answer"]["state"], "certified", "{way:?}");
        assert_eq!(early["answer"]["ranking"][0]["name"], whole["answer"]["ranking"][0]["name"]);
        assert!(early["answer"]["settled_places"].as_u64() >= Some(1));
        assert!(!early["answer"]["missing"].as_array().unwrap().is_empty());
        assert!(early["run"]["nb"].as_u64() < whole["run"]["nb"].as_u64(), "{way:?}");
        // Every interval holds the value of the finished run.
        for row in early["answer"]["ranking"].as_array().unwrap() {
            let rows = whole["answer"]["ranking"].as_array().unwrap();
            let end = rows.iter().find(|end| end["name"] == row["name"]).unwrap();
            let end = end["work"][0].as_f64().unwrap();
            let [lo, hi] = [0, 1].map(|k| row["work"][k].as_f64().unwrap());
            assert!(lo <= end && end <= hi, "{}: {end} is not in {lo} to {hi}", row["name"]);
        }
    }
    let ordered = json(&run(&["rank", path, "--json", "--until", "ordered"]));
    assert_eq!(ordered["answer"]["settled_places"], 6);
    let names = |document: &serde_json::Value| -> Vec<serde_json::Value> {
        let rows = document["answer"]["ranking"].as_array().unwrap().clone();
        rows.into_iter().map(|row| row["name"].clone()).collect()
    };
    assert_eq!(names(&ordered), names(&whole));
}

// verifies REQ-BOUNDS
#[test]
fn an_answer_that_is_due_comes_with_bounds_and_says_what_is_missing() {
    let place = Place::new();
    let path = place.write("heavy.toml", &heavy());
    let path = path.to_str().unwrap();
    for way in [&["--deadline-ms", "1"][..], &["--deadline-ms", "1", "--in-process"]] {
        let mut args = vec!["rank", path, "--json"];
        args.extend(way);
        let output = run(&args);
        assert_eq!(output.status.code(), Some(3), "{way:?}: {}", text(&output.stderr));
        let document = json(&output);
        assert_eq!(document["answer"]["state"], "degraded");
        assert_eq!(document["answer"]["ranking"].as_array().unwrap().len(), 16);
        assert_eq!(document["answer"]["missing"].as_array().unwrap().len(), 16);
        assert_eq!(document["run"]["deadline"]["due_ms"], 1.0);
    }
    // The scenario may set it too; the command line overrides it.
    let timed = heavy().replace("name = \"heavy\"", "name = \"heavy\"\ndeadline_ms = 1");
    let path = place.write("timed.toml", &timed);
    let path = path.to_str().unwrap();
    assert_eq!(run(&["rank", path, "--json"]).status.code(), Some(3));
    let later = run(&["rank", path, "--json", "--deadline-ms", "600000"]);
    assert_eq!(later.status.code(), Some(0), "{}", text(&later.stderr));
}

#[test]
fn an_early_answer_is_replayed_from_its_record_bit_for_bit() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(2000));
    let records = place.path().join("records");
    let (path, folder) = (path.to_str().unwrap(), records.to_str().unwrap());
    let ways: &[&[&str]] = &[
        &["--until", "certified"],
        &["--until", "certified", "--in-process"],
        &["--deadline-ms", "0.3"],
        &["--deadline-ms", "0.3", "--in-process"],
        &["--deadline-ms", "1"],
        &["--deadline-ms", "1", "--in-process"],
        &["--deadline-ms", "2"],
    ];
    for (number, way) in ways.iter().enumerate() {
        let mut args = vec!["rank", path, "--json", "--record", folder];
        args.extend(*way);
        let output = run(&args);
        assert!(matches!(output.status.code(), Some(0 | 3)), "{}", text(&output.stderr));
        let record = records.join(format!("{number:06}.record"));
        let replay = trolley().args(["record", "replay"]).arg(&record).output().unwrap();
        assert!(replay.status.success(), "{way:?}: {}", text(&replay.stderr));
    }
}

// verifies REQ-BOUNDS
#[test]
fn a_request_without_workers_is_answered_by_its_deadline() {
    let place = Place::new();
    let path = place.write("heavy.toml", &heavy());
    let instance = instance();
    let mut child = trolley()
        .args(["rank", path.to_str().unwrap(), "--json", "--deadline-ms", "3000", "--depth", "2"])
        .args(["--workers", "2", "--instance", &instance])
        .spawn()
        .unwrap();
    if let Some(workers) = support::workers_at_work(&mut child, 2) {
        workers.iter().for_each(|pid| support::signal(*pid, rustix::process::Signal::KILL));
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(left_in_shm(&instance), Vec::<String>::new());
    // Complete, if it was faster than the kill.
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", text(&output.stderr));
    let document = json(&output);
    assert_eq!(document["answer"]["ranking"].as_array().unwrap().len(), 16);
}

#[test]
fn terms_that_cannot_be_are_refused() {
    let refused = |args: &[&str], code: i32, word: &str| {
        let output = trolley().arg("demo").args(args).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{args:?}");
        assert!(text(&output.stderr).contains(word), "{}", text(&output.stderr));
    };
    refused(&["--deadline-ms", "0"], 78, "--deadline-ms is 0");
    refused(&["--deadline-ms=-4"], 78, "--deadline-ms is -4");
    refused(&["--deadline-ms", "NaN"], 78, "--deadline-ms is NaN");
    refused(&["--budget", "100"], 78, "--budget is 100");
    refused(&["--budget", "50000", "--record", "x"], 2, "--record");
    refused(&["--until", "sometimes"], 2, "certified");
}
