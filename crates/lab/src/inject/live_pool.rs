//! The worker pool of a campaign: requests whose answers are judged, and successors of workers.

use super::kind::Kind;
use super::plan::Plan;
use super::report::{GUARD_NS, Report, State, judge};
use super::worker_pool::names_of;
use coordinator::{
    Answer, Backend, BodySet, CourseRequest, Mended, Observation, RequestLimits, RunError,
    WorkerPool, WorkerPoolError, rank_courses,
};
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
    pub(super) body_set: &'s BodySet<'s>,
    pub(super) request: &'s CourseRequest<'s>,
    pub(super) limits: RequestLimits,
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

impl Open {
    /// Whether it struck, would have ended a worker, and was not noticed.
    pub(super) fn is_unnoticed(&self) -> bool {
        let is_fatal = !self.kind.may_be_survived() && self.kind != Kind::Poison;
        is_fatal && self.struck_ns.is_some() && self.seen_ns.is_none()
    }

    /// Which fault of which worker, for the report.
    pub(super) fn told(&self) -> String {
        format!("{} of {}", self.kind.name(), named(self.who))
    }
}

fn listed(words: &[String]) -> String {
    if words.is_empty() { "none".to_owned() } else { words.join(", ") }
}

/// A worker, for the report.
fn named(Incarnation { worker, inc }: Incarnation) -> String {
    format!("worker {worker} (process {inc})")
}

pub(super) struct Live<'s> {
    pub(super) stage: &'s Stage<'s>,
    pub(super) backend: Backend,
    pub(super) instance: String,
    pub(super) rng: Rng,
    pub(super) sequence: u16,
    /// Median duration of requests (ns), estimated as they go: it changes when a job is in
    /// quarantine. Faults strike within it.
    pub(super) usual_ns: u64,
    /// Number of jobs of the last request.
    pub(super) jobs: u64,
    pub(super) open: Vec<Open>,
    /// Targets of the previous round's faults, which may still end them.
    pub(super) before: Vec<Incarnation>,
    /// When replacements were started that are not ready yet (ns).
    pub(super) mended_ns: Option<u64>,
    /// Number of system calls that a successor makes until it has greeted, once measured.
    pub(super) calls_of_start: Option<u64>,
}

impl Live<'_> {
    /// The workers.
    pub(super) fn pool(&mut self) -> &mut WorkerPool {
        match &mut self.backend {
            Backend::Workers(pool) => pool,
            Backend::InProcess(_) | Backend::Virtual(_) => unreachable!("a campaign has workers"),
        }
    }

    /// Replaces lost workers by new ones.
    pub(super) fn mend_pool(&mut self) -> Result<Mended, WorkerPoolError> {
        let store = self.stage.store;
        self.pool().mend(store)
    }

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
        let mended = self.mend_pool()?;
        self.look(report);
        report.restarts += mended.started.len() as u64;
        if !mended.started.is_empty() {
            self.mended_ns = Some(begun_ns);
        }
        if waits {
            while self.pool().ready() < usize::from(self.stage.plan.workers) {
                self.pool().rally()?;
                let again = self.mend_pool()?;
                self.look(report);
                report.restarts += again.started.len() as u64;
            }
            if let Some(mended_ns) = self.mended_ns.take() {
                report.whole_ns.push(clock::now_ns() - mended_ns);
            }
        }
        Ok(())
    }

    /// Moves the estimate of the median duration a step towards this one.
    fn note_time(&mut self, took_ns: u64) {
        let step_ns = self.usual_ns / 16 + 1;
        self.usual_ns = match self.usual_ns {
            0 => took_ns.max(1),
            usual_ns if took_ns > usual_ns => usual_ns + step_ns,
            usual_ns => usual_ns.saturating_sub(step_ns).max(1),
        };
    }

    /// Runs one request, and judges the answer.
    pub(super) fn request(&mut self, report: &mut Report) -> Result<State, Failure> {
        let begun_ns = clock::now_ns();
        let Stage { body_set, request, limits, .. } = self.stage;
        let ran = rank_courses(body_set, request, *limits, &mut self.backend);
        let took_ns = clock::now_ns() - begun_ns;
        self.note_time(took_ns);
        report.requests += 1;
        report.slowest_ns = report.slowest_ns.max(took_ns);
        let due_ns = self.stage.plan.deadline_ms.map(|ms| u64::from(ms) * 1_000_000);
        report.late += u64::from(due_ns.is_some_and(|due_ns| took_ns > due_ns));
        report.hangs += u64::from(took_ns > due_ns.map_or(HANG_NS, |due_ns| due_ns + GUARD_NS));
        let state = match ran {
            Ok(ran) => {
                let jobs: u64 = ran.reports.iter().map(|report| report.counts.jobs).sum();
                self.jobs = jobs.max(1);
                for round in &ran.reports {
                    report.reissued += round.counts.reissued;
                    report.fenced += round.counts.fence.sum();
                    report.rejected += round.rejected;
                }
                let answer = ran.answer;
                let state = judge(&answer, self.stage.reference);
                if state == State::Wrong {
                    let kinds: Vec<&str> = self.open.iter().map(|open| open.kind.name()).collect();
                    let work = |answer: &Answer| {
                        let row = |row: &coordinator::CourseRow| (row.name.clone(), row.work);
                        answer.ranking.iter().map(row).collect::<Vec<_>>()
                    };
                    let (ours, right) = (work(&answer), work(self.stage.reference));
                    tracing::error!(?kinds, state = ?answer.state, ?ours, ?right, "wrong answer");
                }
                state
            }
            Err(RunError::WorkerPool(WorkerPoolError::NobodyLeft { .. })) => State::Refused,
            Err(error) => return Err(error.into()),
        };
        report.count(state);
        self.look(report);
        Ok(state)
    }

    /// Determines which open faults were detected, and which workers were killed without cause.
    pub(super) fn look(&mut self, report: &mut Report) {
        for incident in self.pool().take_incidents() {
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
                let open: Vec<String> = self.open.iter().map(Open::told).collect();
                let before: Vec<String> = self.before.iter().copied().map(named).collect();
                report.note_false_kill(format!(
                    "{}: {:?}; faults of this request: {}; struck before: {}",
                    named(incident.who),
                    incident.observation,
                    listed(&open),
                    listed(&before)
                ));
            }
        }
    }

    /// When orders were obeyed.
    pub(super) fn obeyed(&mut self, since_ns: u64) {
        let Some(pool) = self.backend.worker_pool() else { return };
        for open in self.open.iter_mut().filter(|open| open.kind.commanded().is_some()) {
            let at_ns = pool.obeyed_ns(open.who.worker);
            if at_ns >= since_ns && open.struck_ns.is_none() {
                open.struck_ns = Some(at_ns);
            }
        }
    }
}
