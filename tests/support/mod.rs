//! Shared by the multi-process tests: scenarios on disk, the binary, and checks of what it leaves
//! behind.
//!
//! Every run gets an instance name of its own, so that tests run side by side and each can say that
//! nothing of its own is left in /dev/shm.
#![allow(
    dead_code,
    clippy::allow_attributes,
    clippy::unwrap_used,
    reason = "each test target uses its own part of it, and a test that cannot go on has failed"
)]

#[path = "../../tools/src/bounds/service/footprint.rs"]
pub(crate) mod footprint;
pub(crate) mod keys;
pub(crate) mod service;

use geometry::hash::{pair_term, splitmix64};
use geometry::triangle::{self, Triangle};
use geometry::{Corners, DVec3, RelativePose};
use scenario::Overrides;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;
use trolley::{Engine, EngineBuilder, Limits, Scenario};

/// A folder that is removed with the test.
pub(crate) struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    }
}

/// An instance name that no other test of this machine uses at the time.
pub(crate) fn instance() -> String {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    format!("t{:x}-{number}", std::process::id() & 0xff_ffff)
}

/// What a run of this instance has in shared memory.
pub(crate) fn left_in_shm(instance: &str) -> Vec<String> {
    let entries =
        std::fs::read_dir(trolley::doctor::shared_folder()).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.contains(&format!(".{instance}."))).collect()
}

pub(crate) fn trolley() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_trolley"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    // Texts are as wide here as wherever else no terminal reads them.
    command.env_remove("COLUMNS");
    command
}

/// A finished run, checked for what it left behind.
pub(crate) fn run(args: &[&str]) -> Output {
    let instance = instance();
    let output =
        trolley().args(args).args(["--instance", &instance]).spawn().unwrap().wait_with_output();
    assert_eq!(left_in_shm(&instance), Vec::<String>::new(), "left behind by {args:?}");
    output.unwrap()
}

/// The library's engine in a run of its own, with the program's workers.
pub(crate) fn builder() -> EngineBuilder {
    Engine::builder().worker_program(env!("CARGO_BIN_EXE_trolley")).instance(instance())
}

/// The answer of the library, byte for byte as it is recorded.
pub(crate) fn library_answer(engine: &mut Engine, scenario: &Scenario, limits: &Limits) -> String {
    serde_json::to_string(&engine.rank(scenario, limits).unwrap().answer).unwrap()
}

/// Engine settings that differ from the usual ones.
pub(crate) fn overrides(change: impl FnOnce(&mut Overrides)) -> Overrides {
    let mut overrides = Overrides::default();
    change(&mut overrides);
    overrides
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The `answer` object of a JSON document, byte for byte.
pub(crate) fn answer(output: &Output) -> String {
    let document = text(&output.stdout);
    let error = text(&output.stderr);
    let from = document.find("\"answer\":").unwrap_or_else(|| panic!("no answer: {error}"));
    let to = document.find("\n  \"run\":").unwrap_or_else(|| panic!("no run: {document}"));
    document[from..to].to_owned()
}

pub(crate) fn json(output: &Output) -> serde_json::Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| {
        panic!("{error}: {} {}", text(&output.stdout), text(&output.stderr))
    })
}

/// Six ways of a car among six parties, as stated: each way hits somebody but the last.
pub(crate) fn ways(triangles: u32) -> String {
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"ways\"\nmembers = 1\nhorizon_s = 3\n\
         [parties.ego]\ngenerate = {{ shape = \"sedan\", triangles = {triangles} }}\n"
    );
    let parties = [
        ("cyclist", "state", 18.0, -16.0, 90.0, 1.0),
        ("wall", "place", 22.0, -9.0, 90.0, 0.0),
        ("suv", "state", 25.0, 0.0, 180.0, 3.0),
        ("truck", "state", 26.0, 9.0, 180.0, 4.0),
        ("pedestrian", "state", 18.0, 15.0, -90.0, 1.0),
        ("pole", "place", 15.0, 4.0, 0.0, 0.0),
    ];
    for (shape, kind, x, y, yaw, speed) in parties {
        let speed =
            if kind == "state" { format!(", speed_m_s = {speed:?}") } else { String::new() };
        write!(
            text,
            "[parties.{shape}]\ngenerate = {{ shape = \"{shape}\", triangles = {triangles} }}\n\
             {kind} = {{ position_m = [{x:?}, {y:?}, 0], yaw_deg = {yaw:?}{speed} }}\n"
        )
        .unwrap();
    }
    let ways = [-11.0, -6.0, 0.0, 4.5, 11.5];
    for (number, y) in ways.iter().enumerate() {
        write!(
            text,
            "[[candidates]]\nname = \"way {number}\"\n\
             state = {{ position_m = [0, 0, 0], velocity_m_s = [13, {y:?}] }}\n"
        )
        .unwrap();
    }
    text + "[[candidates]]\nname = \"stop\"\npath = { states = [\
            { t_s = 0, position_m = [0, 0, 0] }, { t_s = 1, position_m = [8, 0, 0] }, \
            { t_s = 2, position_m = [10, 0, 0] }, { t_s = 2.1, position_m = [10, 0, 0] } ] }\n"
}

/// Deep enough for tens of thousands of jobs: the run takes long on any machine.
pub(crate) const DEPTH: &str = "17";

/// Work for a while: sixteen ways into a car that stands within the ego already.
pub(crate) fn heavy(triangles: u32) -> String {
    let body = format!("generate = {{ shape = \"sedan\", triangles = {triangles} }}");
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"heavy\"\nmembers = 1\nhorizon_s = 1\n\
         [parties.ego]\n{body}\n[parties.p0]\n{body}\nstate = {{ position_m = [4.0, 0.05, 0], \
         yaw_deg = 175, speed_m_s = 12 }}\n"
    );
    for number in 0..16 {
        let speed = 15.0 + 0.1 * f64::from(number);
        write!(
            text,
            "[[candidates]]\nname = \"way {number}\"\nstate = {{ position_m = [0, 0, 0], \
             speed_m_s = {speed:?} }}\n"
        )
        .unwrap();
    }
    text
}

/// Work for a while: sixteen ways between cars that turn, each past several.
pub(crate) fn long(triangles: u32) -> String {
    let body = format!("generate = {{ shape = \"sedan\", triangles = {triangles} }}");
    let mut text = format!(
        "schema = \"trolley.scenario/2\"\nname = \"long\"\nmembers = 1\nhorizon_s = 5\n\
         resolution_m = 0.00001\n[parties.ego]\n{body}\n"
    );
    for number in 0..8 {
        let (x, y) = (7.0 * f64::from(number + 1), 2.0 - f64::from(number % 2) * 4.0);
        write!(
            text,
            "[parties.c{number}]\n{body}\nstate = {{ position_m = [{x:?}, {y:?}, 0], \
             yaw_deg = {:?}, speed_m_s = 3, yaw_rate_deg_s = 12 }}\n",
            30 * number
        )
        .unwrap();
    }
    for number in 0..16 {
        let speed = 8.0 + 0.5 * f64::from(number);
        write!(
            text,
            "[[candidates]]\nname = \"way {number}\"\nstate = {{ position_m = [0, 0, 0], \
             speed_m_s = {speed:?}, yaw_rate_deg_s = {:?} }}\n",
            f64::from(number) - 8.0
        )
        .unwrap();
    }
    text
}

/// Process ids of the children of a process.
pub(crate) fn children(pid: u32) -> Vec<u32> {
    let path = format!("/proc/{pid}/task/{pid}/children");
    let list = std::fs::read_to_string(path).unwrap_or_default();
    list.split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// CPU time of a process, in clock ticks of 10 ms; `None` if it is gone.
pub(crate) fn cpu_ticks(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let mut fields = stat.rsplit_once(") ")?.1.split(' ').skip(11);
    let mut next = || fields.next()?.parse::<u64>().ok();
    Some(next()? + next()?)
}

/// How many times as long everything may take: `TROLLEY_TEST_PATIENCE`, for an emulator, or 1.
#[expect(clippy::disallowed_methods, reason = "a test binary has no command line of its own")]
fn slowness() -> u32 {
    std::env::var("TROLLEY_TEST_PATIENCE").map_or(1, |text| text.parse().unwrap())
}

/// How long an answer may take that comes in milliseconds.
pub(crate) fn patience() -> Duration {
    Duration::from_secs(20) * slowness()
}

/// Polls every 1 ms until `ready` returns a value; `None` after this many milliseconds, times
/// [`slowness`].
pub(crate) fn wait_for<T>(milliseconds: u32, mut ready: impl FnMut() -> Option<T>) -> Option<T> {
    for _ in 0..milliseconds * slowness() {
        if let Some(value) = ready() {
            return Some(value);
        }
        let nap = rustix::time::Timespec { tv_sec: 0, tv_nsec: 1_000_000 };
        let _slept = rustix::thread::nanosleep(&nap);
    }
    None
}

/// Sends a signal to a process that this test started.
pub(crate) fn signal(pid: u32, signal: rustix::process::Signal) {
    let pid = rustix::process::Pid::from_raw(pid as i32).unwrap();
    let _gone = rustix::process::kill_process(pid, signal);
}

/// Waits until a started run has this many workers, and each of them has worked; `None` if it ended
/// before. It may then wait for somebody to read its output: use `wait_with_output`.
pub(crate) fn workers_at_work(run: &mut Child, count: usize) -> Option<Vec<u32>> {
    let pid = run.id();
    let mut most = 0;
    wait_for(60_000, || {
        let workers = children(pid);
        let is_over = workers.is_empty() && most > 0;
        if is_over || run.try_wait().unwrap().is_some() {
            return Some(None);
        }
        most = most.max(workers.len());
        let ticks: Vec<u64> = workers.iter().filter_map(|worker| cpu_ticks(*worker)).collect();
        // More than it takes them to start, which is longer under an emulator.
        let slowness = u64::from(slowness());
        let all_worked = ticks.iter().all(|t| *t >= slowness);
        let working = all_worked && ticks.iter().sum::<u64>() >= 8 * slowness;
        (ticks.len() == count && working).then_some(Some(workers))
    })
    .flatten()
}

/// A file of `tests/data`, which is part of this project.
pub(crate) fn shipped(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data");
    folder.join(name).canonicalize().unwrap()
}

/// A third-party file that may exist beside this checkout. Tests that need it are ignored, and are
/// in modules named `shared_data`: `cargo x check` runs them if it exists.
pub(crate) fn shared(below: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(below);
    path.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reports that something is skipped because a tool is missing. Bypasses the test runner, which
/// hides the output of passing tests; `cargo x check` shows the line.
pub(crate) fn skipped(what: &str) {
    let _gone = writeln!(std::io::stderr(), "SKIPPED: {what}");
}

/// Counts and hashes of what is hit: of A, of B, and of pairs.
pub(crate) type Found = [(u64, u64); 3];

/// Every pair of triangles, tested one by one: no tree, no job, no process. The hashes are over the
/// ids of the triangles.
pub(crate) fn brute_force(
    (a, ids_a): (&[Corners], &[u32]),
    (b, ids_b): (&[Corners], &[u32]),
    pose: &RelativePose,
) -> Found {
    let mut found = [(0, 0_u64); 3];
    let (mut hit_a, mut hit_b) = (vec![false; a.len()], vec![false; b.len()]);
    let placed: Vec<_> = b.iter().map(|corners| pose.triangle(corners)).collect();
    for (i, corners) in a.iter().enumerate() {
        let at_home = Triangle(corners.map(|c| DVec3::from_array(c.map(f64::from))));
        for (j, other) in placed.iter().enumerate() {
            if triangle::intersect(&at_home, other) {
                (hit_a[i], hit_b[j]) = (true, true);
                let term = pair_term(ids_a[i], ids_b[j]);
                found[2] = (found[2].0 + 1, found[2].1.wrapping_add(term));
            }
        }
    }
    for (side, hits, ids) in [(0, hit_a, ids_a), (1, hit_b, ids_b)] {
        for at in (0..hits.len()).filter(|at| hits[*at]) {
            let term = splitmix64(u64::from(ids[at]));
            found[side] = (found[side].0 + 1, found[side].1.wrapping_add(term));
        }
    }
    found
}

/// Compares a pose of an answer with brute force.
pub(crate) fn assert_found(pose: &serde_json::Value, found: &Found, place: &str) {
    for (side, count, hash) in [(0, "hits_a", "hash_a"), (1, "hits_b", "hash_b")] {
        assert_eq!(pose[count], found[side].0, "{place}: {count}");
        assert_eq!(pose[hash], format!("{:016x}", found[side].1), "{place}: {hash}");
    }
    if let Some(pairs) = pose.get("pairs") {
        assert_eq!(*pairs, found[2].0, "{place}: pairs");
        assert_eq!(pose["hash"], format!("{:016x}", found[2].1), "{place}: hash of pairs");
    }
}
