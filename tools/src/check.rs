//! `cargo x check`: the steps that a change must pass, the quickest to fail first.

use crate::step::Step;
use anyhow::Result;
use std::process::ExitCode;

/// The step that `--quick` leaves out.
pub(crate) const DOCS: &str = "docs";

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
        args: &["clippy", "--package", "cli", "--no-default-features", "--", "-D", "warnings"],
        env: &[],
    },
    Step {
        name: DOCS,
        args: &["doc", "--workspace", "--no-deps"],
        env: &[("RUSTDOCFLAGS", "-D warnings")],
    },
    Step { name: "tests", args: &["test", "--workspace"], env: &[] },
];

/// Runs the steps until one fails; its exit code is ours.
pub(crate) fn run<'a>(steps: impl IntoIterator<Item = &'a Step>) -> Result<ExitCode> {
    let mut out = std::io::stdout().lock();
    for step in steps {
        if let Some(code) = step.run(&mut out)?.failure() {
            return Ok(code);
        }
    }
    Ok(ExitCode::SUCCESS)
}
