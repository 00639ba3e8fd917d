//! The worker pool: worker processes, their channels, and the loop that keeps them busy.
//!
//! ```text
//! loop: take results --> dispatcher --> send batches;  nothing to take: sleep on one epoll
//!       a worker's end (pidfd) or silence --> drain its results --> its jobs go to the others
//! ```
//!
//! `inbox` handles what comes from the workers, `outbox` what goes to them, `supervise` their
//! health, `worker_handle` a single worker.
//!
//! A request that loses a worker goes on with the others. [`WorkerPool::mend`] starts a successor
//! once the request is answered; it takes jobs as soon as it has greeted, whatever the request. The
//! memory that one successor shares is held back for it: some 700 KiB with the default queues.
//!
//! Order at start: preflight, seal store, status page, services, processes, greetings. Order at
//! stop: stop flags, a grace period, SIGKILL, channels, domain. Every wait has a bound.

mod chunk;
mod error;
mod idle;
mod inbox;
mod incident;
#[cfg(feature = "faults")]
mod inject;
mod mend;
mod options;
mod outbox;
mod preflight;
mod report;
mod supervise;
mod worker_handle;

pub use error::WorkerPoolError;
pub use idle::IdleHook;
pub use incident::{Incident, Observation};
#[cfg(feature = "faults")]
pub use inject::Corruption;
pub use mend::Mended;
pub use options::Options;
pub use preflight::{FILES, FILES_PER_WORKER, MissingRequirement, link_sizes, preflight};
pub use report::{Duty, Hardware, WorkerPoolReport, WorkerReport};

use crate::idle_cores::IdleCores;
use crate::work::{PartOf, TaskSource};
use chunk::Outgoing;
use core::sync::atomic::Ordering;
use crossbeam::utils::Backoff;
use dispatch::{Counts, Dispatcher, Effect, Event, LogEntry, MatchScheme, Progress, Restarts};
use outbox::BatchWriter;
use protocol::{Boot, Incarnation, RequestId};
use runtime::{Poller, SealedMemory, StatusMemory, Wake, WrittenWords, clock};
use std::rc::Rc;
use transport::{Domain, SegmentReserve, UseError};
use worker_handle::WorkerHandle;

/// Longest sleep of the coordinator before it checks the workers' heartbeats (ns).
const NAP_NS: u64 = 20_000_000;
/// Maximum sleep while sections wait for capacity: a worker that takes some does not ring.
const BACKLOG_NAP_NS: u64 = 100_000;
/// How long a worker may take to end by itself (ms).
const FAREWELL_MS: u64 = 200;

/// Puts model files into sealed memory, where every process reads them in place.
///
/// # Errors
///
/// If there is not enough memory.
pub fn seal(files: &[&[u8]]) -> Result<SealedMemory, runtime::OsError> {
    let len = body::store::length(files);
    SealedMemory::create("trolley-models", len, |bytes| body::store::fill(bytes, files))
}

/// Worker processes, ready for requests.
#[derive(Debug)]
pub struct WorkerPool {
    // Dropped in this order: channels before the domain that they live in.
    workers: Vec<WorkerHandle>,
    status: StatusMemory,
    /// Where bodies go, for looks at them: written before these are sent.
    paths: Rc<WrittenWords>,
    /// Memory for the next successor, whatever fills the file system.
    reserve: SegmentReserve,
    domain: Domain,
    /// Catches signals: after the domain, as one that came when the work was done ends the process
    /// once they are no longer caught.
    poller: Poller,
    dispatcher: Dispatcher<Box<dyn MatchScheme>>,
    boot: Boot,
    request: u64,
    options: Options,
    restarts: Restarts,
    /// Incidents since the start of the request.
    incidents: Vec<Incident>,
    /// The cores that this thread may run on.
    own_cores: Vec<usize>,
    /// Queue per worker; `None` if nothing is copied.
    outgoing: Option<Vec<Outgoing>>,
    rejected: u64,
    duty: Duty,
    /// Workers whose end was reported and which are not yet reaped: an end is reported once.
    ended: Vec<usize>,
    /// When all heartbeats were last checked (ns): kept across requests, which may be short.
    looked_ns: u64,
    /// The last request that was cancelled.
    cancelled: u64,
    scratch: Vec<u64>,
    effects: Vec<Effect>,
    batch: BatchWriter,
    /// Called while a request is worked on.
    idle_hook: Option<IdleHook>,
    /// How many of the next workers stop themselves before exec.
    #[cfg(feature = "faults")]
    stopped_starts: u32,
}

impl WorkerPool {
    /// Starts the workers and waits until each has greeted. One that does not is replaced once;
    /// then one that has greeted is enough.
    ///
    /// # Errors
    ///
    /// If shared memory, a process or a core is unavailable, or no worker greets. That takes less
    /// than 2 s, unless workers visibly progress: then up to the longest start of the options.
    pub fn start(store: &SealedMemory, options: &Options) -> Result<Self, WorkerPoolError> {
        let workers = options.cores.len();
        if let Some(missing) = preflight(options).into_iter().find(|missing| missing.is_fatal) {
            return Err(WorkerPoolError::MissingRequirement(missing));
        }
        let boot = Boot(clock::random_u64()?);
        let folder = options.folder.clone().unwrap_or_else(transport::default_folder);
        let swept = transport::sweep_leftovers(&folder);
        if swept > 0 {
            tracing::info!(swept, "removed leftovers of killed runs");
        }
        let status = StatusMemory::create()?;
        let paths = WrittenWords::create("trolley-paths", protocol::launch::PATHS_WORDS)?;
        let paths = Rc::new(paths);
        let mut poller = Poller::new()?;
        poller.catch_signals()?;
        let domain = Domain::create(Some(&folder), &options.instance, boot)?;
        let scheme = options.matching.scheme();
        let mut dispatcher = Dispatcher::new(scheme, options.queues, options.cache, workers);
        if options.log {
            dispatcher.keep_log();
        }
        let mut worker_pool = Self {
            workers: Vec::with_capacity(workers),
            status,
            paths,
            poller,
            reserve: SegmentReserve::new(&domain, &preflight::sizes(options)),
            domain,
            dispatcher,
            boot,
            request: 0,
            options: options.clone(),
            restarts: Restarts::new(options.intensity),
            incidents: Vec::new(),
            own_cores: runtime::affinity::allowed_cores(),
            outgoing: options.copies.then(|| (0..workers).map(|_| Outgoing::default()).collect()),
            rejected: 0,
            duty: Duty::default(),
            ended: Vec::new(),
            looked_ns: 0,
            cancelled: 0,
            scratch: Vec::with_capacity(protocol::launch::RESULT_WORDS),
            effects: Vec::new(),
            batch: BatchWriter::default(),
            idle_hook: None,
            #[cfg(feature = "faults")]
            stopped_starts: options.stopped_starts,
        };
        for worker in 0..workers {
            let worker = worker_pool.spawn(Incarnation { worker: worker as u8, inc: 0 }, store)?;
            worker_pool.workers.push(worker);
        }
        worker_pool.await_greetings(Some(store))?;
        worker_pool.hold_back();
        Ok(worker_pool)
    }

    /// Process ids of the workers, in order.
    #[must_use]
    pub fn pids(&self) -> Vec<u32> {
        self.workers.iter().map(|worker| worker.report.pid).collect()
    }

    /// The cores of the workers: idle while none of them is given work. One is this process's own.
    pub(crate) fn idle_cores(&self) -> IdleCores {
        let most = self.own_cores.len().saturating_sub(1);
        IdleCores::of(&self.options.cores, most, self.shares_core())
    }

    /// Whether no core is free of workers: spinning would take a worker's time.
    fn shares_core(&self) -> bool {
        self.own_cores.len() <= self.workers.len()
    }

    /// The cores of this thread, one bit each, if workers call it to theirs: it has none for
    /// itself, and each of them has one. Else 0.
    fn cores_to_call_from(&self) -> u64 {
        let Self { own_cores, options, .. } = self;
        let is_workers = |core: &usize| *core < 64 && options.cores.contains(&Some(*core));
        let has_choice = own_cores.len() > 1 && own_cores.len() == options.cores.len();
        if !has_choice || !own_cores.iter().all(is_workers) {
            return 0;
        }
        own_cores.iter().fold(0, |bits, core| bits | 1 << core)
    }

    /// Leaves the core of a worker that died while it called this thread there.
    fn leave_core_of(&self, worker: usize) {
        let core = self.options.cores.get(worker).copied().flatten();
        let is_left = || runtime::affinity::allowed_cores().into_iter().eq(core);
        if self.cores_to_call_from() != 0 && is_left() {
            let _anywhere = runtime::affinity::widen_self(&self.own_cores);
        }
    }

    /// Whether sections are copied into the memory of each worker.
    pub(crate) fn copies(&self) -> bool {
        self.outgoing.is_some()
    }

    /// Memory for the paths of the next request. Those of an earlier one that was cancelled may
    /// still be read: nobody waits for what comes of that.
    pub(crate) fn paths(&self) -> &Rc<WrittenWords> {
        &self.paths
    }

    /// Tells the workers that the request is cancelled.
    fn cancel(&mut self) {
        self.cancelled = self.request;
        for line in &self.status.page().coordinator {
            line.cancelled.store(self.request, Ordering::SeqCst);
        }
    }

    /// Runs a request to its end, or as far as its limits ask.
    ///
    /// # Errors
    ///
    /// If no worker is left and there is no deadline at which to answer anyway, or a signal came.
    pub fn run<W: TaskSource>(
        &mut self,
        work: &mut W,
    ) -> Result<WorkerPoolReport, WorkerPoolError> {
        self.work_off(work)?;
        Ok(self.report())
    }

    /// [`WorkerPool::run`] without a report, which costs copies: see [`WorkerPool::report`].
    ///
    /// # Errors
    ///
    /// As [`WorkerPool::run`].
    pub fn work_off<W: TaskSource>(&mut self, work: &mut W) -> Result<(), WorkerPoolError> {
        let mut effects = std::mem::take(&mut self.effects);
        effects.clear();
        let done = self.work_off_by(work, &mut effects);
        self.effects = effects;
        done
    }

    /// [`WorkerPool::work_off`] what takes no sections: the log stays that of the last request that
    /// does.
    pub(crate) fn work_off_unlogged<W: TaskSource>(
        &mut self,
        work: &mut W,
    ) -> Result<(), WorkerPoolError> {
        let log = self.dispatcher.exchange_log(None);
        let done = self.work_off(work);
        self.dispatcher.exchange_log(log);
        done
    }

    fn work_off_by<W: TaskSource>(
        &mut self,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Result<(), WorkerPoolError> {
        let begun_ns = clock::now_ns();
        work.accept(begun_ns);
        self.begin();
        // A worker that died since the last request has not been noticed yet.
        self.sleep(0)?;
        let mut progress = self.step(Event::Poll, work, effects);
        let backoff = Backoff::new();
        while self.is_working(progress) {
            let (waits, after) = self.flush(work, effects, progress);
            let (taken, after) = self.take_results(work, effects, after);
            progress = after;
            let now = clock::now_ns();
            if now - self.looked_ns > NAP_NS {
                self.looked_ns = now;
                // While results keep coming the loop never sleeps, and an end would go unnoticed.
                self.sleep(0)?;
                progress = self.look_after(now, work, effects, progress)?;
            }
            let due_ns = self.dispatcher.due_ns();
            if due_ns.is_some_and(|due_ns| due_ns <= now) {
                progress = self.step(Event::Poll, work, effects);
            }
            while let Some(worker) = self.ended.pop() {
                progress = self.reap(worker, work, effects)?;
            }
            if !self.is_working(progress) {
                break;
            }
            if work.is_over(now) {
                self.cancel();
                break;
            }
            if taken {
                backoff.reset();
            } else if work.use_spare_time() {
                backoff.reset();
                // There may be further jobs now.
                progress = self.step(Event::Poll, work, effects);
            } else if self.shares_core() || backoff.is_completed() {
                let due_ns = [due_ns, work.deadline_ns()].into_iter().flatten().min();
                let nap_ns = if waits { BACKLOG_NAP_NS } else { NAP_NS };
                let due_ns = due_ns.map_or(nap_ns, |due_ns| due_ns.saturating_sub(now));
                self.sleep(due_ns.min(nap_ns))?;
            } else {
                backoff.snooze();
            }
        }
        self.duty.run_ns = clock::now_ns() - begun_ns;
        let counts = self.dispatcher.counts();
        if let Some(thrash) = self.dispatcher.thrash() {
            return Err(WorkerPoolError::Thrashed(thrash));
        }
        if progress == Progress::Stranded && work.deadline_ns().is_none() {
            return Err(self.nobody_left(&counts));
        }
        Ok(())
    }

    /// Begins a request: counts start from zero, and every ready worker may have jobs.
    fn begin(&mut self) {
        self.request += 1;
        self.rejected = 0;
        self.duty = Duty::default();
        self.dispatcher.begin(RequestId(self.request));
        for (outgoing, worker) in self.outgoing.iter_mut().flatten().zip(&mut self.workers) {
            outgoing.clear(worker);
        }
        for worker in &mut self.workers {
            worker.restore(&self.status, self.cancelled);
            worker.begin(&self.status);
        }
        for worker in self.workers.iter().filter(|worker| worker.is_ready()) {
            self.dispatcher.admit(worker.who);
        }
    }

    fn nobody_left(&self, counts: &Counts) -> WorkerPoolError {
        let lost = self.workers.iter().filter_map(|worker| {
            let how = worker.report.lost.as_deref()?;
            Some(format!("worker {} by {how}", worker.who.worker))
        });
        WorkerPoolError::NobodyLeft {
            open: counts.jobs - counts.done - counts.cut - counts.abandoned - counts.late,
            jobs: counts.jobs,
            lost: lost.collect::<Vec<_>>().join(", "),
        }
    }

    /// Whether there is something to wait for: jobs, or a worker that is about to greet.
    fn is_working(&self, progress: Progress) -> bool {
        match progress {
            Progress::Working => true,
            Progress::Stranded => self.workers.iter().any(WorkerHandle::is_starting),
            Progress::Finished | Progress::Thrashed => false,
        }
    }

    /// Which worker got which job in the last request, if logged.
    #[must_use]
    pub fn log(&self) -> &[LogEntry] {
        self.dispatcher.log()
    }

    /// The report of the last request.
    #[must_use]
    pub fn report(&self) -> WorkerPoolReport {
        WorkerPoolReport {
            duty: self.duty,
            counts: self.dispatcher.counts(),
            transfer: self.dispatcher.transfer(),
            rejected: self.rejected,
            workers: self.workers.iter().map(|worker| worker.report(&self.status)).collect(),
        }
    }

    /// Handles one event and everything that follows from it.
    fn step<W: TaskSource>(
        &mut self,
        event: Event<PartOf<'_>>,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        let begun_ns = clock::now_ns();
        let mut progress = self.dispatcher.step(begun_ns, event, work, effects);
        let mut stepped_ns = clock::now_ns();
        self.duty.step_ns += stepped_ns - begun_ns;
        // In order: a batch may need sections that went with the one before it. A worker whose
        // queue refused a batch gets none that were made before the refusal was known.
        let mut refused = 0_u32;
        while !effects.is_empty() {
            let (to, batch, jobs, fetch) = match effects.remove(0) {
                Effect::Send { to, batch, jobs, fetch } => (to, batch, jobs, fetch),
                Effect::Kill { who, why } => {
                    let worker = &mut self.workers[usize::from(who.worker)];
                    if worker.who == who && worker.is_alive() {
                        worker.kill(&why.to_string());
                        self.observe(who, Observation::Distrusted(why));
                    }
                    continue;
                }
            };
            let sent = match refused >> to.worker & 1 == 1 {
                true => Err(UseError::Full),
                false => self.send(to, batch, &jobs, &fetch, work),
            };
            self.dispatcher.reuse(jobs, fetch);
            let sent_ns = clock::now_ns();
            self.duty.send_ns += sent_ns - stepped_ns;
            stepped_ns = sent_ns;
            let event = match sent {
                Ok(()) => continue,
                Err(UseError::Full) => {
                    self.observe(to, Observation::Full);
                    refused |= 1 << to.worker;
                    Event::Unsent { to, batch }
                }
                // The channel is broken, or its worker was reaped since.
                Err(error) => {
                    let (who, started) = self.give_up(usize::from(to.worker), error);
                    Event::Lost { who, started }
                }
            };
            progress = self.dispatcher.step(clock::now_ns(), event, work, effects);
        }
        progress
    }

    /// Sleeps until a worker rings or ends, at most `timeout_ns`.
    fn sleep(&mut self, timeout_ns: u64) -> Result<(), WorkerPoolError> {
        let flag = |value| {
            for line in &self.status.page().coordinator {
                line.sleeping.store(value, Ordering::SeqCst);
            }
        };
        flag(1);
        // A result sent before the flag was set woke no one.
        let waiting = self.workers.iter().any(|worker| worker.has_mail(&self.status));
        let wakes = self.poller.wait(Some(if waiting { 0 } else { timeout_ns }));
        flag(0);
        if let Some(idle_hook) = &self.idle_hook {
            idle_hook.call();
        }
        for wake in wakes? {
            match wake {
                Wake::Process(worker) => {
                    self.ended.push(worker as usize);
                    self.observe(self.workers[worker as usize].who, Observation::Ended);
                }
                Wake::Signal(_) => return Err(WorkerPoolError::Interrupted),
                Wake::Event(_) | Wake::Ready(_) | Wake::Timer => {}
            }
        }
        Ok(())
    }
}

impl Drop for WorkerPool {
    fn drop(&mut self) {
        for worker in &self.workers {
            worker.tell_to_stop(&self.status);
        }
        let end = clock::now_ns() + FAREWELL_MS * 1_000_000;
        for worker in &mut self.workers {
            worker.terminate(end.saturating_sub(clock::now_ns()) / 1_000_000);
        }
        self.workers.clear();
    }
}
