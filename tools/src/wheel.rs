//! `cargo x wheel`: the Python package, built, and tried where there is neither cargo nor a
//! checkout on the path.
//!
//! ```text
//! maturin ──▶ target/wheel/dist/*.whl ──▶ an empty environment ──▶ tests
//!                                     ├─▶ one with Jupyter ──────▶ the three notebooks
//!                                     └─▶ one with the peers ────▶ the page (--compare alone)
//! ```
//!
//! Environments lie below the target directory. All but that of the tests are kept; it is made anew
//! each time. Packages come from the index that pip is set up for.

use crate::compare::cases;
use crate::machine;
use anyhow::{Context as _, Result, bail};
use check::built::{self, CargoWorkspace, output, write};
use check::step::cargo;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// What to do with the package.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Compare it with python-fcl, trimesh, coal, trueform, MeshLib and Open3D instead, and write
    /// tools/results/python.md.
    #[arg(long, conflicts_with = "long")]
    compare: bool,
    /// Make a million random calls too, and look for leaks over 100,000 bodies.
    #[arg(long)]
    long: bool,
    /// The Python that makes the environments.
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: PathBuf,
}

/// What builds the package.
const BUILD: &[&str] = &["maturin>=1.16,<2"];

/// What its tests need besides.
const TESTS: &[&str] =
    &["pytest", "pyarrow", "mypy", "trimesh", "commonroad-io", "matplotlib", "fsspec"];

/// What the notebooks need.
const NOTEBOOKS: &[&str] = &["jupytext", "nbconvert", "ipykernel", "matplotlib", "pyarrow"];

/// What it is compared with; each is left out if it cannot be installed.
const PEERS: &[&[&str]] =
    &[&["python-fcl", "trimesh", "scipy"], &["coal"], &["trueform"], &["meshlib"], &["open3d"]];

/// Seeds of the long run of random calls.
const CALLS: &[&str] = &["--calls", "1000000", "--seed", "1"];

/// Builds the package, and tries it.
pub(crate) fn run(options: &Options) -> Result<ExitCode> {
    let workspace = CargoWorkspace::find()?;
    let wheels = workspace.target.join("wheel");
    let python = Python { program: &options.python, folder: &wheels };
    let package = workspace.root.join("crates/python");

    step("wheel")?;
    let build = python.environment("build", BUILD, Kept::Yes)?;
    let wheel = built_wheel(&build, &package, &wheels.join("dist"))?;
    let program =
        built::executable(cargo().args(["build", "--release", "--package", "trolley-cli"]))?;

    if options.compare {
        return compare(&python, &workspace, &wheel, &program);
    }

    step("clippy, with Arrow")?;
    let clippy =
        ["clippy", "--package", "trolley-python", "--all-features", "--", "-D", "warnings"];
    output(cargo().args(clippy))?;

    step("tests in an empty environment")?;
    let empty = python.environment("empty", TESTS, Kept::No)?;
    empty.install(&[&wheel.display().to_string()])?;
    let tests = package.join("tests");
    let cases = workspace.target.join("cases");
    cases::made(&cases, &|_| true)?;
    let cases = cases.canonicalize()?.display().to_string();
    let pytest = ["-m", "pytest", "-p", "no:cacheprovider", "-rs", "--cases", &cases, "tests"];
    empty.run(&pytest, &package, &program)?;
    empty.run(&["-m", "mypy", "--strict", "tests/typed.py"], &package, &program)?;
    if options.long {
        step("a million random calls")?;
        empty.run(&[&["fuzz.py"], CALLS].concat(), &tests, &program)?;
        step("100,000 bodies")?;
        empty.run(&["leaks.py", "--bodies", "100000"], &tests, &program)?;
    }

    step("notebooks")?;
    let jupyter = python.environment("notebooks", NOTEBOOKS, Kept::Yes)?;
    jupyter.install(&["--force-reinstall", "--no-deps", &wheel.display().to_string()])?;
    for name in ["intersect", "policies", "sweep"] {
        let script = package.join(format!("notebooks/{name}.py"));
        let ran = wheels.join(format!("{name}.ipynb"));
        let [script, ran] = [script, ran].map(|path| path.display().to_string());
        let execute = ["-m", "jupytext", "--quiet", "--to", "ipynb", "--execute", "--output"];
        jupyter.run(&[&execute[..], &[&ran, &script]].concat(), &package, &program)?;
        step(&format!("{name}: {ran}"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the page; fails if a gate is missed.
fn compare(
    python: &Python<'_>,
    workspace: &CargoWorkspace,
    wheel: &Path,
    program: &Path,
) -> Result<ExitCode> {
    step("comparison")?;
    let peers = python.environment("peers", &["numpy"], Kept::Yes)?;
    for packages in PEERS {
        if peers.install(packages).is_err() {
            step(&format!("left out: {} cannot be installed", packages.join(", ")))?;
        }
    }
    peers.install(&["--force-reinstall", "--no-deps", &wheel.display().to_string()])?;
    let mut command = peers.command(&["tools/peers/compare_python.py"], program);
    command.current_dir(&workspace.root).arg(program).arg("crates/python/tests");
    let done = command.stderr(Stdio::inherit()).output()?;
    let said = String::from_utf8(done.stdout)?;
    if !said.contains("## Rankings") {
        bail!("{command:?}: {}", done.status);
    }
    let mut page =
        "# The Python package beside others\n\nWritten by `cargo x wheel --compare`.\n\n"
            .to_owned();
    for (name, value) in machine::describe(&workspace.root)? {
        page += &format!("- {name}: {value}\n");
    }
    page += &format!("\n{}\n", said.trim_end());
    write(&workspace.root.join("tools/results/python.md"), &page)?;
    io::stdout().lock().write_all(page.as_bytes())?;
    Ok(if done.status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Has maturin build the one wheel of a folder.
pub(crate) fn built_wheel(build: &Environment, package: &Path, folder: &Path) -> Result<PathBuf> {
    if folder.is_dir() {
        fs::remove_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let mut maturin = Command::new(build.folder.join("bin/maturin"));
    maturin.args(["build", "--release", "--locked", "--quiet", "--out"]).arg(folder);
    output(maturin.current_dir(package))?;
    let mut wheels = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let wheel: Result<PathBuf> = wheels.next().context("maturin wrote no wheel")?;
    let wheel = wheel?;
    let bytes = fs::metadata(&wheel)?.len();
    step(&format!("{}: {:.1} MB", wheel.display(), bytes as f64 / 1e6))?;
    Ok(wheel)
}

/// Says what is done.
fn step(what: &str) -> Result<()> {
    Ok(writeln!(io::stdout().lock(), "wheel   {what}")?)
}

/// What makes environments.
pub(crate) struct Python<'p> {
    pub(crate) program: &'p Path,
    pub(crate) folder: &'p Path,
}

/// Whether an environment is kept from run to run.
#[derive(PartialEq)]
pub(crate) enum Kept {
    Yes,
    No,
}

/// A virtual environment.
pub(crate) struct Environment {
    pub(crate) folder: PathBuf,
}

impl Python<'_> {
    /// An environment with these packages.
    pub(crate) fn environment(
        &self,
        name: &str,
        packages: &[&str],
        kept: Kept,
    ) -> Result<Environment> {
        let folder = self.folder.join(name);
        if kept == Kept::No && folder.is_dir() {
            fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
        }
        if !folder.join("bin/python").exists() {
            output(Command::new(self.program).args(["-m", "venv"]).arg(&folder))
                .context("this needs python3 with venv")?;
        }
        let environment = Environment { folder };
        environment.install(packages)?;
        Ok(environment)
    }
}

impl Environment {
    pub(crate) fn install(&self, packages: &[&str]) -> Result<()> {
        let mut pip = Command::new(self.folder.join("bin/python"));
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        output(pip.args(packages)).map(drop).context("pip could not install what is needed")
    }

    /// Python as somebody has it who has no Rust: nothing but the system and this environment.
    pub(crate) fn command(&self, arguments: &[&str], program: &Path) -> Command {
        let mut command = Command::new(self.folder.join("bin/python"));
        let path = format!("{}:/usr/bin:/bin", self.folder.join("bin").display());
        command.args(arguments).env_clear().env("PATH", path).env("TROLLEY", program);
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        if let Some(home) = std::env::var_os("HOME") {
            command.env("HOME", home);
        }
        command
    }

    fn run(&self, arguments: &[&str], folder: &Path, program: &Path) -> Result<()> {
        let mut command = self.command(arguments, program);
        let status = command.current_dir(folder).stdin(Stdio::null()).status()?;
        if !status.success() {
            bail!("{command:?}: {status}");
        }
        Ok(())
    }
}
