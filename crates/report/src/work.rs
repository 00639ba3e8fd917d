//! How the work was done, from a run or from its record, for engineers.

use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use trolley::record::{RecordedEnd, hex};
use trolley::{Record, Run};

/// What engineers ask.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct WorkDone {
    /// Stages and their times (ms).
    pub stages: Vec<(String, f64)>,
    /// What each worker did; empty without workers.
    pub workers: Vec<Worker>,
    /// Bytes by edge: from, to, messages, bytes.
    pub edges: Vec<(String, String, u64, u64)>,
    /// Names and values: build, jobs, hashes.
    pub facts: Vec<(String, String)>,
    /// What could be better and who was lost, as sentences without full stops.
    pub remarks: Vec<String>,
}

/// What one worker did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Worker {
    /// Its name.
    pub name: String,
    /// Its jobs.
    pub spans: Vec<TimelineSpan>,
}

/// One job on a worker (ms, from the start of the first).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct TimelineSpan {
    /// When it began.
    pub from_ms: f64,
    /// When its result was received.
    pub to_ms: f64,
}

fn fact(name: &str, value: impl Into<String>) -> (String, String) {
    (name.to_owned(), value.into())
}

impl WorkDone {
    /// Of a ranking that was just made.
    #[must_use]
    pub fn of_run(run: &Run) -> Self {
        let s = &run.stages;
        let stages = [
            ("load", s.load_ms),
            ("contacts", s.plan_ms),
            ("start", s.start_ms),
            ("surveys", s.work_ms),
            ("judge", s.assess_ms),
        ];
        let counts = format!(
            "{} done, {} not needed, {} given up, in {} rounds of contacts",
            run.jobs, run.jobs_cut, run.jobs_abandoned, run.rounds
        );
        let transfer = format!("{} messages, {} bytes", run.messages, run.message_bytes);
        Self {
            stages: stages.map(|(name, ms)| (name.to_owned(), ms)).to_vec(),
            facts: vec![fact("build", run.build), fact("jobs", counts), fact("transfer", transfer)],
            remarks: run.remarks.clone(),
            ..Self::default()
        }
    }

    /// Of a recorded ranking.
    #[must_use]
    pub fn of_record(record: &Record) -> Self {
        let Record { content: record, link, .. } = record;
        let count = |end: RecordedEnd| record.all_jobs().filter(|job| job.end == end).count();
        let mut workers: BTreeMap<u8, Vec<TimelineSpan>> = BTreeMap::new();
        for span in &record.spans {
            let (from_ms, to_ms) = (span.from_ns as f64 / 1e6, span.to_ns as f64 / 1e6);
            workers.entry(span.worker).or_default().push(TimelineSpan { from_ms, to_ms });
        }
        let s = &record.settings;
        let mut facts = vec![
            fact("record", format!("{} of its chain, {}", link.number, hex(&link.hash))),
            fact("after", hex(&link.previous)),
            fact("build", record.build.clone()),
            fact("scenario", format!("{} {}", record.scenario.name, record.scenario.hash)),
            fact("policy", format!("{} {}", record.policy.name, record.policy.hash)),
            fact("curves", format!("{} {}", record.curves.name, record.curves.hash)),
            fact("parameters", format!("{} {}", record.parameters.name, record.parameters.hash)),
            fact(
                "settings",
                format!(
                    "{}, {} workers, depth {}, tree {}, {}, batch {}, queue {}, seed {}",
                    s.mode.name(),
                    s.workers,
                    s.depth,
                    s.tree.name(),
                    s.scheme.name(),
                    s.batch,
                    s.queue,
                    s.seed
                ),
            ),
            fact(
                "jobs",
                format!(
                    "{} done, {} not needed, {} given up, in {} rounds of contacts",
                    count(RecordedEnd::Done),
                    count(RecordedEnd::Cut),
                    count(RecordedEnd::Abandoned),
                    record.rounds.len()
                ),
            ),
        ];
        let bodies = record.bodies.iter();
        facts.extend(bodies.map(|body| fact(&format!("body {}", body.party), body.hash.clone())));
        let name = |worker: u8| format!("worker {worker}");
        let edges = record.edges.iter();
        Self {
            stages: record.stages.iter().map(|stage| (stage.name.clone(), stage.ms)).collect(),
            workers: workers
                .into_iter()
                .map(|(worker, spans)| Worker { name: name(worker), spans })
                .collect(),
            edges: edges
                .map(|edge| (edge.from.clone(), edge.to.clone(), edge.messages, edge.bytes))
                .collect(),
            facts,
            remarks: record.faults.clone(),
        }
    }
}
