//! `cargo x mutants`: changes the source in small ways, each of which some test must notice.
//!
//! What no test notices is explained in `tools/safety/mutants.toml`, or this fails.

use crate::machine;
use anyhow::{Context as _, Result, ensure};
use check::built::{CargoWorkspace, write};
use check::step::{cargo, now};
use clap::Args;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

/// How much to do.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Every Nth mutant alone; the page says so.
    #[arg(long, value_name = "N", default_value_t = 1)]
    every: u32,
    /// The page to write.
    #[arg(long, value_name = "FILE", default_value = "tools/results/mutants.md")]
    out: PathBuf,
}

/// What is changed, and what must notice.
struct Part {
    name: &'static str,
    /// Whose tests run.
    package: &'static str,
    /// Only those whose names contain this.
    tests: &'static str,
    files: &'static [&'static str],
}

const PARTS: [Part; 2] = [
    Part {
        name: "dispatch",
        package: "trolley-dispatch",
        tests: "",
        files: &["crates/dispatch/src/**"],
    },
    // All tests of this package take minutes: its own have to do.
    Part {
        name: "rank",
        package: "trolley-damage",
        tests: "rank::",
        files: &["crates/damage/src/rank.rs", "crates/damage/src/rank/**"],
    },
];

/// Flaws on purpose, of a feature that these builds do not have.
const FLAWS: &str = "crates/dispatch/src/dispatcher/flaw.rs";

/// No test of one mutant takes longer (s): those that never end are noticed by this alone.
const LONGEST_S: &str = "30";

/// A mutant that no test notices, and why none needs to.
#[derive(Debug, Deserialize)]
struct Survivor {
    file: String,
    /// As cargo-mutants says it: `replace X with Y in Z`.
    change: String,
    why: String,
}

impl Survivor {
    /// Whether this is the mutant that a line names: `FILE:LINE:COLUMN: CHANGE`.
    fn is(&self, line: &str) -> bool {
        line.split_once(": ").is_some_and(|(place, change)| {
            place.starts_with(&format!("{}:", self.file)) && change == self.change
        })
    }
}

#[derive(Debug, Deserialize)]
struct Survivors {
    #[serde(default)]
    survivor: Vec<Survivor>,
}

/// What came of the mutants of a part, and how long it took (s).
#[derive(Debug)]
struct Outcome {
    /// A test failed, or the compiler refused it.
    caught: BTreeSet<String>,
    endless: BTreeSet<String>,
    missed: BTreeSet<String>,
    seconds: f64,
}

/// Tries all, and writes the page.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let known = cargo().args(["mutants", "--version"]).output();
    let known = known.is_ok_and(|done| done.status.success());
    ensure!(known, "there is no cargo-mutants\n  help: cargo install cargo-mutants --locked");
    let table = fs::read_to_string(workspace.root.join("tools/safety/mutants.toml"))?;
    let Survivors { survivor: explained } = toml::from_str(&table)?;
    let mut text = String::from(
        "# Mutants: small changes of the source that tests must notice\n\n\
         Written by `cargo x mutants`, with cargo-mutants. The machine does other work too.\n\n\
         | | |\n|---|---|\n",
    );
    for (name, value) in machine::describe(&workspace.root)? {
        writeln!(text, "| {name} | {value} |")?;
    }
    let which = match options.every {
        1 => "All mutants were tried.".to_owned(),
        every => format!("**Every {every}th mutant was tried**, of each file alike."),
    };
    write!(
        text,
        "\n{which} *Endless* are those whose tests did not end within {LONGEST_S} s, which is how \
         they are noticed;\n*caught* those that a test or the compiler refuses. Tests of the \
         package alone count, not those of packages above nor examples; of `rank`, its own.\n\
         What was caught is not tried again: *s* is the time of the last run.\n\n\
         | part | caught | endless | missed | s |\n|---|--:|--:|--:|--:|\n"
    )?;
    let mut missed = Vec::new();
    for part in &PARTS {
        let found = try_all(&workspace, part, options.every)?;
        let part = part.name;
        let Outcome { caught, endless, seconds, .. } = &found;
        let counts = [caught, endless, &found.missed].map(|list| list.len().to_string());
        writeln!(text, "| {part} | {} | {seconds:.0} |", counts.join(" | "))?;
        writeln!(std::io::stderr(), "mutants {part}: {} missed", found.missed.len())?;
        missed.extend(found.missed);
    }
    let (mut explanations, mut unexplained) = (String::new(), String::new());
    for line in &missed {
        match explained.iter().find(|entry| entry.is(line)) {
            Some(Survivor { why, .. }) => writeln!(explanations, "- `{line}`: {why}")?,
            None => writeln!(unexplained, "- `{line}`")?,
        }
    }
    for (title, list) in [("Missed, and why", &explanations), ("Not explained", &unexplained)] {
        if !list.is_empty() {
            write!(text, "\n## {title}\n\n{list}")?;
        }
    }
    let out = workspace.root.join(&options.out);
    write(&out, &text)?;
    writeln!(std::io::stderr(), "mutants written to {}", out.display())?;
    Ok(if unexplained.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs cargo-mutants in a copy of the source; what an earlier run caught is not tried again.
fn try_all(workspace: &CargoWorkspace, part: &Part, every: u32) -> Result<Outcome> {
    let Part { name: part, package, tests, files } = *part;
    let folder = workspace.target.join("mutants").join(format!("{part}-{every}"));
    fs::create_dir_all(&folder)?;
    let command = || {
        let mut command = cargo();
        command.current_dir(&workspace.root).args(["mutants", "--package", package]);
        command.args(["--no-shuffle", "--exclude", FLAWS]);
        command.args(["--sharding", "round-robin", "--shard", &format!("0/{every}")]);
        for file in files {
            command.args(["--file", file]);
        }
        command
    };
    // What was caught in an earlier run may stand elsewhere by now.
    let there = command().arg("--list").output().context("cannot start cargo")?;
    ensure!(there.status.success(), "{part}: cargo mutants --list ended with {}", there.status);
    let there = String::from_utf8_lossy(&there.stdout).into_owned();
    let there: BTreeSet<&str> = there.lines().collect();
    let mut command = command();
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    command.args(["--jobs", &cores.to_string()]);
    command.args(["--iterate", "--timeout", LONGEST_S, "--output"]).arg(&folder);
    // Nothing but unit tests is built, and examples in documentation would be so for each mutant.
    command.args(["--cargo-arg=--lib", "--", tests]);
    // Compiling takes longer than testing.
    for profile in ["DEV", "TEST"] {
        command.env(format!("CARGO_PROFILE_{profile}_OPT_LEVEL"), "0");
    }
    // Each job builds in a copy of its own.
    command.env_remove("CARGO_TARGET_DIR");
    let start = now();
    let status = command.status().context("cannot start cargo")?;
    // 2: some were missed; 3: some did not end.
    let code = status.code();
    ensure!(matches!(code, Some(0 | 2 | 3)), "{part}: cargo mutants ended with {status}");
    let seconds = start.elapsed().as_secs_f64();
    let out = folder.join("mutants.out");
    let list = |names: &[&str]| -> BTreeSet<String> {
        let text = names.iter().map(|name| fs::read_to_string(out.join(name)).unwrap_or_default());
        let lines = text.flat_map(|text| text.lines().map(str::to_owned).collect::<Vec<_>>());
        lines.filter(|line| there.contains(line.as_str())).collect()
    };
    // Earlier runs keep both kinds in one list.
    let caught = list(&["caught.txt", "unviable.txt", "previously_caught.txt"]);
    let (missed, endless) = (list(&["missed.txt"]), list(&["timeout.txt"]));
    Ok(Outcome { caught, endless, missed, seconds })
}
