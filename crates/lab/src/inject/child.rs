//! Faults that take a whole run: starts a program that ranks, and disturbs it.

use super::kind::Kind;
use super::plan::Plan;
use super::report::{Report, State};
use super::signals::flip;
use super::worker_pool::{names_of, options};
use coordinator::{Answer, WorkerPool, WorkerPoolError};
use geometry::rng::Rng;
use runtime::process::{self, Held, Spawn};
use runtime::{Child, Exit, SealedMemory, clock};
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::os::fd::AsFd as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, References};

/// How long a client waits for an answer before it reports "refused" itself (ms).
const PATIENCE_MS: u64 = 20_000;
/// How long orphans may live (ms).
const ORPHANS_MS: u64 = 1_000;

fn instance() -> String {
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
struct Run {
    child: Child,
    out: File,
}

impl Run {
    /// Starts it; `wrap`: a program, with arguments, to run it under.
    fn start(rank: &Rank<'_>, wrap: &[&str]) -> Result<Self, Failure> {
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
        let child = process::spawn(Spawn {
            program: &PathBuf::from(&line[0]),
            args: &line[1..],
            fds: &[(out.as_fd(), 1), (null.as_fd(), 2)],
            core: None,
        })?
        .await_exec(PATIENCE_MS)?;
        Ok(Self { child, out })
    }

    fn workers(&self) -> Vec<u32> {
        let pid = self.child.pid();
        let path = format!("/proc/{pid}/task/{pid}/children");
        let list = std::fs::read_to_string(path).unwrap_or_default();
        list.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    }

    /// Waits for its end, and returns its output.
    fn end(mut self, reference: &Answer) -> Result<State, Failure> {
        let exit = self.child.wait_ms(PATIENCE_MS)?;
        if exit.is_none() {
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
}

/// Injects one fault.
pub(super) fn run(
    rank: &Rank<'_>,
    kind: Kind,
    seed: u64,
    number: u64,
    (reference, store): (&Answer, &SealedMemory),
    report: &mut Report,
) -> Result<(), Failure> {
    let rng = Rng::new(seed ^ number << 20);
    report.requests += 1;
    match kind {
        Kind::CoordinatorKill | Kind::KillInStop | Kind::StaleMemory => {
            kill_coordinator(rank, kind, rng, reference, report)
        }
        Kind::FlipQueue | Kind::FlipPayload => flip_bits(rank, kind, rng, reference, report),
        Kind::VersionSkew => skew(rank, kind, store, report),
        Kind::SmallShm | Kind::FewFiles | Kind::ClockShift => {
            confine(rank, kind, reference, report)
        }
        _ => {
            report.skip(kind, "it is not a fault of a whole run");
            Ok(())
        }
    }
}

/// Kills a coordinator during its work or at its end; its workers must end with it.
fn kill_coordinator(
    rank: &Rank<'_>,
    kind: Kind,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    let mut run = Run::start(rank, &[])?;
    let wait_ms = match kind {
        Kind::KillInStop => run.until_it_stops(),
        _ => rng.below(120),
    };
    let ended = run.child.wait_ms(wait_ms)?;
    let workers: Vec<Held> =
        run.workers().into_iter().filter_map(|pid| Held::of(pid).ok()).collect();
    let struck_ns = clock::now_ns();
    run.child.kill()?;
    run.child.wait_ms(PATIENCE_MS)?;
    let mut alive = workers.len();
    while alive > 0 && clock::now_ns() - struck_ns < ORPHANS_MS * 1_000_000 {
        alive = workers.iter().filter(|held| held.is_alive()).count();
        run.child.wait_ms(0)?;
    }
    report.orphans += alive as u64;
    let gone_ns = clock::now_ns() - struck_ns;
    if ended.is_some() {
        report.missed += 1;
        return Ok(());
    }
    let mut state = State::Refused;
    if kind == Kind::StaleMemory {
        // The next run of the same name finds the leftovers, and must be right.
        state = Run::start(rank, &[])?.end(reference)?;
        report.left_behind += names_of(&instance()).len() as u64;
    }
    report.count(state);
    report.add(kind, state, Some(gone_ns), clock::now_ns() - struck_ns);
    Ok(())
}

/// Flips bits in the shared memory of a run during its work.
fn flip_bits(
    rank: &Rank<'_>,
    kind: Kind,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    let mut run = Run::start(rank, &[])?;
    let _ended = run.child.wait_ms(10 + rng.below(60))?;
    let struck_ns = clock::now_ns();
    let prefix = format!("trolley.{}.", instance());
    let (suffix, bits) = match (kind, rng.below(2)) {
        (Kind::FlipPayload, _) => (".data", 64),
        (_, 0) => (".connection", 16),
        _ => (".dynamic", 16),
    };
    flip(&prefix, suffix, bits, rng);
    let state = run.end(reference)?;
    report.count(state);
    let took_ns = clock::now_ns() - struck_ns;
    report.add(kind, state, None, took_ns);
    Ok(())
}

/// Starts workers that take the coordinator to be another build.
fn skew(
    rank: &Rank<'_>,
    kind: Kind,
    store: &SealedMemory,
    report: &mut Report,
) -> Result<(), Failure> {
    let begun_ns = clock::now_ns();
    let mut options = options(rank.plan, &format!("v{}", std::process::id()));
    options.build = "another build".to_owned();
    let state = match WorkerPool::start(store, &options) {
        Err(WorkerPoolError::ExitedAtStart { .. }) => State::Refused,
        Ok(_) | Err(_) => State::Wrong,
    };
    report.count(state);
    let took_ns = clock::now_ns() - begun_ns;
    report.add(kind, state, Some(took_ns), took_ns);
    report.left_behind += names_of(&options.instance).len() as u64;
    Ok(())
}

/// Runs with too little memory, too few files, or another clock.
fn confine(
    rank: &Rank<'_>,
    kind: Kind,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    let begun_ns = clock::now_ns();
    let shm = "mount -t tmpfs -o size=64k tmpfs /dev/shm && exec \"$0\" \"$@\"";
    let wrap: &[&str] = match kind {
        Kind::SmallShm => &["/usr/bin/unshare", "-m", "/bin/sh", "-c", shm],
        Kind::FewFiles => &["/bin/sh", "-c", "ulimit -n 12; exec \"$0\" \"$@\""],
        _ => &["/usr/bin/unshare", "-T", "--monotonic", "864000", "--fork", "--kill-child"],
    };
    if !Path::new(wrap[0]).exists() || !is_granted(kind)? {
        report.skip(kind, "this machine does not permit it");
        return Ok(());
    }
    let state = Run::start(rank, wrap)?.end(reference)?;
    // Without memory or files there may be no answer; with another clock there must be one.
    let is_due = (kind == Kind::ClockShift) == (state == State::Complete);
    let state = if is_due { state } else { State::Wrong };
    report.count(state);
    let took_ns = clock::now_ns() - begun_ns;
    report.add(kind, state, Some(took_ns), took_ns);
    Ok(())
}

/// Whether the namespaces that a kind needs are available.
fn is_granted(kind: Kind) -> Result<bool, Failure> {
    let test: &[&str] = match kind {
        Kind::SmallShm => &["-m", "/bin/sh", "-c", "mount -t tmpfs tmpfs /dev/shm"],
        Kind::ClockShift => &["-T", "--monotonic", "864000", "--fork", "/bin/true"],
        _ => return Ok(true),
    };
    let args: Vec<String> = test.iter().map(|&word| word.to_owned()).collect();
    let null = File::open("/dev/null")
        .map_err(|error| Failure::new(trolley::FailureKind::System, error.to_string()))?;
    let program = Path::new("/usr/bin/unshare");
    let mut child =
        process::spawn(Spawn { program, args: &args, fds: &[(null.as_fd(), 2)], core: None })?
            .await_exec(PATIENCE_MS)?;
    Ok(child.wait_ms(5_000)? == Some(Exit::Code(0)))
}

impl Run {
    /// Waits until the workers were there and begin to end.
    fn until_it_stops(&mut self) -> u64 {
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

/// What killed runs leave behind after the next run has cleaned up.
pub(super) fn left_behind(rank: &Rank<'_>) -> Result<u64, Failure> {
    let mut run = Run::start(rank, &[])?;
    run.child.wait_ms(PATIENCE_MS)?;
    drop(run);
    Ok(names_of(&instance()).len() as u64)
}
