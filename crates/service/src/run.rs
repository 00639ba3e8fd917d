//! The service's life: open, tell systemd, answer one request after the other, end on a signal.

use crate::ask::Refusal;
use crate::backend::ServiceBackend;
use crate::deployment::{Deployment, Idle};
use crate::housekeeping::Housekeeping;
use crate::ranker::{Ranker, Unranked};
use crate::request_queue::{RequestQueue, Taken};
use crate::stats::{Stats, Times};
use body::{BodyView, Meta};
use coordinator::{IdleHook, Options, RequestLimits, SearchOrder, WorkerPoolError};
use core::cell::RefCell;
use core::time::Duration;
use damage::{Curves, Policy};
use diagnostic::{Diagnostic, FailureKind, chain};
use protocol::public::{Ask, Condition, LatencyStage, Reason, WireAnswer, WireState};
use runtime::{SealedMemory, clock, heap, realtime};
use std::borrow::Cow;
use std::rc::Rc;
use std::sync::Arc;
use transport::{Address, OpenError, Server};

/// How long it sleeps at most (ns): a client that cannot ring is heard then.
const NAP_NS: u64 = 10_000_000;
/// How often it says how it is (ns).
const HEALTH_NS: u64 = 1_000_000_000;
/// How long to wait before a successor is tried again where none could be started (ns).
const RETRY_NS: u64 = 1_000_000_000;
/// So many times what requests usually take is plenty.
const PLENTY: u64 = 4;
/// How often pulses are felt between requests (ns).
const MEND_NS: u64 = 20_000_000;
/// With `spin`: how often a sleeper's duties are looked after (ns).
const LOOK_NS: u64 = 1_000_000;

/// All that a service needs, made and checked by whoever starts it.
#[derive(Debug)]
pub struct ServiceConfig<'s> {
    /// Settings.
    pub deployment: &'s Deployment,
    /// The policy.
    pub policy: &'s Policy,
    /// The curves.
    pub curves: &'s Curves,
    /// The bodies in the store, in the order of the deployment's models.
    pub bodies: &'s [(Meta, BodyView<'s>)],
    /// The store.
    pub store: &'s SealedMemory,
    /// How workers are started; `None`: all work is done in this process.
    pub options: Option<&'s Options>,
    /// Distribution depth.
    pub depth: u32,
}

/// Something that real time needs and that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingRealtime {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// The service could not start or go on.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// Its channels cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Its workers cannot be started.
    #[error(transparent)]
    WorkerPool(#[from] WorkerPoolError),
    /// The operating system refused.
    #[error(transparent)]
    System(#[from] runtime::OsError),
    /// Files cannot be written.
    #[error("cannot keep decisions in {folder}: {source}")]
    Files {
        /// Where.
        folder: String,
        /// Why.
        source: std::io::Error,
    },
    /// Real time was required, and is not to be had.
    #[error("no real time: {}", .0.iter().map(|missing| format!("{} ({})", missing.what, missing.why))
        .collect::<Vec<_>>().join("; "))]
    NoRealtime(Vec<MissingRealtime>),
    /// There is no memory for counting.
    #[error("no memory is left for histograms")]
    Memory,
}

impl Diagnostic for ServiceError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Open(error) => error.kind(),
            Self::WorkerPool(error) => error.kind(),
            Self::System(error) => error.kind(),
            Self::Files { .. } => FailureKind::System,
            Self::NoRealtime(_) => FailureKind::NoRealtime,
            Self::Memory => FailureKind::Resources,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Open(error) => error.remedy(),
            Self::WorkerPool(error) => error.remedy(),
            Self::System(error) => error.remedy(),
            Self::Files { .. } => Some("`decisions` needs a folder that may be written to".into()),
            Self::NoRealtime(_) => Some(
                "raise LimitRTPRIO and LimitMEMLOCK (see tools/systemd), or start without \
                 --require-rt"
                    .into(),
            ),
            Self::Memory => None,
        }
    }
}

/// Serves until SIGTERM or SIGINT. `ready` is called once, when the first request can be answered,
/// with what real time missing list.
///
/// # Errors
///
/// If it cannot start, or the operating system refuses to go on.
pub fn serve(
    config: &ServiceConfig<'_>,
    ready: impl FnOnce(&[MissingRealtime]),
) -> Result<(), ServiceError> {
    let deployment = config.deployment;
    let address = Address::new(&deployment.folder, &deployment.instance)?;
    let server = Server::open(&address)?;
    let housekeeper = server.housekeeper();
    let stats = Stats::new().ok_or(ServiceError::Memory)?;
    let queue = Rc::new(RefCell::new(RequestQueue::new(server, stats, deployment.queue)));
    let watchdog = Rc::new(Watchdog::new());
    let idle_hook = {
        let (queue, watchdog) = (queue.clone(), watchdog.clone());
        IdleHook::new(move || {
            watchdog.kick();
            // Borrowed only while it is answered from: never at the same time as here.
            if let Ok(mut queue) = queue.try_borrow_mut() {
                // A wake fd that goes on ringing would let the coordinator sleep no more.
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
    let house = Housekeeping::start(deployment, housekeeper).map_err(|source| {
        let folder = deployment.decisions.as_ref().map(|kept| kept.folder.display().to_string());
        ServiceError::Files { folder: folder.unwrap_or_default(), source }
    })?;
    let mut service = Service {
        config,
        ranker: Ranker::new(
            config.deployment,
            config.bodies,
            (Arc::new(config.policy.clone()), Arc::new(config.curves.clone())),
            config.depth,
        ),
        queue,
        backend,
        house,
        watchdog,
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
    ready(&service.missing);
    notify(&[sd_notify::NotifyState::Ready]);
    let done = service.turn_until_told();
    notify(&[sd_notify::NotifyState::Stopping]);
    service.part();
    done
}

fn notify(states: &[sd_notify::NotifyState<'_>]) {
    // Without systemd there is nobody to tell.
    if let Err(error) = sd_notify::notify(states) {
        tracing::debug!(%error, "systemd cannot be told");
    }
}

/// Systemd's watchdog, if it watches.
struct Watchdog {
    every_ns: Option<u64>,
    kicked_ns: core::cell::Cell<u64>,
}

impl Watchdog {
    fn new() -> Self {
        let length = sd_notify::watchdog_enabled();
        // A third of the time: two kicks may be late.
        let every_ns = length.map(|length| length.as_nanos() as u64 / 3);
        Self { every_ns, kicked_ns: core::cell::Cell::new(0) }
    }

    fn kick(&self) {
        let Some(every_ns) = self.every_ns else { return };
        let now_ns = clock::now_ns();
        if now_ns - self.kicked_ns.get() >= every_ns {
            self.kicked_ns.set(now_ns);
            notify(&[sd_notify::NotifyState::Watchdog]);
        }
    }
}

/// The limits of a request that is due then (ns; 0: whenever all is done), where requests of late
/// took so long (ns; 0: it is not known).
fn limits(answer_by_ns: u64, usual_ns: u64) -> RequestLimits {
    if answer_by_ns == 0 {
        return RequestLimits::default();
    }
    let left_ns = answer_by_ns.saturating_sub(clock::now_ns());
    let mut limits = RequestLimits::due_in(Duration::from_nanos(left_ns));
    if usual_ns > 0 && left_ns / PLENTY > usual_ns {
        // All will be done in time, and soonest if nobody looks for who is certain first.
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
    watchdog: Rc<Watchdog>,
    missing: Vec<MissingRealtime>,
    request: u64,
    told_ns: u64,
    /// What requests of late have taken at most until all was done (ns); 0: none was yet.
    usual_ns: u64,
    /// When it was looked who is missing (ns).
    mended_ns: u64,
    /// Somebody is missing who cannot be replaced now.
    is_short: bool,
    is_stopping: bool,
}

impl Service<'_> {
    /// Asks for all that real time needs, and notes what was refused.
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

    /// Until a signal comes.
    fn turn_until_told(&mut self) -> Result<(), ServiceError> {
        let mut looked_ns = 0;
        while !self.is_stopping {
            let taken = {
                let mut queue = self.queue.borrow_mut();
                // First the rings, then the requests: one that comes in between rings again.
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
            self.watchdog.kick();
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

    /// Gives successors to workers that were lost, and looks whether one stands still at what an
    /// earlier request left it.
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
            tracing::warn!(worker = who.worker, pid, "a worker was lost, and has a successor");
            if priority > 0 && self.missing.is_empty() && pid > 0 {
                // One that has ended already needs none.
                let _refused = realtime::fifo(pid, priority);
            }
        }
        if let Err(error) = realtime::unshare_after_fork() {
            tracing::debug!(%error, "the next request will have page faults");
        }
        self.tell(self.condition());
        Ok(())
    }

    /// Works one request off, and answers it.
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
        self.house.keep(&ask, &answer);
    }

    fn work_off(
        &mut self,
        ask: &Ask,
        begun_ns: u64,
        times: &mut Times,
    ) -> Result<WireAnswer, Refusal> {
        let refuse = |reason: Reason, text: String| Refusal { reason, text };
        if ask.answer_by_ns != 0 && ask.answer_by_ns <= begun_ns {
            let text = "the time was up before its turn came".to_owned();
            return Err(refuse(Reason::TooLate, text));
        }
        let checked = self.ranker.check(ask)?;
        self.request += 1;
        let usual_ns = self.usual_ns;
        let limits = || limits(ask.answer_by_ns, usual_ns);
        let ranked = self.ranker.rank(ask.sequence, checked, limits, &mut self.backend.backend);
        let ranked = ranked.map_err(|error| match error {
            Unranked::Refused(refusal) => refusal,
            Unranked::WorkerPool(WorkerPoolError::Interrupted) => {
                self.is_stopping = true;
                refuse(Reason::Stopping, "the service is stopping".to_owned())
            }
            Unranked::WorkerPool(error) => {
                tracing::error!(%error, "a request could not be worked off");
                match error {
                    WorkerPoolError::NobodyLeft { .. } => {
                        refuse(Reason::NoWorkers, "all workers were lost".to_owned())
                    }
                    error => refuse(Reason::Internal, chain(&error)),
                }
            }
        })?;
        self.queue.borrow_mut().stats.shared(self.backend.shares());
        times.set(LatencyStage::Plan, ranked.planned_ns - begun_ns);
        times.set(LatencyStage::Work, ranked.worked_ns - ranked.planned_ns);
        times.set(LatencyStage::Assess, ranked.done_ns - ranked.worked_ns);
        if ranked.answer.verdict() == WireState::Complete {
            let lasted_ns = ranked.done_ns - begun_ns;
            self.usual_ns = (self.usual_ns - self.usual_ns / 32).max(lasted_ns);
        }
        Ok(ranked.answer)
    }

    /// Says how it is to whoever listens.
    fn tell(&mut self, condition: Condition) {
        let queue = self.queue.borrow();
        let mut health = queue.stats.health();
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

    /// Nobody waits for an answer that will not come.
    fn part(&mut self) {
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
