//! Bad input: each kind gives an error with file, place, remedy and exit code, and leaves nothing
//! behind.

use crate::support::{self, Place, builder, overrides, run, text, ways};
use trolley::dispatch_options::{DispatchOptions, TransferMode};
use trolley::{FailureKind, Limits, Scenario};

struct Bad {
    /// What is replaced in a good scenario, and by what.
    change: (&'static str, &'static str),
    /// What the error must say.
    says: &'static [&'static str],
    code: i32,
}

const BAD: &[Bad] = &[
    Bad {
        change: ("[parties.ego]", "colour = \"red\"\n[parties.ego]"),
        says: &["bad.toml:5:", "colour", "help"],
        code: 65,
    },
    Bad {
        change: ("[parties.suv]", "[parties.suv]\nmass_kg = -5"),
        says: &["bad.toml:", "mass_kg", "help"],
        code: 65,
    },
    Bad {
        change: ("[parties.ego]", "deadline_ms = -1\n[parties.ego]"),
        says: &["bad.toml:5:", "deadline_ms", "help"],
        code: 65,
    },
    Bad {
        change: (
            "name = \"way 0\"",
            "name = \"way 0\"\nreactions = { suvv = { place = { position_m = [25, 0, 0] } } }",
        ),
        says: &["bad.toml:", "\"suvv\" is not defined", "Did you mean \"suv\"?"],
        code: 65,
    },
    Bad {
        change: ("[parties.ego]", "policy = \"no-such.toml\"\n[parties.ego]"),
        says: &["bad.toml:5:", "no-such.toml"],
        code: 65,
    },
    Bad {
        change: ("generate = { shape = \"suv\", triangles = 600 }", "file = \"no.trolley\""),
        says: &["bad.toml:", "no.trolley", "help"],
        code: 65,
    },
    Bad {
        change: ("generate = { shape = \"suv\", triangles = 600 }", "file = \"bad.toml\""),
        says: &["bad.toml", "not a model file", "trolley model import"],
        code: 65,
    },
    Bad { change: ("triangles = 600", "triangles = 6"), says: &["bad.toml:6:", "6"], code: 65 },
    Bad { change: ("yaw_deg = 180.0", "yaw_deg = nan"), says: &["bad.toml:"], code: 65 },
    Bad {
        change: ("trolley.scenario/2", "trolley.scenario/1"),
        says: &["bad.toml:1:", "trolley.scenario/1", "contacts are found"],
        code: 65,
    },
    Bad { change: ("schema = ", "schema ="), says: &[], code: 0 },
];

#[test]
fn each_fault_of_a_scenario_is_named_with_its_place_and_remedy() {
    let place = Place::new();
    let good = ways(600);
    for Bad { change: (from, to), says, code } in BAD {
        assert!(good.contains(from), "{from}");
        let path = place.write("bad.toml", &good.replacen(from, to, 1));
        let output = run(&["rank", path.to_str().unwrap(), "--workers", "1"]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(*code), "{to}: {error}");
        for part in *says {
            assert!(error.contains(part), "{to}: \"{part}\" is not said by: {error}");
        }
        assert_eq!(output.stdout.is_empty(), *code != 0, "{to}");
    }
}

#[test]
fn a_scenario_without_candidates_is_refused() {
    let place = Place::new();
    let good = ways(600);
    let head = &good[..good.find("\n[[candidates]]").unwrap()];
    let path = place.write("none.toml", head);
    let output = run(&["rank", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(65));
    assert!(text(&output.stderr).contains("candidate"), "{}", text(&output.stderr));
}

#[test]
fn settings_on_the_command_line_obey_the_same_rules() {
    let place = Place::new();
    let path = place.write("ways.toml", &ways(600));
    let path = path.to_str().unwrap();
    for (args, says) in [
        (&["--workers", "0"][..], "workers"),
        (&["--workers", "17"], "workers"),
        (&["--depth", "99"], "depth"),
        (&["--batch", "0"], "batch"),
        (&["--batch", "64", "--queue", "8"], "queue"),
        (&["--build", "magic"], "build"),
        (&["--queue", "0"], "queue"),
        (&["--cores", "0,x", "--workers", "2"], "cores"),
        (&["--cores", "0,900", "--workers", "2"], "core"),
    ] {
        let mut all = vec!["rank", path];
        all.extend(args);
        let output = run(&all);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(78), "{args:?}: {error}");
        assert!(error.contains(says) && error.contains("help:"), "{args:?}: {error}");
    }
}

#[test]
fn how_jobs_are_handed_out_obeys_rules_too() {
    let place = Place::new();
    let scenario = Scenario::open(place.write("ways.toml", &ways(600))).unwrap();
    let copy = DispatchOptions { transfer: TransferMode::Copy, ..DispatchOptions::default() };
    let none = DispatchOptions::default();
    for (dispatch_options, says) in [
        (DispatchOptions { linger_us: 20_000, ..none }, "linger"),
        (DispatchOptions { cache_bytes: Some(1000), ..none }, "cache-bytes"),
        (DispatchOptions { memory_budget: Some(99_999_999), ..none }, "memory-budget"),
        (DispatchOptions { memory_budget: Some(1000), ..copy }, "memory-budget"),
        (DispatchOptions { cache_bytes: Some(99_999_999), ..copy }, "cache-bytes"),
    ] {
        let mut engine = builder().workers(1).dispatch_options(dispatch_options).build().unwrap();
        let failure = engine.rank(&scenario, &Limits::default()).unwrap_err();
        assert_eq!(failure.kind(), FailureKind::Configuration, "{failure}");
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
    }
    for (change, says) in [
        (overrides(|all| all.alpha = Some(2.0)), "alpha"),
        (overrides(|all| all.scheme = Some("worst-match".to_owned())), "scheme"),
    ] {
        let failure = builder().overrides(change).build().unwrap_err();
        assert_eq!(failure.kind(), FailureKind::Configuration, "{failure}");
        assert!(failure.what().contains(says) && failure.remedy().is_some(), "{failure}");
    }
}

#[test]
fn a_copy_that_does_not_fit_ends_the_run_and_says_why() {
    let place = Place::new();
    let scenario = Scenario::open(place.write("ways.toml", &ways(2000))).unwrap();
    // Capacity for the largest section at this depth, but not for all that one worker needs.
    let dispatch_options = DispatchOptions {
        transfer: TransferMode::Copy,
        memory_budget: Some(90_000),
        ..DispatchOptions::default()
    };
    let mut engine =
        builder().workers(1).depth(6).dispatch_options(dispatch_options).build().unwrap();
    let failure = engine.rank(&scenario, &Limits::default()).unwrap_err();
    assert_eq!(failure.kind(), FailureKind::Resources, "{failure}");
    let what = failure.what();
    assert!(what.contains("thrashed: worker 0 holds") && what.contains("of 90000"), "{what}");
    assert!(failure.remedy().is_some());
}

#[test]
fn a_missing_file_a_folder_and_a_bad_instance_name_are_errors() {
    let place = Place::new();
    let folder = place.path().to_str().unwrap();
    for path in [folder.to_owned(), format!("{folder}/no.toml")] {
        let output = run(&["rank", &path]);
        assert_eq!(output.status.code(), Some(65), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains(&path));
    }
    let scenario = place.write("ways.toml", &ways(600));
    let output = support::trolley()
        .args(["rank", scenario.to_str().unwrap(), "--instance", "../../evil"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(78), "{}", text(&output.stderr));
}

#[test]
fn a_worker_is_not_started_by_hand() {
    let output = support::trolley().args(["worker", "nonsense"]).output().unwrap();
    assert_eq!(output.status.code(), Some(78));
    assert!(text(&output.stderr).contains("coordinator"), "{}", text(&output.stderr));
}

#[test]
fn bodies_that_overlap_from_the_start_are_not_called_free_of_contact() {
    let place = Place::new();
    let good = ways(600);
    let first = good.find("[parties.cyclist]").unwrap();
    let text_ = format!(
        "{}[parties.suv]\ngenerate = {{ shape = \"suv\", triangles = 600 }}\n\
         place = {{ position_m = [0.1, 0, 0] }}\n\
         [[candidates]]\nname = \"stand\"\n\
         state = {{ position_m = [0, 0, 0], speed_m_s = 0 }}\n\
         [[candidates]]\nname = \"go\"\nstate = {{ position_m = [0, 0, 0], speed_m_s = 9 }}\n",
        &good[..first]
    );
    let path = place.write("overlap.toml", &text_);
    let output = run(&["rank", path.to_str().unwrap(), "--json", "--workers", "1"]);
    let document = support::json(&output);
    let rows = document["answer"]["ranking"].as_array().unwrap();
    // Who drives on does not come out of nothing either.
    let go = rows.iter().find(|row| row["name"] == "go").unwrap();
    let is_told = !go["contacts"].as_array().unwrap().is_empty()
        || !go["parts_from"].as_array().unwrap().is_empty();
    assert!(is_told, "{go}");
    let row = rows.iter().find(|row| row["name"] == "stand").unwrap();
    assert_eq!(row["contacts"][0]["unevaluable"], "already-overlapping");
    for person in row["persons"].as_array().unwrap() {
        assert_eq!((&person["work"][0], &person["work"][1]), (&0.0.into(), &1.0.into()), "{row}");
    }
    assert_ne!(output.status.code(), Some(0), "an answer with a hole in it is not complete");
}
