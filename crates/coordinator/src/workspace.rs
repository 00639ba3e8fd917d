//! What requests are worked on with: sealed bodies, and workers or this process.

use crate::idle_cores::IdleCores;
use crate::in_process::InProcessExecutor;
use crate::request::RequestError;
use crate::virtual_cores::{VirtualCores, VirtualTime};
use crate::work::TaskSource;
use crate::worker_pool::{IdleHook, WorkerPool, WorkerPoolError, WorkerPoolReport};
use body::{BodyView, Meta};
use bvh::support::Extremes;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// The sealed bodies that requests refer to, and the depth at which their trees are cut.
#[derive(Clone, Copy, Debug)]
pub struct BodySet<'b> {
    /// The bodies, as stored.
    pub bodies: &'b [(Meta, BodyView<'b>)],
    /// The extremes of each body; `None`: they come from its tree, which is quicker for a single
    /// request.
    pub extremes: Option<&'b [Extremes]>,
    /// Distribution depth.
    pub depth: u32,
}

/// What runs the jobs.
#[derive(Debug)]
pub enum Backend {
    /// Worker processes.
    Workers(Box<WorkerPool>),
    /// This process, one job after the other.
    InProcess(Box<InProcessExecutor>),
    /// This process, as if by workers on cores that there are not.
    Virtual(Box<VirtualCores>),
}

/// A request that could not be completed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The request itself is unusable.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// Its jobs could not be run.
    #[error(transparent)]
    WorkerPool(#[from] WorkerPoolError),
}

impl Diagnostic for RunError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Request(error) => error.kind(),
            Self::WorkerPool(error) => error.kind(),
        }
    }

    fn what(&self) -> String {
        match self {
            Self::Request(error) => error.what(),
            Self::WorkerPool(error) => error.what(),
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Request(error) => error.remedy(),
            Self::WorkerPool(error) => error.remedy(),
        }
    }
}

impl Backend {
    /// Runs tasks to their end, or as far as limits ask. Returns how many jobs this process ran
    /// itself.
    ///
    /// # Errors
    ///
    /// As [`WorkerPool::run`]; never without worker processes.
    pub fn work_off<W: TaskSource>(&mut self, work: &mut W) -> Result<u64, WorkerPoolError> {
        match self {
            Self::Workers(worker_pool) => worker_pool.work_off(work).map(|()| 0),
            Self::InProcess(executor) => Ok(executor.work_off(work)),
            Self::Virtual(cores) => Ok(cores.work_off(work)),
        }
    }

    /// The workers, if there are any.
    #[must_use]
    pub fn worker_pool(&self) -> Option<&WorkerPool> {
        match self {
            Self::Workers(worker_pool) => Some(worker_pool),
            Self::InProcess(_) | Self::Virtual(_) => None,
        }
    }

    /// The workers, if there are any.
    pub fn worker_pool_mut(&mut self) -> Option<&mut WorkerPool> {
        match self {
            Self::Workers(worker_pool) => Some(worker_pool),
            Self::InProcess(_) | Self::Virtual(_) => None,
        }
    }

    /// The report of the last request, if there are workers.
    #[must_use]
    pub fn report(&self) -> Option<WorkerPoolReport> {
        self.worker_pool().map(WorkerPool::report)
    }

    /// The cores of workers, which wait while no work is off; none in this process.
    pub(crate) fn idle_cores(&self) -> IdleCores {
        match self {
            Self::Workers(worker_pool) => worker_pool.idle_cores(),
            Self::InProcess(_) => IdleCores::default(),
            Self::Virtual(cores) => cores.idle_cores(),
        }
    }

    /// Begins to rank what was accepted at this time (monotonic, ns).
    pub(crate) fn begin(&mut self, accepted_ns: u64) {
        if let Self::Virtual(cores) = self {
            cores.begin(accepted_ns);
        }
    }

    /// The answer is made.
    pub(crate) fn end(&mut self) {
        if let Self::Virtual(cores) = self {
            cores.end();
        }
    }

    /// How long the last ranking took on virtual cores, if it ran on any.
    #[must_use]
    pub fn virtual_time(&self) -> Option<&VirtualTime> {
        match self {
            Self::Virtual(cores) => Some(cores.time()),
            Self::Workers(_) | Self::InProcess(_) => None,
        }
    }

    /// What is called while a request is worked on, if something is.
    pub(crate) fn idle_hook(&self) -> Option<IdleHook> {
        match self {
            Self::Workers(worker_pool) => worker_pool.idle_hook().cloned(),
            Self::InProcess(executor) => executor.idle_hook().cloned(),
            Self::Virtual(_) => None,
        }
    }
}
