//! Packages checked from what they would publish, each with its own features alone.
//!
//! ```text
//! cargo package ──▶ target/package/*.crate ──tar──▶ target/packages/* ──▶ cargo check, one by one
//! ```
//!
//! `cargo package` would build all of them itself, with everything that they depend on, and take
//! what it built of the same version before for unchanged. Here most of what they depend on is
//! known from the lints, sources are those just packed, and no code is generated: what is missing
//! in an archive is missed by the compiler's front end.

use crate::built::CargoWorkspace;
use crate::step::{CheckStep, StepOutcome, cargo, now};
use anyhow::{Context as _, Result, ensure};
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

#[cfg(test)]
mod tests;

/// Runs the step that packs, and checks what it packed.
///
/// # Errors
///
/// If cargo or tar cannot be started, or a folder of the build cannot be written.
pub fn run(pack: &CheckStep, out: &mut impl Write) -> Result<StepOutcome> {
    let workspace = CargoWorkspace::find()?;
    let archives = workspace.target.join("package");
    // None of packages that are gone.
    clear(&archives)?;
    let packed = pack.run(out)?;
    if packed.failure().is_some() {
        return Ok(packed);
    }
    write!(out, "{:<7} cargo check of each package ... ", pack.name)?;
    out.flush()?;
    let begun = now();
    let folder = workspace.target.join("packages");
    clear(&folder)?;
    let packages = unpack(&archives, &folder)?;
    ensure!(!packages.is_empty(), "{} has no packages", archives.display());
    fs::write(folder.join("Cargo.toml"), manifest(&packages))
        .with_context(|| format!("cannot write into {}", folder.display()))?;
    // The versions that everything else is tested with.
    fs::copy(workspace.root.join("Cargo.lock"), folder.join("Cargo.lock"))
        .context("cannot copy Cargo.lock")?;
    let mut checked = packed;
    for (package, _) in &packages {
        let mut check = cargo();
        check.args(["check", "--quiet", "--offline", "--package", package]);
        check.current_dir(&folder).env("CARGO_TARGET_DIR", &workspace.target);
        let done = check.stdin(Stdio::null()).output().context("cannot start cargo check")?;
        checked = StepOutcome::of(done);
        if checked.failure().is_some() {
            let seconds = begun.elapsed().as_secs_f64();
            writeln!(out, "FAILED {seconds:.1} s\n{}in {package}", checked.said())?;
            return Ok(checked);
        }
    }
    writeln!(out, "{} packages, ok {:.1} s", packages.len(), begun.elapsed().as_secs_f64())?;
    Ok(checked)
}

/// Removes a folder with all that it has.
fn clear(folder: &Path) -> Result<()> {
    match fs::remove_dir_all(folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot remove {}", folder.display()))
        }
        _ => Ok(()),
    }
}

/// Unpacks all archives of a folder into another one, as files of now: those of an archive are from
/// 2006, so cargo would take a package that it checked before for unchanged. Returns the name of
/// each package, and its folder there, in the order of names.
fn unpack(archives: &Path, to: &Path) -> Result<Vec<(String, String)>> {
    fs::create_dir_all(to).with_context(|| format!("cannot make {}", to.display()))?;
    let entries = fs::read_dir(archives)
        .with_context(|| format!("cannot read {}", archives.display()))?
        .map(|entry| Ok(entry?.path()))
        .collect::<Result<Vec<PathBuf>>>()?;
    let mut packages = Vec::new();
    for archive in entries.iter().filter(|path| path.extension() == Some(OsStr::new("crate"))) {
        let done = Command::new("tar").arg("-xzmf").arg(archive).arg("-C").arg(to).status();
        let done = done.context("cannot start tar, which unpacks archives")?;
        ensure!(done.success(), "tar -xzmf {}: {done}", archive.display());
        // trolley-bvh-0.1.0.crate
        let stem = archive.file_stem().and_then(OsStr::to_str).context("a name in UTF-8")?;
        let (name, _version) = stem.rsplit_once('-').context("a name with a version")?;
        packages.push((name.to_owned(), stem.to_owned()));
    }
    packages.sort();
    Ok(packages)
}

/// A workspace in which packages find each other here, and everything else in the registry.
fn manifest(packages: &[(String, String)]) -> String {
    let mut text = "[workspace]\nresolver = \"3\"\nmembers = [\"*\"]\n".to_owned();
    text += "\n[patch.crates-io]\n";
    for (name, folder) in packages {
        let _infallible = writeln!(text, "{name} = {{ path = \"{folder}\" }}");
    }
    text
}
