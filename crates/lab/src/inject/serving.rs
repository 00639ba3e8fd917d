//! A service in a folder of its own, and clients that ask it what the plan says.

use super::report::{Report, State};
use super::run::Rank;
use crate::latency::WARM;
use coordinator::Answer;
use runtime::process::{self, Spawn};
use runtime::{Child, Exit, clock};
use scenario::Source;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::os::fd::AsFd as _;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, FailureKind, Scenario};

/// How long a service may take to start, and its first client to get an answer (ms).
pub(super) const START_MS: u64 = 20_000;
/// How long a service may take to end when it is told to (ms).
const END_MS: u64 = 5_000;
/// How long after its deadline a client may still run (ms): it starts, reads files, and ends.
const CLIENT_MS: u64 = 1_000;
/// How long each of many requests of one client may take in the mean (ms), on a machine with other
/// work.
pub(super) const REPEAT_MS: u64 = 250;
/// What clients ask for: the scene as stated. Faults strike between requests and within them, of
/// which there are to be many.
pub(super) const MEMBERS: i64 = 1;
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
    /// How long it may run.
    patience_ms: u64,
}

/// A folder for services of one instance, one after the other.
pub(super) struct Serving {
    rank: PathBuf,
    scenario: PathBuf,
    place: tempfile::TempDir,
    deployment: PathBuf,
    /// Size of the file system of shared files, which it then has for itself (bytes).
    own_bytes: Option<u64>,
    /// The folder that stands in for the user's runtime folder.
    open: Option<PathBuf>,
    service: Option<Child>,
}

fn system(error: impl std::fmt::Display) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
}

impl Serving {
    /// Prepares a folder; `None` if some bodies are not generated.
    pub(super) fn prepare(rank: &Rank<'_>, scenario: &Scenario) -> Result<Option<Self>, Failure> {
        // The names of sockets in it must be short.
        let prefix = format!("i{:x}.", std::process::id());
        let place = tempfile::Builder::new().prefix(&prefix).rand_bytes(3).tempdir_in("/dev/shm");
        let place = place.map_err(system)?;
        let mut text = format!(
            "schema = \"trolley.deployment/1\"\ninstance = \"{INSTANCE}\"\nfolder = {:?}\n\
             [engine]\nworkers = {}\n[realtime]\npriority = 0\nworker_priority = 0\n\
             lock_memory = false\nheap_mib = 8\n",
            place.path().join("shm"),
            rank.plan.workers
        );
        std::fs::create_dir(place.path().join("shm")).map_err(system)?;
        for (number, party) in scenario.parsed().parties.iter().enumerate() {
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
        // Clients may have another working directory.
        let asked = rank.plan.asked.canonicalize().map_err(system)?;
        let rank = rank.program.to_owned();
        let (own_bytes, open, service) = (None, None, None);
        Ok(Some(Self { rank, scenario: asked, place, deployment, own_bytes, open, service }))
    }

    /// Gives the next service a file system of this size (bytes) for its shared files, which takes
    /// mount namespaces.
    pub(super) fn confine(&mut self, bytes: u64) {
        self.own_bytes = Some(bytes);
    }

    /// Where this process sees the shared files of a confined service.
    pub(super) fn seen_folder(&self) -> Option<PathBuf> {
        let pid = self.pid()?;
        Some(PathBuf::from(format!("/proc/{pid}/root{}", self.folder().display())))
    }

    pub(super) fn pid(&self) -> Option<u32> {
        self.service.as_ref().map(Child::pid)
    }

    /// Process ids of its workers.
    pub(super) fn workers(&self) -> Vec<u32> {
        let Some(pid) = self.pid() else { return Vec::new() };
        let list = std::fs::read_to_string(format!("/proc/{pid}/task/{pid}/children"));
        list.unwrap_or_default().split_whitespace().filter_map(|word| word.parse().ok()).collect()
    }

    /// The folder of shared files.
    pub(super) fn folder(&self) -> PathBuf {
        self.open
            .as_ref()
            .map_or_else(|| self.place.path().join("shm"), |open| open.join("trolley"))
    }

    /// Moves to the default folder of a user whose runtime folder everybody may write to, which is
    /// returned: as /dev/shm is.
    pub(super) fn open_to_strangers(&mut self) -> Result<PathBuf, Failure> {
        let with_mode = |path: &Path, mode: u32| {
            std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).map_err(system)
        };
        let open = self.place.path().join("open");
        std::fs::create_dir(&open).map_err(system)?;
        with_mode(&open, 0o1777)?;
        with_mode(self.place.path(), 0o711)?;
        let text = std::fs::read_to_string(&self.deployment).map_err(system)?;
        let is_kept = |line: &&str| !line.starts_with("folder = ");
        let lines: Vec<&str> = text.lines().filter(is_kept).collect();
        std::fs::write(&self.deployment, lines.join("\n")).map_err(system)?;
        self.open = Some(open.clone());
        Ok(open)
    }

    /// Waits for the end of a service that should not start.
    pub(super) fn await_end(&mut self, ms: u64) -> Result<Option<Exit>, Failure> {
        self.service.as_mut().map_or(Ok(None), |service| Ok(service.wait_ms(ms)?))
    }

    /// Starts a service, which may take a while until it serves.
    pub(super) fn start(&mut self) -> Result<(), Failure> {
        let deployment = self.deployment.display().to_string();
        let script = self.own_bytes.map(|bytes| {
            let folder = self.folder();
            format!(
                "mount -t tmpfs -o size={bytes},mode=700 tmpfs {} && exec \"$0\" \"$@\"",
                folder.display()
            )
        });
        let wrap: Vec<&str> = match &script {
            Some(script) => vec!["/usr/bin/unshare", "-m", "/bin/sh", "-c", script],
            None => Vec::new(),
        };
        let line = ["-q", "serve", deployment.as_str()];
        let (child, _output) = self.run(&wrap, &line)?;
        self.service = Some(child);
        Ok(())
    }

    /// How the service ended; `None` while it runs.
    pub(super) fn ended(&mut self) -> Result<Option<Exit>, Failure> {
        self.service.as_mut().map_or(Ok(None), |service| Ok(service.try_wait()?))
    }

    fn run(&self, wrap: &[&str], args: &[&str]) -> Result<(Child, File), Failure> {
        let own = self.rank.display().to_string();
        let runtime = self.open.as_ref().map(|open| format!("XDG_RUNTIME_DIR={}", open.display()));
        let env = runtime.as_ref().map(|set| ["/usr/bin/env", "-u", "RUNTIME_DIRECTORY", set]);
        let words = wrap.iter().copied().chain(env.into_iter().flatten()).chain([own.as_str()]);
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
        self.ask_with(deadline_ms, &[])
    }

    /// Starts a client that asks this many times, each time with this deadline, and compares the
    /// answers itself.
    pub(super) fn ask_again_and_again(
        &self,
        times: u32,
        deadline_ms: u64,
    ) -> Result<Asking, Failure> {
        let mut asking = self.ask_with(deadline_ms, &["--repeat", &times.to_string()])?;
        // It loads its bodies first, and ends when all are answered, not one.
        asking.patience_ms = START_MS + CLIENT_MS + u64::from(WARM + times) * REPEAT_MS;
        Ok(asking)
    }

    fn ask_with(&self, deadline_ms: u64, more: &[&str]) -> Result<Asking, Failure> {
        let files = [&self.deployment, &self.scenario].map(|path| path.display().to_string());
        let due = deadline_ms.to_string();
        let mut line = vec!["-q", "query", &files[0], &files[1], "--json", "--deadline-ms", &due];
        let members = MEMBERS.to_string();
        line.extend(["--members", &members]);
        line.extend(more);
        let pid = self.pid().filter(|_| self.own_bytes.is_some()).map(|pid| pid.to_string());
        let wrap = pid.as_ref().map(|pid| ["/usr/bin/nsenter", "-m", "-t", pid]);
        let (child, out) = self.run(wrap.as_ref().map_or(&[], |words| words), &line)?;
        Ok(Asking { child, out, patience_ms: deadline_ms + CLIENT_MS })
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

    /// Starts a service: whether it answers. If not, the fault cannot be placed, which is counted.
    pub(super) fn starts(
        &mut self,
        reference: &Answer,
        report: &mut Report,
    ) -> Result<bool, Failure> {
        self.start()?;
        let is_serving = self.is_serving(reference)?;
        if !is_serving {
            report.missed += 1;
            self.end()?;
        }
        Ok(is_serving)
    }

    /// Ends the service, and starts and ends another one, as an init system does, whatever became
    /// of the first: whether that one answered. What is left then is counted.
    pub(super) fn starts_again(
        &mut self,
        reference: &Answer,
        report: &mut Report,
    ) -> Result<bool, Failure> {
        report.hangs += u64::from(!self.end()?);
        self.start()?;
        let is_serving = self.is_serving(reference)?;
        report.hangs += u64::from(!self.end()?);
        report.left_behind += self.left();
        Ok(is_serving)
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

    /// Waits for its end, at most for so long after its deadline as a client may take.
    pub(super) fn document(mut self) -> Result<(Option<Exit>, Option<Value>), Failure> {
        let exit = self.child.wait_ms(self.patience_ms)?;
        if exit.is_none() {
            self.child.kill()?;
        }
        let mut text = String::new();
        let read =
            self.out.seek(SeekFrom::Start(0)).and_then(|_| self.out.read_to_string(&mut text));
        Ok((exit, read.ok().and_then(|_| serde_json::from_str(&text).ok())))
    }

    /// Waits for what it is told.
    pub(super) fn told(self, reference: &Answer) -> Result<Told, Failure> {
        let (exit, document) = self.document()?;
        let known = serde_json::to_value(reference).map_err(system)?;
        let state = document.map_or(State::Refused, |document| judge(&document, &known));
        Ok(Told { state, exit })
    }
}

/// Compares what a client was told with the answer of this process.
fn judge(document: &Value, known: &Value) -> State {
    // A late answer may be of fewer members: its means are no bounds on those of all.
    let count = |of: &Value| of["members"]["count"].as_u64().unwrap_or(1);
    let is_part = count(document) < count(known);
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
        Some("degraded") if has_all && is_part => State::Degraded,
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
