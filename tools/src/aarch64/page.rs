//! The page of a run: what ran, how long it took, what is equal, and what an emulator cannot show.

use super::equal::Row;
use super::root::Root;
use super::suites::Ended;
use crate::machine;
use anyhow::Result;
use check::built::CargoWorkspace;
use check::step::TestTally;
use std::fmt::{self, Display, Formatter};

/// What a reader must not take from it.
const LIMITS: &str = include_str!("limits.md");

/// Everything that is on it.
#[derive(Debug)]
pub(crate) struct Page<'a> {
    machine: Vec<(&'static str, String)>,
    there: Vec<(&'static str, String)>,
    ended: &'a [Ended],
    rows: &'a [Row],
    left_out: &'a [String],
}

impl<'a> Page<'a> {
    /// Asks for versions.
    pub(crate) fn new(
        workspace: &CargoWorkspace,
        root: &Root,
        ended: &'a [Ended],
        rows: &'a [Row],
        left_out: &'a [String],
    ) -> Result<Self> {
        let emulator = root.says(&["qemu-aarch64", "--version"])?;
        let there = vec![
            ("compiler for aarch64", root.says(&["rustc", "--version"])?),
            ("emulator", emulator.lines().next().unwrap_or_default().to_owned()),
        ];
        Ok(Self { machine: machine::describe(&workspace.root)?, there, ended, rows, left_out })
    }

    fn tests(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(
            "\n## Tests there\n\n\
             Optimised and without the laboratory, as the program ships; tests that need it are \
             left out.\nWaits of tests are longer, by `TROLLEY_TEST_PATIENCE`, and the program, \
             told to end, may take as many times longer\nbefore it is ended by force: it is built \
             with `TROLLEY_SLOWNESS`, which what ships is not.\n\n\
             | tests | passed | failed | ignored | s |\n|---|--:|--:|--:|--:|\n",
        )?;
        for end in self.ended {
            let TestTally { passed, failed, ignored, .. } = end.tally;
            let (name, seconds) = (&end.name, end.seconds);
            writeln!(f, "| {name} | {passed} | {failed} | {ignored} | {seconds:.1} |")?;
        }
        let failed: Vec<_> = self.ended.iter().filter(|end| !end.failed.is_empty()).collect();
        if !failed.is_empty() {
            writeln!(f, "\nFailed:\n")?;
        }
        for end in failed {
            writeln!(f, "- {}: {}", end.name, end.failed.join(", "))?;
        }
        Ok(())
    }

    /// Whether all tests passed, and everything is equal.
    pub(crate) fn is_well(&self) -> bool {
        self.ended.iter().all(|end| end.failed.is_empty()) && self.rows.iter().all(Row::is_equal)
    }
}

impl Display for Page<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(
            "# ARM: tests under an emulator, and both architectures compared\n\n\
             Written by `cargo x aarch64`. *Here* is x86-64 without an emulator, *there* is \
             aarch64 under one, on the same\nmachine, which does other work too.\n\n\
             | | |\n|---|---|\n",
        )?;
        for (name, value) in self.machine.iter().chain(&self.there) {
            writeln!(f, "| {name} | {value} |")?;
        }
        let mut all = TestTally::default();
        self.ended.iter().for_each(|end| all.add(&end.tally));
        let equal = self.rows.iter().filter(|row| row.is_equal()).count();
        let tests = if all.is_empty() { String::new() } else { format!("{all}. ") };
        writeln!(f, "\n**{tests}{equal} of {} comparisons are equal.**\n", self.rows.len())?;

        f.write_str(
            "## What both compute\n\n\
             Hashes are BLAKE3, the first 16 digits: of the `answer` byte for byte, of model \
             files, of records without build,\nhash and times. Hit sets have the number of pairs \
             or triangles, and the sums that the help of `intersect` defines.\n\n\
             | what | here | there | here, s | there, s | |\n|---|---|---|--:|--:|---|\n",
        )?;
        for row in self.rows {
            let [here, there] = &row.hashes;
            let verdict = if row.is_equal() { "equal" } else { "**DIFFER**" };
            let [here_s, there_s] = row.seconds;
            let what = &row.what;
            writeln!(f, "| {what} | {here} | {there} | {here_s:.1} | {there_s:.1} | {verdict} |")?;
        }

        if !self.ended.is_empty() {
            self.tests(f)?;
        }
        if !self.left_out.is_empty() {
            writeln!(f, "\n**Not run, or not in this run: {}.**", self.left_out.join("; "))?;
        }
        write!(f, "\n{LIMITS}")
    }
}

impl Display for Ended {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "tests   {}: {} in {:.0} s", self.name, self.tally, self.seconds)?;
        if !self.failed.is_empty() {
            write!(f, ", FAILED: {}", self.failed.join(", "))?;
        }
        Ok(())
    }
}

impl Display for Row {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [here, there] = &self.hashes;
        if self.is_equal() {
            write!(f, "equal   {}: {here}", self.what)
        } else {
            write!(f, "DIFFER  {}: {here} here, {there} there", self.what)
        }
    }
}
