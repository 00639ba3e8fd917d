//! Whether the tests that requirements of `tools/safety` name ran and passed.

use crate::built::CargoWorkspace;
use anyhow::{Context as _, Result};
use std::collections::BTreeSet;
use std::fs;

/// The tests of requirements that did not pass in a run of which this is the output.
///
/// # Errors
///
/// If the table of requirements cannot be read.
pub fn not_run(said: &str) -> Result<Vec<String>> {
    let path = CargoWorkspace::find()?.root.join("tools/safety/requirements.toml");
    let table: toml::Table = toml::from_str(&fs::read_to_string(path)?)?;
    let passed = passed(said);
    let list = |entry: &toml::Value| entry["tests"].as_array().cloned().unwrap_or_default();
    let all = table["requirement"].as_array().context("no list of tables")?;
    let tests = all.iter().flat_map(list).filter_map(|test| Some(test.as_str()?.to_owned()));
    Ok(tests.filter(|test| !is_in(&passed, test)).collect())
}

/// The last words of the paths of tests that passed: `test a::b::name ... ok`.
fn passed(said: &str) -> BTreeSet<&str> {
    fn name(line: &str) -> Option<&str> {
        // The output of another test may stand before.
        let (_, rest) = line.strip_suffix(" ... ok")?.rsplit_once("test ")?;
        rest.rsplit("::").next()
    }
    said.lines().filter_map(name).collect()
}

/// Whether a test, as a requirement names it (`FILE::NAME`), is among those that passed.
fn is_in(passed: &BTreeSet<&str>, test: &str) -> bool {
    test.rsplit("::").next().is_some_and(|name| passed.contains(name))
}

#[cfg(test)]
mod tests {
    //! A test counts if it passed, not if it was ignored, failed or has another name.
    use super::*;

    #[test]
    fn only_tests_that_passed_count() {
        let said = "running 4 tests\ntest a::ran ... ok\ntest a::left ... ignored, why\n\
                    some words test b::c::late ... ok\ntest failed ... FAILED\n";
        let passed = passed(said);
        assert!(is_in(&passed, "x/y.rs::ran") && is_in(&passed, "z.rs::late"));
        assert!(["left", "failed", "an"].iter().all(|name| !is_in(&passed, name)));
        let missing = not_run(said).unwrap();
        assert!(missing.len() > 30, "{missing:?}");
        let all: String = missing
            .iter()
            .map(|test| format!("test m::{} ... ok\n", test.rsplit("::").next().unwrap()))
            .collect();
        assert_eq!(not_run(&all).unwrap(), Vec::<String>::new());
    }
}
