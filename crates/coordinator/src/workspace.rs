//! The path of one request from a scenario to its evidence, whatever the caller and the backend.
//!
//! ```text
//! Scenario --plan--> Request --> Work --Backend: workers, or this process--> evidence --> read
//! ```
//!
//! A command that ranks once and a service that ranks for months both go through
//! [`RankingWorkspace::rank`], so that they cannot drift apart.

use crate::in_process::InProcessExecutor;
use crate::request::{Candidates, Request, RequestError};
use crate::request_limits::RequestLimits;
use crate::work::{RankingRun, RunBuffers, TaskSource};
use crate::worker_pool::{IdleHook, WorkerPool, WorkerPoolError, WorkerPoolReport};
use body::{BodyView, Meta};
use bvh::support::Extremes;
use damage::{Curves, Policy};
use diagnostic::{Diagnostic, FailureKind};
use runtime::clock;
use scenario::Scenario;
use std::borrow::Cow;
use std::sync::Arc;

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

/// One request.
#[derive(Clone, Debug)]
pub struct RankingRequest<'a> {
    /// Parties and candidates.
    pub scenario: &'a Scenario,
    /// The body of each party: its number in the store.
    pub models: &'a [usize],
    /// Policy and curves that judge the candidates.
    pub rules: (Arc<Policy>, Arc<Curves>),
    /// Whether a job history of questions and jobs is kept.
    pub job_history: bool,
}

/// What runs the jobs.
#[derive(Debug)]
pub enum Backend {
    /// Worker processes.
    Workers(Box<WorkerPool>),
    /// This process, one job after the other.
    InProcess(Box<InProcessExecutor>),
}

/// When the stages of one request ended (ns, monotonic), and what was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunTimes {
    /// Paths and hulls are known.
    pub planned_ns: u64,
    /// All jobs are closed, or no longer waited for.
    pub worked_ns: u64,
    /// Number of jobs that this process ran itself.
    pub jobs_in_process: u64,
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

/// Buffers kept from one request to the next, so that the next does not allocate.
///
/// They must not be used with other bodies or another depth: they hold the zones of their bodies.
#[derive(Debug, Default)]
pub struct RankingWorkspace {
    candidates: Candidates,
    buffers: RunBuffers,
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
        }
    }

    /// The workers, if there are any.
    #[must_use]
    pub fn worker_pool(&self) -> Option<&WorkerPool> {
        match self {
            Self::Workers(worker_pool) => Some(worker_pool),
            Self::InProcess(_) => None,
        }
    }

    /// The workers, if there are any.
    pub fn worker_pool_mut(&mut self) -> Option<&mut WorkerPool> {
        match self {
            Self::Workers(worker_pool) => Some(worker_pool),
            Self::InProcess(_) => None,
        }
    }

    /// The report of the last request, if there are workers.
    #[must_use]
    pub fn report(&self) -> Option<WorkerPoolReport> {
        self.worker_pool().map(WorkerPool::report)
    }

    /// What is called while a request is worked on, if something is.
    pub(crate) fn idle_hook(&self) -> Option<IdleHook> {
        match self {
            Self::Workers(worker_pool) => worker_pool.idle_hook().cloned(),
            Self::InProcess(executor) => executor.idle_hook().cloned(),
        }
    }
}

impl RankingWorkspace {
    /// Runs a request, and passes what is known at its end to `read`. `limits` gives the limits
    /// once the request is planned, when the time left before a deadline is known.
    ///
    /// # Errors
    ///
    /// If the request is unusable, or no worker is left to run its jobs.
    ///
    /// # Panics
    ///
    /// If there is no model for a party, or no such body.
    pub fn rank<T>(
        &mut self,
        stage: &BodySet<'_>,
        inquiry: RankingRequest<'_>,
        limits: impl FnOnce() -> RequestLimits,
        backend: &mut Backend,
        read: impl FnOnce(&mut RankingRun<'_>, RunTimes) -> T,
    ) -> Result<T, RunError> {
        let RankingRequest { scenario, models, rules, job_history } = inquiry;
        let candidates = core::mem::take(&mut self.candidates);
        let request = Request::with_models(
            scenario,
            stage.bodies,
            (models, stage.extremes),
            rules,
            candidates,
        )?;
        let buffers = core::mem::take(&mut self.buffers);
        let mut work = RankingRun::with_buffers(&request, stage.bodies, stage.depth, buffers)
            .with_limits(limits());
        if job_history {
            work = work.with_job_history();
        }
        let planned_ns = clock::now_ns();
        let done = backend.work_off(&mut work);
        let worked_ns = clock::now_ns();
        let told = done.map(|jobs_in_process| {
            read(&mut work, RunTimes { planned_ns, worked_ns, jobs_in_process })
        });
        self.buffers = work.into_buffers();
        self.candidates = request.into_buffers();
        Ok(told?)
    }
}
