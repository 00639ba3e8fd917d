//! Processes that are killed as they enter one of their system calls.

use super::kind::Kind;
use super::report::{Report, State};
use super::run::{PATIENCE_MS, Rank, Run, instance};
use super::signals::still_alive;
use super::worker_pool::names_of;
use coordinator::Answer;
use core::sync::atomic::{AtomicBool, Ordering};
use geometry::rng::Rng;
use runtime::clock;
use runtime::process::{self, Held, Traced, trace};
use trolley::Failure;

/// How long a process that nobody waits for any more may make no call (ns) before it is let go.
const IDLE_NS: u64 = 30_000_000;

/// A stopped process, and the call at which it is to be killed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trace {
    /// Index among the request's faults.
    pub(super) number: usize,
    pub(super) pid: u32,
    pub(super) call: u64,
}

impl Trace {
    /// Kills it there: returns when (ns), or `None` if it did not get so far.
    pub(super) fn run(self, is_over: &AtomicBool) -> Option<(usize, u64)> {
        let over = |idle_ns| is_over.load(Ordering::SeqCst) && idle_ns > IDLE_NS;
        match trace(self.pid, Some(self.call), over) {
            Ok(Traced::Killed { at_ns }) => Some((self.number, at_ns)),
            Ok(Traced::Ended { .. } | Traced::Released { .. }) => None,
            Err(error) => {
                tracing::warn!(%error, "a process was not traced");
                None
            }
        }
    }
}

/// Kills a coordinator at one of its system calls, from its exec to its end. Its workers must end
/// with it, and the next run of the same name must be right.
pub(super) fn kill_at_call(
    rank: &Rank<'_>,
    mut rng: Rng,
    reference: &Answer,
    report: &mut Report,
) -> Result<(), Failure> {
    let begun_ns = clock::now_ns();
    let is_late = |_| clock::now_ns() - begun_ns > PATIENCE_MS * 1_000_000;
    let counted = Run::start_by(rank, &[], process::spawn_stopped)?;
    let traced = process::trace(counted.child.pid(), None, is_late)?;
    let state = counted.end(reference, report)?;
    report.count(state);
    let Traced::Ended { calls: calls @ 1.. } = traced else {
        report.hangs += 1;
        return Ok(());
    };
    let mut run = Run::start_by(rank, &[], process::spawn_stopped)?;
    let begun_ns = clock::now_ns();
    let is_late = |_| clock::now_ns() - begun_ns > PATIENCE_MS * 1_000_000;
    let traced = process::trace(run.child.pid(), Some(1 + rng.below(calls)), is_late)?;
    let Traced::Killed { at_ns } = traced else {
        let state = run.end(reference, report)?;
        report.count(state);
        report.missed += 1;
        return Ok(());
    };
    let workers: Vec<Held> =
        run.workers().into_iter().filter_map(|pid| Held::of(pid).ok()).collect();
    run.child.wait_ms(PATIENCE_MS)?;
    report.orphans += still_alive(&workers, at_ns);
    let gone_ns = clock::now_ns() - at_ns;
    let state = Run::start(rank, &[])?.end(reference, report)?;
    // Whatever was left half made, the next run has cleaned it up and is not misled.
    let state = if state == State::Complete { state } else { State::Wrong };
    report.left_behind += names_of(&instance()).len() as u64;
    report.count(state);
    report.add(Kind::CoordinatorKillAtCall, state, Some(gone_ns), clock::now_ns() - at_ns);
    Ok(())
}
