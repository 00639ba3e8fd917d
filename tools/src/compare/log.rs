//! What was measured: every line that a driver printed, and medians over the rounds.

use super::row::{Row, Section};
use anyhow::Result;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;

/// A driver's line. Times are medians within its run, in milliseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    pub(crate) peer: String,
    /// Building both trees.
    pub(crate) build_ms: f64,
    /// What a new pose costs before it can be queried.
    pub(crate) pose_ms: f64,
    /// A query.
    pub(crate) query_ms: f64,
    /// What was asked, for those that can be asked more than all pairs.
    #[serde(default = "pairs")]
    pub(crate) question: String,
    #[serde(default)]
    pub(crate) pairs: u64,
    #[serde(default)]
    pub(crate) hash: String,
    #[serde(default)]
    pub(crate) nb: u64,
    #[serde(default)]
    pub(crate) np: u64,
    /// How many triangles of A and of B are hit, and the hashes of these sets, if they are known.
    pub(crate) hits_a: Option<u64>,
    pub(crate) hits_b: Option<u64>,
    pub(crate) hash_a: Option<String>,
    pub(crate) hash_b: Option<String>,
}

fn pairs() -> String {
    "pairs".into()
}

impl Measured {
    /// Whether this is the answer to its question, if `truth` is all there is to know.
    pub(crate) fn agrees(&self, truth: &Self) -> bool {
        match self.question.as_str() {
            "touches" => self.pairs == u64::from(truth.pairs > 0),
            "sets" => self.hits_a.is_some() && self.sets() == truth.sets(),
            _ => (self.pairs, &self.hash) == (truth.pairs, &truth.hash),
        }
    }

    fn sets(&self) -> (Option<u64>, Option<u64>, &Option<String>, &Option<String>) {
        (self.hits_a, self.hits_b, &self.hash_a, &self.hash_b)
    }
}

/// All runs.
#[derive(Debug, Default)]
pub(crate) struct Log(Vec<Run>);

#[derive(Debug)]
struct Run {
    section: Section,
    row: String,
    case: String,
    round: u32,
    measured: Measured,
}

impl Log {
    pub(crate) fn add(&mut self, row: &Row, case: &str, round: u32, measured: Measured) {
        let (section, row) = row.key();
        self.0.push(Run { section, row, case: case.to_owned(), round, measured });
    }

    /// The medians of a row on a case over all rounds, with the last answer; `None` without any.
    pub(crate) fn median(&self, row: &Row, case: &str) -> Option<Measured> {
        let key = row.key();
        let runs: Vec<&Measured> = self
            .0
            .iter()
            .filter(|run| (run.section, &run.row) == (key.0, &key.1) && run.case == case)
            .map(|run| &run.measured)
            .collect();
        let median_of =
            |time: fn(&Measured) -> f64| median(runs.iter().map(|run| time(run)).collect());
        Some(Measured {
            build_ms: median_of(|run| run.build_ms),
            pose_ms: median_of(|run| run.pose_ms),
            query_ms: median_of(|run| run.query_ms),
            ..(*runs.last()?).clone()
        })
    }

    /// One line of JSON for the machine, one per exact answer, one per run.
    pub(crate) fn lines(
        &self,
        machine: &[(&str, String)],
        truths: &BTreeMap<String, Measured>,
    ) -> Result<String> {
        let machine: BTreeMap<_, _> = machine.iter().cloned().collect();
        let mut lines = vec![json!({ "machine": machine })];
        lines.extend(truths.iter().map(|(case, truth)| json!({ "case": case, "exact": truth })));
        lines.extend(self.0.iter().map(|Run { section, row, case, round, measured }| {
            json!({
                "section": section.name(),
                "row": row,
                "case": case,
                "round": round,
                "measured": measured,
            })
        }));
        Ok(lines.iter().map(|line| format!("{line}\n")).collect())
    }
}

/// The middle one; of an even number the upper of the two. NaN for none.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
