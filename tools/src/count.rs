//! `cargo x count`: instructions per kernel, counted by callgrind and held against a record.
//!
//! Times on a shared machine cannot gate a change; instruction counts can: they are the same on
//! every run. They ignore caches and branch misprediction, so they guard against accidents and do
//! not measure speed. Callgrind supports at most AVX2.
//!
//! The workloads are those of the bench target `counted` of `bvh`, one program: without arguments
//! it lists their names, with a name it runs that workload, inside [`COUNTED`].

mod record;
#[cfg(test)]
mod tests;

use crate::machine;
use anyhow::{Context as _, Result, bail};
use check::built::{self, CargoWorkspace, output, write};
use check::step::cargo;
use record::{Entry, Record};
use std::fs;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

/// Path of the record, from the root.
const RECORD: &str = "tools/results/instructions.tsv";
/// Instructions are counted between entry and return of this function.
const COUNTED: &str = "counted::measured*";
/// More instructions than recorded by more than this fraction fail.
const TOLERANCE: f64 = 0.03;

/// Counts all workloads; writes the record, or compares with it.
pub(crate) fn run(record: bool) -> Result<ExitCode> {
    let mut out = io::stdout().lock();
    if !is_there("valgrind") {
        writeln!(out, "count   SKIPPED, nothing was compared: valgrind is not installed.")?;
        writeln!(out, "        apt-get install valgrind, then run this again.")?;
        return if record { bail!("nothing to record") } else { Ok(ExitCode::SUCCESS) };
    }
    let workspace = CargoWorkspace::find()?;
    let program = built::executable(cargo().args([
        "bench",
        "--package",
        "trolley-bvh",
        "--bench",
        "counted",
        "--no-run",
    ]))?;
    let scratch = workspace.target.join("callgrind.out");
    let path = workspace.root.join(RECORD);
    let known = match fs::read_to_string(&path) {
        Ok(text) => text.parse().with_context(|| path.display().to_string())?,
        Err(e) if record && e.kind() == io::ErrorKind::NotFound => Record::default(),
        Err(e) => return Err(e).with_context(|| format!("{RECORD}: write it with --record")),
    };

    let (commit, rustc) = (machine::commit(&workspace.root)?, machine::rustc()?);
    let mut counted = Record::default();
    let mut worse = 0;
    writeln!(out, "{:<28} {:>15} {:>15} {:>8}", "instructions", "recorded", "now", "change")?;
    for name in output(&mut Command::new(&program))?.lines() {
        let now = instructions(&program, name, &scratch)?;
        let before = known.instructions(name);
        let change = before.map(|before| now as f64 / before as f64 - 1.0);
        let is_worse = change.is_none_or(|change| change > TOLERANCE);
        worse += usize::from(is_worse);
        writeln!(
            out,
            "{name:<28} {:>15} {now:>15} {:>8}{}",
            before.map_or("-".into(), |before| before.to_string()),
            change.map_or("new".into(), |change| format!("{:+.2} %", 100.0 * change)),
            if is_worse && !record { "  <--" } else { "" },
        )?;
        let (benchmark, commit, rustc) = (name.to_owned(), commit.clone(), rustc.clone());
        counted.0.push(Entry { benchmark, instructions: now, commit, rustc });
    }
    if record {
        write(&path, &counted.to_string())?;
        writeln!(out, "written to {RECORD}")?;
        return Ok(ExitCode::SUCCESS);
    }
    if known.0.iter().any(|entry| entry.rustc != rustc) {
        writeln!(out, "note: recorded with another compiler than this, {rustc}")?;
    }
    for gone in known.0.iter().filter(|entry| counted.instructions(&entry.benchmark).is_none()) {
        writeln!(out, "note: {} is recorded but no longer exists", gone.benchmark)?;
    }
    if worse > 0 {
        writeln!(out, "{worse} are new or need more than {:.0} % more", 100.0 * TOLERANCE)?;
        writeln!(out, "if that is intended: cargo x count --record, and say why")?;
        return Ok(ExitCode::FAILURE);
    }
    Ok(ExitCode::SUCCESS)
}

fn is_there(program: &str) -> bool {
    let quiet = || Stdio::null();
    Command::new(program).arg("--version").stdout(quiet()).stderr(quiet()).status().is_ok()
}

/// Runs one workload under callgrind, which writes its figures to `scratch`.
fn instructions(program: &Path, name: &str, scratch: &Path) -> Result<u64> {
    let mut file = std::ffi::OsString::from("--callgrind-out-file=");
    file.push(scratch);
    let status = Command::new("valgrind")
        .args(["--quiet", "--tool=callgrind", &format!("--toggle-collect={COUNTED}")])
        .arg(file)
        .arg(program)
        .arg(name)
        .status()
        .context("cannot start valgrind")?;
    if !status.success() {
        bail!("valgrind, {name}: {status}");
    }
    let figures = fs::read_to_string(scratch).context("the figures of callgrind")?;
    match total(&figures) {
        Some(0) | None => bail!("{name}: callgrind counted nothing inside {COUNTED}"),
        Some(count) => Ok(count),
    }
}

/// The sum that callgrind writes at the end of its figures.
fn total(figures: &str) -> Option<u64> {
    figures.lines().find_map(|line| line.strip_prefix("totals: ")?.trim().parse().ok())
}
