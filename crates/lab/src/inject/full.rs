//! A file system without room, in which workers are killed and clients come.
//!
//! It is one of the service's own, in a mount namespace that its clients enter.

use super::kind::Kind;
use super::report::{Report, State};
use super::serving::{START_MS, Serving, Told, files_below};
use super::signals::KILL;
use coordinator::Answer;
use geometry::rng::Rng;
use runtime::process::Held;
use runtime::{Exit, clock};
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use trolley::{Failure, FailureKind};

/// Room for shared files (bytes): more than a service and some clients take.
const ROOM_BYTES: u64 = 32 << 20;
/// How long a successor may take to stand in for a killed worker (ns).
const SUCCESSOR_NS: u64 = 5_000_000_000;
/// Requests of the client that was connected before.
const REQUESTS: u32 = 400;
/// Deadline of new clients (ms).
const DEADLINE_MS: u64 = 1_000;

/// Fills the file system, kills a worker or two, and lets new clients come. The connected client
/// is always answered, each worker replaced, new clients answered or refused with a code; nobody
/// ends by a signal, and once there is room, everybody is served.
pub(super) fn strike(
    serving: &mut Serving,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    serving.confine(ROOM_BYTES);
    serving.start()?;
    let (is_serving, seen) = (serving.is_serving(reference)?, serving.seen_folder());
    let (true, Some(seen)) = (is_serving, seen) else {
        report.missed += 1;
        serving.end()?;
        return Ok(());
    };
    let mut connected = serving.ask_again_and_again(REQUESTS, START_MS)?;
    connected.wait_ms(20 + rng.below(30))?;
    let filler = seen.join("filler");
    fill(&filler)?;
    let struck_ns = clock::now_ns();
    let mut longest_ns = Some(0);
    for _ in 0..1 + rng.below(2) {
        let workers = serving.workers();
        let Some(killed) = workers.get(rng.below(workers.len().max(1) as u64) as usize) else {
            break;
        };
        Held::of(*killed)?.signal(KILL)?;
        let killed_ns = clock::now_ns();
        let replaced_ns = until_replaced(serving, &workers)?;
        longest_ns = longest_ns
            .zip(replaced_ns)
            .map(|(longest_ns, at_ns)| at_ns.saturating_sub(killed_ns).max(longest_ns));
    }
    let mut worst = State::Complete;
    let mut note = |state: State, report: &mut Report| {
        report.requests += 1;
        report.count(state);
        worst = worst.max(state);
    };
    for _ in 0..2 {
        let Told { state, exit } = serving.ask(DEADLINE_MS)?.told(reference)?;
        let is_clear = matches!(exit, Some(Exit::Code(_)));
        report.hangs += u64::from(exit.is_none());
        note(if is_clear { state } else { State::Wrong }, report);
    }
    let (exit, document) = connected.document()?;
    report.hangs += u64::from(exit.is_none());
    let answers = document.map_or([None, None], |document| {
        [document["wrong"].as_u64(), document["answers"][0].as_u64()]
    });
    let are_complete = answers == [Some(0), Some(REQUESTS.into())];
    note(if are_complete { State::Complete } else { State::Wrong }, report);
    note(if longest_ns.is_some() { State::Complete } else { State::Wrong }, report);
    std::fs::remove_file(&filler).map_err(system)?;
    let recovers = serving.ended()?.is_none() && serving.is_serving(reference)?;
    note(if recovers { State::Complete } else { State::Wrong }, report);
    // What is left can be seen as long as this is open.
    let left = File::open(&seen).map_err(system)?;
    report.hangs += u64::from(!serving.end()?);
    use std::os::fd::AsRawFd as _;
    let left = PathBuf::from(format!("/proc/self/fd/{}", left.as_raw_fd()));
    report.left_behind += files_below(&left).len() as u64;
    report.add(Kind::FullShm, worst, longest_ns, clock::now_ns() - struck_ns);
    Ok(())
}

/// Waits until there is a worker that was not there before, and still lives a while later: when
/// (ns).
fn until_replaced(serving: &mut Serving, before: &[u32]) -> Result<Option<u64>, Failure> {
    let end_ns = clock::now_ns() + SUCCESSOR_NS;
    while clock::now_ns() < end_ns {
        let at_ns = clock::now_ns();
        let now = serving.workers();
        let new = now.iter().find(|pid| !before.contains(pid));
        if serving.ended()?.is_some() {
            return Ok(None);
        }
        // One that finds no room ends by itself, soon.
        if let (Some(new), true) = (new, now.len() >= before.len()) {
            let is_over = |ns| clock::now_ns() > at_ns + ns;
            while !is_over(200_000_000) {
                std::thread::yield_now();
            }
            if serving.workers().contains(new) {
                return Ok(Some(at_ns));
            }
        }
        std::thread::yield_now();
    }
    Ok(None)
}

/// Writes until nothing fits any more.
fn fill(path: &Path) -> Result<(), Failure> {
    let mut file = File::create_new(path).map_err(system)?;
    for block in [vec![0; 1 << 16], vec![0; 1 << 12]] {
        while file.write(&block).is_ok_and(|written| written > 0) {}
    }
    Ok(())
}

fn system(error: std::io::Error) -> Failure {
    Failure::new(FailureKind::System, error.to_string())
}
