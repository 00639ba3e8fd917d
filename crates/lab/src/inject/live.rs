//! Faults in a worker pool that answers requests in turn, and is repaired in between.

use super::arm::Planned;
use super::calls::Trace;
use super::kind::Kind;
use super::live_pool::{Live, Open, Stage};
use super::report::{Report, State};
use super::signals::{self, Gunner};
use super::worker_pool::{names_of, options};
use crate::progress::Progress;
use coordinator::{Backend, WorkerPool};
use core::sync::atomic::{AtomicBool, Ordering};
use geometry::rng::Rng;
use runtime::clock;
use runtime::process::Held;
use trolley::Failure;

/// For how long plain requests follow one in which a fault was not detected, until it must be (ns):
/// longer than the longest silence.
const CHASE_NS: u64 = 3_000_000_000;
/// Maximum number of plain requests where a job must reach a worker that has an order.
const CHASES: usize = 12;
/// Growth of resident memory that is no leak (bytes): heaps do not shrink.
const GROWTH_BYTES: u64 = 32 << 20;

pub(super) fn run(
    stage: &Stage<'_>,
    kinds: &[Kind],
    seed: u64,
    report: &mut Report,
    progress: &Progress<'_>,
) -> Result<(), Failure> {
    let instance = format!("f{}", std::process::id());
    let worker_pool = WorkerPool::start(stage.store, &options(stage.plan, &instance))?;
    let mut live = Live {
        stage,
        backend: Backend::Workers(Box::new(worker_pool)),
        instance,
        rng: Rng::new(seed ^ 0x0fa7),
        sequence: 0,
        usual_ns: 0,
        jobs: 1,
        open: Vec::new(),
        before: Vec::new(),
        mended_ns: None,
        calls_of_start: None,
    };
    for _ in 0..20 {
        live.request(report)?;
    }
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

impl Live<'_> {
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
        let roster = self.pool().roster();
        let mut workers: Vec<usize> = (0..roster.len()).collect();
        for at in (1..workers.len()).rev() {
            workers.swap(at, self.rng.below(at as u64 + 1) as usize);
        }
        let begun_ns = clock::now_ns();
        let mut planned = Planned::default();
        self.before = self.open.drain(..).map(|open| open.who).collect();
        for (number, (kind, _)) in chosen.iter().enumerate() {
            let (who, pid) = roster[workers[number % workers.len()]];
            let targets = if kind.takes_all() { roster.clone() } else { vec![(who, pid)] };
            for (who, pid) in targets {
                let open = Open { number, kind: *kind, who, struck_ns: None, seen_ns: None };
                self.open.push(open);
                self.arm(*kind, who, pid, &mut planned, report)?;
            }
        }
        let is_over = &AtomicBool::new(false);
        let state = std::thread::scope(|scope| {
            let gunner = Gunner::start(scope);
            planned.shots.into_iter().for_each(|shot| gunner.add(shot));
            let start = |trace: Trace| scope.spawn(move || trace.run(is_over));
            let tracers: Vec<_> = planned.traces.into_iter().map(start).collect();
            let state = self.request(report);
            is_over.store(true, Ordering::SeqCst);
            let killed = tracers.into_iter().filter_map(|tracer| tracer.join().ok().flatten());
            let killed: Vec<(usize, u64)> = killed.collect();
            for (number, at_ns) in gunner.end().into_iter().chain(killed) {
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
        // First, because the ends of those that are replaced are noticed, too.
        self.book(&chosen, left, state, answered_ns, report);
        self.disarm(report)?;
        for (who, _) in self.pool().roster() {
            self.pool().command_fault(who.worker, None);
        }
        Ok(())
    }

    /// Replaces workers that one of these faults would still end in a later request: by an order
    /// that they have not obeyed yet, or because nobody noticed what was done to them. A worker
    /// that gets no job is not watched.
    fn disarm(&mut self, report: &mut Report) -> Result<(), Failure> {
        for (who, pid) in self.pool().roster() {
            let is_armed = |open: &Open| {
                let is_pending = match open.struck_ns {
                    None => open.kind.commanded().is_some(),
                    Some(_) => open.is_unnoticed(),
                };
                open.who == who && is_pending
            };
            if self.open.iter().any(is_armed)
                && let Ok(held) = Held::of(pid)
            {
                signals::end(held)?;
                report.note_end(who);
            }
        }
        self.mend(true, report)
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
                if open.is_unnoticed() {
                    report.note_unseen(open.told());
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
