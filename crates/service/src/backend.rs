//! What executes requests: a worker pool that replaces lost workers, or, for comparison and for
//! machines with a single core, this process itself.

use body::{BodyView, Meta};
use coordinator::{
    Backend, IdleHook, InProcessExecutor, Mended, Options, WorkerPool, WorkerPoolError,
};
use runtime::{OsError, Poller, SealedMemory, Wake};
use std::os::fd::BorrowedFd;

/// Wakes this process while it has no worker pool.
const WAKE_KEY: u32 = 0;

/// The workers, or the in-process substitute.
pub(crate) struct ServiceBackend<'s> {
    /// The epoll that this process sleeps on while it has no worker pool.
    guard: Poller,
    pub(crate) backend: Backend,
    store: &'s SealedMemory,
}

/// A signal arrived.
#[derive(Debug)]
pub(crate) struct Interrupted;

impl<'s> ServiceBackend<'s> {
    /// Starts the workers; without options, all work is done in this process.
    pub(crate) fn start(
        (store, bodies): (&'s SealedMemory, &'s [(Meta, BodyView<'s>)]),
        options: Option<&Options>,
        wake_fd: BorrowedFd<'_>,
        idle_hook: IdleHook,
    ) -> Result<Self, WorkerPoolError> {
        let mut guard = Poller::new()?;
        guard.catch_signals()?;
        guard.add_fd(wake_fd, WAKE_KEY)?;
        let backend = match options {
            Some(options) => {
                let mut worker_pool = WorkerPool::start(store, options)?;
                worker_pool.listen(wake_fd, idle_hook)?;
                Backend::Workers(Box::new(worker_pool))
            }
            None => {
                let executor = InProcessExecutor::with_room_for(bodies);
                Backend::InProcess(Box::new(executor.with_idle_hook(idle_hook)))
            }
        };
        Ok(Self { guard, backend, store })
    }

    /// Starts replacements for lost workers, without waiting for them.
    pub(crate) fn mend(&mut self) -> Result<Mended, WorkerPoolError> {
        let store = self.store;
        self.backend
            .worker_pool_mut()
            .map_or_else(|| Ok(Mended::default()), |worker_pool| worker_pool.mend(store))
    }

    /// Process ids of the workers.
    pub(crate) fn pids(&self) -> Vec<u32> {
        self.backend.worker_pool().map(WorkerPool::pids).unwrap_or_default()
    }

    /// Configured number of workers.
    pub(crate) fn size(&self) -> usize {
        self.backend.worker_pool().map_or(0, WorkerPool::size)
    }

    /// Number of lost workers.
    pub(crate) fn missing(&self) -> usize {
        self.backend.worker_pool().map_or(0, WorkerPool::missing)
    }

    /// Sleeps until a client rings, a worker ends, a signal arrives or the timeout passes; 0 polls.
    pub(crate) fn idle(&mut self, timeout_ns: u64) -> Result<Option<Interrupted>, OsError> {
        if let Some(worker_pool) = self.backend.worker_pool_mut() {
            return match worker_pool.idle(timeout_ns) {
                Ok(()) => Ok(None),
                Err(WorkerPoolError::System(error)) => Err(error),
                Err(_) => Ok(Some(Interrupted)),
            };
        }
        let mut wakes = self.guard.wait(Some(timeout_ns))?;
        Ok(wakes.any(|wake| matches!(wake, Wake::Signal(_))).then_some(Interrupted))
    }
}
