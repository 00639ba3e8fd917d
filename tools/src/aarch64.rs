//! `cargo x aarch64`: builds for ARM, tests under an emulator, and compares with this machine.

mod equal;
mod page;
mod root;
mod suites;

use anyhow::{Context as _, Result};
use check::built::{CargoWorkspace, output, write};
use check::step::{cargo, now};
use clap::Args;
pub(crate) use equal::{Program, SCENARIOS, build_here};
use page::Page;
pub(crate) use root::{REGISTER, Root, TARGET, bootstrap, logged, namespaced};
use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use suites::Which;
pub(crate) use suites::{BUILD, PACKED, build_program};

/// How much to do.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// Compare one answer alone, and write no page.
    #[arg(long)]
    quick: bool,
    /// Leave out all tests, or the unit tests of pure crates; the page says so.
    #[arg(long, value_name = "WHAT", value_parser = ["tests", "units"])]
    without: Option<String>,
    /// Number of pairs of triangles that are compared with exact arithmetic.
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    pairs: u64,
    /// The page to write.
    #[arg(long, value_name = "FILE", default_value = "tools/results/aarch64.md")]
    out: PathBuf,
}

/// Makes the root file system if there is none, builds, tests, compares, and writes the page.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let start = now();
    let root = Root::open(&workspace)?;
    tell("root    a Debian with a compiler and an emulator is there")?;
    // All packages of all targets, since there is no network where they are built.
    output(cargo().args(["fetch", "--locked"])).context("cargo fetch")?;
    let source = workspace.root.canonicalize()?;
    let file = build_here()?;
    let here = Program { file: &file, root: None, source: &source };
    if options.quick {
        let file = build_program(&root, &source, BUILD)?.program()?;
        let there = Program { file: &file, root: Some(&root), source: &source };
        let row = equal::quick(&here, &there)?;
        tell(&row.to_string())?;
        return Ok(if row.is_equal() { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }

    let without = options.without.as_deref();
    let mut built = match without {
        Some("tests") => build_program(&root, &source, BUILD)?,
        _ => suites::build_whole(&root, &source)?,
    };
    tell(&format!("built   after {:.0} s", start.elapsed().as_secs_f64()))?;
    let file = built.program()?;
    let there = Program { file: &file, root: Some(&root), source: &source };
    let rows = equal::all(&here, &there, &root.place, |row| tell(&row.to_string()))?;
    let out = workspace.root.join(&options.out);
    let mut ended: Vec<suites::Ended> = Vec::new();
    // After each suite: a run that is broken off leaves the page of what was done.
    let publish = |ended: &[suites::Ended], left_out: &[String]| {
        let page = Page::new(&workspace, &root, ended, &rows, left_out)?;
        write(&out, &page.to_string())?;
        Ok::<_, anyhow::Error>(page.is_well())
    };
    let parts: &[Which] = match without {
        Some("tests") => &[],
        Some(_) => &[Which::Whole(options.pairs)],
        None => &[Which::Units, Which::Whole(options.pairs)],
    };
    let all = [Which::Units, Which::Whole(options.pairs)].map(|part| part.to_string());
    let mut is_well = publish(&[], &all)?;
    for (number, part) in parts.iter().enumerate() {
        if matches!(part, Which::Units) {
            suites::build_units(&root, &source, &mut built)?;
        }
        let later: Vec<String> = match without {
            Some(_) => vec![Which::Units.to_string()],
            None => parts[number + 1..].iter().map(Which::to_string).collect(),
        };
        let mut left = suites::suites(&source, &built, *part)?.into_iter();
        while let Some(suite) = left.next() {
            let end = suite.run(&root)?;
            tell(&end.to_string())?;
            ended.push(end);
            let names = left.as_slice().iter().map(|suite| suite.name.clone());
            let names: Vec<String> = names.chain(later.iter().cloned()).collect();
            is_well = publish(&ended, &names)?;
        }
    }
    tell(&format!("written to {}", out.display()))?;
    Ok(if is_well { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A line of progress.
fn tell(line: &str) -> Result<()> {
    Ok(writeln!(std::io::stderr(), "aarch64 {line}")?)
}
