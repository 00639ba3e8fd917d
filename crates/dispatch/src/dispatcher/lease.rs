//! Leases: how they begin, and every way in which they end other than with a result.
//!
//! | what happened | what follows |
//! |---|---|
//! | the worker is dead | the job it had started is blamed, the others go back |
//! | the batch was not handed over | its jobs go back; the core rests for [`REST_NS`] |
//! | the worker has answered the batch | what is still leased was lost on the way, and goes back |
//! | the job failed, the worker lives | the job is blamed |
//! | the time is up | everything open is closed |
//!
//! *Blame* is for a job that is known to have been started. A blamed job is a suspect: it runs
//! alone on a core, so that a second death is unambiguous; after [`BLAME_MAX`] it is abandoned, and
//! later requests skip it for a while (`quarantine.rs`).
//!
//! *Trust* is per incarnation of a worker: after [`FAULTS_MAX`] messages lost or rejected in one
//! request, or [`REFUSALS_MAX`] batches refused in a row, the worker is killed.

use super::{Closed, Dispatcher, Effect, JobSource, LogEntry, Queues, State, Why};
use crate::scheme::MatchScheme;
use core::mem::replace;
use protocol::{Incarnation, JobId, Section};
use std::collections::VecDeque;

/// How often a job may fail or kill its worker before it is abandoned.
const BLAME_MAX: u8 = 2;
/// How many messages an incarnation may lose or garble in a request.
const FAULTS_MAX: u8 = 3;
/// How many batches in a row a worker's queue may refuse.
const REFUSALS_MAX: u8 = 8;
/// How long a core rests after its queue was full (ns).
const REST_NS: u64 = 1_000_000;

/// The batch number of a job that is still in the outbox.
const UNSENT: u32 = u32::MAX;

/// A batch that a worker has not answered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Batch {
    number: u32,
    /// Number of jobs.
    len: u32,
    /// The jobs; empty if it belongs to an earlier request.
    jobs: Vec<JobId>,
}

/// One core, and the incarnation that serves it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Core {
    pub(super) who: Option<Incarnation>,
    /// Jobs leased to it, and jobs of earlier requests in its queue.
    pub(super) queued: u32,
    pub(super) outbox: Vec<(JobId, u8)>,
    /// Sections that jobs in the outbox need and the core did not hold.
    pub(super) fetch: Vec<Section>,
    /// When the first job of the outbox was added (ns).
    pub(super) since_ns: u64,
    /// Until when it gets no jobs, because its queue was full (ns).
    shut_until_ns: u64,
    /// The suspect that it runs alone.
    alone: Option<JobId>,
    /// Number of the next batch. Those handed over have no gaps: a worker that rejects one cannot
    /// read its number, so it counts.
    next: u32,
    /// All batches below are answered, or forgotten.
    floor: u32,
    sent: VecDeque<Batch>,
    faults: u8,
    /// Messages rejected whose jobs are not missed yet: the same fault, observed twice.
    garbled: u8,
    refusals: u8,
    is_doomed: bool,
}

impl Core {
    /// Creates a core whose worker has just said hello.
    pub(super) fn of(who: Incarnation) -> Self {
        Self { who: Some(who), ..Self::default() }
    }

    /// Whether a job may be placed here: needs a free slot, and capacity for a whole batch, so that
    /// batches do not shrink to one job as single results come back.
    pub(super) fn takes(&self, queues: Queues) -> bool {
        self.is_open()
            && self.alone.is_none()
            && self.queued < queues.capacity
            && (!self.outbox.is_empty() || self.queued + queues.batch <= queues.capacity)
    }

    fn is_open(&self) -> bool {
        self.who.is_some() && !self.is_doomed && self.shut_until_ns == 0
    }

    /// When it may be retried, if its queue was full (ns).
    pub(super) fn shut_until_ns(&self) -> Option<u64> {
        (self.shut_until_ns > 0).then_some(self.shut_until_ns)
    }

    /// Reopens it if it has rested long enough.
    pub(super) fn look(&mut self, now_ns: u64) {
        if self.shut_until_ns <= now_ns {
            self.shut_until_ns = 0;
        }
    }

    /// Reopens it: the queue is draining again.
    pub(super) fn open(&mut self) {
        self.refusals = 0;
        self.shut_until_ns = 0;
    }
}

impl<S: MatchScheme> Dispatcher<S> {
    /// Leases a job. It stays in the outbox until it is sent.
    pub(super) fn lease<W: JobSource>(
        &mut self,
        now_ns: u64,
        job: JobId,
        who: Incarnation,
        work: &mut W,
    ) {
        let number = usize::from(who.worker);
        let core = &mut self.cores[number];
        let slot = &mut self.slots[job.0 as usize];
        slot.state = State::Leased(who);
        slot.parts = 0;
        slot.batch = UNSENT;
        let (attempt, spec) = (slot.attempt, slot.spec);
        let sections = [spec.a, spec.b].map(|section| (section, work.weight(section)));
        for (section, bytes) in sections {
            if self.ledger.need(number, section, bytes) {
                core.fetch.push(section);
            }
        }
        if let Some(log) = &mut self.log {
            log.push(LogEntry::Assigned { job, attempt, who, sections });
        }
        core.queued += 1;
        if core.outbox.is_empty() {
            core.since_ns = now_ns;
        }
        core.outbox.push((job, attempt));
    }

    /// Sends the content of the outbox, if any.
    pub(super) fn flush(&mut self, number: usize, effects: &mut Vec<Effect>) {
        let core = &mut self.cores[number];
        if let (Some(to), false) = (core.who, core.outbox.is_empty()) {
            self.counts.batches += 1;
            let batch = core.next;
            core.next += 1;
            for (job, _) in &core.outbox {
                self.slots[job.0 as usize].batch = batch;
            }
            let spare = &mut self.spare;
            let jobs = replace(&mut core.outbox, spare.outboxes.pop().unwrap_or_default());
            let fetch = replace(&mut core.fetch, spare.fetches.pop().unwrap_or_default());
            let mut sent = spare.jobs.pop().unwrap_or_default();
            sent.extend(jobs.iter().map(|(job, _)| *job));
            core.sent.push_back(Batch {
                number: batch,
                len: u32::try_from(jobs.len()).unwrap_or(u32::MAX),
                jobs: sent,
            });
            effects.push(Effect::Send { to, batch, jobs, fetch });
        }
    }

    /// Assigns each suspect a core of its own. Returns the core that takes nothing else because a
    /// suspect waits until its jobs are answered.
    pub(super) fn place_suspects<W: JobSource>(
        &mut self,
        now_ns: u64,
        work: &mut W,
        effects: &mut Vec<Effect>,
    ) -> Option<usize> {
        while let Some(&job) = self.suspects.front() {
            if work.is_obsolete(&self.slots[job.0 as usize].spec) {
                self.suspects.pop_front();
                self.close(job, Closed::Cut, work);
                self.refill(now_ns, work);
                continue;
            }
            let open = self.cores.iter().enumerate().filter(|(_, core)| core.is_open());
            let (number, core) = open.min_by_key(|(number, core)| (core.queued, *number))?;
            let who = core.who?;
            if core.queued > 0 {
                return Some(number);
            }
            self.suspects.pop_front();
            self.lease(now_ns, job, who, work);
            self.cores[number].alone = Some(job);
            self.flush(number, effects);
        }
        None
    }

    /// Ends a lease and frees its slot.
    pub(super) fn unlease(&mut self, job: JobId) {
        if let State::Leased(who) = self.slots[job.0 as usize].state {
            self.slots[job.0 as usize].state = State::Pending;
            let core = &mut self.cores[usize::from(who.worker)];
            core.queued = core.queued.saturating_sub(1);
            core.alone = core.alone.filter(|alone| *alone != job);
        }
    }

    /// Returns a job to the front of the queue: work in progress is finished first.
    pub(super) fn put_back(&mut self, job: JobId) {
        let slot = &mut self.slots[job.0 as usize];
        slot.parts = 0;
        self.counts.reissued += 1;
        match slot.blame {
            0 => self.pending.push_front(job),
            _ => self.suspects.push_front(job),
        }
    }

    pub(super) fn blame<W: JobSource>(&mut self, now_ns: u64, job: JobId, work: &mut W) {
        let slot = &mut self.slots[job.0 as usize];
        slot.blame += 1;
        slot.attempt += 1;
        if slot.blame < BLAME_MAX {
            return self.put_back(job);
        }
        if let Some(key) = work.key(&slot.spec) {
            self.quarantine.add(key, now_ns);
        }
        self.close(job, Closed::Abandoned, work);
    }

    /// Blames only the started job; the others are returned without consequences.
    pub(super) fn reap<W: JobSource>(
        &mut self,
        now_ns: u64,
        who: Incarnation,
        started: Option<(JobId, u8)>,
        work: &mut W,
    ) {
        let Some(core) = self.cores.get_mut(usize::from(who.worker)) else { return };
        if core.who != Some(who) {
            return;
        }
        *core = Core::default();
        self.ledger.lose(usize::from(who.worker));
        if let Some(log) = &mut self.log {
            log.push(LogEntry::Lost { who });
        }
        #[cfg(feature = "faults")]
        if self.reap_badly(who, work) {
            return;
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
                self.blame(now_ns, job, work);
            } else {
                self.put_back(job);
            }
        }
    }

    /// Returns the jobs of a batch that was not handed over.
    pub(super) fn unsent(
        &mut self,
        now_ns: u64,
        to: Incarnation,
        batch: u32,
        effects: &mut Vec<Effect>,
    ) {
        let Some(core) = self.core_of(to) else { return };
        let Some(at) = core.sent.iter().position(|sent| sent.number == batch) else { return };
        core.shut_until_ns = now_ns.saturating_add(REST_NS);
        core.refusals = core.refusals.saturating_add(1);
        let is_stuck = core.refusals >= REFUSALS_MAX;
        let sent = core.sent.remove(at);
        core.next = core.sent.back().map_or(core.floor, |last| last.number + 1);
        self.reclaim(to, sent);
        if is_stuck {
            self.doom(to, Why::Full, effects);
        }
    }

    /// Returns the unanswered jobs of the batches that the worker is done with.
    pub(super) fn answered(&mut self, who: Incarnation, batches: u32, effects: &mut Vec<Effect>) {
        let mut lost = 0;
        while let Some(core) = self.core_of(who)
            && core.sent.front().is_some_and(|batch| batch.number < batches)
        {
            core.open();
            let batch = core.sent.pop_front();
            core.floor = batch.as_ref().map_or(core.floor, |batch| batch.number + 1);
            lost += self.reclaim(who, batch);
        }
        let Some(core) = self.core_of(who).filter(|_| lost > 0) else { return };
        if core.garbled > 0 {
            core.garbled -= 1;
        } else {
            self.distrust(who, Why::Forgetful, effects);
        }
    }

    /// Ends all leases of a batch; returns how many there were.
    fn reclaim(&mut self, who: Incarnation, batch: Option<Batch>) -> u32 {
        let Some(batch) = batch else { return 0 };
        if batch.jobs.is_empty() {
            // Of an earlier request: it held slots, but no leases.
            if let Some(core) = self.core_of(who) {
                core.queued = core.queued.saturating_sub(batch.len);
            }
            return 0;
        }
        let mut ended = 0;
        for job in batch.jobs.iter().rev() {
            let Some(slot) = self.slots.get(job.0 as usize) else { continue };
            if slot.state == State::Leased(who) && slot.batch == batch.number {
                self.unlease(*job);
                self.put_back(*job);
                ended += 1;
            }
        }
        self.lay_aside(batch.jobs);
        ended
    }

    /// Keeps the list of a batch for reuse.
    fn lay_aside(&mut self, mut jobs: Vec<JobId>) {
        jobs.clear();
        self.spare.jobs.push(jobs);
    }

    /// Counts a channel fault of a worker; after too many, it is killed.
    pub(super) fn distrust(&mut self, who: Incarnation, why: Why, effects: &mut Vec<Effect>) {
        let Some(core) = self.core_of(who) else { return };
        core.faults = core.faults.saturating_add(1);
        core.garbled = core.garbled.saturating_add(u8::from(why == Why::Garbled));
        if core.faults >= FAULTS_MAX {
            self.doom(who, why, effects);
        }
    }

    fn doom(&mut self, who: Incarnation, why: Why, effects: &mut Vec<Effect>) {
        let Some(core) = self.core_of(who).filter(|core| !core.is_doomed) else { return };
        core.is_doomed = true;
        effects.push(Effect::Kill { who, why });
    }

    /// Drops all leases, but not the slots that their jobs still occupy in the queues.
    pub(super) fn retire(&mut self) {
        let (slots, spare) = (&self.slots, &mut self.spare);
        for core in &mut self.cores {
            let leased = core.who.map(State::Leased);
            for batch in core.sent.iter_mut().filter(|batch| !batch.jobs.is_empty()) {
                let held = batch.jobs.iter().filter_map(|job| slots.get(job.0 as usize));
                let held = held
                    .filter(|slot| Some(slot.state) == leased && slot.batch == batch.number)
                    .count();
                batch.len = u32::try_from(held).unwrap_or(u32::MAX);
                let mut jobs = std::mem::take(&mut batch.jobs);
                jobs.clear();
                spare.jobs.push(jobs);
            }
            core.floor = core.next;
            core.sent.retain(|batch| batch.len > 0);
            core.queued = core.sent.iter().map(|batch| batch.len).sum();
            core.outbox.clear();
            core.fetch.clear();
            core.alone = None;
            core.faults = 0;
            core.garbled = 0;
        }
    }

    /// Closes all open jobs because the time is up.
    pub(super) fn expire<W: JobSource>(&mut self, work: &mut W) {
        self.is_over = true;
        self.retire();
        self.pending.clear();
        self.suspects.clear();
        for number in 0..self.slots.len() {
            if self.slots[number].state != State::Closed {
                let job = JobId(u32::try_from(number).unwrap_or(u32::MAX));
                self.close(job, Closed::Late, work);
            }
        }
    }

    fn core_of(&mut self, who: Incarnation) -> Option<&mut Core> {
        self.cores.get_mut(usize::from(who.worker)).filter(|core| core.who == Some(who))
    }
}
