//! A run of the program that ranks the plan's scenario once, for faults that take a whole run.

use super::plan::Plan;
use super::report::{Report, State};
use coordinator::Answer;
use runtime::process::{self, Spawn};
use runtime::{Child, Exit, clock};
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, References};

/// How long a client waits for an answer before it reports "refused" itself (ms).
pub(super) const PATIENCE_MS: u64 = 20_000;

pub(super) fn instance() -> String {
    format!("c{}", std::process::id())
}

/// The program to run, which ranks the scenario of a plan.
#[derive(Clone, Copy)]
pub(super) struct Rank<'r> {
    pub(super) program: &'r Path,
    pub(super) plan: &'r Plan,
    pub(super) references: References,
}

/// Such a run, its output in a file.
pub(super) struct Run {
    pub(super) child: Child,
    out: File,
}

impl Run {
    /// Starts it; `wrap`: a program, with arguments, to run it under.
    pub(super) fn start(rank: &Rank<'_>, wrap: &[&str]) -> Result<Self, Failure> {
        let Self { child, out } = Self::start_by(rank, wrap, process::spawn)?;
        Ok(Self { child: child.await_exec(PATIENCE_MS)?, out })
    }

    pub(super) fn start_by(
        rank: &Rank<'_>,
        wrap: &[&str],
        spawn: fn(Spawn<'_>) -> Result<Child, runtime::OsError>,
    ) -> Result<Self, Failure> {
        let internal =
            |error: std::io::Error| Failure::new(trolley::FailureKind::System, error.to_string());
        let Rank { program, plan, references } = rank;
        let outside = (*references == References::Anywhere).then_some("--allow-outside");
        let own = program.display().to_string();
        let scenario = plan.scenario.display().to_string();
        let (workers, depth) = (plan.workers.to_string(), plan.depth.to_string());
        let name = instance();
        let line = [
            own.as_str(),
            "-q",
            "rank",
            &scenario,
            "--json",
            "--workers",
            &workers,
            "--depth",
            &depth,
            "--instance",
            &name,
        ];
        let line: Vec<String> =
            wrap.iter().copied().chain(line).chain(outside).map(str::to_owned).collect();
        let out = tempfile::tempfile().map_err(internal)?;
        let null = File::open("/dev/null").map_err(internal)?;
        let child = spawn(Spawn {
            program: &PathBuf::from(&line[0]),
            args: &line[1..],
            fds: &[(out.as_fd(), 1), (null.as_fd(), 2)],
            core: None,
        })?;
        Ok(Self { child, out })
    }

    pub(super) fn workers(&self) -> Vec<u32> {
        let pid = self.child.pid();
        let path = format!("/proc/{pid}/task/{pid}/children");
        let list = std::fs::read_to_string(path).unwrap_or_default();
        list.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    }

    /// Waits for its end, and judges its answer. A run that does not end is killed, and counted as
    /// a hang.
    pub(super) fn end(mut self, reference: &Answer, report: &mut Report) -> Result<State, Failure> {
        let exit = self.child.wait_ms(PATIENCE_MS)?;
        if exit.is_none() {
            report.hangs += 1;
            self.child.kill()?;
        }
        let mut text = String::new();
        let read =
            self.out.seek(SeekFrom::Start(0)).and_then(|_| self.out.read_to_string(&mut text));
        let answer: Option<serde_json::Value> = match (exit, read) {
            (Some(Exit::Code(0)), Ok(_)) => serde_json::from_str(&text).ok(),
            _ => None,
        };
        Ok(match answer {
            None => State::Refused,
            Some(document) => {
                // As text as well: parsing a number may round it.
                let expected = serde_json::to_string(reference).ok();
                let expected: Option<serde_json::Value> =
                    expected.and_then(|text| serde_json::from_str(&text).ok());
                let is_same = document.get("answer") == expected.as_ref();
                if is_same { State::Complete } else { State::Wrong }
            }
        })
    }

    /// Waits until the workers were there and begin to end.
    pub(super) fn until_it_stops(&mut self) -> u64 {
        let mut most = 0;
        let end = clock::now_ns() + PATIENCE_MS * 1_000_000;
        while clock::now_ns() < end {
            let now = self.workers().len();
            if now < most || !matches!(self.child.wait_ms(1), Ok(None)) {
                break;
            }
            most = most.max(now);
        }
        0
    }
}
