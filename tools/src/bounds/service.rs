//! A service that is asked as much as may be, under watch.

use super::doctor;
mod footprint;

use anyhow::{Context as _, Result, bail};
use footprint::{Taken, folder, largest_request};
use serde_json::Value;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A deployment to measure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Case {
    pub(super) name: &'static str,
    triangles: u32,
    /// 0: all work is done in the service.
    workers: u32,
    members: u32,
    /// Memory is locked, and so much of the heap touched in advance (MiB).
    locked_mib: Option<u32>,
}

/// From a service that locks nothing, where what is used shows, to one as it ships.
pub(super) const CASES: [Case; 4] = [
    Case {
        name: "2 workers, 10,000 triangles, 32 members",
        triangles: 10_000,
        workers: 2,
        members: 32,
        locked_mib: None,
    },
    Case {
        name: "4 workers, 100,000 triangles, 8 members",
        triangles: 100_000,
        workers: 4,
        members: 8,
        locked_mib: None,
    },
    Case {
        name: "2 workers, 10,000 triangles, 8 members, locked",
        triangles: 10_000,
        workers: 2,
        members: 8,
        locked_mib: Some(64),
    },
    Case {
        name: "no workers, 10,000 triangles, 8 members",
        triangles: 10_000,
        workers: 0,
        members: 8,
        locked_mib: None,
    },
];

/// What was computed and measured.
#[derive(Debug)]
pub(super) struct Measured {
    pub(super) case: Case,
    pub(super) computed: Value,
    pub(super) service: Taken,
    pub(super) worker: Taken,
    pub(super) segments: u64,
    pub(super) bytes: u64,
    /// What `trolley top` says after the same small request again and again: messages of one,
    /// allocations of the last one, page faults of all after the first hundred.
    pub(super) small: Value,
    pub(super) small_requests: u64,
}

/// Requests of the small kind: the first hundred are not counted.
const SMALL: u64 = 300;
/// Clients and listeners that a service takes.
const CLIENTS: usize = 16;

/// Runs a service and asks.
#[expect(clippy::disallowed_methods, reason = "no event says what a process has taken")]
pub(super) fn measure(program: &Path, case: Case, scratch: &Path) -> Result<Measured> {
    let place = scratch.join("s");
    fs::create_dir_all(&place)?;
    let file = scratch.join("deployment.toml");
    fs::write(&file, case.deployment(&place))?;
    let in_process = (case.workers == 0).then_some("--in-process");
    let more: Vec<&str> = ["--jobs", "0"].into_iter().chain(in_process).collect();
    let computed = doctor(program, &file, &more)?;
    let mut command = Command::new(program);
    command.arg("serve").arg(&file).args(in_process).stderr(Stdio::piped());
    let mut serving = Serving(command.spawn()?);
    let stderr = serving.0.stderr.take().context("no stderr")?;
    let is_ready = |line: &std::io::Result<String>| {
        line.as_ref().is_ok_and(|line| line.contains("serving as"))
    };
    if !BufReader::new(stderr).lines().any(|line| is_ready(&line)) {
        bail!("{}: the service did not start", case.name);
    }
    let pid = serving.0.id();
    let ask = |scenario: &PathBuf| {
        let mut query = Command::new(program);
        query.arg("query").arg(&file).arg(scenario).args(["--deadline-ms", "3600000"]);
        query.stdout(Stdio::null()).stderr(Stdio::null());
        query
    };
    // The small request first: what is counted of it begins with the service.
    let small = scratch.join("small.toml");
    fs::write(&small, case.small())?;
    let repeat = (SMALL - 200).to_string();
    let done = ask(&small).args(["--repeat", &repeat]).status()?;
    if !done.success() {
        bail!("{}: the small request failed", case.name);
    }
    let top =
        Command::new(program).arg("top").arg(&file).args(["--times", "2", "--json"]).output()?;
    let said = String::from_utf8(top.stdout)?;
    let last = said.lines().last().context("top said nothing")?;
    let last: Value = serde_json::from_str(last)?;

    let large = scratch.join("large.toml");
    fs::write(&large, largest_request(case.triangles, case.members))?;
    let mut asking = vec![ask(&large).spawn()?];
    let alone = ["--members", "1"];
    for _ in 1..CLIENTS {
        asking.push(ask(&large).args(alone).spawn()?);
    }
    for _ in 0..CLIENTS {
        let mut top = Command::new(program);
        top.arg("top").arg(&file).args(["--times", "4"]);
        asking.push(top.stdout(Stdio::null()).stderr(Stdio::null()).spawn()?);
    }
    let (mut service, mut worker) = (Taken::default(), Taken::default());
    let (mut segments, mut bytes) = (0, 0);
    let children = format!("/proc/{pid}/task/{pid}/children");
    while !asking.is_empty() {
        service.look(pid);
        let workers = fs::read_to_string(&children).unwrap_or_default();
        workers.split_whitespace().flat_map(str::parse).for_each(|pid| worker.look(pid));
        let found = folder(&place);
        (segments, bytes) = (segments.max(found.0), bytes.max(found.1));
        std::thread::sleep(Duration::from_millis(20));
        let mut failed = false;
        asking.retain_mut(|child| match child.try_wait() {
            // Busy, or too many of its kind, is an answer too.
            Ok(Some(end)) => {
                failed |= !matches!(end.code(), Some(0 | 3 | 75));
                false
            }
            _ => true,
        });
        if failed {
            bail!("{}: a client failed", case.name);
        }
    }
    drop(serving);
    let answers = |at: usize| last["answers"][at][1].as_u64().unwrap_or(0);
    let small_requests = (0..5).map(answers).sum();
    Ok(Measured { case, computed, service, worker, segments, bytes, small: last, small_requests })
}

impl Case {
    fn deployment(&self, folder: &Path) -> String {
        let Self { triangles, members, workers, locked_mib, .. } = *self;
        let (is_locked, heap) = (locked_mib.is_some(), locked_mib.unwrap_or(0));
        let workers = workers.max(1);
        let mut text = format!(
            "schema = \"trolley.deployment/1\"\ninstance = \"bounds\"\nfolder = {folder:?}\n\
             members = {members}\nmembers_max = {members}\nmembers_limit = {members}\n\
             [engine]\nworkers = {workers}\n[realtime]\npriority = 0\nworker_priority = 0\n\
             lock_memory = {is_locked}\nheap_mib = {heap}\n"
        );
        for (id, shape) in [(1, "sedan"), (2, "suv")] {
            text += &format!(
                "[[models]]\nid = {id}\nname = \"{shape}\"\n\
                 generate = {{ shape = \"{shape}\", triangles = {triangles} }}\n"
            );
        }
        text
    }

    /// A crash as it is said.
    fn small(&self) -> String {
        let triangles = self.triangles;
        format!(
            "schema = \"trolley.scenario/2\"\nname = \"a crash\"\nmembers = 1\n[parties]\n\
             ego = {{ generate = {{ shape = \"sedan\", triangles = {triangles} }} }}\n\
             [parties.other]\ngenerate = {{ shape = \"suv\", triangles = {triangles} }}\n\
             place = {{ position_m = [12, 0.5, 0], yaw_deg = 20 }}\n\
             [[candidates]]\nname = \"straight on\"\n\
             state = {{ position_m = [0, 0, 0], velocity_m_s = [12, 0] }}\n\
             [[candidates]]\nname = \"to the side\"\n\
             state = {{ position_m = [0, 0, 0], velocity_m_s = [12, -1] }}\n"
        )
    }
}

/// A service, which ends with this value.
struct Serving(Child);

impl Drop for Serving {
    fn drop(&mut self) {
        if let Some(pid) = i32::try_from(self.0.id()).ok().and_then(rustix::process::Pid::from_raw)
        {
            let _gone = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        }
        let _reaped = self.0.wait();
    }
}
