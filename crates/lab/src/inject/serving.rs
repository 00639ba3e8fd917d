//! A service in a folder of its own, and clients that ask it for the ranking of the plan's
//! scenario.

use super::report::State;
use super::run::Rank;
use coordinator::Answer;
use runtime::process::{self, Spawn};
use runtime::{Child, Exit, clock};
use scenario::{Scenario, Source};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, FailureKind};

/// How long a service may take to start, and its first client to get an answer (ms).
pub(super) const START_MS: u64 = 20_000;
/// How long a service may take to end when it is told to (ms).
const END_MS: u64 = 5_000;
/// How long after its deadline a client may still run (ms): it starts, reads files, and ends.
const CLIENT_MS: u64 = 1_000;
const INSTANCE: &str = "faulty";
const TERMINATE: i32 = 15;

/// What a client was told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Told {
    pub(super) state: State,
    /// How it ended; `None`: it did not, and was killed.
    pub(super) exit: Option<Exit>,
}

/// A client on its way.
pub(super) struct Asking {
    child: Child,
    out: File,
    deadline_ms: u64,
}

/// A folder for services of one instance, one after the other.
pub(super) struct Serving {
    rank: PathBuf,
    scenario: PathBuf,
    place: tempfile::TempDir,
    deployment: PathBuf,
    /// A program, with arguments, to run services under.
    wrap: Vec<String>,
    service: Option<Child>,
}

fn system(error: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
}

impl Serving {
    /// Prepares a folder; `None` if some bodies are not generated.
    pub(super) fn prepare(rank: &Rank<'_>, scenario: &Scenario) -> Result<Option<Self>, Failure> {
        // The names of sockets in it must be short.
        let place = tempfile::Builder::new().prefix("i").tempdir_in("/dev/shm").map_err(system)?;
        let mut text = format!(
            "schema = \"trolley.deployment/1\"\ninstance = \"{INSTANCE}\"\nfolder = {:?}\n\
             [engine]\nworkers = {}\n[realtime]\npriority = 0\nworker_priority = 0\n\
             lock_memory = false\nheap_mib = 8\n",
            place.path().join("shm"),
            rank.plan.workers
        );
        std::fs::create_dir(place.path().join("shm")).map_err(system)?;
        for (number, party) in scenario.parties.iter().enumerate() {
            let Source::Generate { shape, triangles, seed } = party.source else {
                return Ok(None);
            };
            // Writing to a string cannot fail.
            let _written = writeln!(
                text,
                "[[models]]\nid = {0}\nname = \"m{0}\"\ngenerate = {{ shape = \"{1}\", triangles = \
                 {triangles}, seed = {seed} }}",
                number + 1,
                shape.name()
            );
        }
        let deployment = place.path().join("deployment.toml");
        std::fs::write(&deployment, text).map_err(system)?;
        let scenario = rank.plan.scenario.clone();
        let rank = rank.program.to_owned();
        let (wrap, service) = (Vec::new(), None);
        Ok(Some(Self { rank, scenario, place, deployment, wrap, service }))
    }

    /// The folder of shared files.
    pub(super) fn folder(&self) -> PathBuf {
        self.place.path().join("shm")
    }

    /// Starts a service, which may take a while until it serves.
    pub(super) fn start(&mut self) -> Result<(), Failure> {
        let deployment = self.deployment.display().to_string();
        let line = ["-q", "serve", deployment.as_str()];
        let (child, _output) = self.run(&line)?;
        self.service = Some(child);
        Ok(())
    }

    /// How the service ended; `None` while it runs.
    pub(super) fn ended(&mut self) -> Result<Option<Exit>, Failure> {
        self.service.as_mut().map_or(Ok(None), |service| Ok(service.try_wait()?))
    }

    fn run(&self, args: &[&str]) -> Result<(Child, File), Failure> {
        let own = self.rank.display().to_string();
        let words = self.wrap.iter().map(String::as_str).chain([own.as_str()]);
        let line: Vec<String> = words.chain(args.iter().copied()).map(str::to_owned).collect();
        let out = tempfile::tempfile().map_err(system)?;
        let null = File::open("/dev/null").map_err(system)?;
        let child = process::spawn(Spawn {
            program: Path::new(&line[0]),
            args: &line[1..],
            fds: &[(out.as_fd(), 1), (null.as_fd(), 2)],
            core: None,
        })?;
        Ok((child, out))
    }

    /// Starts a client.
    pub(super) fn ask(&self, deadline_ms: u64) -> Result<Asking, Failure> {
        let files = [&self.deployment, &self.scenario].map(|path| path.display().to_string());
        let due = deadline_ms.to_string();
        let line = ["-q", "query", &files[0], &files[1], "--json", "--deadline-ms", &due];
        let (child, out) = self.run(&line)?;
        Ok(Asking { child, out, deadline_ms })
    }

    /// Asks until there is an answer: whether it came in time and is complete.
    pub(super) fn is_serving(&self, reference: &Answer) -> Result<bool, Failure> {
        let end_ns = clock::now_ns() + START_MS * 1_000_000;
        while clock::now_ns() < end_ns {
            match self.ask(5_000)?.told(reference)?.state {
                State::Complete => return Ok(true),
                State::Wrong => return Ok(false),
                State::Degraded | State::Refused => {}
            }
        }
        Ok(false)
    }

    /// Tells the service to end: whether it did in time. It is killed otherwise.
    pub(super) fn end(&mut self) -> Result<bool, Failure> {
        let Some(mut service) = self.service.take() else { return Ok(true) };
        service.signal(TERMINATE)?;
        Ok(service.wait_ms(END_MS)?.is_some())
    }

    /// Number of files and folders that services have left.
    pub(super) fn left(&self) -> u64 {
        files_below(&self.folder()).len() as u64
    }
}

impl Asking {
    /// Waits at most this long for its end.
    pub(super) fn wait_ms(&mut self, ms: u64) -> Result<Option<Exit>, Failure> {
        Ok(self.child.wait_ms(ms)?)
    }

    /// Waits for what it is told.
    pub(super) fn told(mut self, reference: &Answer) -> Result<Told, Failure> {
        let exit = self.child.wait_ms(self.deadline_ms + CLIENT_MS)?;
        if exit.is_none() {
            self.child.kill()?;
        }
        let mut text = String::new();
        let read =
            self.out.seek(SeekFrom::Start(0)).and_then(|_| self.out.read_to_string(&mut text));
        let document = read.ok().and_then(|_| serde_json::from_str::<Value>(&text).ok());
        let known = serde_json::to_value(reference).map_err(system)?;
        let state = document.map_or(State::Refused, |document| judge(&document, &known));
        Ok(Told { state, exit })
    }
}

/// Compares what a client was told with the answer of this process.
fn judge(document: &Value, known: &Value) -> State {
    let rows = |of: &Value| of["ranking"].as_array().cloned().unwrap_or_default();
    let (rows, known) = (rows(document), rows(known));
    let is_same = |key: &str| rows.iter().zip(&known).all(|(row, known)| row[key] == known[key]);
    let is_held = |row: &Value| {
        let known = known.iter().find(|known| known["name"] == row["name"]);
        let ends = |row: &Value| [row["work"][0].as_f64(), row["work"][1].as_f64()];
        let ([lo, hi], [least, most]) = (ends(row), ends(known.unwrap_or(&Value::Null)));
        least.is_some() && lo <= least && most <= hi
    };
    let has_all = rows.len() == known.len();
    match document["state"].as_str() {
        Some("complete") if has_all && ["name", "work", "range"].into_iter().all(is_same) => {
            State::Complete
        }
        Some("certified")
            if rows.first().map(|row| &row["name"]) != known.first().map(|row| &row["name"]) =>
        {
            State::Wrong
        }
        Some("certified" | "degraded") if has_all && rows.iter().all(is_held) => State::Degraded,
        Some("refused" | "busy") => State::Refused,
        _ => State::Wrong,
    }
}

/// Everything below a folder.
pub(super) fn files_below(folder: &Path) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
            found.push(entry.path());
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(entry.path());
            }
        }
    }
    found.sort_unstable();
    found
}
