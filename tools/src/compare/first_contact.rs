//! `cargo x compare --first-contact`: first contact of bodies that move, beside other libraries.
//!
//! ```text
//! encounters ──▶ bench `sweeps`: ours, checked by exact poses and brute force; halving ─┐
//!         └────▶ drivers: parry3d, FCL, ipctk, each family in one process ──────────────┼▶ page
//! motions ────▶ bench `motions`: ours alone, checked by exact poses ────────────────────┘
//! ```
//!
//! Everything is pinned to one core, one program after the other; the median of some runs of each
//! query counts. Nothing of a peer is checked but its answer.

mod page;
#[cfg(test)]
mod tests;

use super::{Options, cases, peers, say, tell};
use crate::machine;
use anyhow::{Context as _, Result};
use check::built::{self, CargoWorkspace, output, write};
use check::step::cargo;
use page::Page;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::{Command, ExitCode};

/// Ours, and how it used to be done.
const OURS: &str = "trolley";
const HALVING: &str = "halving";

/// A line that a program printed.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Line {
    peer: String,
    /// The encounter.
    name: String,
    /// `None`: never.
    first_contact_m: Option<f64>,
    query_ms: f64,
    #[serde(flatten)]
    effort: Effort,
}

/// What only our lines have.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
struct Effort {
    #[serde(skip_serializing_if = "Option::is_none")]
    boxes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pairs: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    exact_tests: Option<u64>,
    /// Exact poses tried before first contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    poses: Option<u64>,
    /// How many of them touch.
    #[serde(skip_serializing_if = "Option::is_none")]
    touching: Option<u64>,
    /// Whether all pairs one by one give the same bits.
    #[serde(skip_serializing_if = "Option::is_none")]
    brute_force: Option<bool>,
}

/// Measures everything and writes the page.
pub(super) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let bench = ["bench", "--package", "trolley-bvh", "--bench", "sweeps", "--no-run"];
    let ours = built::executable(cargo().args(bench))?;
    let (mut drivers, mut skipped) = (Vec::new(), Vec::new());
    for driver in peers::sweeps(&workspace) {
        match driver {
            Ok(driver) => drivers.push(driver),
            Err(why) => skipped.push(why),
        }
    }
    say(&skipped)?;

    let only = options.only.as_deref().unwrap_or_default();
    let seconds = options.seconds.to_string();
    let mut lines = Vec::new();
    let mut families = BTreeMap::new();
    for family in cases::FAMILIES {
        let made =
            cases::swept(&workspace.target.join("cases"), family, &|name| name.contains(only))?;
        let Some((folder, names)) = made else { continue };
        tell(format_args!("{family}: {} encounters", names.len()))?;
        let mut command = pinned(options.core, &ours);
        lines.extend(read(command.args(["lines", only, family]))?);
        for driver in &drivers {
            tell(format_args!("{family}: {}", driver.last().unwrap_or(&ours).display()))?;
            let mut command = pinned(options.core, &driver[0]);
            command.args(&driver[1..]).arg(&folder).args(["--seconds", &seconds]);
            match read(&mut command) {
                Ok(of_peer) => lines.extend(of_peer),
                Err(fault) => skipped.push(format!("{family}: {fault:#}")),
            }
        }
        families.insert(*family, names);
    }

    let motions = match only {
        "" => {
            let bench = ["bench", "--package", "trolley-bvh", "--bench", "motions", "--no-run"];
            let program = built::executable(cargo().args(bench))?;
            tell(format_args!("cars that turn"))?;
            output(pinned(options.core, &program).arg("table"))?
        }
        _ => String::new(),
    };

    let machine = machine::describe(&workspace.root)?;
    let page = Page {
        command: format!(
            "cargo x compare --first-contact --seconds {seconds}{}",
            options.only.as_ref().map_or(String::new(), |only| format!(" --only {only}"))
        ),
        machine: &machine,
        versions: &peers::versions(),
        families: &families,
        lines: &lines,
        motions: &motions,
        skipped: &skipped,
    };
    let text = page.to_string();
    let out = options.out(&workspace, "tools/results/first-contact.md");
    write(&out, &text)?;
    let json: Result<Vec<String>, _> = lines.iter().map(serde_json::to_string).collect();
    write(&out.with_extension("jsonl"), &(json?.join("\n") + "\n"))?;
    io::stdout().lock().write_all(text.as_bytes())?;
    tell(format_args!("written to {}", out.display()))?;
    let wrong = lines.iter().filter(|line| line.is_wrong()).map(|line| &line.name);
    let mut exit = ExitCode::SUCCESS;
    for name in wrong {
        tell(format_args!("WRONG: {name}"))?;
        exit = ExitCode::FAILURE;
    }
    Ok(exit)
}

impl Line {
    /// Whether a check of ours failed.
    fn is_wrong(&self) -> bool {
        self.effort.touching.is_some_and(|count| count > 0)
            || self.effort.brute_force == Some(false)
    }
}

/// `program` on one core.
fn pinned(core: usize, program: &Path) -> Command {
    let mut command = Command::new("taskset");
    command.args(["--cpu-list", &core.to_string()]).arg(program);
    command
}

fn read(command: &mut Command) -> Result<Vec<Line>> {
    let said = output(command)?;
    let line = |text: &str| serde_json::from_str(text).with_context(|| text.to_owned());
    said.lines().filter(|line| line.starts_with('{')).map(line).collect()
}
