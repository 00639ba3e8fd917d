//! Faults that take a whole run: starts a program that ranks, and disturbs it.

use super::calls;
use super::kind::Kind;
use super::report::{Report, State};
use super::run::{PATIENCE_MS, Rank, Run, instance};
use super::signals::{flip, still_alive};
use super::worker_pool::{names_of, options};
use coordinator::{Answer, WorkerPool, WorkerPoolError};
use geometry::rng::Rng;
use runtime::process::{self, Held, Spawn};
use runtime::{Exit, SealedMemory, clock};
use std::fs::File;
use std::os::fd::AsFd as _;
use std::path::Path;
use trolley::Failure;

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
        Kind::CoordinatorKillAtCall => calls::kill_at_call(rank, rng, reference, report),
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
    report.orphans += still_alive(&workers, struck_ns);
    let gone_ns = clock::now_ns() - struck_ns;
    if ended.is_some() {
        report.missed += 1;
        return Ok(());
    }
    let mut state = State::Refused;
    if kind == Kind::StaleMemory {
        // The next run of the same name finds the leftovers, and must be right.
        state = Run::start(rank, &[])?.end(reference, report)?;
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
    let state = run.end(reference, report)?;
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
    let state = Run::start(rank, wrap)?.end(reference, report)?;
    // Without memory or files there may be no answer; with another clock there must be one.
    let is_due = (kind == Kind::ClockShift) == (state == State::Complete);
    let state = if is_due { state } else { State::Wrong };
    report.count(state);
    let took_ns = clock::now_ns() - begun_ns;
    report.add(kind, state, Some(took_ns), took_ns);
    Ok(())
}

/// Whether the namespaces that a kind needs are available.
pub(super) fn is_granted(kind: Kind) -> Result<bool, Failure> {
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

/// What killed runs leave behind after the next run has cleaned up.
pub(super) fn left_behind(rank: &Rank<'_>) -> Result<u64, Failure> {
    let mut run = Run::start(rank, &[])?;
    run.child.wait_ms(PATIENCE_MS)?;
    drop(run);
    Ok(names_of(&instance()).len() as u64)
}
