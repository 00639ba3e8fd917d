//! The page: computed beside measured, and what is bound how.

use super::service::Measured;
use crate::machine;
use anyhow::Result;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

/// What a reader must know of the figures.
const NOTES: &str = include_str!("notes.md");

/// Everything that is on it.
#[derive(Debug)]
pub(super) struct Page<'p> {
    pub(super) root: &'p Path,
    /// What the program that was measured says of itself.
    pub(super) version: String,
    pub(super) shipped: Vec<(&'static str, Value)>,
    pub(super) services: Vec<Measured>,
    pub(super) campaign: Value,
}

/// A row of a service: what, computed, measured.
type Row = (String, u64, u64);

impl Page<'_> {
    /// Whether nothing that was measured exceeds what was computed.
    pub(super) fn is_well(&self) -> bool {
        let sizes = self.services.iter().flat_map(rows);
        let times = times(&self.campaign);
        sizes.into_iter().all(|(_, computed, measured)| measured <= computed)
            && times.iter().all(|(_, bound, measured)| {
                bound.zip(*measured).is_none_or(|(bound, measured)| measured <= bound)
            })
    }

    /// The page.
    pub(super) fn text(&self) -> Result<String> {
        let mut text = String::from(
            "# Bounds: memory, descriptors, threads and times of a deployment\n\n\
             Written by `cargo x bounds`. The machine does other work too.\n\n| | |\n|---|---|\n",
        );
        for (name, value) in machine::describe(self.root)? {
            writeln!(text, "| {name} | {value} |")?;
        }
        writeln!(text, "| program | {} |", self.version)?;
        writeln!(
            text,
            "\n## Deployments that ship\n\nComputed by `trolley doctor --deployment FILE.toml`: \
             what does not depend on program and machine (bytes).\n\n\
             | deployment | descriptors | heap of a request | files of the folder | without a name \
             | segments |\n|---|--:|--:|--:|--:|--:|"
        )?;
        for (name, found) in &self.shipped {
            let of = &found["footprint"];
            let (descriptors, request) = (&of["processes"][0]["descriptors"], &of["request_bytes"]);
            let (folder, unnamed) = (&of["folder_bytes"], &of["unnamed_bytes"]);
            writeln!(
                text,
                "| {name} | {descriptors} | {request} | {folder} | {unnamed} | {} |",
                of["segments"]
            )?;
        }
        text += "\n## Services at their limits\n\nSixteen clients and sixteen listeners at a time; \
                 a request has 16 candidates, 32 parties and\n6,976 states. *Own* is what is \
                 resident but for the program. MiB.\n\n\
                 | service | what | computed | measured | ratio |\n|---|---|--:|--:|--:|\n";
        for measured in &self.services {
            for (what, computed, taken) in rows(measured) {
                let is_bytes = what.contains("MiB");
                let shown = |value: u64| match is_bytes {
                    true => format!("{:.1}", value as f64 / f64::from(1 << 20)),
                    false => value.to_string(),
                };
                let ratio = computed as f64 / taken.max(1) as f64;
                let (computed, taken) = (shown(computed), shown(taken));
                let name = measured.case.name;
                writeln!(text, "| {name} | {what} | {computed} | {taken} | {ratio:.2} |")?;
            }
        }
        text += "\n## A request from the heap\n\nA small crash asked again and again: \
                 two candidates, one other party.\n\n\
                 | service | requests | allocations of one | messages of one \
                 | page faults of all |\n\
                 |---|--:|--:|--:|--:|\n";
        for measured in &self.services {
            let small = &measured.small;
            let requests = measured.small_requests.max(1);
            let messages = small["messages"].as_u64().unwrap_or(0) / requests;
            let (name, faults) = (measured.case.name, &small["page_faults"]);
            let allocations = &small["allocations"];
            writeln!(text, "| {name} | {requests} | {allocations} | {messages} | {faults} |")?;
        }
        self.campaign(&mut text)?;
        text += "\n";
        text += NOTES;
        Ok(text)
    }

    fn campaign(&self, text: &mut String) -> Result<()> {
        let costs = &self.campaign["costs"];
        let number = |value: &Value| value.as_u64().unwrap_or(0);
        writeln!(
            text,
            "\n## Times: a measured bound, not WCET\n\n\
             `trolley doctor --deployment config/deployments/dual-core.toml --jobs {jobs}`: {jobs} \
             jobs that are made to be\ndear, on {threads} threads at a time. µs of CPU time; a \
             bound is the budget × the dearest test, which took {test:.1} ns,\nand {start:.1} µs \
             to begin a job.\n\n| what | bound | measured |\n|---|--:|--:|",
            jobs = number(&costs["jobs"]),
            threads = number(&costs["threads"]),
            test = costs["test_ns"].as_f64().unwrap_or(f64::NAN),
            start = number(&costs["start_ns"]) as f64 / 1e3,
        )?;
        let shown =
            |ns: &Option<u64>| ns.map_or("–".to_owned(), |ns| format!("{:.1}", ns as f64 / 1e3));
        for (what, bound, measured) in times(&self.campaign) {
            writeln!(text, "| {what} | {} | {} |", shown(&bound), shown(&measured))?;
        }
        text.push_str(
            "\n| jobs by what makes them dear | jobs | spent, millions | dearest test, ns \
             | longest job, µs | on the clock | between beats | of a look |\n\
             |---|--:|--:|--:|--:|--:|--:|--:|\n",
        );
        for kind in costs["kinds"].as_array().into_iter().flatten() {
            let us = |key: &str| format!("{:.1}", number(&kind[key]) as f64 / 1e3);
            writeln!(
                text,
                "| {} | {} | {} | {:.1} | {} | {} | {} | {} |",
                kind["kind"].as_str().unwrap_or_default(),
                number(&kind["jobs"]),
                number(&kind["spent"]) / 1_000_000,
                kind["test_ns"].as_f64().unwrap_or(f64::NAN),
                us("job_ns"),
                us("job_wall_ns"),
                us("gap_ns"),
                us("look_gap_ns"),
            )?;
        }
        Ok(())
    }
}

/// What is bound by a computation, of one service.
fn rows(measured: &Measured) -> Vec<Row> {
    let footprint = &measured.computed["footprint"];
    let mut rows = Vec::new();
    for (number, taken) in [measured.service, measured.worker].iter().enumerate() {
        let bound = &footprint["processes"][number];
        let Some(process) = bound["process"].as_str() else { continue };
        for (what, key, taken) in [
            ("own, MiB", "own_bytes", taken.own_bytes),
            ("program, MiB", "program_bytes", taken.program_bytes),
            ("descriptors", "descriptors", taken.descriptors),
            ("threads", "threads", taken.threads),
        ] {
            rows.push((format!("{process}: {what}"), bound[key].as_u64().unwrap_or(0), taken));
        }
    }
    let computed = |key: &str| footprint[key].as_u64().unwrap_or(0);
    rows.push(("folder, MiB".to_owned(), computed("folder_bytes"), measured.bytes));
    rows.push(("segments".to_owned(), computed("segments"), measured.segments));
    rows
}

/// The rows of times: what, bound, measured (ns).
fn times(campaign: &Value) -> Vec<(String, Option<u64>, Option<u64>)> {
    let row = |row: &Value| {
        let what = row["what"].as_str().unwrap_or_default().to_owned();
        (what, row["bound_ns"].as_u64(), row["measured_ns"].as_u64())
    };
    campaign["times"].as_array().into_iter().flatten().map(row).collect()
}
