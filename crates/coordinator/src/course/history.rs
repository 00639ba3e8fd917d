//! What of the work on a request depends on the clock and on workers, and the same work once more.
//!
//! A course takes its steps, looks for contacts and what comes of them, in an order that follows
//! from the scene and from the harm found so far, whatever workers do. So the numbers of those that
//! were not done say where the search ended in every candidate, and the job history of each round
//! says what was known of its contacts. What comes after looks at the clock at points that follow
//! from the scene, too: the number of the point at which time was over says where it ended.

use super::search::CourseSearch;
use super::selection::CourseOrder;
use super::{CourseRequest, RankedCourses, follow};
use crate::idle_cores::IdleCores;
use crate::looks::{LookEffort, LookSource as _, look_here};
use crate::request_limits::RequestLimits;
use crate::work::SurveyRun;
use crate::worker_pool::IdleHook;
use crate::worker_pool::{WorkerPoolError, WorkerPoolReport};
use crate::workspace::{Backend, BodySet, RunError};
use core::cell::Cell;
use core::ops::ControlFlow;
use record::{OpenStep, RecordedRound, RecordedSearch, RecordedUntil};
use runtime::clock;
#[cfg(any(test, feature = "faults"))]
use {
    crate::in_process::InProcessExecutor,
    dispatch::{Closed, JobSource as _},
    geometry::rng::Rng,
};

/// What an answer was made from besides the request: with it, the same answer is made again.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CourseHistory {
    /// When work was to stop.
    pub until: RecordedUntil,
    /// How far the search came; `None`: it had no deadline.
    pub search: Option<RecordedSearch>,
    /// Questions and jobs by round.
    pub rounds: Vec<RecordedRound>,
    /// Steps of the search that were not done, ascending.
    pub open_steps: Vec<OpenStep>,
}

/// Ranks the candidates of a recorded request again, in this process: from the same bodies and
/// rules the answer is the same, complete or not.
///
/// # Errors
///
/// If a contact cannot be assessed at all.
///
/// # Panics
///
/// As [`super::rank_courses`].
pub fn replay_courses(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    history: &CourseHistory,
) -> Result<RankedCourses, RunError> {
    let mut surveyor = Surveyor::replay(&history.rounds, &history.open_steps);
    let (until, clock) = (history.until.into(), SearchClock::recorded(history.search));
    follow((stage, request), (until, CourseOrder::default()), &clock, &mut surveyor)
}

/// Until when there is time.
#[derive(Clone, Copy, Debug)]
enum TimeLimit {
    /// Always.
    Never,
    /// Until that time (ns, monotonic).
    At(u64),
    /// Until that point, as recorded; `None`: always.
    Point(Option<u64>),
    /// Until that point, and looks for contacts are points too.
    #[cfg(any(test, feature = "faults"))]
    Anywhere(Option<u64>),
}

/// The clock of a request: says whether time is over, and counts the points at which it was asked.
#[derive(Debug)]
pub(super) struct SearchClock {
    limit: TimeLimit,
    points: Cell<u64>,
    over_at: Cell<Option<u64>>,
    /// What is called between looks, and when it was last (ns).
    idle_hook: Option<(IdleHook, Cell<u64>)>,
}

/// Least time between two calls of an idle hook (ns).
const ATTEND_NS: u64 = 5_000_000;

impl SearchClock {
    /// Time is over at `due_ns` (monotonic); `None`: never.
    pub(super) fn until(due_ns: Option<u64>) -> Self {
        Self::new(due_ns.map_or(TimeLimit::Never, TimeLimit::At))
    }

    /// Time is over when it was in a recorded search.
    pub(super) fn recorded(search: Option<RecordedSearch>) -> Self {
        let point = |search: RecordedSearch| TimeLimit::Point(search.over_at);
        Self::new(search.map_or(TimeLimit::Never, point))
    }

    /// Time is over at some point of a trial; `None`: at none.
    #[cfg(any(test, feature = "faults"))]
    pub(super) fn trial(over_at: Option<u64>) -> Self {
        Self::new(TimeLimit::Anywhere(over_at))
    }

    fn new(limit: TimeLimit) -> Self {
        Self { limit, points: Cell::new(0), over_at: Cell::new(None), idle_hook: None }
    }

    /// With something that is called whenever it is asked.
    pub(super) fn with_idle_hook(self, idle_hook: Option<IdleHook>) -> Self {
        Self { idle_hook: idle_hook.map(|hook| (hook, Cell::new(clock::now_ns()))), ..self }
    }

    /// Whether there is a deadline.
    pub(super) fn has_limit(&self) -> bool {
        !matches!(self.limit, TimeLimit::Never)
    }

    /// Whether it has to be asked.
    pub(super) fn is_watched(&self) -> bool {
        self.has_limit() || self.idle_hook.is_some()
    }

    /// Whether time is over while looking for contacts: no point that is recorded, as it is known
    /// which looks were done.
    pub(super) fn is_past(&self) -> bool {
        self.attend();
        match self.limit {
            TimeLimit::Never | TimeLimit::Point(_) => false,
            TimeLimit::At(due_ns) => clock::now_ns() >= due_ns,
            #[cfg(any(test, feature = "faults"))]
            TimeLimit::Anywhere(_) => self.is_over(),
        }
    }

    fn attend(&self) {
        if let Some((idle_hook, called_ns)) = &self.idle_hook {
            let now_ns = clock::now_ns();
            if now_ns - called_ns.get() >= ATTEND_NS {
                called_ns.set(now_ns);
                idle_hook.call();
            }
        }
    }

    /// Whether time is over at this point.
    pub(super) fn is_over(&self) -> bool {
        self.attend();
        let point = self.points.replace(self.points.get() + 1);
        let is_over = match self.limit {
            TimeLimit::Never => false,
            TimeLimit::At(due_ns) => clock::now_ns() >= due_ns,
            TimeLimit::Point(over_at) => over_at.is_some_and(|over_at| point >= over_at),
            #[cfg(any(test, feature = "faults"))]
            TimeLimit::Anywhere(over_at) => over_at.is_some_and(|over_at| point >= over_at),
        };
        if is_over && self.over_at.get().is_none() {
            self.over_at.set(Some(point));
        }
        is_over
    }

    /// How often it was asked.
    #[cfg(any(test, feature = "faults"))]
    pub(super) fn points(&self) -> u64 {
        self.points.get()
    }

    /// At which point time was over; `None` if there is no deadline.
    pub(super) fn search(&self) -> Option<RecordedSearch> {
        self.has_limit().then(|| RecordedSearch { over_at: self.over_at.get() })
    }
}

/// Which contacts are not assembled any more.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cutoff<'c> {
    /// Those for which there is no time.
    Clock(&'c SearchClock),
    /// Those that were not, ascending.
    Recorded(&'c [OpenStep]),
}

impl Cutoff<'_> {
    pub(super) fn is_over(&self, step: OpenStep) -> bool {
        match self {
            Self::Clock(time) => time.is_past(),
            Self::Recorded(open_steps) => open_steps.binary_search(&step).is_ok(),
        }
    }
}

/// What surveys the contacts of a round.
#[derive(Debug)]
pub(super) enum Surveyor<'s> {
    /// Workers, or this process.
    Backend {
        backend: &'s mut Backend,
        limits: RequestLimits,
        /// When work ends (ns, monotonic).
        due_ns: Option<u64>,
        /// The rounds so far, if they are recorded.
        rounds: Option<Vec<RecordedRound>>,
        /// Steps of the search that were not done.
        open_steps: Vec<OpenStep>,
    },
    /// A recorded request.
    Recorded {
        /// The rounds still to come.
        rounds: core::slice::Iter<'s, RecordedRound>,
        /// Steps of the search that were not done, ascending.
        open_steps: &'s [OpenStep],
    },
    /// This process, which loses one job of so many; 0: none.
    #[cfg(any(test, feature = "faults"))]
    Lossy { executor: Box<InProcessExecutor>, rng: Rng, loses: u64 },
}

impl<'s> Surveyor<'s> {
    /// One that does what was done.
    pub(super) fn replay(rounds: &'s [RecordedRound], open_steps: &'s [OpenStep]) -> Self {
        Self::Recorded { rounds: rounds.iter(), open_steps }
    }

    /// A round's work with its limits.
    pub(super) fn limit<'w>(&self, work: SurveyRun<'w>) -> SurveyRun<'w> {
        let Self::Backend { limits, due_ns, rounds, .. } = self else { return work };
        let left_ns = due_ns.map(|due_ns| due_ns.saturating_sub(clock::now_ns()));
        let limits = RequestLimits { deadline_ns: left_ns, ..*limits };
        let work = work.with_limits(limits);
        if rounds.is_some() { work.with_job_history() } else { work }
    }

    /// Does a round's work as far as there is time, or as far as it was done. Returns how many jobs
    /// this process ran itself.
    pub(super) fn survey(
        &mut self,
        work: &mut SurveyRun<'_>,
        stage: &BodySet<'_>,
    ) -> Result<u64, WorkerPoolError> {
        match self {
            Self::Backend { backend, rounds, .. } => {
                let jobs = backend.work_off(work)?;
                if let (Some(rounds), Some(history)) = (rounds, work.job_history()) {
                    rounds.push(history.round.clone());
                }
                Ok(jobs)
            }
            Self::Recorded { rounds, .. } => {
                // Of a round that was not recorded nothing is known.
                let none = RecordedRound::default();
                Ok(crate::replay::replay(work, stage.bodies, rounds.next().unwrap_or(&none)))
            }
            #[cfg(any(test, feature = "faults"))]
            Self::Lossy { executor, rng, loses } => Ok(work_off_lossy(work, executor, rng, *loses)),
        }
    }

    /// The cores that may help this process between rounds.
    pub(super) fn idle_cores(&self) -> IdleCores {
        match self {
            Self::Backend { backend, .. } => backend.idle_cores(),
            _ => IdleCores::default(),
        }
    }

    /// Which contacts are not assembled.
    pub(super) fn cutoff<'c>(&self, time: &'c SearchClock) -> Cutoff<'c>
    where
        's: 'c,
    {
        match self {
            Self::Recorded { open_steps, .. } => Cutoff::Recorded(open_steps),
            _ => Cutoff::Clock(time),
        }
    }

    /// Searches for the next contacts of courses, as far as there is time, or as far as it was
    /// done.
    pub(super) fn look(
        &mut self,
        search: &mut CourseSearch<'_, '_>,
        stage: &BodySet<'_>,
        time: &SearchClock,
    ) -> Result<LookEffort, WorkerPoolError> {
        match self {
            Self::Backend { backend, due_ns, open_steps, .. } => {
                let is_past = || time.is_past();
                let is_due = time.is_watched().then_some(&is_past as &dyn Fn() -> bool);
                let looked = backend.look(search, stage.bodies, (*due_ns, is_due))?;
                open_steps.append(&mut search.not_done);
                Ok(looked)
            }
            Self::Recorded { open_steps, .. } => {
                let is_open = |step| Cutoff::Recorded(open_steps).is_over(step);
                Ok(look_at_some(search, |step| !is_open(step)))
            }
            #[cfg(any(test, feature = "faults"))]
            Self::Lossy { rng, loses, .. } => {
                // The clock is that of a trial, which ends at one of its looks.
                let loses = *loses;
                let is_done = |_| !(time.is_past() || loses > 0 && rng.below(loses) == 0);
                Ok(look_at_some(search, is_done))
            }
        }
    }

    /// What the workers did for the last round, if there are any.
    pub(super) fn report(&self) -> Option<WorkerPoolReport> {
        match self {
            Self::Backend { backend, .. } => backend.report(),
            Self::Recorded { .. } => None,
            #[cfg(any(test, feature = "faults"))]
            Self::Lossy { .. } => None,
        }
    }
}

/// Looks in this process, at those that are done.
fn look_at_some(
    search: &mut CourseSearch<'_, '_>,
    mut is_done: impl FnMut(OpenStep) -> bool,
) -> LookEffort {
    look_here(search, |search, look| {
        is_done(look.step).then(|| search.look(look, &mut |_| ControlFlow::Continue(())))?
    })
}

#[cfg(any(test, feature = "faults"))]
fn work_off_lossy(
    work: &mut SurveyRun<'_>,
    executor: &mut InProcessExecutor,
    rng: &mut Rng,
    loses: u64,
) -> u64 {
    let (mut jobs, mut count) = (Vec::new(), 0);
    loop {
        jobs.clear();
        work.more(&mut jobs);
        if jobs.is_empty() {
            return count;
        }
        for job in &jobs {
            count += 1;
            if work.is_obsolete(job) {
                work.close(job, Closed::Cut);
            } else if loses > 0 && rng.below(loses) == 0 {
                work.close(job, Closed::Abandoned);
            } else {
                executor.run(work, job, &mut |_, _| {});
            }
        }
    }
}
