//! `cargo x soak`, `model`, `corrupt` and `fuzz`: long versions of short tests.

use anyhow::{Context as _, Result, bail};
use check::built::{CargoWorkspace, executable};
use check::step::cargo;
use clap::Args;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Coverage for libFuzzer, by flags that stable Rust has; and the checks of debug builds.
const COVERAGE: &str = "-Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters \
    -Cllvm-args=-sanitizer-coverage-pc-table -Cllvm-args=-sanitizer-coverage-trace-compares \
    -Ccodegen-units=1 -Cdebug-assertions -Coverflow-checks";

/// How to fuzz.
#[derive(Debug, Args)]
pub(crate) struct FuzzOptions {
    /// Targets to fuzz; empty: all.
    targets: Vec<String>,
    /// For how much CPU time each (s).
    #[arg(long, value_name = "S", default_value_t = 600)]
    seconds: u64,
    /// Another folder of inputs to start from.
    #[arg(long, value_name = "DIR")]
    seeds: Option<PathBuf>,
}

/// Simulated worlds, on all cores.
pub(crate) fn soak(worlds: u64, from: u64) -> Result<ExitCode> {
    let program = executable(cargo().args(["build", "--release", "--package", "trolley-cli"]))?;
    let (worlds, from) = (worlds.to_string(), from.to_string());
    let worlds = ["simulate", "faults", "--worlds", &worlds, "--from", &from];
    passed(Command::new(program).args(worlds))
}

/// All states of the larger small worlds.
pub(crate) fn model() -> Result<ExitCode> {
    test(&["--package", "trolley-simulate", "--lib", "--", "faults::model"])
}

/// Ten million corrupted messages.
pub(crate) fn corrupt() -> Result<ExitCode> {
    test(&["--package", "trolley-protocol", "--test", "corrupt", "--"])
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
    let workspace = CargoWorkspace::find()?;
    let corpora = workspace.root.join("tools/fuzz/corpus");
    let targets = names(&corpora)?;
    if let Some(name) = options.targets.iter().find(|name| !targets.contains(name)) {
        bail!("unknown target {name}: expected one of {}", targets.join(", "));
    }
    let home = workspace.target.join("fuzz");
    // A target named, even if it is this machine's: else build scripts would be compiled with the
    // flags too, and not link.
    let triple = format!("{}-unknown-linux-gnu", std::env::consts::ARCH);
    let program = executable(
        cargo()
            .args(["build", "--release", "--package", "trolley-fuzz", "--features", "libfuzzer"])
            .args(["--target", &triple])
            .env("RUSTFLAGS", COVERAGE)
            .env("CARGO_TARGET_DIR", &home),
    )?;
    let mut code = ExitCode::SUCCESS;
    for name in &targets {
        if !options.targets.is_empty() && !options.targets.contains(name) {
            continue;
        }
        let grown = home.join("grown").join(name);
        let found = home.join("found").join(name);
        for folder in [&grown, &found] {
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        }
        let begun_s = children_s();
        // libFuzzer goes by the clock on the wall: on a busy machine one run is not enough.
        while children_s() - begun_s < options.seconds as f64 {
            let left_s = options.seconds as f64 - (children_s() - begun_s);
            let mut command = Command::new(&program);
            command
                .arg(format!("--target={name}"))
                .arg(&grown)
                .arg(corpora.join(name))
                .args(&options.seeds)
                .arg(format!("-max_total_time={}", left_s.ceil().max(5.0)))
                .args(["-timeout=10", "-rss_limit_mb=1024", "-max_len=65536"])
                .arg("-print_final_stats=1")
                .arg(format!("-artifact_prefix={}/", found.display()));
            let status = command.status().with_context(|| format!("cannot start {command:?}"))?;
            if !status.success() {
                code = ExitCode::FAILURE;
                break;
            }
        }
        let mut out = std::io::stdout().lock();
        writeln!(out, "{name}: {:.0} s of CPU time", children_s() - begun_s)?;
    }
    Ok(code)
}

/// What a folder holds, sorted.
fn names(folder: &Path) -> Result<Vec<String>> {
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut names = Vec::new();
    for entry in entries {
        names.push(entry?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

/// CPU time of all children that have ended (s).
fn children_s() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Fields after the name in parentheses; 16 and 17 of all, in ticks of 10 ms.
    let fields = text.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(13).take(2).filter_map(|n| n.parse::<u64>().ok());
    ticks.sum::<u64>() as f64 / 100.0
}
