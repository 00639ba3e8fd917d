//! A process under watch: it and its children, their memory and their time.

use anyhow::{Context as _, Result};
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// How often the memory of a process is looked at: the kernel keeps its peak in between.
const LOOK: Duration = Duration::from_millis(5);

/// What a process may take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    /// Resident memory of it and its children together (MiB).
    pub(super) mib: u64,
    /// From its start to its end.
    pub(super) time: Duration,
}

/// How a process ended.
#[derive(Debug)]
pub(super) struct Ended {
    /// `None`: by a signal, ours included.
    pub(super) code: Option<i32>,
    pub(super) stderr: String,
    /// Sum of the peaks of the processes that were there at once, as last seen (MiB).
    pub(super) peak_mib: u64,
    pub(super) time: Duration,
}

/// Runs a command without input; its output is not kept. It is killed beyond a limit.
#[expect(
    clippy::disallowed_methods,
    reason = "a time of the wall is what is measured, and no event says that memory grew"
)]
pub(super) fn run(mut command: Command, scratch: &Path, limits: Bounds) -> Result<Ended> {
    let log = scratch.join("stderr");
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(File::create(&log)?);
    let begin = Instant::now();
    let mut child = command.spawn().with_context(|| format!("cannot start {command:?}"))?;
    let mut peak_mib = 0;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        peak_mib = peak_mib.max(resident_kib(child.id()) / 1024);
        if peak_mib > limits.mib || begin.elapsed() >= limits.time {
            // Its children die with it: they ask the kernel for that.
            child.kill()?;
            break child.wait()?;
        }
        std::thread::sleep(LOOK);
    };
    let stderr = String::from_utf8_lossy(&fs::read(&log)?).into_owned();
    Ok(Ended { code: status.code(), stderr, peak_mib, time: begin.elapsed() })
}

/// Peak resident memory of a process and of all that it started (KiB); 0 of one that has ended.
fn resident_kib(process: u32) -> u64 {
    let mut open = vec![process.to_string()];
    let mut kib = 0;
    while let Some(id) = open.pop() {
        let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let number = peak.and_then(|text| text.trim().strip_suffix("kB")?.trim().parse().ok());
        kib += number.unwrap_or(0_u64);
        let children = fs::read_to_string(format!("/proc/{id}/task/{id}/children"));
        open.extend(children.unwrap_or_default().split_whitespace().map(str::to_owned));
    }
    kib
}
