//! The main loop of a worker: inherit, greet, take batches until told to stop.

use crate::answer::{Answer, Outlet, Started};
use crate::call::{CALL_AGAIN_NS, CALL_NS, Call};
use crate::copy::Copies;
#[cfg(feature = "faults")]
use crate::fault::FaultCommands;
use crate::look::Looker;
use body::{BodyView, Meta, store};
use bvh::NodePair;
use core::sync::atomic::Ordering;
use crossbeam::utils::Backoff;
use diagnostic::Diagnostic;
use executor::{Executor, NotDone};
use protocol::{
    Head, Launch, MessageKind, Reject, RequestId, WireJob, WireLook, WireTask, WorkerState, job,
    launch,
};
use runtime::{EventFd, ReadWords, SealedMemory, StatusMemory, clock, futex, process};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use transport::{Domain, Sizes, UseError, WorkerLink};

/// A worker cannot start or go on.
#[derive(Debug, thiserror::Error)]
pub enum WorkerError {
    /// The argument on the command line does not come from a coordinator.
    #[error("a worker is started by a coordinator, not by hand")]
    Launch,
    /// A system call failed.
    #[error(transparent)]
    System(#[from] runtime::OsError),
    /// The channels cannot be opened.
    #[error(transparent)]
    Open(#[from] transport::OpenError),
    /// The channels broke.
    #[error("the channel to the coordinator broke: {0}")]
    Use(#[from] UseError),
    /// A batch was rejected. The worker ends, which gives its jobs back.
    #[error("a batch of jobs was rejected: {0}")]
    Batch(Reject),
    /// The model store cannot be read.
    #[error("model store: {0}")]
    Store(#[from] body::file::FileError),
}

impl Diagnostic for WorkerError {
    fn kind(&self) -> diagnostic::FailureKind {
        match self {
            Self::Launch => diagnostic::FailureKind::Configuration,
            Self::Open(open) if open.is_skew() => diagnostic::FailureKind::Skew,
            Self::Open(_) => diagnostic::FailureKind::Resources,
            Self::System(error) => Diagnostic::kind(error),
            Self::Use(_) | Self::Batch(_) | Self::Store(_) => diagnostic::FailureKind::Internal,
        }
    }
}

/// How long a worker stays awake without a job (ns). Within a request the next one is rarely
/// farther away, and a core that has gone to sleep takes tenths of a millisecond to be there again
/// where it is a virtual one.
const AWAKE_NS: u64 = 1_000_000;

/// Longest sleep of an idle worker before it checks again (ns).
const NAP_NS: u64 = 50_000_000;

/// Runs a worker to its end. `word` is from [`Launch::to_word`], `build` is this program's build
/// id.
///
/// # Errors
///
/// If it cannot start, or its channels break.
pub fn run(word: &str, build: &str) -> Result<(), WorkerError> {
    if let Some(place) = launch::read_clean_word(word) {
        transport::service::clean(Path::new(place));
        return Ok(());
    }
    let launch = Launch::from_word(word).ok_or(WorkerError::Launch)?;
    let store = SealedMemory::from_fd(process::inherited(launch::STORE_FD)?)?;
    let status = StatusMemory::from_fd(process::inherited(launch::STATUS_FD)?)?;
    let wake_event = EventFd::from_fd(process::inherited(launch::EVENT_FD)?);
    let paths = ReadWords::from_fd(process::inherited(launch::PATHS_FD)?, launch::PATHS_WORDS)?;
    let worker = usize::from(launch.who.worker);
    let page = status.page();
    let line = page.workers.get(worker).ok_or(WorkerError::Launch)?;
    let coordinator = page.coordinator.get(worker).ok_or(WorkerError::Launch)?;
    let bodies = store::open(store.bytes())?;
    let domain = Domain::open(&launch.domain)?;
    let sizes = Sizes {
        job_words: launch.batch_words(),
        job_queue: launch.batches(),
        result_words: launch::RESULT_WORDS,
        result_queue: launch::RESULTS,
    };
    let link = WorkerLink::open(&domain, launch.who, &sizes, build)?;
    let outlet = Outlet {
        sender: &link.results,
        line,
        coordinator,
        wake_event: &wake_event,
        who: launch.who,
        boot: launch.boot,
        sent: core::cell::Cell::new(0),
        #[cfg(feature = "faults")]
        corruption: core::cell::Cell::new(None),
    };
    line.inc.store(launch.who.inc, Ordering::Relaxed);
    line.cpu.store(
        runtime::affinity::current_core().map_or(0, |core| core as u32 + 1),
        Ordering::Relaxed,
    );
    line.state.store(WorkerState::Hello as u32, Ordering::Release);
    outlet.tell(outlet.head(RequestId(0), MessageKind::Hello))?;
    line.state.store(WorkerState::Ready as u32, Ordering::Release);
    let mut job_loop = JobLoop::new(&bodies, paths, &outlet);
    job_loop.call = Call::of(&launch, page);
    if launch.copies {
        job_loop.copies = Some(Copies::like(bodies.iter().map(|(_, body)| body)));
    }
    #[cfg(feature = "faults")]
    if launch.obeys {
        job_loop.fault_commands = Some(FaultCommands::default());
    }
    let mut words = Vec::with_capacity(sizes.job_words);
    while let Some(head) = job_loop.next_batch(&link, &mut words)? {
        job_loop.work_off(&head, &words)?;
        job_loop.answered(u64::from(head.job) + 1);
    }
    line.state.store(WorkerState::Bye as u32, Ordering::Release);
    Ok(())
}

/// The loop that runs jobs.
struct JobLoop<'w> {
    bodies: &'w [(Meta, BodyView<'w>)],
    outlet: &'w Outlet<'w>,
    executor: Executor,
    looker: Looker,
    /// Set if the coordinator is called here when there is nothing to do.
    call: Option<Call<'w>>,
    /// Set if jobs are done on copies.
    copies: Option<Copies>,
    /// Set if faults are injected.
    #[cfg(feature = "faults")]
    fault_commands: Option<FaultCommands>,
}

impl<'w> JobLoop<'w> {
    fn new(bodies: &'w [(Meta, BodyView<'w>)], paths: ReadWords, outlet: &'w Outlet<'w>) -> Self {
        let executor = Executor::with_room_for(bodies);
        Self {
            bodies,
            outlet,
            executor,
            looker: Looker::new(paths),
            call: None,
            copies: None,
            #[cfg(feature = "faults")]
            fault_commands: None,
        }
    }

    /// Publishes that all batches below a number are answered, after the last of their results was
    /// sent.
    fn answered(&self, batches: u64) {
        let known = self.outlet.line.answered.load(Ordering::Relaxed);
        self.outlet.line.answered.store(batches.max(known), Ordering::SeqCst);
        self.outlet.notify();
    }

    /// Waits for a batch: stays awake for a while, then sleeps until the coordinator changes the
    /// futex word. `None`: stop.
    fn next_batch(
        &mut self,
        link: &WorkerLink,
        words: &mut Vec<u64>,
    ) -> Result<Option<Head>, WorkerError> {
        let Outlet { line, coordinator, .. } = self.outlet;
        let backoff = Backoff::new();
        let idle_from_ns = clock::now_ns();
        let mut call_ns = CALL_NS;
        loop {
            let seen = coordinator.wake.load(Ordering::SeqCst);
            if coordinator.stop.load(Ordering::Acquire) == 1 {
                return Ok(None);
            }
            match link.jobs.take(words)? {
                Some(Ok(head)) if head.kind == MessageKind::Batch as u8 => return Ok(Some(head)),
                Some(Ok(head)) if head.kind == MessageKind::Section as u8 => {
                    let is_stored = self.copies.as_mut().is_some_and(|copies| copies.store(words));
                    line.beat.fetch_add(1, Ordering::Relaxed);
                    if is_stored {
                        continue;
                    }
                    return Err(WorkerError::Batch(Reject::Length));
                }
                Some(Ok(_)) => return Err(WorkerError::Batch(Reject::Foreign)),
                // It may have been a section, without which later jobs cannot run.
                Some(Err(reject)) if self.copies.is_some() => {
                    return Err(WorkerError::Batch(reject));
                }
                // Answered without results: the coordinator sees that, and sends its jobs again. If
                // it was not the next batch, the batch that follows corrects the number.
                Some(Err(_)) => {
                    self.answered(line.answered.load(Ordering::Relaxed) + 1);
                }
                None => {}
            }
            let idle_ns = clock::now_ns() - idle_from_ns;
            if idle_ns >= call_ns {
                call_ns = idle_ns + CALL_AGAIN_NS;
                self.call = self.call.take().filter(Call::make);
            }
            if idle_ns < AWAKE_NS {
                // Whoever else waits for this core goes first.
                backoff.snooze();
                continue;
            }
            line.sleeping.store(1, Ordering::SeqCst);
            // A coordinator that did not see the flag has changed the word since `seen`.
            let _woken = futex::wait(&coordinator.wake, seen, Some(NAP_NS));
            // No heartbeat: a worker that sleeps while it should have jobs must look silent.
            line.sleeping.store(0, Ordering::SeqCst);
        }
    }

    fn work_off(&mut self, head: &Head, words: &[u64]) -> Result<(), WorkerError> {
        let (tasks, jobs) = job::read_batch(words).ok_or(WorkerError::Batch(Reject::Length))?;
        let request = RequestId(head.request);
        if !self.outlet.is_wanted(request) {
            return Ok(());
        }
        for job in jobs {
            let _started = Started::new(self.outlet, request, job);
            let run = AssertUnwindSafe(|| {
                #[cfg(feature = "faults")]
                if let Some(fault_commands) = &mut self.fault_commands {
                    fault_commands.obey(self.outlet, job)?;
                }
                self.run(request, &tasks[job.task as usize], job)
            });
            match catch_unwind(run) {
                Ok(result) => result?,
                Err(_) => self.refuse(request, job)?,
            }
            if !self.outlet.is_wanted(request) {
                return Ok(());
            }
        }
        Ok(())
    }

    fn run(&mut self, request: RequestId, task: &WireTask, job: &WireJob) -> Result<(), UseError> {
        let started_ns = clock::now_ns();
        let body = |number: u32| match &self.copies {
            Some(copies) => copies.body(number),
            None => self.bodies.get(number as usize).map(|(_, body)| *body),
        };
        let start = NodePair { a: job.node_a, b: job.node_b };
        let part = executor::JobInput { start, budget: job.budget };
        let mut answer = Answer::new(self.outlet, request, *job);
        if let Some(look) = WireLook::of(task) {
            return match self.looker.look(&look, body, &mut answer) {
                Ok((seen, counters)) => answer.finish_look(&seen, counters, started_ns),
                Err(NotDone::Stopped) => answer.abandon(),
                Err(NotDone::Unknown) => self.refuse(request, job),
            };
        }
        match self.executor.execute(task, body, part, &mut answer) {
            Ok(done) => answer.finish(&done, self.executor.rest(), started_ns),
            // Told to stop mid-job: the job is not answered, since nobody waits for it.
            Err(NotDone::Stopped) => answer.abandon(),
            Err(NotDone::Unknown) => self.refuse(request, job),
        }
    }

    /// Answers that a job cannot be run here.
    fn refuse(&self, request: RequestId, job: &WireJob) -> Result<(), UseError> {
        let head = self.outlet.head(request, MessageKind::Nack);
        self.outlet.tell(Head { job: job.job, attempt: job.attempt as u8, ..head })
    }
}
