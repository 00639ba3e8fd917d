//! The worker pool of a service: between requests it sleeps on the same epoll as within them, and
//! while it works a hook serves waiting clients.

use super::{WorkerPool, WorkerPoolError};
use core::cell::RefCell;
use core::fmt;
use runtime::Wake;
use std::os::fd::BorrowedFd;
use std::rc::Rc;

/// Called repeatedly while a request is worked on: whenever the coordinator is about to sleep, and
/// at least every 20 ms; in-process, between two jobs. Clones call the same.
#[derive(Clone)]
pub struct IdleHook(Rc<RefCell<dyn FnMut()>>);

impl IdleHook {
    /// A hook. It must be quick: a worker may be waiting.
    pub fn new(attend: impl FnMut() + 'static) -> Self {
        Self(Rc::new(RefCell::new(attend)))
    }

    pub(crate) fn call(&self) {
        // One that calls itself is at work already.
        if let Ok(mut attend) = self.0.try_borrow_mut() {
            attend();
        }
    }
}

impl fmt::Debug for IdleHook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("IdleHook")
    }
}

/// The key of the service's wake fd, apart from those of the workers.
const WAKE_KEY: u32 = u32::MAX;

impl WorkerPool {
    /// Ends sleeps whenever this descriptor is readable; the caller must drain it.
    ///
    /// # Errors
    ///
    /// If file descriptors ran out.
    pub fn listen(
        &mut self,
        wake_fd: BorrowedFd<'_>,
        idle_hook: IdleHook,
    ) -> Result<(), WorkerPoolError> {
        self.poller.add_fd(wake_fd, WAKE_KEY)?;
        self.idle_hook = Some(idle_hook);
        Ok(())
    }

    /// What [`listen`](Self::listen) was given.
    pub(crate) fn idle_hook(&self) -> Option<&IdleHook> {
        self.idle_hook.as_ref()
    }

    /// Sleeps until the wake fd rings or a worker ends, at most `timeout_ns`; 0 polls without
    /// sleeping.
    ///
    /// # Errors
    ///
    /// [`WorkerPoolError::Interrupted`] if a signal came.
    pub fn idle(&mut self, timeout_ns: u64) -> Result<(), WorkerPoolError> {
        for wake in self.poller.wait(Some(timeout_ns))? {
            match wake {
                Wake::Process(worker) => self.ended.push(worker as usize),
                Wake::Signal(_) => return Err(WorkerPoolError::Interrupted),
                Wake::Event(_) | Wake::Ready(_) | Wake::Timer => {}
            }
        }
        Ok(())
    }

    /// Number of workers that the pool should have.
    #[must_use]
    pub fn size(&self) -> usize {
        self.workers.len()
    }

    /// Number of workers that are lost and not replaced.
    #[must_use]
    pub fn missing(&self) -> usize {
        let gone = |(number, worker): (usize, &super::WorkerHandle)| {
            !worker.is_alive() || self.ended.contains(&number)
        };
        self.workers.iter().enumerate().filter(|worker| gone(*worker)).count()
    }
}
