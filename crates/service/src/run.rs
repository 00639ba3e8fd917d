//! The main loop: open, notify the manager, answer one request after the other, end on a signal.

mod error;

pub use error::{MissingRealtime, ServiceError};

use crate::ask::Refusal;
use crate::backend::ServiceBackend;
use crate::decisions::DecisionSigner;
use crate::deployment::{Deployment, Idle};
use crate::housekeeping::Housekeeping;
use crate::manager::Manager;
use crate::ranker::{Ranker, Unranked};
use crate::request_queue::{RequestQueue, Taken};
use crate::stats::{Stats, Times};
use body::{BodyView, Meta};
use coordinator::{IdleHook, Options, RequestLimits, SearchOrder, WorkerPoolError};
use core::cell::RefCell;
use core::time::Duration;
use damage::Criteria;
use diagnostic::chain;
use protocol::public::{Ask, Condition, LatencyStage, Reason, WireAnswer, WireState};
use runtime::{SealedMemory, clock, heap, process, realtime};
use std::rc::Rc;
use transport::{Address, Server};

/// Longest sleep (ns), after which a client that cannot ring is noticed.
const NAP_NS: u64 = 10_000_000;
/// Interval between health messages (ns).
const HEALTH_NS: u64 = 1_000_000_000;
/// Delay before another attempt to replace a worker, after one failed (ns).
const RETRY_NS: u64 = 1_000_000_000;
/// Time, as a multiple of that of recent requests, in which a request surely completes.
const PLENTY: u64 = 4;
/// Interval between checks of the workers' heartbeats between requests (ns).
const MEND_NS: u64 = 20_000_000;
/// With `spin`: interval between the checks that a sleeping service makes on waking (ns).
const LOOK_NS: u64 = 1_000_000;

/// Everything that a service needs, made and checked by its caller.
#[derive(Debug)]
pub struct ServiceConfig<'s> {
    /// Settings.
    pub deployment: &'s Deployment,
    /// The number of the group whose members may be clients, too; `None`: of no group.
    pub group: Option<u32>,
    /// What requests are judged by.
    pub criteria: &'s Criteria,
    /// The bodies in the store, in the order of the deployment's models.
    pub bodies: &'s [(Meta, BodyView<'s>)],
    /// The store.
    pub store: &'s SealedMemory,
    /// How to start workers; `None`: all work is done in this process.
    pub options: Option<&'s Options>,
    /// Distribution depth.
    pub depth: u32,
    /// Who signs the decisions that are kept; `None`: nobody.
    pub signer: Option<DecisionSigner>,
}

/// Serves until a signal ends it. `ready` is called once, when the first request can be answered,
/// with the real-time settings that were refused.
///
/// # Errors
///
/// If the service cannot start, or the operating system reports an error.
pub fn serve(
    config: &ServiceConfig<'_>,
    ready: impl FnOnce(&[MissingRealtime]),
) -> Result<(), ServiceError> {
    let deployment = config.deployment;
    let address = Address::new(deployment.folder.as_deref(), &deployment.instance)?;
    let address = address.with_group(config.group);
    let server = Server::open(&address)?;
    let housekeeper = server.housekeeper();
    let stats = Stats::new().ok_or(ServiceError::Memory)?;
    let queue = Rc::new(RefCell::new(RequestQueue::new(server, stats, deployment.queue)));
    let manager = Rc::new(Manager::from_environment());
    let idle_hook = {
        let (queue, manager) = (queue.clone(), manager.clone());
        IdleHook::new(move || {
            manager.ping();
            // Borrowed only while a request is answered: never at the same time as here.
            if let Ok(mut queue) = queue.try_borrow_mut() {
                // A wake fd that stays readable would keep the coordinator awake.
                queue.server.drain();
                queue.drain();
            }
        })
    };
    let wake_fd = queue.borrow().server.wake_fd().try_clone_to_owned();
    let wake_fd = wake_fd.map_err(|source| runtime::OsError::new("copy", "bell", source))?;
    use std::os::fd::AsFd as _;
    let backend = ServiceBackend::start(
        (config.store, config.bodies),
        config.options,
        wake_fd.as_fd(),
        idle_hook,
    )?;
    // From here on signals are caught: the thread inherits that.
    let program = config
        .options
        .map_or_else(|| process::self_exe().to_owned(), |options| options.program.clone());
    let house = Housekeeping::start(deployment, config.signer.as_ref(), housekeeper, program)?;
    let mut service = Service {
        config,
        ranker: Ranker::new(
            config.deployment,
            config.bodies,
            config.criteria.clone(),
            config.depth,
        ),
        queue,
        backend,
        house,
        manager,
        missing: Vec::new(),
        request: 0,
        told_ns: 0,
        usual_ns: 0,
        mended_ns: 0,
        is_short: false,
        is_stopping: false,
    };
    service.apply_realtime();
    if deployment.realtime.require && !service.missing.is_empty() {
        return Err(ServiceError::NoRealtime(service.missing));
    }
    let pids = service.backend.pids();
    service.queue.borrow_mut().stats.replaced(&pids, true);
    service.tell(Condition::Ready);
    // Whoever reads that it serves may rely on its being watched.
    service.manager.ready();
    ready(&service.missing);
    let done = service.turn_until_told();
    service.manager.stopping();
    service.refuse_waiting();
    done
}

/// The limits of a request with this deadline (ns; 0: none), given the time that recent requests
/// took (ns; 0: unknown).
fn limits(answer_by_ns: u64, usual_ns: u64) -> RequestLimits {
    if answer_by_ns == 0 {
        return RequestLimits::default();
    }
    let left_ns = answer_by_ns.saturating_sub(clock::now_ns());
    let mut limits = RequestLimits::due_in(Duration::from_nanos(left_ns));
    if usual_ns > 0 && left_ns / PLENTY > usual_ns {
        // All work will be done in time, and soonest without looking for an early winner.
        limits.search_order = SearchOrder::AsAsked;
    }
    limits
}

struct Service<'s> {
    config: &'s ServiceConfig<'s>,
    ranker: Ranker<'s>,
    // Dropped in this order: the workers, the files, then the port.
    backend: ServiceBackend<'s>,
    house: Housekeeping,
    queue: Rc<RefCell<RequestQueue>>,
    manager: Rc<Manager>,
    missing: Vec<MissingRealtime>,
    request: u64,
    told_ns: u64,
    /// The longest time of recent requests to completion (ns); 0: none yet.
    usual_ns: u64,
    /// When lost workers were last looked for (ns).
    mended_ns: u64,
    /// A worker is missing and cannot be replaced now.
    is_short: bool,
    is_stopping: bool,
}

impl Service<'_> {
    /// Requests all real-time settings, and notes those refused.
    fn apply_realtime(&mut self) {
        let settings = &self.config.deployment.realtime;
        let mut missing = Vec::new();
        let mut note = |what: &str, done: Result<(), runtime::OsError>| {
            if let Err(error) = done {
                let cause = std::error::Error::source(&error).map(ToString::to_string);
                let why = cause.unwrap_or_else(|| error.to_string());
                missing.push(MissingRealtime { what: what.to_owned(), why });
            }
        };
        realtime::prefault(settings.heap_mib << 20);
        if settings.lock_memory {
            note("memory is not locked", realtime::lock_memory());
        }
        realtime::sharpen_timers();
        for pid in self.backend.pids() {
            if settings.worker_priority > 0 {
                note(
                    "a worker has no fixed priority",
                    realtime::fifo(pid, settings.worker_priority),
                );
            }
        }
        if settings.priority > 0 {
            note("the coordinator has no fixed priority", realtime::fifo(0, settings.priority));
        }
        missing.dedup();
        self.missing = missing;
    }

    /// Serves until a signal arrives.
    fn turn_until_told(&mut self) -> Result<(), ServiceError> {
        let mut looked_ns = 0;
        while !self.is_stopping {
            let taken = {
                let mut queue = self.queue.borrow_mut();
                // First the rings, then the requests: one that arrives in between rings again.
                if self.config.deployment.idle == Idle::Park {
                    queue.server.drain();
                }
                queue.drain();
                queue.next()
            };
            if let Some(taken) = taken {
                self.answer(taken);
                looked_ns = 0;
            }
            let now_ns = clock::now_ns();
            let is_quiet = self.queue.borrow().waiting() == 0;
            let sleep_ns = match self.config.deployment.idle {
                Idle::Park if looked_ns != 0 && is_quiet => NAP_NS,
                _ => 0,
            };
            if sleep_ns == 0 && now_ns - looked_ns < LOOK_NS {
                core::hint::spin_loop();
                continue;
            }
            looked_ns = now_ns;
            self.manager.ping();
            if self.backend.idle(sleep_ns)?.is_some() {
                self.is_stopping = true;
            } else {
                self.mend()?;
            }
            if clock::now_ns() - self.told_ns >= HEALTH_NS {
                self.tell(self.condition());
            }
            if self.config.deployment.idle == Idle::Spin {
                self.queue.borrow().server.drain();
            }
        }
        Ok(())
    }

    fn condition(&self) -> Condition {
        if self.backend.missing() > 0 { Condition::Short } else { Condition::Ready }
    }

    /// Replaces lost workers, and checks whether one is stuck at jobs of an earlier request.
    fn mend(&mut self) -> Result<(), ServiceError> {
        let now_ns = clock::now_ns();
        let missing = self.backend.missing();
        let pause_ns = if self.is_short { RETRY_NS } else { MEND_NS };
        if now_ns - self.mended_ns < pause_ns && (missing == 0 || self.is_short) {
            return Ok(());
        }
        self.mended_ns = now_ns;
        let mended = match self.backend.mend() {
            Ok(mended) => mended,
            Err(WorkerPoolError::Interrupted) => {
                self.is_stopping = true;
                return Ok(());
            }
            Err(error) => {
                tracing::error!(%error, "no worker can be started; trying again in a second");
                self.is_short = true;
                return Ok(());
            }
        };
        self.is_short = !mended.off.is_empty();
        if mended.started.is_empty() {
            return Ok(());
        }
        let pids = self.backend.pids();
        let mut queue = self.queue.borrow_mut();
        queue.stats.lost += mended.started.len() as u64;
        queue.stats.replaced(&pids, false);
        drop(queue);
        let priority = self.config.deployment.realtime.worker_priority;
        for who in mended.started {
            let pid = pids.get(usize::from(who.worker)).copied().unwrap_or_default();
            tracing::warn!(worker = who.worker, pid, "a worker was lost and is replaced");
            if priority > 0 && self.missing.is_empty() && pid > 0 {
                // One that has already ended needs none.
                let _refused = realtime::fifo(pid, priority);
            }
        }
        if let Err(error) = realtime::unshare_after_fork() {
            tracing::debug!(%error, "the next request will have page faults");
        }
        self.tell(self.condition());
        Ok(())
    }

    /// Executes one request, and answers it.
    fn answer(&mut self, taken: Taken) {
        let Taken { ask, taken_ns } = taken;
        let (faults, allocations) = (realtime::page_faults(), heap::allocations());
        let begun_ns = clock::now_ns();
        let mut times = Times::default();
        times.set(LatencyStage::Queue, begun_ns - taken_ns);
        let mut answer = match self.work_off(&ask, begun_ns, &mut times) {
            Ok(answer) => answer,
            Err(Refusal { reason, text }) => {
                WireAnswer::without_ranking(ask.sequence, WireState::Refused, reason, &text)
            }
        };
        answer.request = self.request;
        answer.queued_ns = begun_ns - taken_ns;
        answer.worked_ns = clock::now_ns() - begun_ns;
        let answer = answer.sealed();
        let mut queue = self.queue.borrow_mut();
        queue.answer(&answer);
        times.set(LatencyStage::Total, clock::now_ns() - taken_ns);
        let faulted = realtime::page_faults();
        let faults = (faulted.0 - faults.0) + (faulted.1 - faults.1);
        let allocations = heap::allocations() - allocations;
        if answer.verdict().has_ranking() {
            queue.stats.worked(times, faults, allocations);
        }
        // The client has its answer: whoever listens may wait.
        queue.server.publish_ranking(&answer);
        self.house.record(&ask, &answer);
    }

    fn work_off(
        &mut self,
        ask: &Ask,
        begun_ns: u64,
        times: &mut Times,
    ) -> Result<WireAnswer, Refusal> {
        let refuse = |reason: Reason, text: String| Refusal { reason, text };
        if ask.answer_by_ns != 0 && ask.answer_by_ns <= begun_ns {
            let text = "the deadline passed before its turn".to_owned();
            return Err(refuse(Reason::TooLate, text));
        }
        if !ask.is_intact() {
            let text = "the request was changed on its way: its checksum does not match";
            return Err(refuse(Reason::Corrupt, text.to_owned()));
        }
        let checked = self.ranker.check(ask)?;
        self.request += 1;
        let limits = limits(ask.answer_by_ns, self.usual_ns);
        let ranked = self.ranker.rank(ask.sequence, &checked, limits, &mut self.backend.backend);
        let ranked = ranked.map_err(|error| match error {
            Unranked::Refused(refusal) => refusal,
            Unranked::WorkerPool(WorkerPoolError::Interrupted) => {
                self.is_stopping = true;
                refuse(Reason::Stopping, "the service is stopping".to_owned())
            }
            Unranked::WorkerPool(error) => {
                tracing::error!(%error, "a request could not be executed");
                match error {
                    WorkerPoolError::NobodyLeft { .. } => {
                        refuse(Reason::NoWorkers, "all workers were lost".to_owned())
                    }
                    error => refuse(Reason::Internal, chain(&error)),
                }
            }
        })?;
        self.queue.borrow_mut().stats.shared(&ranked.reports);
        times.set(LatencyStage::Plan, ranked.search_ns);
        times.set(LatencyStage::Work, ranked.surveys_ns);
        times.set(LatencyStage::Assess, ranked.judge_ns);
        if ranked.answer.verdict() == WireState::Complete {
            self.usual_ns = (self.usual_ns - self.usual_ns / 32).max(ranked.lasted_ns);
        }
        Ok(ranked.answer)
    }

    /// Publishes the health of the service.
    fn tell(&mut self, condition: Condition) {
        let queue = self.queue.borrow();
        let mut health = queue.stats.health();
        health.model_set = self.ranker.model_set();
        health.condition = condition as u32;
        health.workers = self.backend.size() as u32;
        health.alive = (self.backend.size() - self.backend.missing()) as u32;
        health.waiting = queue.waiting() as u32;
        health.queue = self.config.deployment.queue as u32;
        health.clients = queue.server.clients() as u32;
        queue.server.publish_health(&health);
        self.house.tell(&health);
        self.told_ns = health.at_ns;
    }

    /// Refuses all waiting requests, so that no client waits in vain.
    fn refuse_waiting(&mut self) {
        let mut queue = self.queue.borrow_mut();
        queue.drain();
        while let Some(Taken { ask, .. }) = queue.next() {
            let text = "the service is stopping";
            let answer = WireAnswer::without_ranking(
                ask.sequence,
                WireState::Refused,
                Reason::Stopping,
                text,
            );
            queue.answer(&answer);
        }
        drop(queue);
        self.tell(Condition::Stopping);
    }
}
