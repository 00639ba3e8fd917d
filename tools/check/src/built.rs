//! Builds programs, runs commands, writes files.

use crate::step::cargo;
use anyhow::{Context as _, Result, bail};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Folders of the workspace and of its build.
#[derive(Debug)]
pub struct CargoWorkspace {
    /// Its root.
    pub root: PathBuf,
    /// Cargo's target folder.
    pub target: PathBuf,
}

impl CargoWorkspace {
    /// Asks cargo.
    ///
    /// # Errors
    ///
    /// If cargo cannot be asked.
    pub fn find() -> Result<Self> {
        let said = output(cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
        let known: Value = serde_json::from_str(&said).context("cargo metadata")?;
        let folder = |key: &str| known[key].as_str().map(PathBuf::from).context("cargo metadata");
        Ok(Self { root: folder("workspace_root")?, target: folder("target_directory")? })
    }
}

/// Has cargo build one program; `command` starts cargo with all that it needs to know but the
/// format of its messages.
///
/// # Errors
///
/// If it does not build.
pub fn executable(command: &mut Command) -> Result<PathBuf> {
    let said = output(command.arg("--message-format=json-render-diagnostics"))?;
    let messages = said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let mut made = messages.filter_map(|message| Some(message["executable"].as_str()?.into()));
    made.next_back().with_context(|| format!("{command:?} made no program"))
}

/// Output of a command, if it succeeds; its stderr goes to the terminal.
///
/// # Errors
///
/// If it cannot be started, fails, or writes what is no text.
pub fn output(command: &mut Command) -> Result<String> {
    let done = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let done = done.with_context(|| format!("cannot start {command:?}"))?;
    if !done.status.success() {
        bail!("{command:?}: {}", done.status);
    }
    Ok(String::from_utf8(done.stdout)?)
}

/// Writes a file, creating its folder if missing.
///
/// # Errors
///
/// If it cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().context("a file without a folder")?;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    fs::write(path, text).with_context(|| path.display().to_string())
}
