//! `cargo x check`: the steps that a change must pass, fastest first.

use crate::packages;
use crate::safety;
use crate::step::{Step, now};
use anyhow::Result;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

/// The steps that `--quick` leaves out.
pub(crate) const THOROUGH: [&str; 2] = ["docs", "package"];

/// All steps, in order.
pub(crate) const STEPS: &[Step] = &[
    Step { name: "format", args: &["fmt", "--all", "--check"], env: &[] },
    Step {
        name: "clippy",
        args: &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"],
        env: &[],
    },
    Step {
        name: "clippy of an ECU build",
        args: &[
            "clippy",
            "--package",
            "trolley-cli",
            "--no-default-features",
            "--",
            "-D",
            "warnings",
        ],
        env: &[],
    },
    Step {
        name: "docs",
        args: &["doc", "--workspace", "--no-deps"],
        env: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step { name: "tests", args: &["test", "--workspace"], env: &[] },
    Step {
        name: "example",
        args: &["run", "--quiet", "--package", "trolley", "--example", "rank"],
        env: &[],
    },
    Step {
        name: "example",
        args: &[
            "run",
            "--quiet",
            "--package",
            "trolley",
            "--example",
            "pairs",
            "--",
            "crates/trolley/examples/data/step.stl",
            "crates/trolley/examples/data/pole.stl",
        ],
        env: &[],
    },
    Step {
        name: "example",
        args: &[
            "run",
            "--quiet",
            "--package",
            "trolley",
            "--example",
            "sweep",
            "--",
            "crates/trolley/examples/data/step.stl",
            "crates/trolley/examples/data/pole.stl",
            "-1",
            "0",
            "0",
            "10",
        ],
        env: &[],
    },
    PACKAGE,
];

/// Every package, as it would be published; [`packages`] checks what is in it.
const PACKAGE: Step = Step {
    name: "package",
    args: &["package", "--workspace", "--no-verify", "--quiet", "--allow-dirty"],
    env: &[],
};

/// Third-party files beside the checkout.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data");

/// The tests that need [`DATA`]: they are ignored, and lie in modules of this name.
const WITH_DATA: Step = Step {
    name: "data",
    args: &[
        "test",
        "--workspace",
        // All that the step before has built: other packages or targets would be compiled anew.
        "--tests",
        "--",
        "--ignored",
        "shared_data::",
    ],
    env: &[],
};

/// Runs the steps until one fails; its exit code is ours.
pub(crate) fn run<'a>(steps: impl IntoIterator<Item = &'a Step>) -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    let data = Path::new(DATA).is_dir().then_some(&WITH_DATA);
    let steps: Vec<&Step> = steps.into_iter().chain(data).collect();
    let begun = now();
    let mut tests = String::new();
    for (number, step) in steps.iter().enumerate() {
        write!(out, "{:>2}/{} ", number + 1, steps.len())?;
        let outcome = if step.name == PACKAGE.name {
            packages::run(step, &mut out)?
        } else {
            step.run(&mut out)?
        };
        if let Some(code) = outcome.failure() {
            return Ok(code);
        }
        if step.args[0] == "test" {
            tests += &outcome.said();
        }
    }
    // No second run: what the steps above have run is read.
    let missing = safety::not_run(&tests)?;
    if !missing.is_empty() {
        writeln!(out, "needs   FAILED: these tests of requirements did not run and pass:")?;
        missing.iter().try_for_each(|test| writeln!(out, "        {test}"))?;
        return Ok(ExitCode::FAILURE);
    }
    if data.is_none() {
        let left_out =
            "LEFT OUT: ../shared/data does not exist; see the tests that are ignored for it";
        writeln!(out, "{:<7} {left_out}", WITH_DATA.name)?;
    }
    writeln!(out, "{} steps in {:.0} s", steps.len(), begun.elapsed().as_secs_f64())?;
    Ok(ExitCode::SUCCESS)
}
