//! Flipped bits in what iceoryx2 shares besides messages and their queues.

use super::kind::Kind;
use super::report::{Report, State};
use super::serving::{Serving, Told, files_below};
use super::signals::flip_in;
use coordinator::Answer;
use geometry::rng::Rng;
use runtime::clock;
use std::path::{Path, PathBuf};
use trolley::Failure;

/// Deadline of the requests that follow (ms).
const DEADLINE_MS: u64 = 1_000;

/// Whether a file is neither a message, nor a queue that the faults `flip-queue` reach.
fn is_management(path: &Path) -> bool {
    let is = |end: &str| path.extension().is_some_and(|extension| extension == end);
    let is_of_pool = path.to_string_lossy().contains("/trolley.");
    let is_long = path.symlink_metadata().is_ok_and(|stat| stat.is_file() && stat.len() > 0);
    is_long && !is("data") && !(is_of_pool && (is("connection") || is("dynamic")))
}

/// Flips bits while clients ask a service. Nobody is told anything wrong, nobody waits beyond the
/// deadline, and the next service answers and leaves nothing.
pub(super) fn flip(
    serving: &mut Serving,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    if !serving.starts(reference, report)? {
        return Ok(());
    }
    let mut first = serving.ask(DEADLINE_MS)?;
    first.wait_ms(rng.below(8))?;
    let struck_ns = clock::now_ns();
    let all: Vec<PathBuf> =
        files_below(&serving.folder()).into_iter().filter(|path| is_management(path)).collect();
    for _ in 0..1 + rng.below(4) {
        if !all.is_empty() {
            flip_in(&all[rng.below(all.len() as u64) as usize], 1 + rng.below(8), &mut rng);
        }
    }
    let mut worst = State::Complete;
    let mut note = |told: Told, report: &mut Report| {
        report.requests += 1;
        report.count(told.state);
        report.hangs += u64::from(told.exit.is_none());
        worst = worst.max(told.state);
    };
    note(first.told(reference)?, report);
    for _ in 0..2 {
        note(serving.ask(DEADLINE_MS)?.told(reference)?, report);
    }
    let seen_ns = serving.ended()?.map(|_| clock::now_ns() - struck_ns);
    if !serving.starts_again(reference, report)? {
        note(Told { state: State::Wrong, exit: None }, report);
    }
    report.add(Kind::FlipManagement, worst, seen_ns, clock::now_ns() - struck_ns);
    Ok(())
}
