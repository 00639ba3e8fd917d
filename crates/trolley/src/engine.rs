//! The engine: it owns the sealed bodies, the workers and the workspace, and ranks.
//!
//! ```text
//! Scenario --Bodies::of_scenario--> sealed store --Backend--> RankingWorkspace::rank --> Ranking
//! ```
//!
//! Bodies, trees, workers and workspace are kept while scenarios name the same bodies with the same
//! settings, so ranking many variants of a scene pays for them once.

use crate::Failure;
use crate::bodies::{OnProgress, PartyBody, SILENT};
use crate::limits::Limits;
use crate::run::{Kept, Run, Stages, milliseconds};
use crate::scenario::{Scenario, SourceText, Texts};
use coordinator::{
    Answer, Backend, BodySet, CourseHistory, Explanation, JobHistory, RankingRequest, Row,
    RunTimes, WorkerPool,
};
use dispatch::LogEntry;
use runtime::{affinity, clock};
use scenario::{EngineSettings as Settings, Overrides};

mod builder;
mod cores;
mod horizon;
mod loaded;

pub use builder::EngineBuilder;
pub use cores::{pin_coordinator, worker_cores};
pub use horizon::HorizonRanking;

use loaded::{Loaded, Subject, loaded};

/// Ranks scenarios.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// use trolley::{Engine, Limits};
///
/// let mut engine = Engine::builder().in_process().build()?;
/// let ranking = engine.rank(&scenario, &Limits::default())?;
/// assert_eq!(ranking.answer.ranking.len(), 4);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug)]
pub struct Engine {
    settings: EngineBuilder,
    loaded: Option<Loaded>,
}

/// A scenario, ranked.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
/// println!("{}, after {} jobs", ranking.answer.state.name(), ranking.run.jobs);
/// assert!(ranking.explanation.is_none(), "it was not requested");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ranking {
    /// The answer. A complete one is the same, byte for byte, with and without workers.
    pub answer: Answer,
    /// The chain from contact to rank, if it was requested.
    pub explanation: Option<Explanation>,
    /// How the work was done.
    pub run: Run,
    /// What a record is made from, if one was requested.
    pub(crate) recorded: Option<Recorded>,
}

/// What a record holds besides answer, explanation and run.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    pub(crate) texts: Texts,
    /// The other texts that the scenario names.
    pub(crate) files: Vec<SourceText>,
    pub(crate) unknown_is_fixed: bool,
    pub(crate) history: RecordedHistory,
    pub(crate) settings: Settings,
    pub(crate) bodies: Vec<record::RecordedBody>,
}

/// Which work was done: at impact in one request, over a horizon in rounds.
#[derive(Clone, Debug)]
pub(crate) enum RecordedHistory {
    Jobs(JobHistory),
    Rounds(CourseHistory),
}

/// A ranking that can begin.
struct Begun<'l> {
    loaded: &'l mut Loaded,
    backend: Backend,
    /// With nothing done yet.
    run: Run,
    loaded_ns: u64,
    started_ns: u64,
}

/// What is known of a request when its work is done.
struct Told {
    answer: Answer,
    answered_ns: u64,
    explanation: Option<Explanation>,
    job_history: Option<JobHistory>,
    run: Run,
    accepted_ns: u64,
    course: RunTimes,
}

impl Engine {
    /// Returns a builder with default settings.
    ///
    /// ```
    /// let engine = trolley::Engine::builder().in_process().build()?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn builder() -> EngineBuilder {
        EngineBuilder::default()
    }

    /// Ranks a scenario.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// use trolley::Limits;
    ///
    /// let ranking = engine.rank(&scenario, &Limits::default())?;
    /// let again = engine.rank(&scenario, &Limits::default())?; // bodies and trees are kept
    /// assert_eq!(ranking.answer, again.answer);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a body cannot be loaded, the scenario cannot be ranked, or the machine refuses what
    /// workers need. An incomplete answer is not an error: see [`Answer::state`].
    pub fn rank(&mut self, scenario: &Scenario, limits: &Limits) -> Result<Ranking, Failure> {
        self.rank_telling(scenario, limits, SILENT)
    }

    /// Ranks a scenario like [`rank`](Self::rank), and reports how far the bodies are built.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let progress = |done, total| eprintln!("{done} of {total} triangles");
    /// let ranking = engine.rank_telling(&scenario, &trolley::Limits::default(), &progress)?;
    /// assert!(ranking.best().is_some());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`].
    pub fn rank_telling(
        &mut self,
        scenario: &Scenario,
        limits: &Limits,
        progress: OnProgress<'_>,
    ) -> Result<Ranking, Failure> {
        let begun_ns = clock::now_ns();
        scenario.check_unknown()?;
        let settings = applied(&scenario.parsed.engine, &self.settings.overrides)?;
        limits.check()?;
        let request_limits = limits.request_limits(scenario.parsed.deadline);
        scenario.check_references()?;
        let subject = Subject {
            file: scenario.file(),
            bodies: scenario.parsed.parties.iter().map(PartyBody::of).collect(),
            needs_shells: false,
            find: &|reference| scenario.path_of(reference),
            check_kinds: &|kinds| scenario.parsed.check_kinds(scenario.file(), kinds),
        };
        let begun = self.begin(&subject, &settings, request_limits.deadline_ns, progress)?;
        let Begun { loaded, mut backend, run, loaded_ns, started_ns } = begun;
        let views = loaded.bodies.views()?;
        let stage =
            BodySet { bodies: &views, extremes: loaded.extremes.as_deref(), depth: settings.depth };
        let models: Vec<usize> = (0..views.len()).collect();
        let inquiry = RankingRequest {
            scenario: &scenario.parsed,
            models: &models,
            rules: (scenario.policy.clone(), scenario.curves.clone()),
            job_history: limits.wants_job_history(),
        };
        let told = loaded.workspace.rank(
            &stage,
            inquiry,
            || request_limits,
            &mut backend,
            |work, course| {
                Ok::<_, coordinator::RequestError>(Told {
                    answer: work.answer()?,
                    answered_ns: clock::now_ns(),
                    explanation: limits
                        .wants_explanation()
                        .then(|| work.explanation())
                        .transpose()?,
                    job_history: work.job_history().cloned(),
                    run: run.with_effort(work),
                    accepted_ns: work.accepted_ns(),
                    course,
                })
            },
        );
        // Workers that could not finish are not used again.
        let told = told?;
        let report = backend.report();
        loaded.backend = Some(backend);
        let Told { answer, answered_ns, explanation, job_history, mut run, accepted_ns, course } =
            told?;
        run.stages = Stages {
            load_ms: milliseconds(loaded_ns - begun_ns),
            plan_ms: milliseconds(course.planned_ns - started_ns),
            start_ms: milliseconds(started_ns - loaded_ns),
            work_ms: milliseconds(course.worked_ns - course.planned_ns),
            assess_ms: milliseconds(answered_ns - course.worked_ns),
            stop_ms: 0.0,
        };
        let due = limits.deadline(scenario.parsed.deadline);
        run.deadline = due.map(|due| Kept::of(due, answered_ns.saturating_sub(accepted_ns)));
        run.jobs = course.jobs_in_process;
        if let Some(report) = report {
            run = run.with_worker_pool(report, loaded.bodies.store().bytes().len());
        }
        let recorded = job_history.map(|job_history| Recorded {
            texts: scenario.texts.clone(),
            files: Vec::new(),
            unknown_is_fixed: scenario.unknown_is_fixed,
            history: RecordedHistory::Jobs(job_history),
            settings,
            bodies: loaded.bodies.recorded(&subject.bodies, &models),
        });
        Ok(Ranking { answer, explanation, run, recorded })
    }

    /// Loads the bodies, unless they are kept, and readies what runs jobs.
    fn begin(
        &mut self,
        subject: &Subject<'_>,
        settings: &Settings,
        deadline_ns: Option<u64>,
        progress: OnProgress<'_>,
    ) -> Result<Begun<'_>, Failure> {
        let loaded = loaded(&mut self.loaded, subject, settings, progress)?;
        if subject.needs_shells {
            loaded.find_shells()?;
        }
        let loaded_ns = clock::now_ns();
        let backend = loaded.ready(&self.settings, settings, deadline_ns)?;
        let started_ns = clock::now_ns();
        let cores_granted = affinity::allowed_cores();
        let remarks = self.settings.remarks(settings, &cores_granted);
        let views = loaded.bodies.views()?;
        let run = Run::new(self.settings.mode(), settings, &views, (cores_granted, remarks));
        Ok(Begun { loaded, backend, run, loaded_ns, started_ns })
    }

    /// Stops the workers, if there are any, and returns how long that took (ms). The next ranking
    /// starts new ones.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// engine.rank(&scenario, &trolley::Limits::default())?;
    /// println!("stopped in {} ms", engine.stop_workers());
    /// assert!(engine.worker_pids().is_empty());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    pub fn stop_workers(&mut self) -> f64 {
        let begun_ns = clock::now_ns();
        if let Some(loaded) = &mut self.loaded {
            drop(loaded.backend.take());
        }
        milliseconds(clock::now_ns() - begun_ns)
    }

    /// Returns the process ids of the workers, in order; empty before the first ranking.
    ///
    /// ```no_run
    /// # use trolley::{Engine, Limits, Scenario};
    /// let mut engine = Engine::builder().workers(2).build()?;
    /// engine.rank(&Scenario::demo()?, &Limits::default())?;
    /// assert_eq!(engine.worker_pids().len(), 2);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn worker_pids(&self) -> Vec<u32> {
        let backend = self.loaded.as_ref().and_then(|loaded| loaded.backend.as_ref());
        backend.and_then(Backend::worker_pool).map(WorkerPool::pids).unwrap_or_default()
    }

    /// Returns which worker got which job in the last ranking, if
    /// [`DispatchOptions::log`](crate::dispatch_options::DispatchOptions::log) is set.
    ///
    /// ```no_run
    /// # use trolley::{Engine, Limits, Scenario};
    /// use trolley::dispatch_options::{DispatchOptions, log_csv};
    ///
    /// let options = DispatchOptions { log: true, ..DispatchOptions::default() };
    /// let mut engine = Engine::builder().workers(2).dispatch_options(options).build()?;
    /// engine.rank(&Scenario::demo()?, &Limits::default())?;
    /// println!("{}", log_csv(engine.job_log()));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn job_log(&self) -> &[LogEntry] {
        let backend = self.loaded.as_ref().and_then(|loaded| loaded.backend.as_ref());
        backend.and_then(Backend::worker_pool).map_or(&[], WorkerPool::log)
    }
}

impl Ranking {
    /// Returns the candidate of least harm, if there is one: see [`Answer::best`].
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let ranking = engine.rank(&scenario, &trolley::Limits::default())?;
    /// if let Some(best) = ranking.best() {
    ///     println!("least harm: {}", best.name);
    /// }
    /// # assert!(ranking.best().is_some());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn best(&self) -> Option<&Row> {
        self.answer.best()
    }
}

/// The settings with some replaced; a replacement that does not fit is a configuration error.
fn applied(settings: &Settings, overrides: &Overrides) -> Result<Settings, Failure> {
    let applied = settings.apply(overrides);
    applied.map_err(|misfit| Failure::from(misfit).of_kind(crate::FailureKind::Configuration))
}

#[cfg(test)]
mod tests;
