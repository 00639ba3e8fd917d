//! Successors of lost workers: started between requests, never within one.
//!
//! A successor is a new incarnation, with channels of new names and a blank line on the status
//! page. It greets when it is ready, whatever the coordinator is doing.
//!
//! Its shared memory is held back while there is none to start, see [`transport::SegmentReserve`]:
//! whoever fills the file system then keeps no worker from being replaced. One reserve is enough
//! for any number of losses, because each predecessor gives back what its successor takes.

use super::worker_handle::WorkerHandle;
use super::{Incarnation, WorkerPool, WorkerPoolError};
use dispatch::Leave;
use protocol::Launch;
use runtime::{SealedMemory, clock};

/// What became of lost workers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Successors that were started.
    pub started: Vec<Incarnation>,
    /// Cores left without a worker for now: their workers died too often.
    pub off: Vec<u8>,
}

impl WorkerPool {
    /// Starts successors of all lost workers whose cores may have one, without waiting for them.
    ///
    /// # Errors
    ///
    /// If shared memory, a process or a core is unavailable. Those that are lost stay so until a
    /// later call.
    pub fn mend(&mut self, store: &SealedMemory) -> Result<Mended, WorkerPoolError> {
        self.notice_the_dead()?;
        self.hold_back();
        let mut mended = Mended::default();
        let lost = |worker: &&WorkerHandle| !worker.is_alive();
        let lost: Vec<Incarnation> =
            self.workers.iter().filter(lost).map(|worker| worker.who).collect();
        if lost.is_empty() {
            return Ok(mended);
        }
        for who in lost {
            match self.restarts.leave(who.worker, clock::now_ns()) {
                Leave::Granted => {
                    let successor = Incarnation { inc: who.inc.wrapping_add(1), ..who };
                    self.replace(successor, store)?;
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

    /// Holds memory for a successor, if there is room.
    pub(super) fn hold_back(&mut self) {
        if let Err(error) = self.reserve.hold() {
            tracing::debug!(%error, "no memory is held back");
        }
    }

    /// Starts a successor with the memory that was held back for it.
    fn replace(
        &mut self,
        successor: Incarnation,
        store: &SealedMemory,
    ) -> Result<(), WorkerPoolError> {
        // Without room for both ends it would begin, fail, and count as one more death.
        self.reserve.hold()?;
        self.reserve.release();
        let started = self.spawn(successor, store);
        let started = started.map(|worker| {
            // What the predecessor had is free from here on.
            self.workers[usize::from(successor.worker)] = worker;
        });
        self.hold_back();
        started
    }

    /// Waits until all live workers have greeted. Those that end instead are lost, as are those
    /// that do not greet in time.
    ///
    /// # Errors
    ///
    /// If no worker greets.
    pub fn rally(&mut self) -> Result<(), WorkerPoolError> {
        self.await_greetings(None)
    }

    /// Number of workers that take jobs.
    #[must_use]
    pub fn ready(&self) -> usize {
        self.workers.iter().filter(|worker| worker.is_ready()).count()
    }

    /// The worker that serves each core, or did last, with its process id.
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
            thread: runtime::affinity::this_thread(),
            cores: self.cores_to_call_from(),
            domain: self.domain.text().to_owned(),
        };
        let wake_fd = self.poller.add_event(key)?;
        let core = options.cores.get(usize::from(who.worker)).copied().flatten();
        let memory = (store, &self.status, &*self.paths);
        #[cfg(not(feature = "faults"))]
        let spawn = runtime::process::spawn;
        #[cfg(feature = "faults")]
        let spawn = super::inject::how_to_spawn(&mut self.stopped_starts);
        let domain = &self.domain;
        let worker = WorkerHandle::start(&launch, domain, options, core, memory, wake_fd, spawn)?;
        self.poller.add_process(worker.child(), key)?;
        Ok(worker)
    }
}
