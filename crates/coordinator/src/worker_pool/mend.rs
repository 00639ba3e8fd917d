//! Successors for workers that were lost: started between requests, never inside one.
//!
//! A successor is a new incarnation, with channels of new names and a blank line on the status
//! page. It greets when it is ready, whatever the coordinator is doing then.

use super::worker_handle::WorkerHandle;
use super::{Incarnation, WorkerPool, WorkerPoolError};
use dispatch::Leave;
use protocol::Launch;
use runtime::{SealedMemory, clock};

/// What became of those who were lost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Who has a successor, which is this one.
    pub started: Vec<Incarnation>,
    /// Cores that stay without one for now: their workers died too often.
    pub off: Vec<u8>,
}

impl WorkerPool {
    /// Starts successors of all lost workers whose cores may have one. Does not wait for them.
    ///
    /// Cleans up behind the dead before, unless somebody is starting: then the next call does.
    ///
    /// # Errors
    ///
    /// If shared memory, a process or a core is not to be had.
    pub fn mend(&mut self, store: &SealedMemory) -> Result<Mended, WorkerPoolError> {
        self.notice_the_dead()?;
        let mut mended = Mended::default();
        let lost = |worker: &&WorkerHandle| !worker.is_alive();
        let lost: Vec<Incarnation> =
            self.workers.iter().filter(lost).map(|worker| worker.who).collect();
        if lost.is_empty() {
            return Ok(mended);
        }
        if !self.workers.iter().any(WorkerHandle::is_starting) {
            let _removed = self.domain.cleaner().run();
        }
        for who in lost {
            match self.restarts.leave(who.worker, clock::now_ns()) {
                Leave::Granted => {
                    let successor = Incarnation { inc: who.inc.wrapping_add(1), ..who };
                    let worker = self.spawn(successor, store)?;
                    self.workers[usize::from(who.worker)] = worker;
                    mended.started.push(successor);
                }
                Leave::CoreOff | Leave::AllOff => {
                    tracing::warn!(worker = who.worker, "no successor: workers die too often");
                    mended.off.push(who.worker);
                }
            }
        }
        Ok(mended)
    }

    /// Waits until all who live have greeted. Those that end instead are lost, and so are those
    /// that do not greet in time.
    ///
    /// # Errors
    ///
    /// If nobody greets.
    pub fn rally(&mut self) -> Result<(), WorkerPoolError> {
        self.await_greetings()
    }

    /// Workers that take jobs.
    #[must_use]
    pub fn ready(&self) -> usize {
        self.workers.iter().filter(|worker| worker.is_ready()).count()
    }

    /// Who serves each core now, or did last, with process ids.
    #[must_use]
    pub fn roster(&self) -> Vec<(Incarnation, u32)> {
        self.workers.iter().map(|worker| (worker.who, worker.report.pid)).collect()
    }

    /// Starts a worker.
    pub(super) fn spawn(
        &mut self,
        who: Incarnation,
        store: &SealedMemory,
    ) -> Result<WorkerHandle, WorkerPoolError> {
        let key = u32::from(who.worker);
        if let Some(line) = self.status.page().workers.get(usize::from(who.worker)) {
            line.reset();
        }
        if let Some(line) = self.status.page().coordinator.get(usize::from(who.worker)) {
            line.reset();
        }
        let options = &self.options;
        let launch = Launch {
            who,
            boot: self.boot,
            batch: options.queues.batch,
            queue: options.queues.capacity,
            copies: options.copies,
            #[cfg(feature = "faults")]
            obeys: options.obeys,
            domain: self.domain.text().to_owned(),
        };
        let wake_fd = self.poller.add_event(key)?;
        let core = options.cores.get(usize::from(who.worker)).copied().flatten();
        let status = &self.status;
        let worker =
            WorkerHandle::start(&launch, &self.domain, options, core, store, status, wake_fd)?;
        self.poller.add_process(worker.child(), key)?;
        Ok(worker)
    }
}
