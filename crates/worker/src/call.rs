//! Calling the coordinator to the core of a worker that has nothing to do.
//!
//! With a worker on every core the coordinator has none for itself. It wakes up on the core of a
//! worker that is at work, and one of the two waits, while a worker that stays awake for its next
//! job keeps its own core from looking idle to the system, which therefore leaves the coordinator
//! where it is.

use core::sync::atomic::Ordering;
use protocol::{Launch, StatusPage, WorkerState};
use runtime::affinity;

/// How long a worker has no job before it calls (ns): in a batch the next one is there at once, and
/// a call takes some microseconds.
pub(crate) const CALL_NS: u64 = 10_000;

/// How long after that it calls again (ns): the coordinator slept since, and woke up elsewhere.
pub(crate) const CALL_AGAIN_NS: u64 = 100_000;

/// Who is called, and where to.
#[derive(Debug)]
pub(crate) struct Call<'w> {
    page: &'w StatusPage,
    worker: usize,
    thread: u32,
    core: usize,
    cores: Vec<usize>,
}

impl<'w> Call<'w> {
    /// `None`: the coordinator is not to be called, or it is not known which core this is.
    pub(crate) fn of(launch: &Launch, page: &'w StatusPage) -> Option<Self> {
        let core = affinity::current_core().filter(|_| launch.cores != 0)?;
        let cores = (0..64).filter(|core| launch.cores >> core & 1 == 1).collect();
        let worker = usize::from(launch.who.worker);
        Some(Self { page, worker, thread: launch.thread, core, cores })
    }

    /// Calls it, if all other workers are at work: where one of them has nothing to do either, it
    /// was called there already, or is about to. `false`: it cannot be called.
    pub(crate) fn make(&self) -> bool {
        let others = self.page.workers.iter().enumerate();
        let others = others.filter(|(number, _)| *number != self.worker).map(|(_, line)| line);
        let mut others = others.filter(|line| line.state() == Some(WorkerState::Ready));
        let all_work = others.all(|line| line.started.load(Ordering::Relaxed) != 0);
        !all_work || affinity::call(self.thread, self.core, &self.cores).is_ok()
    }
}
