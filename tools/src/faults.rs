//! `cargo x soak`, `model`, `corrupt` and `fuzz`: the long runs of what the tests run briefly.

use crate::built::{Workspace, executable};
use crate::step::cargo;
use anyhow::{Context as _, Result, bail};
use clap::Args;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

/// Names of the targets of `tools/fuzz`.
const TARGETS: &[&str] =
    &["obj", "stl", "ply", "gltf", "scenario", "policy", "curves", "model-file", "record", "wire"];
/// Coverage for libFuzzer, by flags that stable Rust has; and the checks of debug builds.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares \
    -Ccodegen-units=1 -Cdebug-assertions -Coverflow-checks";

/// How to fuzz.
#[derive(Debug, Args)]
pub(crate) struct FuzzOptions {
    /// Which targets; all if none is named.
    targets: Vec<String>,
    /// For how long each (s).
    #[arg(long, value_name = "S", default_value_t = 600)]
    seconds: u64,
    /// Another folder of inputs to start from.
    #[arg(long, value_name = "DIR")]
    seeds: Option<PathBuf>,
}

/// Simulated worlds, on all cores.
pub(crate) fn soak(worlds: u64, from: u64) -> Result<ExitCode> {
    let program = executable(cargo().args(["build", "--release", "--package", "cli"]))?;
    let (worlds, from) = (worlds.to_string(), from.to_string());
    let worlds = ["simulate", "faults", "--worlds", &worlds, "--from", &from];
    passed(Command::new(program).args(worlds))
}

/// All states of the larger small worlds.
pub(crate) fn model() -> Result<ExitCode> {
    test(&["--package", "simulate", "--lib", "--", "faults::model"])
}

/// Ten million corrupted messages.
pub(crate) fn corrupt() -> Result<ExitCode> {
    test(&["--package", "protocol", "--test", "corrupt", "--"])
}

fn test(of: &[&str]) -> Result<ExitCode> {
    let how = ["--include-ignored", "--nocapture", "--test-threads", "1"];
    passed(cargo().args(["test", "--release"]).args(of).args(how))
}

fn passed(command: &mut Command) -> Result<ExitCode> {
    let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
    Ok(if status.success() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Fuzzes each target for its time; what is found stays in the folder that is named.
pub(crate) fn fuzz(options: &FuzzOptions) -> Result<ExitCode> {
    if let Some(name) = options.targets.iter().find(|name| !TARGETS.contains(&name.as_str())) {
        bail!("there is no target {name}: there are {}", TARGETS.join(", "));
    }
    let workspace = Workspace::find()?;
    let home = workspace.target.join("fuzz");
    // A target named, even if it is this machine's: else build scripts would be compiled with the
    // flags too, and not link.
    let triple = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let program = executable(
        cargo()
            .args(["build", "--release", "--package", "fuzz", "--features", "libfuzzer"])
            .args(["--target", &triple])
            .env("RUSTFLAGS", COVERAGE)
            .env("CARGO_TARGET_DIR", &home),
    )?;
    let mut code = ExitCode::SUCCESS;
    for name in TARGETS {
        if !options.targets.is_empty() && !options.targets.iter().any(|asked| asked == name) {
            continue;
        }
        let grown = home.join("grown").join(name);
        let found = home.join("found").join(name);
        for folder in [&grown, &found] {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        let mut command = Command::new(&program);
        command
            .arg(format!("--target={name}"))
            .arg(&grown)
            .arg(workspace.root.join("tools/fuzz/corpus").join(name))
            .args(&options.seeds)
            .arg(format!("-max_total_time={}", options.seconds))
            .args(["-timeout=10", "-rss_limit_mb=1024", "-max_len=65536", "-print_final_stats=1"])
            .arg(format!("-artifact_prefix={}/", found.display()));
        let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
        if !status.success() {
            code = ExitCode::FAILURE;
        }
    }
    Ok(code)
}
