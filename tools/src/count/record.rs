//! The record of instruction counts: tab-separated, one row per benchmark, for diffs to be read.

use anyhow::{Context as _, Result, bail};
use std::fmt;
use std::str::FromStr;

const HEADER: &str = "benchmark\tinstructions\tcommit\trustc";

/// One row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    pub(crate) benchmark: String,
    pub(crate) instructions: u64,
    /// What it was counted on: the last commit, with a `+` if there was more than that.
    pub(crate) commit: String,
    pub(crate) rustc: String,
}

/// All rows, in the order in which they were counted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Record(pub(crate) Vec<Entry>);

impl Record {
    /// The count of one benchmark, if it was recorded.
    pub(crate) fn instructions(&self, benchmark: &str) -> Option<u64> {
        let entry = self.0.iter().find(|entry| entry.benchmark == benchmark);
        entry.map(|entry| entry.instructions)
    }
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{HEADER}")?;
        for Entry { benchmark, instructions, commit, rustc } in &self.0 {
            writeln!(f, "{benchmark}\t{instructions}\t{commit}\t{rustc}")?;
        }
        Ok(())
    }
}

impl FromStr for Record {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        if lines.next() != Some(HEADER) {
            bail!("does not begin with the names of its columns");
        }
        let entry = |line: &str| -> Result<Entry> {
            let cells: Vec<&str> = line.split('\t').collect();
            let [benchmark, instructions, commit, rustc] = cells[..] else {
                bail!("not four cells: {line}");
            };
            Ok(Entry {
                benchmark: benchmark.into(),
                instructions: instructions.parse().with_context(|| line.to_owned())?,
                commit: commit.into(),
                rustc: rustc.into(),
            })
        };
        Ok(Self(lines.map(entry).collect::<Result<_>>()?))
    }
}
