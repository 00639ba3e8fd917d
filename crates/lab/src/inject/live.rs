//! Faults in a worker pool that answers requests in turn, and is repaired in between.

use super::kind::Kind;
use super::plan::Plan;
use super::report::{GUARD_NS, Report, State, judge};
use super::signals::{Deed, Gunner, Shot};
use super::worker_pool::{names_of, options};
use crate::progress::Progress;
use coordinator::{Answer, Corruption, Observation, RankingRun, WorkerPool, WorkerPoolError};
use geometry::rng::Rng;
use protocol::{FaultCommand, Incarnation, InjectedFault};
use runtime::process::Held;
use runtime::{SealedMemory, clock, machine};
use trolley::Failure;

/// For how long plain requests follow one in which a fault was not detected, until it must be (ns):
/// longer than the longest silence.
const CHASE_NS: u64 = 3_000_000_000;
/// Maximum number of plain requests where a job must reach a worker that has an order.
const CHASES: usize = 12;
/// No request without a deadline may take longer (ns): the longest silence, the longest sleep, and
/// twice that for consecutive faults.
const HANG_NS: u64 = 6_000_000_000;
/// Growth of resident memory that is no leak (bytes): heaps do not shrink.
const GROWTH_BYTES: u64 = 32 << 20;

/// State shared by all requests.
pub(super) struct Stage<'s> {
    pub(super) plan: &'s Plan,
    pub(super) store: &'s SealedMemory,
    pub(super) reference: &'s Answer,
}

/// A fault that is scheduled or has taken effect, and whose end is open.
#[derive(Clone, Copy, Debug)]
struct Open {
    /// Index among the request's faults.
    number: usize,
    kind: Kind,
    who: Incarnation,
    struck_ns: Option<u64>,
    seen_ns: Option<u64>,
}

struct Live<'s, F> {
    stage: &'s Stage<'s>,
    make: F,
    worker_pool: WorkerPool,
    instance: String,
    rng: Rng,
    sequence: u16,
    /// Duration of a request without faults (ns), and its number of jobs.
    usual_ns: u64,
    jobs: u64,
    open: Vec<Open>,
    /// Targets of the previous round's faults, which may still end them.
    before: Vec<Incarnation>,
    /// When replacements were started that are not ready yet (ns).
    mended_ns: Option<u64>,
}

pub(super) fn run<'w>(
    stage: &Stage<'_>,
    make: &impl Fn() -> RankingRun<'w>,
    kinds: &[Kind],
    seed: u64,
    report: &mut Report,
    progress: &Progress<'_>,
) -> Result<(), Failure> {
    let instance = format!("f{}", std::process::id());
    let worker_pool = WorkerPool::start(stage.store, &options(stage.plan, &instance))?;
    let mut live = Live {
        stage,
        make,
        worker_pool,
        instance,
        rng: Rng::new(seed ^ 0x0fa7),
        sequence: 0,
        usual_ns: 1,
        jobs: 1,
        open: Vec::new(),
        before: Vec::new(),
        mended_ns: None,
    };
    let mut times = Vec::new();
    for _ in 0..20 {
        let begun_ns = clock::now_ns();
        live.request(report)?;
        times.push(clock::now_ns() - begun_ns);
    }
    times.sort_unstable();
    live.usual_ns = times[times.len() / 2].max(1);
    let mut left: Vec<(Kind, u32)> = kinds.iter().map(|kind| (*kind, 0)).collect();
    let mut baseline = None;
    let total = left.len();
    while !left.is_empty() && !report.is_interrupted {
        // After a tenth everything has happened once, and has allocated the memory that it keeps.
        if baseline.is_none() && left.len() * 10 <= total * 9 {
            live.settle(report)?;
            baseline = Some(live.footprint());
        }
        let before = left.len();
        match live.round(&mut left, report) {
            // Report what is finished.
            Err(failure) if failure.kind() == trolley::FailureKind::Interrupted => {
                report.is_interrupted = true
            }
            other => other?,
        }
        progress.add(before.saturating_sub(left.len()) as u64);
    }
    live.settle(report)?;
    if let (Some((files, shm, memory)), (files_now, shm_now, memory_now)) =
        (baseline, live.footprint())
    {
        report.files_grown = files_now as i64 - files as i64;
        report.shm_grown = shm_now as i64 - shm as i64;
        report.memory_grown = memory_now.saturating_sub(memory);
        report.memory_leaked = report.memory_grown > GROWTH_BYTES;
    }
    let instance = live.instance.clone();
    drop(live);
    report.left_behind += names_of(&instance).len() as u64;
    Ok(())
}

impl<'w, F: Fn() -> RankingRun<'w>> Live<'_, F> {
    /// Descriptors, files in shared memory, resident memory (bytes).
    fn footprint(&self) -> (usize, usize, u64) {
        (
            machine::files_open().unwrap_or(0),
            names_of(&self.instance).len(),
            machine::resident_bytes().unwrap_or(0),
        )
    }

    /// Restores all workers, and cleans up.
    fn settle(&mut self, report: &mut Report) -> Result<(), Failure> {
        for _ in 0..3 {
            self.mend(true, report)?;
            self.request(report)?;
        }
        Ok(())
    }

    /// Replaces lost workers.
    fn mend(&mut self, waits: bool, report: &mut Report) -> Result<(), Failure> {
        let begun_ns = clock::now_ns();
        let mended = self.worker_pool.mend(self.stage.store)?;
        self.look(report);
        report.restarts += mended.started.len() as u64;
        if !mended.started.is_empty() {
            self.mended_ns = Some(begun_ns);
        }
        if waits {
            while self.worker_pool.ready() < usize::from(self.stage.plan.workers) {
                self.worker_pool.rally()?;
                let again = self.worker_pool.mend(self.stage.store)?;
                self.look(report);
                report.restarts += again.started.len() as u64;
            }
            if let Some(mended_ns) = self.mended_ns.take() {
                report.whole_ns.push(clock::now_ns() - mended_ns);
            }
        }
        Ok(())
    }

    /// Runs one request, and judges the answer.
    fn request(&mut self, report: &mut Report) -> Result<State, Failure> {
        let begun_ns = clock::now_ns();
        let mut work = (self.make)();
        let ran = self.worker_pool.run(&mut work);
        let took_ns = clock::now_ns() - begun_ns;
        report.requests += 1;
        report.slowest_ns = report.slowest_ns.max(took_ns);
        let due_ns = self.stage.plan.deadline_ms.map(|ms| u64::from(ms) * 1_000_000);
        report.late += u64::from(due_ns.is_some_and(|due_ns| took_ns > due_ns));
        report.hangs += u64::from(took_ns > due_ns.map_or(HANG_NS, |due_ns| due_ns + GUARD_NS));
        let state = match ran {
            Ok(ran) => {
                self.jobs = ran.counts.jobs.max(1);
                report.reissued += ran.counts.reissued;
                report.fenced += ran.counts.fence.sum();
                report.rejected += ran.rejected;
                let answer = work.answer()?;
                let state = judge(&answer, self.stage.reference);
                if state == State::Wrong {
                    let kinds: Vec<&str> = self.open.iter().map(|open| open.kind.name()).collect();
                    let work = |answer: &Answer| {
                        let row = |row: &coordinator::Row| (row.name.clone(), row.work);
                        answer.ranking.iter().map(row).collect::<Vec<_>>()
                    };
                    let (ours, right) = (work(&answer), work(self.stage.reference));
                    tracing::error!(?kinds, state = ?answer.state, ?ours, ?right, "wrong answer");
                }
                state
            }
            Err(WorkerPoolError::NobodyLeft { .. }) => State::Refused,
            Err(error) => return Err(error.into()),
        };
        report.count(state);
        self.look(report);
        Ok(state)
    }

    /// Determines which open faults were detected, and which workers were killed without cause.
    fn look(&mut self, report: &mut Report) {
        for incident in self.worker_pool.incidents() {
            let mut is_known = self.before.contains(&incident.who);
            for open in self.open.iter_mut().filter(|open| open.who == incident.who) {
                is_known = true;
                if open.struck_ns.is_none_or(|struck_ns| struck_ns <= incident.at_ns) {
                    open.seen_ns.get_or_insert(incident.at_ns);
                }
            }
            let is_end = matches!(
                incident.observation,
                Observation::Ended
                    | Observation::StoodStill(_)
                    | Observation::Distrusted(_)
                    | Observation::Impossible
            );
            if is_end && !is_known && report.note_end(incident.who) {
                report.false_kills += 1;
                tracing::warn!(?incident, "a healthy worker was killed");
            }
        }
    }

    /// Takes some of the remaining faults. One that takes all workers stays alone.
    fn choose(&mut self, left: &mut Vec<(Kind, u32)>) -> Vec<(Kind, u32)> {
        let most = 1 + self.rng.below(self.stage.plan.at_once.into()) as usize;
        let mut chosen: Vec<(Kind, u32)> = Vec::new();
        while chosen.len() < most {
            let is_alone = |(kind, _): &mut (Kind, u32)| chosen.is_empty() || !kind.takes_all();
            let Some(next) = left.pop_if(is_alone) else { break };
            chosen.push(next);
            if next.0.takes_all() {
                break;
            }
        }
        chosen
    }

    /// Runs a request with some of the remaining faults.
    fn round(&mut self, left: &mut Vec<(Kind, u32)>, report: &mut Report) -> Result<(), Failure> {
        let waits = self.rng.below(4) > 0;
        self.mend(waits, report)?;
        let chosen = self.choose(left);
        let roster = self.worker_pool.roster();
        let mut workers: Vec<usize> = (0..roster.len()).collect();
        for at in (1..workers.len()).rev() {
            workers.swap(at, self.rng.below(at as u64 + 1) as usize);
        }
        let begun_ns = clock::now_ns();
        let mut shots = Vec::new();
        self.before = self.open.drain(..).map(|open| open.who).collect();
        for (number, (kind, _)) in chosen.iter().enumerate() {
            let (who, pid) = roster[workers[number % workers.len()]];
            let targets = if kind.takes_all() { roster.clone() } else { vec![(who, pid)] };
            for (who, pid) in targets {
                let open = Open { number, kind: *kind, who, struck_ns: None, seen_ns: None };
                self.open.push(open);
                self.arm(*kind, who, pid, &mut shots)?;
            }
        }
        let state = std::thread::scope(|scope| {
            let gunner = Gunner::start(scope);
            shots.into_iter().for_each(|shot| gunner.add(shot));
            let state = self.request(report);
            for (number, at_ns) in gunner.end() {
                if let Some(open) = self.open.get_mut(number) {
                    open.struck_ns = Some(at_ns);
                }
            }
            state
        })?;
        self.obeyed(begun_ns);
        let answered_ns = clock::now_ns();
        self.look(report);
        self.mend(false, report)?;
        for chase in 0.. {
            let is_over = |open: &Open| {
                open.seen_ns.is_some()
                    || open.kind == Kind::Poison
                    || (open.struck_ns.is_some() && open.kind.may_be_survived())
                    || (open.struck_ns.is_none() && open.kind.commanded().is_none())
                    || (open.struck_ns.is_none() && chase >= CHASES)
            };
            if self.open.iter().all(is_over) || clock::now_ns() > answered_ns + CHASE_NS {
                break;
            }
            self.request(report)?;
            self.obeyed(begun_ns);
            self.look(report);
            self.mend(false, report)?;
        }
        self.disarm(report)?;
        self.book(&chosen, left, state, answered_ns, report);
        for (who, _) in self.worker_pool.roster() {
            self.worker_pool.command_fault(who.worker, None);
        }
        Ok(())
    }

    /// Replaces workers with a pending order, which they would obey in a later request.
    fn disarm(&mut self, report: &mut Report) -> Result<(), Failure> {
        for (who, pid) in self.worker_pool.roster() {
            let is_armed = |open: &Open| {
                let is_order = open.kind.commanded().is_some();
                open.who == who && is_order && open.struck_ns.is_none()
            };
            if self.open.iter().any(is_armed)
                && let Ok(held) = Held::of(pid)
            {
                held.signal(super::signals::KILL)?;
                report.note_end(who);
            }
        }
        self.mend(true, report)
    }

    /// Prepares a fault.
    fn arm(
        &mut self,
        kind: Kind,
        who: Incarnation,
        pid: u32,
        shots: &mut Vec<Shot>,
    ) -> Result<(), Failure> {
        let number = self.open.len() - 1;
        let within_ns = self.rng.below(self.usual_ns);
        let mut shoot = |after_ns: u64, deed: Deed| {
            // A worker that has ended by itself cannot be signalled.
            if let Ok(at) = Held::of(pid) {
                shots.push(Shot { number, at, after_ns, deed });
            }
        };
        match kind {
            Kind::Kill | Kind::KillAll => shoot(within_ns, Deed::Kill),
            Kind::KillIdle | Kind::KillAtStart => {
                if let Ok(held) = Held::of(pid) {
                    self.open[number].struck_ns = Some(clock::now_ns());
                    held.signal(super::signals::KILL)?;
                }
                if kind == Kind::KillAtStart {
                    // Its replacement is killed before it greets, or shortly after.
                    let _mended = self.worker_pool.mend(self.stage.store)?;
                    self.look_at_start(number);
                    let next = self.worker_pool.roster()[usize::from(who.worker)];
                    let after_ns = self.rng.below(20_000_000);
                    if next.0 != who
                        && let Ok(at) = Held::of(next.1)
                    {
                        self.open[number].who = next.0;
                        self.open[number].seen_ns = None;
                        shots.push(Shot { number, at, after_ns, deed: Deed::Kill });
                    }
                }
            }
            Kind::StopBeforeExec => {
                // Its replacement stops on its way from fork to exec.
                Held::of(pid)?.signal(super::signals::KILL)?;
                self.worker_pool.stop_next_starts(1);
                let mended = self.worker_pool.mend(self.stage.store)?;
                self.worker_pool.stop_next_starts(0);
                if let Some(next) = mended.started.iter().find(|next| next.worker == who.worker) {
                    self.open[number].who = *next;
                    self.open[number].struck_ns = Some(clock::now_ns());
                }
            }
            Kind::Stop => shoot(within_ns, Deed::Stop),
            Kind::StopContinue => {
                let ns = 1_000_000 + self.rng.below(250_000_000);
                shoot(within_ns, Deed::Pause(ns));
            }
            Kind::Slow => shoot(within_ns / 2, Deed::Choke(20)),
            Kind::GarbleBatch | Kind::QueueFull => {
                let bit = self.rng.bits() as u32;
                let how = if kind == Kind::QueueFull {
                    Corruption::Refused
                } else {
                    Corruption::Garbled(bit)
                };
                self.worker_pool.corrupt_next(who.worker, how);
                self.open[number].struck_ns = Some(clock::now_ns());
            }
            Kind::FlipStatus => {
                self.worker_pool.flip_status(who.worker, self.rng.bits());
                self.open[number].struck_ns = Some(clock::now_ns());
            }
            _ => {
                let Some(fault) = kind.commanded() else { return Ok(()) };
                self.sequence = self.sequence.wrapping_add(1).max(1);
                let share = self.jobs / u64::from(self.stage.plan.workers) / 2;
                let argument = match fault {
                    // All get the same job.
                    InjectedFault::Poison => {
                        (Rng::new(self.usual_ns ^ u64::from(self.sequence / 16)).bits() % self.jobs)
                            as u32
                    }
                    _ => self.rng.bits() as u32,
                };
                let after = self.rng.below(share.clamp(1, 20)) as u8;
                let order = FaultCommand { sequence: self.sequence, fault, after, argument };
                self.worker_pool.command_fault(who.worker, Some(order));
            }
        }
        Ok(())
    }

    /// The death of the first worker at start-up does not count.
    fn look_at_start(&mut self, number: usize) {
        self.open[number].seen_ns = None;
    }

    /// When orders were obeyed.
    fn obeyed(&mut self, since_ns: u64) {
        for open in self.open.iter_mut().filter(|open| open.kind.commanded().is_some()) {
            let at_ns = self.worker_pool.obeyed_ns(open.who.worker);
            if at_ns >= since_ns && open.struck_ns.is_none() {
                open.struck_ns = Some(at_ns);
            }
        }
    }

    /// Records the outcome of each fault; one that did not take effect is retried a few times.
    fn book(
        &mut self,
        chosen: &[(Kind, u32)],
        left: &mut Vec<(Kind, u32)>,
        state: State,
        answered_ns: u64,
        report: &mut Report,
    ) {
        for (number, (kind, tries)) in chosen.iter().enumerate() {
            let mut has_struck = false;
            for open in self.open.iter().filter(|open| open.number == number) {
                let Some(struck_ns) = open.struck_ns else { continue };
                has_struck = true;
                let recovered_ns = answered_ns.max(open.seen_ns.unwrap_or(0));
                report.add(
                    *kind,
                    state,
                    open.seen_ns.map(|seen_ns| seen_ns.saturating_sub(struck_ns)),
                    recovered_ns.saturating_sub(struck_ns),
                );
                if open.seen_ns.is_none() && !kind.may_be_survived() && *kind != Kind::Poison {
                    report.unseen += 1;
                }
            }
            if !has_struck {
                match tries {
                    0..4 => left.insert(0, (*kind, tries + 1)),
                    _ => report.missed += 1,
                }
            }
        }
    }
}
