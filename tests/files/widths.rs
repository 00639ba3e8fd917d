//! What a person reads fits a terminal of 60 columns and more: no line is longer, and no number is
//! cut.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::support::service::{deployment, of_ways, serve};
use crate::support::{Place, skipped, text, trolley, ways};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// What a command prints on a terminal of this width.
fn printed(args: &[&str], columns: usize) -> String {
    let output = trolley().args(args).env("COLUMNS", columns.to_string()).output().unwrap();
    let said = text(&output.stdout);
    assert!(!said.is_empty(), "{args:?}: {}", text(&output.stderr));
    said
}

/// The words of a text that have a digit in them, but for those that a run has for itself.
fn numbers(said: &str) -> BTreeSet<String> {
    let is_number = |word: &&str| word.contains(|c: char| c.is_ascii_digit());
    said.split_whitespace().filter(is_number).map(str::to_owned).collect()
}

/// Checks that no line is longer than the terminal is wide, but for one that is a single long word:
/// a path or a hash, which is not broken.
fn assert_fits(said: &str, columns: usize, what: &str) {
    for line in said.lines().filter(|line| line.chars().count() > columns) {
        let longest = line.split_whitespace().map(|word| word.chars().count()).max();
        assert!(longest.unwrap_or(0) > columns / 2, "{what} at {columns}:\n{line}\nin\n{said}");
    }
}

/// Checks a command whose text is the same each time but for its width.
fn check(args: &[&str]) {
    let (narrow, usual) = (printed(args, 60), printed(args, 100));
    for columns in [60, 80, 120] {
        assert_fits(&printed(args, columns), columns, &format!("{args:?}"));
    }
    let cut: Vec<String> = numbers(&narrow).difference(&numbers(&usual)).cloned().collect();
    // What is left out on a narrow terminal says how wide that is.
    let cut: Vec<&String> = cut.iter().filter(|word| *word != "60").collect();
    assert!(cut.is_empty(), "{args:?}: {cut:?} in\n{narrow}\nand not in\n{usual}");
}

#[test]
fn bodies_records_and_the_machine_fit() {
    let place = Place::new();
    let (model, records) = (place.path().join("suv.trolley"), place.path().join("records"));
    let [model, records] = [&model, &records].map(|path| path.to_str().unwrap());
    let scenario = place.write("ways.toml", &ways(600));
    let scenario = scenario.to_str().unwrap();
    printed(&["model", "generate", "suv", "--triangles", "1500", "-o", model], 60);
    let rank = ["rank", scenario, "--in-process", "--record", records];
    printed(&rank, 60);
    check(&["model", "info", model]);
    check(&[
        "model",
        "info",
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tests/data/hatchback.obj")
            .to_str()
            .unwrap(),
    ]);
    check(&["record", "show", &format!("{records}/000000.record")]);
    for columns in [60, 80, 120] {
        assert_fits(&printed(&["doctor"], columns), columns, "doctor");
    }
}

#[test]
fn rankings_and_explanations_fit() {
    let place = Place::new();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/scenarios");
    let file = place
        .write("ways.toml", &ways(600).replace("[parties.truck]", "[parties.truck]\nmass_kg = 25"));
    let crossing = shipped.join("crossing.toml");
    for file in [file.as_path(), crossing.as_path()] {
        for members in ["1", "8"] {
            let args =
                ["rank", file.to_str().unwrap(), "--in-process", "--explain", "--members", members];
            for columns in [60, 80, 120] {
                let said = printed(&args, columns);
                assert_fits(&said, columns, &format!("{args:?}"));
                let has_range = said.contains("range %\n") || said.contains("range % ");
                assert!(has_range || said.contains("Left out to fit"), "{said}");
            }
        }
    }
    let measure = ["measure", "--scenario", file.to_str().unwrap(), "--in-process"];
    for columns in [60, 80, 120] {
        assert_fits(&printed(&measure, columns), columns, "measure");
    }
}

#[test]
fn answers_of_a_service_fit() {
    let place = Place::new();
    let scenario = place.write("ways.toml", &ways(600));
    let serving = serve(&deployment(&place, 2, &of_ways(600)), &[]);
    for members in ["1", "4"] {
        for columns in [60, 80, 120] {
            let deployment = serving.deployment.to_str().unwrap();
            let args = [
                "query",
                deployment,
                scenario.to_str().unwrap(),
                "--instance",
                &serving.instance,
                "--deadline-ms",
                "20000",
                "--members",
                members,
            ];
            assert_fits(&printed(&args, columns), columns, "query");
            let args = ["top", deployment, "--instance", &serving.instance, "--times", "1"];
            assert_fits(&printed(&args, columns), columns, "top");
        }
    }
    serving.end();
}

/// A terminal is asked how wide it is.
#[test]
fn a_terminal_is_asked_for_its_width() {
    let program = env!("CARGO_BIN_EXE_trolley");
    let line = format!("stty cols 60 rows 24; exec '{program}' doctor");
    let mut command = Command::new("script");
    command.args(["-qec", &line, "/dev/null"]).env_remove("COLUMNS");
    let Ok(output) = command.stdin(std::process::Stdio::null()).output() else {
        return skipped("the width of a terminal: there is no script(1)");
    };
    let said = text(&output.stdout).replace('\r', "");
    assert!(said.contains("cores"), "{said}");
    assert_fits(&said, 60, "doctor");
    assert!(said.lines().any(|line| line.chars().count() > 40), "{said}");
    // And without one, lines are as long as they are.
    let piped = text(&trolley().arg("doctor").output().unwrap().stdout);
    assert!(piped.lines().any(|line| line.chars().count() > 100), "{piped}");
}
