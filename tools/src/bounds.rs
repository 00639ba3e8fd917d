//! `cargo x bounds`: what deployments take, computed by `trolley doctor` and measured on services
//! at their limits; and what jobs cost that are made to be dear.

mod page;
mod service;

use anyhow::{Context as _, Result};
use check::built::{self, CargoWorkspace, write};
use check::step::cargo;
use page::Page;
use serde_json::Value;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// How much to measure, and where the page goes.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Jobs that are made to be dear.
    #[arg(long, value_name = "N", default_value_t = 10_000_000)]
    jobs: u64,
    /// The page to write.
    #[arg(long, value_name = "FILE", default_value = "tools/results/bounds.md")]
    out: PathBuf,
    /// A program that is built already, instead of a new one.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// Deployments that ship.
const SHIPPED: [&str; 3] = ["minimal", "dual-core", "quad-core"];

/// Measures all, and writes the page.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let program = match &options.program {
        Some(program) => program.canonicalize()?,
        None => built::executable(cargo().args(["build", "--release", "--package=trolley-cli"]))?,
    };
    let scratch = tempfile::Builder::new().prefix("b").tempdir_in("/dev/shm")?;
    let mut shipped = Vec::new();
    for name in SHIPPED {
        let file = workspace.root.join(format!("config/deployments/{name}.toml"));
        shipped.push((name, doctor(&program, &file, &["--jobs", "0"])?));
    }
    let mut services = Vec::new();
    for case in service::CASES {
        let measured = service::measure(&program, case, scratch.path())?;
        writeln!(std::io::stderr(), "bounds  {}", case.name)?;
        services.push(measured);
    }
    let jobs = options.jobs.to_string();
    let file = workspace.root.join("config/deployments/dual-core.toml");
    let campaign = doctor(&program, &file, &["--jobs", &jobs])?;
    let version = built::output(Command::new(&program).arg("--version"))?;
    let version = version.trim().to_owned();
    let page = Page { root: &workspace.root, version, shipped, services, campaign };
    let out = workspace.root.join(&options.out);
    write(&out, &page.text()?)?;
    writeln!(std::io::stderr(), "bounds  written to {}", out.display())?;
    Ok(if page.is_well() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What `trolley doctor` finds about a deployment, whatever the machine lacks besides.
fn doctor(program: &Path, file: &Path, more: &[&str]) -> Result<Value> {
    let mut command = Command::new(program);
    command.args(["doctor", "--json", "--deployment"]).arg(file).args(more);
    let done = command.output().with_context(|| format!("cannot start {command:?}"))?;
    let said: Value = serde_json::from_slice(&done.stdout)
        .with_context(|| String::from_utf8_lossy(&done.stderr).into_owned())?;
    Ok(said["deployment"].clone())
}
