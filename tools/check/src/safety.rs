//! `cargo x needs`: the tables of `tools/safety` as `needs.json`, which sphinx-needs imports.

use crate::built::{CargoWorkspace, write};
use anyhow::{Context as _, Result};
use clap::Args;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// Where it is written.
#[derive(Debug, Args)]
pub struct NeedsOptions {
    /// The file [default: needs.json in the target folder].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Output of `cargo test`: fails if a test that verifies a requirement did not run and pass.
    #[arg(long, value_name = "LOG")]
    ran: Option<PathBuf>,
}

/// Each table: its file, the key of its entries, and the type that they have among needs: those of
/// S-CORE's process for failure modes and assumptions.
const TABLES: [(&str, &str, &str); 3] = [
    ("requirements.toml", "requirement", "comp_req"),
    ("assumptions.toml", "assumption", "aou_req"),
    ("fmea.toml", "row", "comp_saf_fmea"),
];

/// Writes the file.
///
/// # Errors
///
/// If a table cannot be read, has an entry without an id, or the file cannot be written.
pub fn run(options: &NeedsOptions) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let version = env!("CARGO_PKG_VERSION");
    let mut needs = Map::new();
    for (file, key, kind) in TABLES {
        let path = workspace.root.join("tools/safety").join(file);
        let text = fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let table: toml::Table = toml::from_str(&text).with_context(|| file.to_owned())?;
        for entry in table[key].as_array().context("no list of tables")? {
            let need = need(entry, kind).with_context(|| format!("{file}: {entry}"))?;
            let id = need["id"].as_str().unwrap_or_default().to_owned();
            needs.insert(id, need);
        }
    }
    let count = needs.len();
    let document = json!({
        "project": "trolley",
        "current_version": version,
        "versions": { version: { "needs_amount": count, "needs": needs } },
    });
    let out = options.out.clone().unwrap_or_else(|| workspace.target.join("needs.json"));
    write(&out, &(serde_json::to_string_pretty(&document)? + "\n"))?;
    let Some(log) = &options.ran else { return Ok(ExitCode::SUCCESS) };
    let said = fs::read_to_string(log).with_context(|| log.display().to_string())?;
    let missing = not_run(&said)?;
    for test in &missing {
        writeln!(std::io::stderr(), "did not run and pass: {test}")?;
    }
    Ok(if missing.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

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

/// One entry, with the fields that its type has.
fn need(entry: &toml::Value, kind: &str) -> Result<Value> {
    let field = |key: &str| entry.get(key).and_then(toml::Value::as_str).unwrap_or_default();
    let list = |key: &str| {
        let list = entry.get(key).and_then(toml::Value::as_array);
        list.into_iter().flatten().filter_map(toml::Value::as_str).collect::<Vec<_>>()
    };
    anyhow::ensure!(!field("id").is_empty(), "has no id");
    let common = json!({ "id": field("id"), "type": kind, "status": "valid", "safety": "QM" });
    let own = match kind {
        "comp_saf_fmea" => json!({
            "title": format!("{}: {}", field("element"), field("mode")),
            "content": field("detection"),
            "fault_id": list("kinds").join(", "),
            "failure_effect": field("effect"),
            "mitigated_by": list("mitigated_by"),
            // Whether the measures suffice is for whoever has the whole vehicle to say.
            "sufficient": "no",
            "mitigation_issue": field("untried"),
            "violates": [],
        }),
        "aou_req" => json!({
            "title": field("text"),
            "content": field("doctor").to_owned() + field("test") + field("integrator"),
        }),
        _ => json!({
            "title": field("text"),
            "content": "",
            "testlink": list("tests").join(", "),
        }),
    };
    let mut all = common;
    if let (Some(all), Some(own)) = (all.as_object_mut(), own.as_object()) {
        all.extend(own.iter().map(|(key, value)| (key.clone(), value.clone())));
    }
    Ok(all)
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
