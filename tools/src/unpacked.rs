//! Packages built from what they would publish, and never from what they published before.
//!
//! cargo takes a package from a registry for unchanged if its version is. `cargo package
//! --workspace` makes such a registry below the target directory, and unpacks it below the home of
//! cargo, in a folder named by the registry's path: a second run with the same target directory, or
//! a second clone at the same place, verifies the sources of the first. A target directory that no
//! run had before has neither.

use crate::step::{Outcome, Step};
use anyhow::{Context as _, Result};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs a step in a target directory of its own, and removes what cargo unpacked for it.
pub(crate) fn run_fresh(step: &Step, out: &mut impl Write) -> Result<Outcome> {
    let target = tempfile::Builder::new()
        .prefix("package-")
        .tempdir_in(target()?)
        .context("cannot make a target directory for the packages")?;
    let before = unpacked()?;
    let in_target = |cargo: &mut Command| {
        cargo.env("CARGO_TARGET_DIR", target.path());
    };
    let outcome = step.run_with(in_target, out)?;
    for folder in unpacked()?.difference(&before) {
        std::fs::remove_dir_all(folder)
            .with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    Ok(outcome)
}

/// The workspace's own target directory.
fn target() -> Result<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../target"), PathBuf::from);
    std::fs::create_dir_all(&target)
        .with_context(|| format!("cannot make {}", target.display()))?;
    target.canonicalize().with_context(|| format!("cannot find {}", target.display()))
}

/// The folders of sources from registries on this machine, which have no host in their names.
fn unpacked() -> Result<BTreeSet<PathBuf>> {
    let Some(home) = home() else { return Ok(BTreeSet::new()) };
    let sources = home.join("registry/src");
    let entries = match std::fs::read_dir(&sources) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(BTreeSet::new()),
        Err(error) => {
            return Err(error).with_context(|| format!("cannot read {}", sources.display()));
        }
    };
    entries
        .map(|entry| Ok(entry?.path()))
        .filter(|path: &Result<PathBuf>| {
            let name = path.as_ref().map(|path| path.file_name().map(|name| name.to_owned()));
            name.is_ok_and(|name| name.is_some_and(|name| name.as_encoded_bytes()[0] == b'-'))
        })
        .collect()
}

/// The home of cargo, as cargo finds it.
fn home() -> Option<PathBuf> {
    let named = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    named.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".cargo")))
}
