//! `cargo x oracle`: the campaign of `crates/geometry/tests/oracle`, optimised, of any length.

use crate::step::cargo;
use anyhow::{Context as _, Result};
use std::process::ExitCode;

/// Compares `pairs` pairs of triangles of `seed`; fails with the first difference, which it prints.
pub(crate) fn run(pairs: u64, seed: u64) -> Result<ExitCode> {
    let status = cargo()
        .args(["test", "--release", "--package", "trolley-geometry", "--test", "oracle"])
        .args(["--", "--nocapture", "--test-threads", "1"])
        .env("ORACLE_PAIRS", pairs.to_string())
        .env("ORACLE_SEED", seed.to_string())
        .status()
        .context("cannot start cargo")?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
