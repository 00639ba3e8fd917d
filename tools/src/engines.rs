//! `cargo x engines`: a study by every engine, with nodes and drivers killed, and its page.
//!
//! ```text
//! wheel ──▶ an environment with Ray ──▶ a network namespace with lo alone ──▶ the page
//! ```
//!
//! Ray listens on all interfaces, so it never runs here where anybody else could reach it.

use crate::machine;
use crate::wheel::{Kept, Python, built_wheel};
use anyhow::{Context as _, Result, bail};
use check::built::{CargoWorkspace, write};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// What to study, and how often to kill.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Number of scenes.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    scenes: u32,
    /// How often a node and a driver are killed, each time at other moments.
    #[arg(long, value_name = "N", default_value_t = 10)]
    seeds: u32,
    /// The package, in place of one that is built now.
    #[arg(long, value_name = "FILE")]
    wheel: Option<PathBuf>,
    /// The Python that makes the environment.
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: PathBuf,
}

/// Builds the package, has every engine run the study, and writes the page; fails if a gate is
/// missed.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let wheels = workspace.target.join("wheel");
    let python = Python { program: &options.python, folder: &wheels };
    let wheel = match &options.wheel {
        Some(wheel) => wheel.clone(),
        None => {
            let build = python.environment("build", &["maturin>=1.16,<2"], Kept::Yes)?;
            let package = workspace.root.join("crates/python");
            built_wheel(&build, &package, &wheels.join("dist"))?
        }
    };
    let needed = ["ray>=2.52", "duckdb", "polars", "pyarrow", "numpy"];
    let ray = python.environment("ray", &needed, Kept::Yes)?;
    ray.install(&["--force-reinstall", "--no-deps", &wheel.display().to_string()])?;
    // Paths of sockets are short.
    let folder = tempfile::Builder::new().prefix("trolley-engines").tempdir()?;
    let numbers = [options.scenes.to_string(), options.seeds.to_string()];
    let script = workspace.root.join("tools/study/engines.py");
    let (script, place) = (script.display().to_string(), folder.path().join("e"));
    let place = place.display().to_string();
    let [scenes, seeds] = &numbers;
    let arguments = [&*script, &place, "--scenes", scenes, "--seeds", seeds];
    let asked = ray.command(&arguments, Path::new(""));
    let mut command = Command::new("unshare");
    command.args(["--net", "sh", "-c", "ip link set lo up && exec \"$@\"", "sh"]);
    command.arg(asked.get_program()).args(asked.get_args());
    command.env_clear();
    command.envs(asked.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let path = format!("{}:/usr/sbin:/usr/bin:/sbin:/bin", ray.folder.join("bin").display());
    command.env("PATH", path).env("HOME", folder.path());
    let done = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let done = done.context("this needs unshare, ip and root")?;
    let said = String::from_utf8(done.stdout)?;
    if !said.contains("## The same rows") {
        bail!("{command:?}: {}", done.status);
    }
    let mut page = "# Engines of a study\n\nWritten by `cargo x engines".to_owned();
    if options.seeds != 10 || options.scenes != 20_000 {
        page += &format!(" --scenes {} --seeds {}", options.scenes, options.seeds);
    }
    page += "`.\n\n";
    for (name, value) in machine::describe(&workspace.root)? {
        page += &format!("- {name}: {value}\n");
    }
    page += &format!("\n{}\n", said.trim_end());
    write(&workspace.root.join("tools/results/study/engines.md"), &page)?;
    io::stdout().lock().write_all(page.as_bytes())?;
    Ok(if done.status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
