//! `trolley record show`: the contents of a record, as text or as JSON.

use crate::output::Output;
use crate::print;
use crate::record::stated::Stated;
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;
use trolley::record::{Link, RecordContent, RecordedEnd, RecordedSource, SignedStatement, hex};
use trolley::{Failure, Record};

pub(super) fn run(path: &Path, output: &Output) -> Result<ExitCode, Failure> {
    let Record { content: record, link, statement } = Record::read(path)?;
    let statement = statement.as_ref();
    let answer = parsed(&record.answer)?;
    if output.json {
        let explanation = parsed(&record.explanation)?;
        let mut document =
            serde_json::to_value(&record).map_err(|error| Failure::internal(error.to_string()))?;
        document["schema"] = json!("trolley.record/2");
        document["number"] = json!(link.number);
        document["previous"] = json!(hex(&link.previous));
        document["hash"] = json!(hex(&link.hash));
        document["signed"] = json!(statement.map(Stated::of));
        document["answer"] = answer;
        document["explanation"] = explanation;
        return print::out(&print::json(&document)?);
    }
    print::text(&words(path, &record, &link, statement, &answer))
}

fn parsed(text: &str) -> Result<Value, Failure> {
    serde_json::from_str(text).map_err(|error| Failure::internal(error.to_string()))
}

fn words(
    path: &Path,
    record: &RecordContent,
    link: &Link,
    statement: Option<&SignedStatement>,
    answer: &Value,
) -> String {
    let s = &record.settings;
    let count = |end: RecordedEnd| record.all_jobs().filter(|job| job.end == end).count();
    let ms: f64 = record.stages.iter().map(|stage| stage.ms).sum();
    let mut lines = vec![
        format!(
            "{}: record {} of its chain, hash {}",
            path.display(),
            link.number,
            hex(&link.hash)
        ),
        format!("after {}", hex(&link.previous)),
        match statement.map(Stated::of) {
            None => "signed    no".to_owned(),
            Some(stated) => format!(
                "signed    {stated}, with the key {}; `record verify --key` checks whose it is",
                stated.key
            ),
        },
        format!("build     {}", record.build),
        format!("scenario  {} ({})", record.scenario.name, record.scenario.hash),
        format!("policy    {} ({})", record.policy.name, record.policy.hash),
        format!("curves    {} ({})", record.curves.name, record.curves.hash),
        format!("parameters {} ({})", record.parameters.name, record.parameters.hash),
    ];
    lines
        .extend(record.files.iter().map(|file| format!("path      {} ({})", file.name, file.hash)));
    lines.extend([format!(
        "settings  {}, {} workers, depth {}, tree {}, leaves of {}, {} (alpha {}), batch {}, \
             queue {}, seed {}",
        s.mode.name(),
        s.workers,
        s.depth,
        s.tree.name(),
        s.leaf_size,
        s.scheme.name(),
        s.alpha,
        s.batch,
        s.queue,
        s.seed
    )]);
    for body in &record.bodies {
        let source = match &body.source {
            RecordedSource::Generated => "generated".to_owned(),
            RecordedSource::File { path, hash } => format!("{path} ({hash})"),
        };
        lines.push(format!("body      {}: {source}; with its tree {}", body.party, body.hash));
    }
    lines.push(format!(
        "jobs      {} done, {} not needed, {} given up; {ms:.1} ms in all",
        count(RecordedEnd::Done),
        count(RecordedEnd::Cut),
        count(RecordedEnd::Abandoned)
    ));
    if !record.rounds.is_empty() {
        lines.push(format!("rounds    {} of contacts", record.rounds.len()));
    }
    if !record.open_steps.is_empty() {
        lines.push(format!("search    steps not done: {}", record.open_steps.len()));
    }
    if let Some(over_at) = record.search.and_then(|search| search.over_at) {
        lines.push(format!("search    out of time at point {over_at} between jobs"));
    }
    lines.extend(record.faults.iter().map(|fault| format!("note      {fault}")));
    let state = answer["state"].as_str().unwrap_or_default();
    lines.push(format!("answer    {state}"));
    for (at, row) in answer["ranking"].as_array().into_iter().flatten().enumerate() {
        let name = row["name"].as_str().unwrap_or_default();
        lines.push(format!("  {} {name}: {} in {}", at + 1, row["work"], row["range"]));
        lines.extend(row["why"].as_str().map(|why| format!("    {why}")));
    }
    lines.join("\n")
}
