//! The drivers of other libraries: compiled here, if what they need is installed.
//!
//! A missing driver is no error: the reason and its remedy are printed, and the comparison
//! continues without it. Every driver is compiled with full optimisation for this machine.

use anyhow::{Context as _, Result};
use check::built::{self, CargoWorkspace};
use check::step::cargo;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// All peers that can be asked for.
pub(crate) const NAMES: &[&str] = &["embree", "parry", "fcl"];

/// What every driver in C++ is compiled with; fused operations would change the input.
const FLAGS: &[&str] = &["-O3", "-march=native", "-ffp-contract=off", "-DNDEBUG", "-std=c++17"];

/// A driver in C++: `tools/peers/NAME.cpp`.
struct Driver {
    name: &'static str,
    /// Debian packages.
    packages: &'static [&'static str],
    flags: &'static [&'static str],
    libraries: &'static [&'static str],
}

const DRIVERS: &[Driver] = &[
    Driver { name: "embree", packages: &["libembree-dev"], flags: &[], libraries: &["-lembree3"] },
    Driver {
        name: "fcl",
        packages: &["libfcl-dev", "libeigen3-dev"],
        flags: &["-isystem", "/usr/include/eigen3"],
        libraries: &["-lfcl", "-lccd", "-loctomap", "-loctomath"],
    },
    Driver {
        name: "oracle",
        packages: &["libcgal-dev", "libgmp-dev", "libmpfr-dev"],
        flags: &["-frounding-math"],
        libraries: &["-lgmp", "-lmpfr"],
    },
];

/// Continuous collision of FCL.
const FCL_SWEEPS: Driver = Driver {
    name: "sweeps_fcl",
    packages: &["libfcl-dev", "libeigen3-dev"],
    flags: &["-isystem", "/usr/include/eigen3"],
    libraries: &["-lfcl", "-lccd", "-loctomap", "-loctomath"],
};

/// The drivers for first contact, with the programs that run them; or why there are none.
pub(crate) fn sweeps(workspace: &CargoWorkspace) -> Vec<Result<Vec<PathBuf>, String>> {
    let parry = parry(workspace, "peer-parry-sweeps").map(|program| vec![program]);
    let fcl = FCL_SWEEPS.program(workspace).map(|program| vec![program]);
    vec![parry.map_err(|fault| format!("parry: left out: {fault:#}")), fcl, ipctk(workspace)]
}

/// A script, if the Python that is found first has the package.
fn ipctk(workspace: &CargoWorkspace) -> Result<Vec<PathBuf>, String> {
    let mut command = Command::new("python3");
    let there = command.args(["-c", "import ipctk"]).stderr(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        return Err("ipctk: left out, python3 has no package ipctk: pip install ipctk".into());
    }
    Ok(vec!["python3".into(), workspace.root.join("tools/peers/sweeps_ipctk.py")])
}

/// The driver of a peer, or why there is none.
pub(crate) fn driver(name: &str, workspace: &CargoWorkspace) -> Result<PathBuf, String> {
    match DRIVERS.iter().find(|driver| driver.name == name) {
        Some(driver) => driver.program(workspace),
        None => {
            parry(workspace, "peer-parry").map_err(|fault| format!("parry: left out: {fault:#}"))
        }
    }
}

/// The driver that knows the exact answer, or why there is none.
pub(crate) fn oracle(workspace: &CargoWorkspace) -> Result<PathBuf, String> {
    driver("oracle", workspace).map_err(|why| format!("{why}; answers are not checked"))
}

/// The installed versions of what the drivers use.
pub(crate) fn versions() -> Vec<(&'static str, String)> {
    let packages = DRIVERS.iter().map(|driver| driver.packages[0]);
    packages.filter_map(|package| Some((package, version(package)?))).collect()
}

impl Driver {
    fn program(&self, workspace: &CargoWorkspace) -> Result<PathBuf, String> {
        let missing = |package: &&&str| version(package).is_none();
        if let Some(package) = self.packages.iter().find(missing) {
            let all = self.packages.join(" ");
            return Err(format!(
                "{}: left out, there is no Debian package {package}: apt-get install g++ {all}",
                self.name
            ));
        }
        self.compile(workspace).map_err(|fault| format!("{}: left out: {fault:#}", self.name))
    }

    fn compile(&self, workspace: &CargoWorkspace) -> Result<PathBuf> {
        let folder = workspace.target.join("peers");
        fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let (sources, program) = (workspace.root.join("tools/peers"), folder.join(self.name));
        if is_newer(&program, &sources)? {
            return Ok(program);
        }
        let mut command = Command::new("g++");
        command.args(FLAGS).args(self.flags).arg("-o").arg(&program);
        command.arg(sources.join(format!("{}.cpp", self.name))).args(self.libraries);
        built::output(&mut command)?;
        Ok(program)
    }
}

/// Whether `program` was made after the last change to any of the sources.
fn is_newer(program: &Path, sources: &Path) -> Result<bool> {
    let Ok(made) = program.metadata() else { return Ok(false) };
    let made = made.modified()?;
    for entry in fs::read_dir(sources).with_context(|| sources.display().to_string())? {
        if entry?.metadata()?.modified()? >= made {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The version of an installed Debian package.
fn version(package: &str) -> Option<String> {
    let done = Command::new("dpkg-query")
        .args(["--show", "--showformat", "${db:Status-Status} ${Version}", package])
        .stderr(Stdio::null())
        .output()
        .ok()?;
    Some(String::from_utf8(done.stdout).ok()?.strip_prefix("installed ")?.to_owned())
}

/// In a folder of its own, because it is compiled for this machine alone.
fn parry(workspace: &CargoWorkspace, name: &str) -> Result<PathBuf> {
    built::executable(
        cargo()
            .args(["build", "--profile", "peer", "--package", "trolley-tools"])
            .args(["--bin", name, "--features", "parry"])
            .args([OsStr::new("--target-dir"), workspace.target.join("peers").as_os_str()])
            .env("RUSTFLAGS", "-C target-cpu=native"),
    )
}
