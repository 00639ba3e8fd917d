//! `cargo x needs`: the tables of `tools/safety` as `needs.json`, which sphinx-needs imports.

use anyhow::{Context as _, Result};
use check::built::{CargoWorkspace, write};
use check::safety::not_run;
use clap::Args;
use serde_json::{Map, Value, json};
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// Where it is written.
#[derive(Debug, Args)]
pub(crate) struct Options {
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
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
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
