//! The engine: it owns the sealed bodies, the workers and the workspace, and ranks.
//!
//! ```text
//! Scenario --Bodies::of_scenario--> sealed store --Backend--> RankingWorkspace::rank --> Ranking
//! ```
//!
//! Bodies, trees, workers and workspace are kept while scenarios name the same bodies with the same
//! settings, so ranking many variants of a scene pays for them once.

use crate::Failure;
use crate::bodies::{Bodies, ModelFile, OnProgress, PartyBody, SILENT};
use crate::files::InputKind;
use crate::horizon::Horizon;
use crate::limits::Limits;
use crate::run::{Kept, Run, Stages, milliseconds};
use crate::scenario::Scenario;
use body::{BodyKind, Fit, Shape, Shells, file};
use bvh::support::Extremes;
use coordinator::{
    Answer, Backend, BodySet, CourseAnswer, CourseRequest, Explanation, JobHistory, RankedCourses,
    RankingRequest, RankingWorkspace, Row, RunTimes, WorkerPool,
};
use dispatch::LogEntry;
use runtime::{FileMap, affinity, clock};
use scenario::{EngineSettings as Settings, FileRef, Overrides, ScenarioError, Source};
use std::path::PathBuf;

mod builder;
mod cores;

pub use builder::EngineBuilder;
pub use cores::{pin_coordinator, worker_cores};

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

/// A scenario over a horizon, ranked.
///
/// ```
/// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let ranking = engine.rank_horizon(&horizon, &trolley::Limits::default())?;
/// println!("{} after {} ms", ranking.answer.state.name(), ranking.run.stages.plan_ms);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct HorizonRanking {
    /// The answer. A complete one is the same, byte for byte, with and without workers.
    pub answer: CourseAnswer,
    /// How the work was done.
    pub run: Run,
}

/// What a record holds besides answer, explanation and run.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    pub(crate) scenario: Scenario,
    pub(crate) job_history: JobHistory,
    pub(crate) settings: Settings,
    pub(crate) bodies: Vec<record::RecordedBody>,
}

/// What is kept from one scenario to the next.
#[derive(Debug)]
struct Loaded {
    settings: Settings,
    sources: Vec<BodySource>,
    bodies: Bodies,
    /// Computed for the second request about the same bodies: it takes longer than one request.
    extremes: Option<Vec<Extremes>>,
    /// Found for the first scenario over a horizon.
    shells: Vec<Shells>,
    backend: Option<Backend>,
    workspace: RankingWorkspace,
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

impl Loaded {
    /// What runs jobs: kept from the last request, or started.
    fn ready(
        &mut self,
        builder: &EngineBuilder,
        settings: &Settings,
        deadline_ns: Option<u64>,
    ) -> Result<Backend, Failure> {
        let Some(mut backend) = self.backend.take() else {
            return builder.backend(settings, &self.bodies, deadline_ns);
        };
        // Replace lost workers.
        let mended = backend.worker_pool_mut().map(|pool| pool.mend(self.bodies.store()));
        mended.transpose()?;
        Ok(backend)
    }
}

/// The bodies without repetition, and the number of each party's own among them.
fn unique<'s>(all: &[PartyBody<'s>]) -> (Vec<PartyBody<'s>>, Vec<usize>) {
    let mut unique: Vec<PartyBody<'s>> = Vec::new();
    let mut number = |body: &PartyBody<'s>| {
        let is_same = |known: &PartyBody<'s>| known.is_same(body);
        unique.iter().position(is_same).unwrap_or_else(|| {
            unique.push(*body);
            unique.len() - 1
        })
    };
    let models = all.iter().map(&mut number).collect();
    (unique, models)
}

/// Where a party's body comes from; equal ones are equal bodies.
#[derive(Clone, Debug, PartialEq)]
enum BodySource {
    Generated { shape: Shape, triangles: u32, seed: u64, size: Option<Fit> },
    File { path: PathBuf, hash: String, size: Option<Fit> },
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
            find: &|reference| scenario.path_of(reference),
            check_kinds: &|kinds| scenario.parsed.check_kinds(scenario.file(), kinds),
        };
        let loaded = loaded(&mut self.loaded, &subject, &settings, progress)?;
        let loaded_ns = clock::now_ns();
        let mut backend = loaded.ready(&self.settings, &settings, request_limits.deadline_ns)?;
        let started_ns = clock::now_ns();
        let views = loaded.bodies.views()?;
        let cores_granted = affinity::allowed_cores();
        let remarks = self.settings.remarks(&settings, &cores_granted);
        let run = Run::new(self.settings.mode(), &settings, &views, (cores_granted, remarks));
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
            scenario: scenario.clone(),
            job_history,
            settings,
            bodies: loaded.bodies.recorded(&scenario.parsed),
        });
        Ok(Ranking { answer, explanation, run, recorded })
    }

    /// Ranks a scenario over a horizon: every candidate among everybody around.
    ///
    /// ```
    /// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let ranking = engine.rank_horizon(&horizon, &trolley::Limits::default())?;
    /// let best = ranking.answer.best().expect("every candidate has bounds");
    /// println!("least harm: {}", best.name);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank`]; and where limits ask for a record, which there is none of yet.
    pub fn rank_horizon(
        &mut self,
        horizon: &Horizon,
        limits: &Limits,
    ) -> Result<HorizonRanking, Failure> {
        self.rank_horizon_telling(horizon, limits, SILENT)
    }

    /// Ranks like [`rank_horizon`](Self::rank_horizon), and reports how far the bodies are built.
    ///
    /// ```
    /// # let horizon = trolley::Horizon::open("../../config/scenarios/crossing.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let progress = |done, total| eprintln!("{done} of {total} triangles");
    /// let limits = trolley::Limits::default();
    /// let ranking = engine.rank_horizon_telling(&horizon, &limits, &progress)?;
    /// assert_eq!(ranking.answer.ranking.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Engine::rank_horizon`].
    pub fn rank_horizon_telling(
        &mut self,
        horizon: &Horizon,
        limits: &Limits,
        progress: OnProgress<'_>,
    ) -> Result<HorizonRanking, Failure> {
        let begun_ns = clock::now_ns();
        horizon.check_unknown()?;
        let scenario = horizon.parsed();
        let settings = applied(&scenario.engine, &self.settings.overrides)?;
        limits.check()?;
        if limits.wants_job_history() {
            let what = "a scenario over a horizon cannot be recorded yet";
            return Err(Failure::setting(what).with_remedy("leave the record out"));
        }
        let request_limits = limits.request_limits(scenario.deadline);
        horizon.check_references()?;
        let all = horizon.bodies();
        let (unique, models) = unique(&all);
        let check_kinds = |kinds: &[BodyKind]| {
            let kinds: Vec<BodyKind> = models.iter().map(|model| kinds[*model]).collect();
            scenario.check_kinds(horizon.file(), &kinds)
        };
        let subject = Subject {
            file: horizon.file(),
            bodies: unique,
            find: &|reference| horizon.path_of(reference),
            check_kinds: &check_kinds,
        };
        let loaded = loaded(&mut self.loaded, &subject, &settings, progress)?;
        if loaded.shells.is_empty() {
            let views = loaded.bodies.views()?;
            loaded.shells = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
        }
        let loaded_ns = clock::now_ns();
        let mut backend = loaded.ready(&self.settings, &settings, request_limits.deadline_ns)?;
        let started_ns = clock::now_ns();
        let views = loaded.bodies.views()?;
        let cores_granted = affinity::allowed_cores();
        let remarks = self.settings.remarks(&settings, &cores_granted);
        let run = Run::new(self.settings.mode(), &settings, &views, (cores_granted, remarks));
        let stage =
            BodySet { bodies: &views, extremes: loaded.extremes.as_deref(), depth: settings.depth };
        let (shells, rules) = (&loaded.shells[..], horizon.rules());
        let request = CourseRequest { scenario, models: &models, shells, rules };
        // Workers that could not finish are not used again.
        let RankedCourses { answer, effort, reports } =
            coordinator::rank_courses(&stage, &request, request_limits, &mut backend)?;
        let answered_ns = clock::now_ns();
        loaded.backend = Some(backend);
        let mut run = run.with_courses(&effort, reports, loaded.bodies.store().bytes().len());
        run.stages = Stages {
            load_ms: milliseconds(loaded_ns - begun_ns),
            plan_ms: milliseconds(effort.search_ns),
            start_ms: milliseconds(started_ns - loaded_ns),
            work_ms: milliseconds(effort.surveys_ns),
            assess_ms: milliseconds(effort.judge_ns),
            stop_ms: 0.0,
        };
        let due = limits.deadline(scenario.deadline);
        let took_ns = answered_ns.saturating_sub(effort.accepted_ns);
        run.deadline = due.map(|due| Kept::of(due, took_ns));
        Ok(HorizonRanking { answer, run })
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

/// What bodies are loaded for: a scenario of either form.
struct Subject<'s> {
    file: &'s str,
    bodies: Vec<PartyBody<'s>>,
    /// The path of a model file.
    find: &'s dyn Fn(&FileRef) -> PathBuf,
    /// Whether the bodies can play their parts, by their kinds.
    check_kinds: &'s dyn Fn(&[BodyKind]) -> Result<(), ScenarioError>,
}

/// The bodies of a scenario: the kept ones if they are the same, else newly loaded ones.
fn loaded<'l>(
    kept: &'l mut Option<Loaded>,
    subject: &Subject<'_>,
    settings: &Settings,
    progress: OnProgress<'_>,
) -> Result<&'l mut Loaded, Failure> {
    let sources = sources(subject);
    let is_same = kept
        .as_ref()
        .is_some_and(|kept| kept.settings == *settings && sources.as_ref() == Some(&kept.sources));
    if is_same && let Some(kept) = kept {
        let views = kept.bodies.views()?;
        // The bodies are the same, but they may play other parts.
        let kinds: Vec<BodyKind> = views.iter().map(|(meta, _)| meta.kind).collect();
        (subject.check_kinds)(&kinds)?;
        let extremes_of_all = || views.iter().map(|(_, body)| Extremes::of(body)).collect();
        kept.extremes.get_or_insert_with(extremes_of_all);
    } else {
        // Stop the old workers first: the machine may have no room for more.
        *kept = None;
        let find = |_: usize, reference: &FileRef| (subject.find)(reference);
        let bodies = Bodies::of_parties(&subject.bodies, settings, subject.file, &find, progress)?;
        (subject.check_kinds)(&bodies.iter().map(ModelFile::kind).collect::<Vec<_>>())?;
        *kept = Some(Loaded {
            settings: settings.clone(),
            sources: sources.unwrap_or_default(),
            bodies: Bodies::seal(bodies)?,
            extremes: None,
            shells: Vec::new(),
            backend: None,
            workspace: RankingWorkspace::default(),
        });
    }
    kept.as_mut().ok_or_else(|| Failure::internal("no bodies"))
}

/// Where the bodies come from; `None` if a file cannot be read.
fn sources(subject: &Subject<'_>) -> Option<Vec<BodySource>> {
    let source_of = |party: &PartyBody<'_>| {
        let size = party.size;
        Some(match party.source {
            Source::Generate { shape, triangles, seed } => {
                BodySource::Generated { shape: *shape, triangles: *triangles, seed: *seed, size }
            }
            Source::File(reference) => {
                let path = (subject.find)(reference);
                let hash = file::content_hash(FileMap::open(&path, InputKind::Model).ok()?.bytes())
                    .ok()?;
                BodySource::File { path, hash, size }
            }
        })
    };
    subject.bodies.iter().map(source_of).collect()
}

#[cfg(test)]
mod tests;
