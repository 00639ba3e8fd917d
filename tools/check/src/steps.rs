//! `cargo x check`: the steps that a change must pass, fastest first.

use crate::packages;
use crate::safety;
use crate::step::{CheckStep, now};
use anyhow::Result;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

/// The steps that `--quick` leaves out.
const THOROUGH: [&str; 2] = ["docs", "package"];

/// All steps, in order.
pub const STEPS: &[CheckStep] = &[
    CheckStep::cargo("format", &["fmt", "--all", "--check"]),
    CheckStep::cargo("clippy", &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]),
    CheckStep::cargo(
        "clippy of an ECU build",
        &["clippy", "--package", "trolley-cli", "--no-default-features", "--", "-D", "warnings"],
    ),
    CheckStep {
        env: &[("RUSTDOCFLAGS", "-D warnings")],
        ..CheckStep::cargo("docs", &["doc", "--workspace", "--no-deps"])
    },
    CheckStep::cargo("tests", &["test", "--workspace"]),
    CheckStep::example("rank", &[]),
    CheckStep::example("pairs", &[STEP, POLE]),
    CheckStep::example("sweep", &[STEP, POLE, "-1", "0", "0", "10"]),
    PACKAGE,
];

/// Meshes for examples.
const STEP: &str = "crates/trolley/examples/data/step.stl";
const POLE: &str = "crates/trolley/examples/data/pole.stl";

/// Every package, as it would be published. Those of `tools` never are, and use each other, which
/// cargo looks for where they would be. [`packages`] checks what is in them.
const PACKAGE: CheckStep = CheckStep::cargo(
    "package",
    &[
        "package",
        "--workspace",
        "--exclude",
        "trolley-tools",
        "--exclude",
        "trolley-check",
        "--exclude",
        "trolley-fuzz",
        "--no-verify",
        "--quiet",
        "--allow-dirty",
    ],
);

/// Third-party files beside the checkout.
const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// The tests that need [`DATA`]: they are ignored, and lie in modules of this name.
const WITH_DATA: CheckStep = CheckStep::cargo(
    "data",
    // All that the step before has built: other packages or targets would be compiled anew.
    &["test", "--workspace", "--tests", "--", "--ignored", "shared_data::"],
);

/// The steps without documentation and packages.
pub fn quick() -> impl Iterator<Item = &'static CheckStep> {
    STEPS.iter().filter(|step| !THOROUGH.contains(&step.name))
}

/// Runs the steps until one fails; its exit code is ours.
///
/// # Errors
///
/// If cargo cannot be started, or a package or a table of requirements cannot be read.
pub fn run<'a>(steps: impl IntoIterator<Item = &'a CheckStep>) -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    let data = Path::new(DATA).is_dir().then_some(&WITH_DATA);
    let steps: Vec<&CheckStep> = steps.into_iter().chain(data).collect();
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
        if step.args.first() == Some(&"test") {
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
