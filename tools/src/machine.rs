//! The machine of a measurement: processor, caches, kernel, compilers, commit.
//!
//! Dates are those of commits; nothing here reads a clock.

use anyhow::Result;
use check::built::output;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// Everything, as names and values for people.
pub(crate) fn describe(root: &Path) -> Result<Vec<(&'static str, String)>> {
    let mut all = vec![
        ("processor", processor()),
        ("cores", cores()),
        ("caches of core 0", caches()),
        ("system", format!("Linux {}", read("/proc/sys/kernel/osrelease"))),
        ("rustc", rustc()?),
        ("commit", format!("{} of {}", commit(root)?, git(root, &["log", "-1", "--format=%cs"])?)),
    ];
    let version = |program: &str| {
        let said = Command::new(program).arg("--version").stderr(Stdio::null()).output().ok()?;
        Some(String::from_utf8_lossy(&said.stdout).lines().next()?.to_owned())
    };
    all.extend(version("g++").map(|compiler| ("g++", compiler)));
    Ok(all)
}

/// The compiler.
pub(crate) fn rustc() -> Result<String> {
    Ok(output(Command::new("rustc").arg("--version"))?.trim().to_owned())
}

/// The last commit, with a `+` if the sources differ from it.
pub(crate) fn commit(root: &Path) -> Result<String> {
    let head = git(root, &["rev-parse", "--short=10", "HEAD"])?;
    let changed = git(root, &["status", "--porcelain", "--", "crates", "tools", "Cargo.*"])?;
    // The results themselves do not count as changes.
    let changed = changed.lines().any(|line| !line.contains("tools/results/"));
    Ok(head + if changed { "+" } else { "" })
}

fn git(root: &Path, arguments: &[&str]) -> Result<String> {
    Ok(output(Command::new("git").arg("-C").arg(root).args(arguments))?.trim().to_owned())
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap_or_else(|_| "unknown".into()).trim().to_owned()
}

fn processor() -> String {
    let info = read("/proc/cpuinfo");
    let field = |name: &str| {
        let line = info.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    // On ARM there is no name, but the part number of the core.
    let part = || Some(format!("{}, part {}", std::env::consts::ARCH, field("CPU part")?));
    let name = field("model name").or_else(part).unwrap_or_else(|| "unknown".into());
    let flags = field("flags").or_else(|| field("Features")).unwrap_or_default();
    let has = |wanted: &&str| flags.split(' ').any(|flag| flag == *wanted);
    let known = ["avx512f", "avx2", "sse4_2", "asimd"];
    let widest: Vec<&str> = known.into_iter().filter(has).collect();
    format!("{name} ({})", widest.join(", "))
}

fn cores() -> String {
    std::thread::available_parallelism().map_or("unknown".into(), |cores| cores.to_string())
}

fn caches() -> String {
    let cache = |index: usize| {
        let at =
            |name: &str| read(format!("/sys/devices/system/cpu/cpu0/cache/index{index}/{name}"));
        let kind = match at("type").as_str() {
            "Data" => "d",
            "Instruction" => "i",
            _ => "",
        };
        format!("L{}{kind} {}", at("level"), at("size"))
    };
    let there = |index: &usize| {
        Path::new(&format!("/sys/devices/system/cpu/cpu0/cache/index{index}")).is_dir()
    };
    let caches: Vec<String> = (0..8).filter(there).map(cache).collect();
    if caches.is_empty() { "unknown".into() } else { caches.join(", ") }
}
