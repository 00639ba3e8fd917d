//! The job table of one request, and who holds which lease.
//!
//! ```text
//!           assign (eligible core)             last part, in order, lease fits
//! PENDING --------------------------> LEASED ---------------------------------> DONE
//!  ^  ^   core lost, not started           |
//!  |  +------------------------------------+  started, then lost; or failed: blame += 1
//!  +---- blame < 2 ------------------------+---- else ----> ABANDONED
//! moot: PENDING -> CUT                     DONE, CUT, ABANDONED are final
//! ```
//!
//! The fence: a part is taken only if its job is leased to exactly that incarnation and attempt.
//! Parts are folded as they come, which is safe because folding is idempotent; a job whose parts
//! were not all seen in order is run again.

mod event;

pub use event::{Effect, Entry, Event, Progress};

use crate::ledger::{Cache, Ledger, Thrash, Transfer};
use crate::scheme::{CoreView, Scheme};
use protocol::{Incarnation, JobId, Section, TaskId};
use std::collections::VecDeque;

/// How often a job may fail or take its worker down before it is abandoned.
const BLAME_MAX: u8 = 2;

/// A job as the dispatcher knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spec {
    /// The task it belongs to.
    pub task: TaskId,
    /// Section of body A.
    pub a: Section,
    /// Section of body B.
    pub b: Section,
}

/// How a job ended for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// All its parts were folded.
    Done,
    /// It could not matter any longer, and was not run.
    Cut,
    /// It failed too often; what it would have found is unknown.
    Abandoned,
}

/// Where jobs come from and results go to.
pub trait Work {
    /// One part of a result.
    type Part<'p>: Copy;

    /// Hands over more jobs, if there are any by now.
    fn more(&mut self, jobs: &mut Vec<Spec>);
    /// Whether the rest of a task cannot matter any longer.
    fn is_moot(&self, task: TaskId) -> bool;
    /// Takes what one part found. May be called again with what a job found before.
    fn fold(&mut self, job: &Spec, part: Self::Part<'_>);
    /// Takes note that a job is closed: exactly once per job.
    fn close(&mut self, job: &Spec, how: Closed);
    /// Bytes of a section.
    fn weight(&self, section: Section) -> u64;
}

/// Why a part was not taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fence {
    /// The job is closed, or leased to somebody else, or in another attempt.
    pub not_leased: u64,
    /// A part came twice.
    pub repeated: u64,
    /// A part before it is missing.
    pub gap: u64,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Jobs there were.
    pub jobs: u64,
    /// Jobs done.
    pub done: u64,
    /// Jobs cut because they could not matter.
    pub cut: u64,
    /// Jobs abandoned.
    pub abandoned: u64,
    /// Leases that ended without a result.
    pub reissued: u64,
    /// Batches sent.
    pub batches: u64,
    /// Parts turned away.
    pub fence: Fence,
}

/// Sizes of queues and batches: the three settings that the seed calls "buffer".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Queues {
    /// Most jobs a core may hold.
    pub capacity: u32,
    /// Jobs sent at once; at most `capacity`.
    pub batch: u32,
    /// How long a batch that is not full waits for more jobs (ns); 0: it is sent at once.
    pub linger_ns: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Pending,
    Leased(Incarnation),
    Closed,
}

#[derive(Clone, Copy, Debug)]
struct Slot {
    spec: Spec,
    state: State,
    attempt: u8,
    blame: u8,
    parts: u16,
}

#[derive(Clone, Debug, Default)]
struct Core {
    who: Option<Incarnation>,
    queued: u32,
    outbox: Vec<(JobId, u8)>,
    /// Sections that jobs in the outbox need and the core did not hold.
    fetch: Vec<Section>,
    /// When the first job of the outbox was put there (ns).
    since_ns: u64,
}

/// The dispatcher of one instance: the workers outlive a request, the job table does not.
#[derive(Debug)]
pub struct Dispatcher<S> {
    scheme: S,
    queues: Queues,
    cache: Cache,
    cores: Vec<Core>,
    slots: Vec<Slot>,
    pending: VecDeque<JobId>,
    open: u64,
    ledger: Ledger,
    log: Option<Vec<Entry>>,
    counts: Counts,
    fresh: Vec<Spec>,
    views: Vec<CoreView>,
}

impl<S: Scheme> Dispatcher<S> {
    /// A dispatcher for so many cores, none of them ready yet.
    #[must_use]
    pub fn new(scheme: S, queues: Queues, cache: Cache, cores: usize) -> Self {
        let capacity = queues.capacity.max(1);
        Self {
            scheme,
            queues: Queues { capacity, batch: queues.batch.clamp(1, capacity), ..queues },
            cache,
            cores: vec![Core::default(); cores],
            slots: Vec::new(),
            pending: VecDeque::new(),
            open: 0,
            ledger: Ledger::new(cores, cache),
            log: None,
            counts: Counts::default(),
            fresh: Vec::new(),
            views: Vec::with_capacity(cores),
        }
    }

    /// Starts a request: an empty job table, all counts at zero. Cores stay ready.
    pub fn begin(&mut self) {
        self.slots.clear();
        self.pending.clear();
        self.open = 0;
        self.counts = Counts::default();
        self.ledger = Ledger::new(self.cores.len(), self.cache);
        if let Some(log) = &mut self.log {
            log.clear();
        }
        for core in &mut self.cores {
            core.queued = 0;
            core.outbox.clear();
            core.fetch.clear();
        }
    }

    /// A worker takes jobs from now on. None is placed before the next step, so that all who are
    /// there at the start get their share.
    pub fn admit(&mut self, who: Incarnation) {
        let core = self.cores.get_mut(usize::from(who.worker));
        // Who was ready before this request has jobs already.
        if let Some(core) = core.filter(|core| core.who != Some(who)) {
            *core = Core { who: Some(who), ..Core::default() };
        }
    }

    /// From now on writes down who got which job: what [`Dispatcher::transfer`] follows from.
    pub fn keep_log(&mut self) {
        self.log.get_or_insert_default();
    }

    /// What was written down since [`Dispatcher::begin`], in order.
    #[must_use]
    pub fn log(&self) -> &[Entry] {
        self.log.as_deref().unwrap_or_default()
    }

    /// When the next batch has lingered long enough (ns): [`Event::Poll`] sends it then.
    #[must_use]
    pub fn due_ns(&self) -> Option<u64> {
        let waiting = self.cores.iter().filter(|core| !core.outbox.is_empty());
        waiting.map(|core| core.since_ns.saturating_add(self.queues.linger_ns)).min()
    }

    /// The job's spec; `None` if there is no such job.
    #[must_use]
    pub fn spec(&self, job: JobId) -> Option<&Spec> {
        self.slots.get(job.0 as usize).map(|slot| &slot.spec)
    }

    /// Whether a worker holds jobs it has not answered.
    #[must_use]
    pub fn is_busy(&self, worker: u8) -> bool {
        self.cores.get(usize::from(worker)).is_some_and(|core| core.queued > 0)
    }

    /// What was counted since [`Dispatcher::begin`].
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The transfer ledger since [`Dispatcher::begin`].
    #[must_use]
    pub fn transfer(&self) -> Transfer {
        self.ledger.transfer()
    }

    /// The first section that did not fit: then the run is over.
    #[must_use]
    pub fn thrash(&self) -> Option<Thrash> {
        self.ledger.thrash()
    }

    /// Takes one event at `now_ns` [ns, monotonic], asks `work` for jobs, and says what to do.
    pub fn step<W: Work>(
        &mut self,
        now_ns: u64,
        event: Event<'_, W::Part<'_>>,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Progress {
        match event {
            Event::Poll => {}
            Event::Ready(who) => self.admit(who),
            Event::Part { from, job, attempt, part, last, body } => {
                self.take(from, job, attempt, (part, last), body, work);
            }
            Event::Failed { from, job, attempt } => {
                if self.is_leased(from, job, attempt) {
                    self.unlease(job);
                    self.blame(job, work);
                } else {
                    self.counts.fence.not_leased += 1;
                }
            }
            Event::Lost { who, started } => self.bury(who, started, work),
            Event::Unsent { to, jobs } => {
                for job in jobs.iter().rev() {
                    if self.slots.get(job.0 as usize).is_some_and(|s| s.state == State::Leased(to))
                    {
                        self.unlease(*job);
                        self.put_back(*job);
                    }
                }
            }
        }
        self.refill(work);
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

    /// The fence, and what lies behind it.
    fn take<W: Work>(
        &mut self,
        from: Incarnation,
        job: JobId,
        attempt: u8,
        (part, last): (u16, bool),
        body: W::Part<'_>,
        work: &mut W,
    ) {
        if !self.is_leased(from, job, attempt) {
            self.counts.fence.not_leased += 1;
            return;
        }
        let slot = &mut self.slots[job.0 as usize];
        if part < slot.parts {
            self.counts.fence.repeated += 1;
            return;
        }
        if part > slot.parts {
            self.counts.fence.gap += 1;
            if last {
                self.unlease(job);
                self.put_back(job);
            }
            return;
        }
        slot.parts += 1;
        let spec = slot.spec;
        work.fold(&spec, body);
        if last {
            self.unlease(job);
            self.close(job, Closed::Done, work);
        }
    }

    fn close<W: Work>(&mut self, job: JobId, how: Closed, work: &mut W) {
        let slot = &mut self.slots[job.0 as usize];
        slot.state = State::Closed;
        let spec = slot.spec;
        self.open -= 1;
        match how {
            Closed::Done => self.counts.done += 1,
            Closed::Cut => self.counts.cut += 1,
            Closed::Abandoned => self.counts.abandoned += 1,
        }
        work.close(&spec, how);
    }

    /// Ends a lease: the slot is the core's again.
    fn unlease(&mut self, job: JobId) {
        if let State::Leased(who) = self.slots[job.0 as usize].state {
            self.slots[job.0 as usize].state = State::Pending;
            let core = &mut self.cores[usize::from(who.worker)];
            core.queued = core.queued.saturating_sub(1);
        }
    }

    /// To the front: what was begun is finished first.
    fn put_back(&mut self, job: JobId) {
        self.slots[job.0 as usize].parts = 0;
        self.counts.reissued += 1;
        self.pending.push_front(job);
    }

    fn blame<W: Work>(&mut self, job: JobId, work: &mut W) {
        let slot = &mut self.slots[job.0 as usize];
        slot.blame += 1;
        slot.attempt += 1;
        if slot.blame < BLAME_MAX {
            self.put_back(job);
        } else {
            self.close(job, Closed::Abandoned, work);
        }
    }

    /// Only the started job is blamed; the others go back as if nothing had been.
    fn bury<W: Work>(&mut self, who: Incarnation, started: Option<(JobId, u8)>, work: &mut W) {
        let Some(core) = self.cores.get_mut(usize::from(who.worker)) else { return };
        if core.who != Some(who) {
            return;
        }
        *core = Core::default();
        self.ledger.lose(usize::from(who.worker));
        if let Some(log) = &mut self.log {
            log.push(Entry::Lost { who });
        }
        for number in (0..self.slots.len()).rev() {
            let job = JobId(u32::try_from(number).unwrap_or(u32::MAX));
            let slot = &self.slots[number];
            if slot.state != State::Leased(who) {
                continue;
            }
            let guilty = started == Some((job, slot.attempt));
            self.slots[number].state = State::Pending;
            if guilty {
                self.blame(job, work);
            } else {
                self.put_back(job);
            }
        }
    }

    /// Keeps about as many jobs pending as all queues hold: descents are made when needed.
    fn refill<W: Work>(&mut self, work: &mut W) {
        let enough = self.queues.capacity as usize * self.cores.len();
        while self.pending.len() < enough {
            work.more(&mut self.fresh);
            if self.fresh.is_empty() {
                return;
            }
            for spec in self.fresh.drain(..) {
                let job = JobId(u32::try_from(self.slots.len()).unwrap_or(u32::MAX));
                self.slots.push(Slot {
                    spec,
                    state: State::Pending,
                    attempt: 0,
                    blame: 0,
                    parts: 0,
                });
                self.pending.push_back(job);
                self.open += 1;
                self.counts.jobs += 1;
            }
        }
    }

    /// Places pending jobs until no core is eligible.
    fn assign<W: Work>(&mut self, now_ns: u64, work: &mut W, effects: &mut Vec<Effect>) {
        while let Some(&job) = self.pending.front()
            && self.ledger.thrash().is_none()
        {
            let spec = self.slots[job.0 as usize].spec;
            if work.is_moot(spec.task) {
                self.pending.pop_front();
                self.close(job, Closed::Cut, work);
                // Closing a job may have brought the next ones.
                self.refill(work);
                continue;
            }
            self.views.clear();
            for (number, core) in self.cores.iter().enumerate() {
                self.views.push(CoreView {
                    eligible: core.who.is_some() && core.takes(self.queues),
                    queued: core.queued,
                    has_a: self.ledger.holds(number, spec.a),
                    has_b: self.ledger.holds(number, spec.b),
                });
            }
            let Some(number) = self.scheme.choose(&self.views, self.queues.capacity) else { break };
            let Some(who) = self.cores[number].who else { break };
            self.pending.pop_front();
            let slot = &mut self.slots[job.0 as usize];
            slot.state = State::Leased(who);
            slot.parts = 0;
            let attempt = slot.attempt;
            let core = &mut self.cores[number];
            let sections = [spec.a, spec.b].map(|section| (section, work.weight(section)));
            for (section, bytes) in sections {
                if self.ledger.need(number, section, bytes) {
                    core.fetch.push(section);
                }
            }
            if let Some(log) = &mut self.log {
                log.push(Entry::Assigned { job, attempt, who, sections });
            }
            core.queued += 1;
            if core.outbox.is_empty() {
                core.since_ns = now_ns;
            }
            core.outbox.push((job, attempt));
            if core.outbox.len() >= self.queues.batch as usize {
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

    fn flush(&mut self, number: usize, effects: &mut Vec<Effect>) {
        let core = &mut self.cores[number];
        if let (Some(to), false) = (core.who, core.outbox.is_empty()) {
            self.counts.batches += 1;
            let (jobs, fetch) = (std::mem::take(&mut core.outbox), std::mem::take(&mut core.fetch));
            effects.push(Effect::Send { to, jobs, fetch });
        }
    }
}

impl Core {
    /// Whether a job may be placed here: a free slot, and room for a whole batch, so that batches
    /// do not shrink to one job as single results come back.
    fn takes(&self, queues: Queues) -> bool {
        self.queued < queues.capacity
            && (!self.outbox.is_empty() || self.queued + queues.batch <= queues.capacity)
    }
}

#[cfg(test)]
mod tests;
