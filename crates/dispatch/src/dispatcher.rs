//! The job table of one request, and its leases.
//!
//! ```text
//!           assign (eligible core)             last part, in order, lease fits
//! PENDING --------------------------> LEASED ---------------------------------> DONE
//!  ^  ^   core lost, not started;          |
//!  |  |   not handed over; not answered    |
//!  |  +------------------------------------+  started, then lost; or failed: blame += 1
//!  +---- blame < 2: alone on its core -----+---- else ----> ABANDONED
//! obsolete: PENDING -> CUT; time is up: PENDING, LEASED -> LATE
//! DONE, CUT, LATE, ABANDONED are final
//! ```
//!
//! The fence: a part is accepted only if it belongs to this request, and its job is leased to
//! exactly that incarnation and attempt. Parts are folded as they arrive, which is safe because
//! folding is idempotent; a job whose parts did not all arrive in order is run again.
//!
//! No lease is permanent. A lease ends with its result, with its worker, with a batch that was not
//! handed over, or when the worker reports that it has answered the batch (`lease.rs`): results
//! that have not arrived by then never will. The number of losses per incarnation is bounded, and
//! so are the restarts of a core (`restart.rs`); so every request terminates.

mod counts;
mod event;
#[cfg(feature = "faults")]
mod flaw;
mod job;
mod lease;

pub use counts::{Counts, Fence};
pub use event::{Effect, Event, LogEntry, Progress, Why};
#[cfg(feature = "faults")]
pub use flaw::DispatcherFlaw;
pub use job::{Closed, Job, JobSource};

use crate::cache_model::{Cache, CacheModel, Thrash, Transfer};
use crate::quarantine::Quarantine;
use crate::scheme::{CoreView, MatchScheme};
use core::hash::Hash;
use lease::Core;
use protocol::{Incarnation, JobId, RequestId, Section};
use std::collections::VecDeque;

/// Sizes of queues and batches: the three settings that the paper calls "buffer".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Queues {
    /// Maximum number of jobs that a core may hold.
    pub capacity: u32,
    /// Number of jobs per batch; at most `capacity`.
    pub batch: u32,
    /// How long a batch that is not full waits for more jobs (ns); 0 sends it at once.
    pub linger_ns: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum State {
    Pending,
    Leased(Incarnation),
    Closed,
}

/// The outcome of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Taken {
    /// It was folded, or was not needed.
    Well,
    /// The result ended with a part missing.
    Broken,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Slot {
    spec: Job,
    state: State,
    attempt: u8,
    blame: u8,
    parts: u16,
    /// The batch in which it was sent: together with the incarnation, one lease.
    batch: u32,
}

/// Spare job lists, reused by later batches to avoid heap allocation.
#[derive(Clone, Debug, Default)]
struct BatchPool {
    outboxes: Vec<Vec<(JobId, u8)>>,
    fetches: Vec<Vec<Section>>,
    jobs: Vec<Vec<JobId>>,
}

/// The dispatcher of one instance: workers outlive a request, the job table does not.
#[derive(Clone, Debug)]
pub struct Dispatcher<S> {
    scheme: S,
    queues: Queues,
    cores: Vec<Core>,
    slots: Vec<Slot>,
    pending: VecDeque<JobId>,
    /// Jobs that killed a worker, or failed: each waits for a core of its own.
    suspects: VecDeque<JobId>,
    quarantine: Quarantine,
    request: RequestId,
    /// The time is up: no more jobs are requested.
    is_over: bool,
    open: u64,
    ledger: CacheModel,
    log: Option<Vec<LogEntry>>,
    counts: Counts,
    fresh: Vec<Job>,
    views: Vec<CoreView>,
    spare: BatchPool,
    #[cfg(feature = "faults")]
    flaw: Option<DispatcherFlaw>,
}

impl<S: MatchScheme> Dispatcher<S> {
    /// Creates a dispatcher for this many cores, none of them ready yet.
    #[must_use]
    pub fn new(scheme: S, queues: Queues, cache: Cache, cores: usize) -> Self {
        let capacity = queues.capacity.max(1);
        Self {
            scheme,
            queues: Queues { capacity, batch: queues.batch.clamp(1, capacity), ..queues },
            cores: vec![Core::default(); cores],
            slots: Vec::new(),
            pending: VecDeque::new(),
            suspects: VecDeque::new(),
            quarantine: Quarantine::default(),
            request: RequestId(0),
            is_over: false,
            open: 0,
            ledger: CacheModel::new(cores, cache),
            log: None,
            counts: Counts::default(),
            fresh: Vec::new(),
            views: Vec::with_capacity(cores),
            spare: BatchPool::default(),
            #[cfg(feature = "faults")]
            flaw: None,
        }
    }

    /// Starts a request: an empty job table, all counts at zero. Cores stay ready, and jobs of an
    /// earlier request still in their queues continue to occupy slots there.
    pub fn begin(&mut self, request: RequestId) {
        self.request = request;
        self.is_over = false;
        self.retire();
        self.slots.clear();
        self.pending.clear();
        self.suspects.clear();
        self.open = 0;
        self.counts = Counts::default();
        self.ledger.begin();
        if let Some(log) = &mut self.log {
            log.clear();
        }
    }

    /// Takes back the lists of a processed [`Effect::Send`] for reuse. Keeping them has no effect
    /// other than heap allocations for later batches.
    pub fn reuse(&mut self, mut jobs: Vec<(JobId, u8)>, mut fetch: Vec<Section>) {
        jobs.clear();
        fetch.clear();
        self.spare.outboxes.push(jobs);
        self.spare.fetches.push(fetch);
    }

    /// Registers a worker as ready for jobs. None is placed before the next step, so that all
    /// workers present at the start get their share.
    pub fn admit(&mut self, who: Incarnation) {
        let core = self.cores.get_mut(usize::from(who.worker));
        // A worker that was ready before this request already has jobs.
        if let Some(core) = core.filter(|core| core.who != Some(who)) {
            *core = Core::of(who);
        }
    }

    /// Removes a worker that is gone while no open request can have jobs leased to it.
    pub fn dismiss(&mut self, who: Incarnation) {
        let core = self.cores.get_mut(usize::from(who.worker));
        if let Some(core) = core.filter(|core| core.who == Some(who)) {
            *core = Core::default();
        }
    }

    /// Enables the log of assignments, from which [`Dispatcher::transfer`] can be recomputed.
    pub fn keep_log(&mut self) {
        self.log.get_or_insert_default();
    }

    /// Exchanges the log for another one; `None`: there is none, and none is kept. So a request
    /// without sections leaves that of the last one with sections as it is.
    pub fn exchange_log(&mut self, log: Option<Vec<LogEntry>>) -> Option<Vec<LogEntry>> {
        core::mem::replace(&mut self.log, log)
    }

    /// The log since [`Dispatcher::begin`], in order.
    #[must_use]
    pub fn log(&self) -> &[LogEntry] {
        self.log.as_deref().unwrap_or_default()
    }

    /// When the next batch has lingered long enough, or a core whose queue was full may be retried
    /// (ns): [`Event::Poll`] is due then.
    #[must_use]
    pub fn due_ns(&self) -> Option<u64> {
        let waiting = self.cores.iter().filter(|core| !core.outbox.is_empty());
        let lingers = waiting.map(|core| core.since_ns.saturating_add(self.queues.linger_ns));
        let is_wanted = !self.pending.is_empty() || !self.suspects.is_empty();
        let shut = self.cores.iter().filter(|_| is_wanted).filter_map(Core::shut_until_ns);
        lingers.chain(shut).min()
    }

    /// The job's spec; `None` if there is no such job.
    #[must_use]
    pub fn spec(&self, job: JobId) -> Option<&Job> {
        self.slots.get(job.0 as usize).map(|slot| &slot.spec)
    }

    /// Whether a worker holds unanswered jobs.
    #[must_use]
    pub fn is_busy(&self, worker: u8) -> bool {
        self.cores.get(usize::from(worker)).is_some_and(|core| core.queued > 0)
    }

    /// The counts since [`Dispatcher::begin`].
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The state that determines future behaviour, for comparing and hashing. It excludes the
    /// ledger, the log and the counts, so it is valid only for schemes that use loads alone.
    pub fn essence(&self) -> impl Hash + PartialEq + '_ {
        let Self { slots, pending, suspects, quarantine, cores, request, is_over, .. } = self;
        (slots, pending, suspects, quarantine, cores, request, is_over)
    }

    /// The transfer ledger since [`Dispatcher::begin`].
    #[must_use]
    pub fn transfer(&self) -> Transfer {
        self.ledger.transfer()
    }

    /// The first section that did not fit, which ends the run.
    #[must_use]
    pub fn thrash(&self) -> Option<Thrash> {
        self.ledger.thrash()
    }

    /// Processes one event at `now_ns` [ns, monotonic], requests jobs from `work`, and returns the
    /// effects.
    pub fn step<W: JobSource>(
        &mut self,
        now_ns: u64,
        event: Event<W::Part<'_>>,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        match event {
            Event::Poll => {}
            Event::Ready(who) => self.admit(who),
            Event::Part { request, .. } | Event::Failed { request, .. }
                if request != self.request =>
            {
                self.counts.fence.stale += 1;
            }
            Event::Part { from, job, attempt, part, last, body, .. } => {
                if self.take(from, job, attempt, (part, last), body, work) == Taken::Broken {
                    self.distrust(from, Why::Forgetful, effects);
                }
            }
            Event::Failed { from, job, attempt, .. } => {
                if self.is_leased(from, job, attempt) {
                    self.unlease(job);
                    self.blame(now_ns, job, work);
                } else {
                    self.counts.fence.not_leased += 1;
                }
            }
            Event::Lost { who, started } => self.reap(now_ns, who, started, work),
            Event::Unsent { to, batch } => self.unsent(now_ns, to, batch, effects),
            Event::Answered { who, batches } => self.answered(who, batches, effects),
            Event::Garbled { from } => self.distrust(from, Why::Garbled, effects),
            Event::Expired => self.expire(work),
        }
        self.refill(now_ns, work);
        self.assign(now_ns, work, effects);
        self.progress()
    }

    fn progress(&self) -> Progress {
        if self.ledger.thrash().is_some() {
            Progress::Thrashed
        } else if self.open == 0 {
            Progress::Finished
        } else if self.cores.iter().all(|core| core.who.is_none()) {
            Progress::Stranded
        } else {
            Progress::Working
        }
    }

    fn is_leased(&self, from: Incarnation, job: JobId, attempt: u8) -> bool {
        let slot = self.slots.get(job.0 as usize);
        slot.is_some_and(|slot| slot.state == State::Leased(from) && slot.attempt == attempt)
    }

    /// Applies the fence, then folds the part.
    fn take<W: JobSource>(
        &mut self,
        from: Incarnation,
        job: JobId,
        attempt: u8,
        (part, last): (u16, bool),
        body: W::Part<'_>,
        work: &mut W,
    ) -> Taken {
        #[cfg(feature = "faults")]
        if self.take_unfenced(job, last, body, work) {
            return Taken::Well;
        }
        if !self.is_leased(from, job, attempt) {
            self.counts.fence.not_leased += 1;
            return Taken::Well;
        }
        let slot = &mut self.slots[job.0 as usize];
        if part < slot.parts {
            self.counts.fence.repeated += 1;
            return Taken::Well;
        }
        if part > slot.parts {
            self.counts.fence.gap += 1;
            if last {
                self.unlease(job);
                self.put_back(job);
                return Taken::Broken;
            }
            return Taken::Well;
        }
        slot.parts += 1;
        let spec = slot.spec;
        self.cores[usize::from(from.worker)].open();
        work.fold(&spec, body);
        if last {
            self.unlease(job);
            self.close(job, Closed::Done, work);
        }
        Taken::Well
    }

    fn close<W: JobSource>(&mut self, job: JobId, how: Closed, work: &mut W) {
        let slot = &mut self.slots[job.0 as usize];
        slot.state = State::Closed;
        let spec = slot.spec;
        self.open -= 1;
        match how {
            Closed::Done => self.counts.done += 1,
            Closed::Cut => self.counts.cut += 1,
            Closed::Abandoned => self.counts.abandoned += 1,
            Closed::Late => self.counts.late += 1,
        }
        work.close(&spec, how);
    }

    /// Keeps about as many jobs pending as all queues hold: descents are made on demand.
    fn refill<W: JobSource>(&mut self, now_ns: u64, work: &mut W) {
        let enough = self.queues.capacity as usize * self.cores.len();
        while self.pending.len() < enough && !self.is_over {
            work.more(&mut self.fresh);
            if self.fresh.is_empty() {
                return;
            }
            let mut fresh = std::mem::take(&mut self.fresh);
            for spec in fresh.drain(..) {
                let job = JobId(u32::try_from(self.slots.len()).unwrap_or(u32::MAX));
                let state = State::Pending;
                self.slots.push(Slot { spec, state, attempt: 0, blame: 0, parts: 0, batch: 0 });
                self.open += 1;
                self.counts.jobs += 1;
                if !self.quarantine.is_empty()
                    && work.key(&spec).is_some_and(|key| self.quarantine.holds(key, now_ns))
                {
                    self.close(job, Closed::Abandoned, work);
                } else {
                    self.pending.push_back(job);
                }
            }
            self.fresh = fresh;
        }
    }

    /// Places pending jobs until no core is eligible.
    fn assign<W: JobSource>(&mut self, now_ns: u64, work: &mut W, effects: &mut Vec<Effect>) {
        for core in &mut self.cores {
            core.look(now_ns);
        }
        let ward = self.place_suspects(now_ns, work, effects);
        while let Some(&job) = self.pending.front()
            && self.ledger.thrash().is_none()
        {
            let spec = self.slots[job.0 as usize].spec;
            if work.is_obsolete(&spec) {
                self.pending.pop_front();
                self.close(job, Closed::Cut, work);
                // Closing a job may have made more available.
                self.refill(now_ns, work);
                continue;
            }
            self.views.clear();
            for (number, core) in self.cores.iter().enumerate() {
                self.views.push(CoreView {
                    eligible: ward != Some(number) && core.takes(self.queues),
                    queued: core.queued,
                    has_a: self.ledger.holds(number, spec.a),
                    has_b: self.ledger.holds(number, spec.b),
                });
            }
            let Some(number) = self.scheme.choose(&self.views, self.queues.capacity) else { break };
            let Some(who) = self.cores[number].who else { break };
            self.pending.pop_front();
            self.lease(now_ns, job, who, work);
            if self.cores[number].outbox.len() >= self.queues.batch as usize {
                self.flush(number, effects);
            }
        }
        for number in 0..self.cores.len() {
            let since_ns = self.cores[number].since_ns;
            if since_ns.saturating_add(self.queues.linger_ns) <= now_ns {
                self.flush(number, effects);
            }
        }
    }
}

#[cfg(test)]
mod tests;
