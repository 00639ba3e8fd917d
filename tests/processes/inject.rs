//! Faults in real processes, from the command line: survived, counted, nothing left behind; and
//! faults in simulated ones.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{self, Place, json, run, text};

fn plan(place: &Place, faults: &str) -> String {
    let scenario = support::ways(600);
    place.write("small.toml", &scenario);
    place.write("ways.toml", &support::ways(600));
    let plan = format!(
        "schema = \"trolley.faults/1\"\nscenario = \"small.toml\"\n\
         asked = \"ways.toml\"\nworkers = 4\ndepth = 4\n\
         at_once = 2\n[faults]\n{faults}"
    );
    place.write("plan.toml", &plan).to_str().unwrap().to_owned()
}

/// Runs a plan without an instance name: it makes its own.
fn inject(args: &[&str]) -> std::process::Output {
    support::trolley().arg("inject").args(args).output().unwrap()
}

// verifies REQ-MESSAGES
#[test]
fn faults_of_all_sorts_are_survived_and_leave_nothing() {
    let place = Place::new();
    let plan = plan(
        &place,
        "kill = 4\nkill-idle = 1\nkill-all = 1\nabort = 2\npanic = 3\nquit = 1\ngarble-result = 4\n\
         wrong-length = 2\nmasquerade = 1\nrepeat-result = 3\nlose-result = 3\ngarble-batch = 4\n\
         queue-full = 3\nstop = 1\nstop-before-exec = 3\ncoordinator-kill = 1\nstale-memory = 1\n",
    );
    let report = place.path().join("faults.xml");
    let output = inject(&[&plan, "--json", "--seed", "3", "--junit", report.to_str().unwrap()]);
    let document = json(&output);
    for zero in ["wrong_answers", "hangs", "false_kills", "leaks"] {
        assert_eq!(document[zero], 0, "{zero}: {document}");
    }
    assert!(document["injected"].as_u64().unwrap() >= 30, "{document}");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(std::fs::read_to_string(report).unwrap().contains("name=\"garble-batch\""));
}

/// Regression: a flipped bit in a count of messages kept the coordinator from ever sleeping, or a
/// worker from ever sending.
// verifies REQ-MESSAGES
#[test]
fn flipped_bits_of_the_status_page_are_survived() {
    let place = Place::new();
    let plan = plan(&place, "flip-status = 150\n");
    let document = json(&inject(&[&plan, "--json", "--seed", "9"]));
    for zero in ["wrong_answers", "hangs", "false_kills", "leaks"] {
        assert_eq!(document[zero], 0, "{zero}: {document}");
    }
    assert!(document["injected"].as_u64().unwrap() >= 150, "{document}");
}

/// Regression: stopped workers were never detected if each request ended before the first check of
/// them, and the greeting of a replacement between two requests was missed.
#[test]
fn what_short_requests_leave_open_is_found_by_those_that_follow() {
    let place = Place::new();
    let plan = plan(&place, "stop = 3\nkill-idle = 8\nkill = 4\n");
    let text = std::fs::read_to_string(&plan).unwrap();
    std::fs::write(&plan, text.replace("[faults]", "deadline_ms = 60\n[faults]")).unwrap();
    let document = json(&inject(&[&plan, "--json", "--seed", "5"]));
    assert_eq!(document["deadline_ms"], 60);
    for zero in ["wrong_answers", "unseen", "false_kills", "leaks"] {
        assert_eq!(document[zero], 0, "{zero}: {document}");
    }
}

#[test]
fn three_of_four_may_die_again_and_again_and_all_four_are_refused() {
    let place = Place::new();
    let plan = plan(&place, "kill-all = 3\n");
    let output = inject(&[&plan, "--json"]);
    let document = json(&output);
    assert_eq!(document["wrong_answers"], 0);
    let kind = &document["kinds"][0];
    assert_eq!(kind["fault"], "kill-all");
    assert_eq!(kind["answers"]["wrong"], 0, "{document}");
    assert_eq!(document["left"]["names_after_the_end"], 0);
    assert!(output.status.success());
}

#[test]
fn a_plan_that_cannot_be_read_is_refused_with_the_names_there_are() {
    let place = Place::new();
    let plan = plan(&place, "murder = 1\n");
    let output = inject(&[&plan]);
    assert_eq!(output.status.code(), Some(65));
    let said = text(&output.stderr);
    assert!(said.contains("murder") && said.contains("kill-at-start"), "{said}");
}

#[test]
fn a_seed_replays_one_simulated_world() {
    let args = ["simulate", "faults", "--seed", "173", "--json"];
    let twice = [(), ()].map(|()| {
        let output = support::trolley().args(args).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let mut document = json(&output);
        document["seconds"] = 0.into();
        document
    });
    assert_eq!(twice[0], twice[1]);
    assert_eq!(twice[0]["requests"], 4);
    let none = run_without_instance(&["simulate", "faults", "--only", "murder"]);
    assert_eq!(none.status.code(), Some(2));
}

fn run_without_instance(args: &[&str]) -> std::process::Output {
    support::trolley().args(args).output().unwrap()
}

// verifies REQ-RESOURCES
#[test]
fn too_few_descriptors_are_found_before_anything_is_made() {
    let place = Place::new();
    let path = place.write("small.toml", &support::ways(600));
    let trolley = env!("CARGO_BIN_EXE_trolley");
    let output = std::process::Command::new("/bin/sh")
        .args(["-c", "ulimit -n 60; exec \"$0\" \"$@\"", trolley, "rank", path.to_str().unwrap()])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(69), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(said.contains("file descriptors") && said.contains("ulimit -n"), "{said}");
    let fine = run(&["rank", path.to_str().unwrap(), "--json"]);
    assert!(fine.status.success());
}

/// What a report says of one kind; `None` if it was skipped, which is said.
fn row<'d>(document: &'d serde_json::Value, kind: &str) -> Option<&'d serde_json::Value> {
    let skipped = document["skipped"].as_array().unwrap();
    let is_it = |said: &&serde_json::Value| said.as_str().unwrap().contains(kind);
    if let Some(said) = skipped.iter().find(is_it) {
        support::skipped(said.as_str().unwrap());
        return None;
    }
    let rows = document["kinds"].as_array().unwrap();
    let found = rows.iter().find(|row| row["fault"] == kind);
    assert!(found.is_some(), "{kind} is neither injected nor skipped: {document}");
    found
}

#[track_caller]
fn assert_survived(document: &serde_json::Value) {
    for zero in ["wrong_answers", "hangs", "false_kills", "leaks"] {
        assert_eq!(document[zero], 0, "{zero}: {document}");
    }
}

// verifies REQ-REMAINS
#[test]
fn successors_and_coordinators_are_killed_at_any_call_of_their_start() {
    let place = Place::new();
    let plan = plan(&place, "kill-at-call = 12\ncoordinator-kill-at-call = 8\n");
    let document = json(&inject(&[&plan, "--json", "--seed", "11"]));
    assert_survived(&document);
    if let Some(row) = row(&document, "kill-at-call") {
        assert!(row["injected"].as_u64().unwrap() >= 6, "{document}");
        assert_eq!(row["detected"], row["injected"], "{document}");
    }
    if let Some(row) = row(&document, "coordinator-kill-at-call") {
        assert!(row["injected"].as_u64().unwrap() >= 4, "{document}");
        assert_eq!(row["answers"]["complete"], row["injected"], "the next run: {document}");
    }
}

// verifies REQ-MANAGEMENT-DATA
#[test]
fn flipped_bits_in_what_iceoryx2_manages_mislead_and_hold_up_nobody() {
    let place = Place::new();
    let plan = plan(&place, "flip-management = 10\n");
    let document = json(&inject(&[&plan, "--json", "--seed", "4"]));
    assert_survived(&document);
    let row = row(&document, "flip-management").unwrap();
    assert_eq!(row["injected"], 10, "{document}");
    assert!(row["answers"]["complete"].as_u64().unwrap() > 0, "most bits do no harm: {document}");
}

/// Regression: with a full file system a killed worker was never replaced.
// verifies REQ-RESOURCES
#[test]
fn a_full_file_system_costs_neither_answers_nor_workers() {
    let place = Place::new();
    let plan = plan(&place, "full-shm = 3\n");
    let document = json(&inject(&[&plan, "--json", "--seed", "6"]));
    assert_survived(&document);
    if let Some(row) = row(&document, "full-shm") {
        assert_eq!((&row["injected"], &row["detected"]), (&3.into(), &3.into()), "{document}");
    }
}

// verifies REQ-STRANGERS
#[test]
fn what_strangers_plant_around_a_service_holds_up_nobody_and_is_touched_by_nobody() {
    let place = Place::new();
    let plan = plan(&place, "strangers-files = 8\n");
    let document = json(&inject(&[&plan, "--json", "--seed", "2"]));
    assert_survived(&document);
    let Some(row) = row(&document, "strangers-files") else {
        assert!(!super::strangers::is_possible(), "{document}");
        return;
    };
    assert_eq!((&row["injected"], &row["answers"]["complete"]), (&8.into(), &8.into()));
}
