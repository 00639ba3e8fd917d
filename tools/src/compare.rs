//! `cargo x compare`: the kernel compared with other libraries, on the same cases, in one run.
//!
//! ```text
//! cases (made from scenes, or given) ─┐
//! peers: drivers compiled here        ├─ rounds: every row on every case in turn, pinned ─▶ Log
//! rows: ours with options, peers     ─┘        the exact answer, once per case          ─▶ page
//! ```
//!
//! Rows take turns within a round, so that what disturbs the machine disturbs all of them; the
//! median over the rounds counts, and ratios more than times. A driver reads its case, builds its
//! trees, repeats the query and prints one line of JSON; no time includes reading.

pub(crate) mod cases;
mod first_contact;
mod log;
mod page;
mod peers;
mod row;
#[cfg(test)]
mod tests;

use crate::machine;
use anyhow::{Result, bail};
use cases::Case;
use check::built::{self, CargoWorkspace, write};
use check::step::cargo;
use log::Log;
use page::Page;
use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// What to compare.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Cases to use instead of those made here: a folder of folders with a.stl, b.stl, pose.txt.
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Only cases whose names contain this.
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
    /// Number of rounds: each runs every row on every case.
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// The core for all runs but those on two threads.
    #[arg(long, value_name = "N", default_value_t = 0)]
    core: usize,
    /// Which peers, of embree, parry, fcl; the exact oracle runs whenever it is installed.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    peers: Option<Vec<String>>,
    /// Measure with cold caches too: 64 MiB are written between two queries.
    #[arg(long)]
    cold: bool,
    /// Compare first contact of bodies that move instead.
    #[arg(long, conflicts_with_all = ["cases", "rounds", "peers", "cold"])]
    first_contact: bool,
    /// With --first-contact: how long each peer may query each family of bodies (s).
    #[arg(long, value_name = "S", default_value_t = 60, requires = "first_contact")]
    seconds: u32,
    /// The page to write, by default compare.md or first-contact.md in tools/results; what it was
    /// made from is written beside it, as .jsonl.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Options {
    fn out(&self, workspace: &CargoWorkspace, default: &str) -> PathBuf {
        workspace.root.join(self.out.as_deref().unwrap_or(Path::new(default)))
    }
}

/// Makes the cases, compiles the drivers, measures, and writes the page.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    if options.first_contact {
        return first_contact::run(options);
    }
    let workspace = CargoWorkspace::find()?;
    let cases = cases(options, &workspace)?;
    let mut skipped = Vec::new();
    let oracle = peers::oracle(&workspace).map_err(|why| skipped.push(why)).ok();
    let peers = peers(options, &workspace, &mut skipped)?;
    say(&skipped)?;
    let trolley =
        built::executable(cargo().args(["build", "--release", "--package", "trolley-cli"]))?;
    let rows = row::all(&trolley, &peers, options.cold);

    let mut log = Log::default();
    let mut faults = BTreeMap::new();
    let mut truths = BTreeMap::new();
    for case in &cases {
        if let Some(oracle) = &oracle {
            truths.insert(case.name.clone(), row::truth(oracle, case, options.core)?);
        }
    }
    for round in 1..=options.rounds {
        for case in &cases {
            tell(format_args!("round {round} of {}: {}", options.rounds, case.name))?;
            for row in &rows {
                // A row that failed once would fail again.
                if faults.contains_key(&row.key()) {
                    continue;
                }
                match row.run(case, options.core) {
                    Ok(measured) => log.add(row, &case.name, round, measured),
                    Err(fault) => faults.extend([(row.key(), format!("{fault:#}"))]),
                }
            }
        }
    }

    let machine = machine::describe(&workspace.root)?;
    skipped.extend(
        faults
            .iter()
            .map(|((section, row), fault)| format!("{row}, {}: left out: {fault}", section.name())),
    );
    let page = Page {
        machine: &machine,
        versions: &peers::versions(),
        cases: &cases,
        rows: &rows,
        truths: &truths,
        log: &log,
        rounds: options.rounds,
        skipped: &skipped,
    };
    let text = page.to_string();
    let out = options.out(&workspace, "tools/results/compare.md");
    write(&out, &text)?;
    write(&out.with_extension("jsonl"), &log.lines(&machine, &truths)?)?;
    io::stdout().lock().write_all(text.as_bytes())?;
    tell(format_args!("written to {}", out.display()))?;

    let ours_failed = faults.keys().any(|(_, row)| row.starts_with(row::OURS));
    let wrong = page.wrong_of_ours();
    for row in &wrong {
        tell(format_args!("WRONG: {row}"))?;
    }
    Ok(if ours_failed || !wrong.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn cases(options: &Options, workspace: &CargoWorkspace) -> Result<Vec<Case>> {
    let wanted = |name: &str| options.only.as_ref().is_none_or(|text| name.contains(text));
    let cases = match &options.cases {
        Some(folder) => cases::given(folder, &wanted)?,
        None => cases::made(&workspace.target.join("cases"), &wanted)?,
    };
    if cases.is_empty() {
        bail!("no case is left: --only takes part of a case's name");
    }
    Ok(cases)
}

fn peers(
    options: &Options,
    workspace: &CargoWorkspace,
    skipped: &mut Vec<String>,
) -> Result<Vec<(&'static str, PathBuf)>> {
    let mut peers = Vec::new();
    let wanted = |name: &str| {
        options.peers.as_ref().is_none_or(|names| names.iter().any(|wanted| wanted == name))
    };
    if let Some(unknown) =
        options.peers.iter().flatten().find(|name| !peers::NAMES.contains(&name.as_str()))
    {
        bail!("unknown peer {unknown}: expected one of {}", peers::NAMES.join(", "));
    }
    for name in peers::NAMES.iter().filter(|name| wanted(name)) {
        tell(format_args!("compiling the driver for {name}"))?;
        match peers::driver(name, workspace) {
            Ok(program) => peers.push((*name, program)),
            Err(why) => skipped.push(why),
        }
    }
    Ok(peers)
}

/// A line of progress, beside the page.
fn tell(line: std::fmt::Arguments<'_>) -> Result<()> {
    Ok(writeln!(io::stderr(), "{line}")?)
}

fn say(lines: &[String]) -> Result<()> {
    lines.iter().try_for_each(|line| tell(format_args!("{line}")))
}
