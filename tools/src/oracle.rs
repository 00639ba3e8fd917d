//! `cargo x oracle`: the campaign of `crates/geometry/tests/oracle`, optimised, of any length.

use anyhow::{Context as _, Result};
use check::step::cargo;
use std::process::ExitCode;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Everything: the triangle test, contact points and first contact.
    All,
    /// First contact along a straight line.
    FirstContact,
}

/// Compares `pairs` pairs of triangles of `seed`; fails with the first difference, which it prints.
pub(crate) fn run(part: Part, pairs: u64, seed: u64) -> Result<ExitCode> {
    let filter: &[&str] = match part {
        Part::All => &[],
        Part::FirstContact => &["sweeps::"],
    };
    let status = cargo()
        .args(["test", "--release", "--package", "trolley-geometry", "--test", "oracle"])
        .args(["--", "--nocapture", "--test-threads", "1"])
        .args(filter)
        .env("ORACLE_PAIRS", pairs.to_string())
        .env("ORACLE_SEED", seed.to_string())
        .status()
        .context("cannot start cargo")?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
