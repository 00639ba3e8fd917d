//! The worker pool of a campaign: requests whose answers are judged, and successors of workers.

use super::kind::Kind;
use super::plan::Plan;
use super::report::{GUARD_NS, Report, State, judge};
use super::worker_pool::names_of;
use coordinator::{Answer, Observation, RankingRun, WorkerPool, WorkerPoolError};
use geometry::rng::Rng;
use protocol::Incarnation;
use runtime::{SealedMemory, clock, machine};
use trolley::Failure;

/// No request without a deadline may take longer (ns): the longest silence, the longest sleep, and
/// twice that for consecutive faults.
const HANG_NS: u64 = 6_000_000_000;

/// State shared by all requests.
pub(super) struct Stage<'s> {
    pub(super) plan: &'s Plan,
    pub(super) store: &'s SealedMemory,
    pub(super) reference: &'s Answer,
}

/// A fault that is scheduled or has taken effect, and whose end is open.
#[derive(Clone, Copy, Debug)]
pub(super) struct Open {
    /// Index among the request's faults.
    pub(super) number: usize,
    pub(super) kind: Kind,
    pub(super) who: Incarnation,
    pub(super) struck_ns: Option<u64>,
    pub(super) seen_ns: Option<u64>,
}

pub(super) struct Live<'s, F> {
    pub(super) stage: &'s Stage<'s>,
    pub(super) make: F,
    pub(super) worker_pool: WorkerPool,
    pub(super) instance: String,
    pub(super) rng: Rng,
    pub(super) sequence: u16,
    /// Duration of a request without faults (ns), and its number of jobs.
    pub(super) usual_ns: u64,
    pub(super) jobs: u64,
    pub(super) open: Vec<Open>,
    /// Targets of the previous round's faults, which may still end them.
    pub(super) before: Vec<Incarnation>,
    /// When replacements were started that are not ready yet (ns).
    pub(super) mended_ns: Option<u64>,
    /// Number of system calls that a successor makes until it has greeted, once measured.
    pub(super) calls_of_start: Option<u64>,
}

impl<'w, F: Fn() -> RankingRun<'w>> Live<'_, F> {
    /// Descriptors, files in shared memory, resident memory (bytes).
    pub(super) fn footprint(&self) -> (usize, usize, u64) {
        (
            machine::files_open().unwrap_or(0),
            names_of(&self.instance).len(),
            machine::resident_bytes().unwrap_or(0),
        )
    }

    /// Restores all workers, and cleans up.
    pub(super) fn settle(&mut self, report: &mut Report) -> Result<(), Failure> {
        for _ in 0..3 {
            self.mend(true, report)?;
            self.request(report)?;
        }
        Ok(())
    }

    /// Replaces lost workers.
    pub(super) fn mend(&mut self, waits: bool, report: &mut Report) -> Result<(), Failure> {
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
    pub(super) fn request(&mut self, report: &mut Report) -> Result<State, Failure> {
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
    pub(super) fn look(&mut self, report: &mut Report) {
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

    /// When orders were obeyed.
    pub(super) fn obeyed(&mut self, since_ns: u64) {
        for open in self.open.iter_mut().filter(|open| open.kind.commanded().is_some()) {
            let at_ns = self.worker_pool.obeyed_ns(open.who.worker);
            if at_ns >= since_ns && open.struck_ns.is_none() {
                open.struck_ns = Some(at_ns);
            }
        }
    }
}
