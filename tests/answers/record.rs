//! Decision records of real runs: replayed elsewhere they give the same bytes; changed, cut,
//! exchanged or removed records are detected and named.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::{Place, answer, json, run, text, trolley, ways};
use std::path::{Path, PathBuf};
use std::process::Output;

fn command(args: &[&str]) -> Output {
    trolley().args(args).output().unwrap()
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A scenario with a model file in it, ranked with a record; the folder of records.
fn recorded(place: &Place, sets: &[&[&str]]) -> PathBuf {
    let model = place.path().join("suv.trolley");
    let args = ["model", "generate", "suv", "--triangles", "900", "-o", path(&model)];
    let made = command(&args);
    assert!(made.status.success(), "{}", text(&made.stderr));
    let of_file = "file = \"suv.trolley\"";
    let good = ways(900);
    let from = good.find("generate = { shape = \"suv\"").unwrap();
    let to = from + good[from..].find('\n').unwrap();
    let scenario = format!("{}{of_file}{}", &good[..from], &good[to..]);
    let scenario = place.write("ways.toml", &scenario);
    let records = place.path().join("records");
    for options in sets {
        let mut args = vec!["rank", path(&scenario), "--json", "--record", path(&records)];
        args.extend(*options);
        let output = run(&args);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    records
}

// verifies REQ-RECORD
#[test]
fn a_record_is_replayed_bit_for_bit_in_another_place() {
    let place = Place::new();
    let ways: [&[&str]; 3] = [
        &["--workers", "2"],
        &["--in-process", "--depth", "5", "--build", "sah"],
        &["--workers", "3", "--batch", "1", "--queue", "1"],
    ];
    let records = recorded(&place, &ways);
    let verified = command(&["record", "verify", path(&records)]);
    assert!(verified.status.success(), "{}", text(&verified.stderr));
    assert!(text(&verified.stdout).contains("3 records"), "{}", text(&verified.stdout));
    // In another folder neither scenario nor model has its old path.
    let elsewhere = Place::new();
    let model = elsewhere.path().join("x.trolley");
    std::fs::copy(place.path().join("suv.trolley"), model).unwrap();
    for number in 0..3 {
        let name = format!("{number:06}.record");
        let copy = elsewhere.path().join(&name);
        std::fs::copy(records.join(&name), &copy).unwrap();
    }
    drop(place);
    for number in 0..3 {
        let copy = elsewhere.path().join(format!("{number:06}.record"));
        let args = ["record", "replay", path(&copy), "--models", path(elsewhere.path()), "--json"];
        let output = command(&args);
        let document = json(&output);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!((&document["same"], &document["same_build"]), (&true.into(), &true.into()));
        assert!(document["jobs"].as_u64().unwrap() > 20);
    }
    let without = command(&["record", "replay", path(&elsewhere.path().join("000000.record"))]);
    let error = text(&without.stderr);
    assert_eq!(without.status.code(), Some(65), "{error}");
    assert!(error.contains("\"suv\" is missing") && error.contains("--models"), "{error}");
}

#[test]
fn a_record_shows_what_was_asked_and_decided() {
    let place = Place::new();
    let records = recorded(&place, &[&["--workers", "2"]]);
    let file = records.join("000000.record");
    let show = command(&["record", "show", path(&file), "--json"]);
    let shown = json(&show);
    let scenario = place.path().join("ways.toml");
    let ranked = run(&["rank", path(&scenario), "--json", "--in-process"]);
    let told: serde_json::Value =
        serde_json::from_str(&format!("{{{}}}", answer(&ranked).trim_end_matches(','))).unwrap();
    assert_eq!(shown["answer"], told["answer"]);
    // To the last digit, which a parser that is off by one bit would hide.
    let figures = |text: &str| -> std::collections::BTreeSet<String> {
        let words = text.split(|c: char| !c.is_ascii_digit() && !".e-".contains(c));
        words.filter(|word| word.contains('.')).map(str::to_owned).collect()
    };
    let (all, told) = (figures(&text(&show.stdout)), figures(&answer(&ranked)));
    let other: Vec<&String> = told.difference(&all).collect();
    assert!(told.len() > 100 && other.is_empty(), "{other:?}");
    assert_eq!(shown["settings"]["workers"], 2);
    assert_eq!(shown["bodies"].as_array().unwrap().len(), 7);
    assert_eq!(shown["scenario"]["hash"].as_str().unwrap().len(), 64);
    let rounds = shown["rounds"].as_array().unwrap().iter();
    let jobs: usize = rounds.map(|round| round["jobs"].as_array().unwrap().len()).sum();
    assert!(jobs > 20, "{jobs}");
    assert!(shown["explanation"]["stability"]["reserves"].is_array());
    let words = text(&command(&["record", "show", path(&file)]).stdout);
    for said in ["build", "policy", "jobs", "answer    complete", "before"] {
        assert!(words.contains(said), "{said}: {words}");
    }
    assert!(words.lines().all(|line| line.chars().count() <= 140), "{words}");
}

// verifies REQ-RECORD
#[test]
fn each_of_1000_changed_bytes_is_found_and_the_file_named() {
    let place = Place::new();
    let records = recorded(&place, &[&["--in-process", "--depth", "2"], &["--in-process"]]);
    let file = records.join("000001.record");
    let good = std::fs::read(&file).unwrap();
    let mut state = 5;
    let mut draw = |below: u64| {
        state = geometry::hash::splitmix64(state);
        state % below
    };
    for _ in 0..1000 {
        let (at, flip) = (draw(good.len() as u64) as usize, 1 + draw(255) as u8);
        let mut bad = good.clone();
        bad[at] ^= flip;
        std::fs::write(&file, &bad).unwrap();
        let output = command(&["record", "verify", path(&records)]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "byte {at}: {error}");
        assert!(error.contains("000001.record") && error.contains("help"), "{error}");
    }
    std::fs::write(&file, &good).unwrap();
    assert!(command(&["record", "verify", path(&records)]).status.success());
}

// verifies REQ-VERSIONS
#[test]
fn what_is_cut_foreign_of_another_version_or_removed_is_told_apart() {
    let place = Place::new();
    let records = recorded(&place, &[&["--in-process"][..]; 3]);
    let file = records.join("000001.record");
    let good = std::fs::read(&file).unwrap();
    let third = std::fs::read(records.join("000002.record")).unwrap();
    let newer = [&good[..8], &[99, 0, 0, 0], &good[12..]].concat();
    let older = [&good[..8], &[5, 0, 0, 0], &good[12..]].concat();
    let cases: [(&[u8], &str); 5] = [
        (&good[..good.len() / 2], "was cut"),
        (b"", "not a decision record"),
        (b"hello", "not a decision record"),
        (&newer, "version 99"),
        (&older, "version 5"),
    ];
    for (bytes, says) in cases {
        std::fs::write(&file, bytes).unwrap();
        for args in [
            &["record", "verify", path(&records)][..],
            &["record", "show", path(&file)],
            &["record", "replay", path(&file)],
        ] {
            let output = command(args);
            let error = text(&output.stderr);
            assert_eq!(output.status.code(), Some(65), "{args:?}: {error}");
            assert!(error.contains("000001.record") && error.contains(says), "{args:?}: {error}");
        }
    }
    // Nothing is added to a chain whose end cannot be read.
    std::fs::write(records.join("000002.record"), b"hello").unwrap();
    let scenario = place.path().join("ways.toml");
    let output = run(&["rank", path(&scenario), "--in-process", "--record", path(&records)]);
    let error = text(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(65), true), "{error}");
    assert!(error.contains("000002.record"), "{error}");
    let file_in_the_way = run(&["rank", path(&scenario), "--record", path(&scenario)]);
    assert_eq!(file_in_the_way.status.code(), Some(71));
    std::fs::write(records.join("000002.record"), &third).unwrap();
    std::fs::remove_file(&file).unwrap();
    let output = command(&["record", "verify", path(&records)]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(65), "{error}");
    assert!(error.contains("number 2") && error.contains("1 should come"), "{error}");
}

/// A record that was changed and hashed again is intact as a file: its inputs are compared, too.
#[test]
fn a_replay_is_of_the_recorded_inputs_alone() {
    let place = Place::new();
    let records = recorded(&place, &[&["--in-process", "--depth", "2"]]);
    let file = records.join("000000.record");
    let good = trolley::Record::read(&file).unwrap();
    let models = Some(place.path());
    let replayed = |record: &trolley::Record| record.replay(&file, models, trolley::bodies::SILENT);
    assert_eq!(replayed(&good).unwrap().json, good.content.answer);
    let slower = |text: &mut String| *text = text.replacen("[13, ", "[12, ", 1);
    type Change<'c> = (&'c str, &'c dyn Fn(&mut trolley::record::RecordContent));
    let changes: [Change<'_>; 5] = [
        ("the scenario in it is not the one", &|content| slower(&mut content.scenario.text)),
        ("the policy in it is not the one", &|content| content.policy.text.push('\n')),
        ("the set of curves in it is not the one", &|content| content.curves.text.push('\n')),
        ("it holds the bodies of", &|content| drop(content.bodies.pop())),
        ("it holds the bodies of", &|content| content.bodies[1].party = "p9".into()),
    ];
    for (says, change) in changes {
        let mut changed = good.clone();
        change(&mut changed.content);
        assert_ne!(changed.content, good.content, "{says}");
        let failure = replayed(&changed).unwrap_err();
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
        assert!(failure.what().contains("000000.record"), "{failure}");
        assert_eq!(failure.kind().exit_code(), 65);
    }
    // Files that are named to be compared.
    let scenario = place.path().join("ways.toml");
    let replay = |scenario: &Path| {
        let models = path(place.path());
        let args = ["record", "replay", path(&file), "--models", models, "--scenario"];
        command(&[&args[..], &[path(scenario)]].concat())
    };
    let output = replay(&scenario);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut other = std::fs::read_to_string(&scenario).unwrap();
    slower(&mut other);
    let refused = |scenario: &Path, says: &str| {
        let output = replay(scenario);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(65), "{error}");
        assert!(error.contains(says) && error.contains("000000.record"), "{error}");
        assert!(error.contains("help: name the file that was ranked"), "{error}");
    };
    refused(&place.write("slower.toml", &other), "slower.toml is not the one of");
    let suv = place.path().join("suv.trolley");
    let args = ["model", "generate", "suv", "--triangles", "600", "-o", path(&suv)];
    std::fs::copy(&suv, place.path().join("kept.trolley")).unwrap();
    std::fs::remove_file(&suv).unwrap();
    assert!(command(&args).status.success());
    refused(&scenario, "suv.trolley is not the one of");
}
