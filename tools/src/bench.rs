//! `cargo x bench`: criterion's benchmarks of the kernels, with criterion's own report.
//!
//! For kernel development on one machine. `cargo x count` gates changes; `cargo x compare` compares
//! with other libraries.

use anyhow::{Context as _, Result};
use check::step::cargo;
use std::process::ExitCode;

/// Runs the benchmarks whose names contain `filter`, all if there is none.
pub(crate) fn run(quick: bool, filter: Option<&str>) -> Result<ExitCode> {
    let status = cargo()
        .args(["bench", "--package", "trolley-geometry", "--package", "trolley-bvh"])
        .args(["--bench", "triangles", "--bench", "queries", "--bench", "sweeps"])
        .args(["--bench", "motions", "--bench", "builds", "--"])
        .args(quick.then_some("--quick"))
        .args(filter)
        .status()
        .context("cannot start cargo")?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
