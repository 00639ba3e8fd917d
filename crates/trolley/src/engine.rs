//! The engine: it owns the sealed bodies, the workers and the workspace, and ranks.
//!
//! ```text
//! Scenario --Bodies::of_scenario--> sealed store --Backend--> RankingWorkspace::rank --> Ranking
//! ```
//!
//! Bodies, trees, workers and workspace are kept for as long as scenarios are about the same bodies
//! and cut in the same way: whoever ranks many variants of a scene pays for them once.

use crate::bodies::{Bodies, OnProgress, SILENT};
use crate::dispatch_options::{self, DispatchOptions};
use crate::limits::Limits;
use crate::run::{Kept, Run, Stages, milliseconds};
use crate::scenario::Scenario;
use crate::{BUILD, Failure};
use body::{BodyKind, BodyView, Build, Fit, Meta, Shape, file};
use bvh::support::Extremes;
use coordinator::{
    Answer, Backend, BodySet, Explanation, InProcessExecutor, JobHistory, Options, RankingRequest,
    RankingWorkspace, Row, RunTimes, WorkerPool,
};
use dispatch::LogEntry;
use record::Mode;
use runtime::{FileMap, affinity, clock};
use scenario::{Cores, EngineSettings as Settings, FileRef, Overrides, Source};
use std::path::PathBuf;

/// Says how an [`Engine`] is to work.
#[derive(Clone, Debug, Default)]
pub struct EngineBuilder {
    overrides: Overrides,
    in_process: bool,
    instance: Option<String>,
    program: Option<PathBuf>,
    dispatch_options: DispatchOptions,
}

/// Ranks scenarios: see the [crate's page](crate).
#[derive(Debug)]
pub struct Engine {
    settings: EngineBuilder,
    loaded: Option<Loaded>,
}

/// A scenario, ranked.
#[derive(Clone, Debug)]
pub struct Ranking {
    /// What was asked, answered. Complete answers are the same bytes whoever did the work.
    pub answer: Answer,
    /// The chain from contact to rank, if it was asked for.
    pub explanation: Option<Explanation>,
    /// What it took.
    pub run: Run,
    /// What a record is made from, if one is wanted.
    pub(crate) recorded: Option<Recorded>,
}

/// What a record holds beside answer, explanation and run.
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
    /// Found when the bodies are asked about for the second time: it takes longer than one request.
    extremes: Option<Vec<Extremes>>,
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

/// Where a party's body comes from; equal ones are equal bodies.
#[derive(Clone, Debug, PartialEq)]
enum BodySource {
    Generated { shape: Shape, triangles: u32, seed: u64, size: Option<Fit> },
    File { path: PathBuf, hash: String, size: Option<Fit> },
}

impl EngineBuilder {
    /// So many worker processes, 1 to 16, instead of the scenario's.
    #[must_use]
    pub fn workers(mut self, workers: usize) -> Self {
        self.overrides.workers = Some(workers as i64);
        self
    }

    /// All jobs in the calling process: nothing is started and nothing stands in shared memory.
    #[must_use]
    pub fn in_process(self) -> Self {
        Self { in_process: true, ..self }
    }

    /// Distribution depth: levels of both trees that the coordinator descends itself.
    #[must_use]
    pub fn depth(mut self, levels: u32) -> Self {
        self.overrides.depth = Some(i64::from(levels));
        self
    }

    /// How trees are built.
    #[must_use]
    pub fn tree(mut self, build: Build) -> Self {
        self.overrides.build = Some(build.name().to_owned());
        self
    }

    /// All settings of the engine that a scenario may state, in place of the scenario's; those that
    /// were set before are lost.
    #[must_use]
    pub fn overrides(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }

    /// The name of this instance in shared memory, 1 to 12 of a-z, 0-9 and -; else one is made of
    /// the process id.
    #[must_use]
    pub fn instance(self, name: impl Into<String>) -> Self {
        Self { instance: Some(name.into()), ..self }
    }

    /// The program that plays the workers, else this program itself: see
    /// [`play_worker`](crate::play_worker). It must be of the same [build](BUILD).
    #[must_use]
    pub fn worker_program(self, program: impl Into<PathBuf>) -> Self {
        Self { program: Some(program.into()), ..self }
    }

    /// How jobs reach the workers: for measurements.
    #[must_use]
    pub fn dispatch_options(self, dispatch_options: DispatchOptions) -> Self {
        Self { dispatch_options, ..self }
    }

    /// The engine. Workers are started with the first scenario, whose bodies they need.
    ///
    /// # Errors
    ///
    /// If a setting is out of range or contradicts another.
    pub fn build(self) -> Result<Engine, Failure> {
        applied(&Settings::DEFAULT, &self.overrides)?;
        Ok(Engine { settings: self, loaded: None })
    }
}

impl Engine {
    /// Begins to say how an engine is to work.
    #[must_use]
    pub fn builder() -> EngineBuilder {
        EngineBuilder::default()
    }

    /// Ranks a scenario.
    ///
    /// # Errors
    ///
    /// If a body cannot be had, the request cannot be worked on, or the machine refuses what
    /// workers need. An answer that is not complete is no error: see [`Answer::state`].
    pub fn rank(&mut self, scenario: &Scenario, limits: &Limits) -> Result<Ranking, Failure> {
        self.rank_telling(scenario, limits, SILENT)
    }

    /// The same, and tells how far the bodies are built.
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
        let loaded = loaded(&mut self.loaded, scenario, &settings, progress)?;
        let loaded_ns = clock::now_ns();
        let mut backend = match loaded.backend.take() {
            Some(mut backend) => {
                // Whoever was lost has a successor.
                backend
                    .worker_pool_mut()
                    .map(|worker_pool| worker_pool.mend(loaded.bodies.store()))
                    .transpose()?;
                backend
            }
            None => self.settings.backend(&settings, &loaded.bodies)?,
        };
        let started_ns = clock::now_ns();
        let views = loaded.bodies.views()?;
        let run = Run::new(&self.settings, &settings, &views);
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

    /// Ends the workers, if there are any, and says how long that took (ms). The next ranking
    /// starts others.
    pub fn stop_workers(&mut self) -> f64 {
        let begun_ns = clock::now_ns();
        if let Some(loaded) = &mut self.loaded {
            drop(loaded.backend.take());
        }
        milliseconds(clock::now_ns() - begun_ns)
    }

    /// Process ids of the workers, in order; none before the first ranking.
    #[must_use]
    pub fn worker_pids(&self) -> Vec<u32> {
        let backend = self.loaded.as_ref().and_then(|loaded| loaded.backend.as_ref());
        backend.and_then(Backend::worker_pool).map(WorkerPool::pids).unwrap_or_default()
    }

    /// Who got which job in the last ranking, if [`DispatchOptions::log`] is set.
    #[must_use]
    pub fn job_log(&self) -> &[LogEntry] {
        let backend = self.loaded.as_ref().and_then(|loaded| loaded.backend.as_ref());
        backend.and_then(Backend::worker_pool).map_or(&[], WorkerPool::log)
    }
}

impl Ranking {
    /// The candidate of least harm.
    #[must_use]
    pub fn best(&self) -> Option<&Row> {
        self.answer.best()
    }
}

/// Settings with some replaced; what does not fit is a fault of whoever replaced it.
fn applied(settings: &Settings, overrides: &Overrides) -> Result<Settings, Failure> {
    let applied = settings.apply(overrides);
    applied.map_err(|misfit| Failure::from(misfit).of_kind(crate::FailureKind::Configuration))
}

/// The bodies of a scenario: those there are, if they are the same, or others in their place.
fn loaded<'l>(
    kept: &'l mut Option<Loaded>,
    scenario: &Scenario,
    settings: &Settings,
    progress: OnProgress<'_>,
) -> Result<&'l mut Loaded, Failure> {
    let sources = sources(scenario);
    let is_same = kept
        .as_ref()
        .is_some_and(|kept| kept.settings == *settings && sources.as_ref() == Some(&kept.sources));
    if is_same && let Some(kept) = kept {
        let views = kept.bodies.views()?;
        // The bodies are the same, who is what among them may not be.
        let kinds: Vec<BodyKind> = views.iter().map(|(meta, _)| meta.kind).collect();
        scenario.parsed.check_kinds(scenario.file(), &kinds)?;
        let of_all = || views.iter().map(|(_, body)| Extremes::of(body)).collect();
        kept.extremes.get_or_insert_with(of_all);
    } else {
        // First the old workers go: they may be as many as the machine has room for.
        *kept = None;
        let find = |_: usize, reference: &FileRef| scenario.path_of(reference);
        let file = scenario.file();
        let bodies = Bodies::of_scenario(&scenario.parsed, settings, file, &find, progress)?;
        *kept = Some(Loaded {
            settings: settings.clone(),
            sources: sources.unwrap_or_default(),
            bodies,
            extremes: None,
            backend: None,
            workspace: RankingWorkspace::default(),
        });
    }
    kept.as_mut().ok_or_else(|| Failure::internal("no bodies"))
}

/// Where the bodies come from; `None` if a file cannot be looked at.
fn sources(scenario: &Scenario) -> Option<Vec<BodySource>> {
    let of = |party: &scenario::Party| {
        let size = party.size;
        Some(match &party.source {
            Source::Generate { shape, triangles, seed } => {
                BodySource::Generated { shape: *shape, triangles: *triangles, seed: *seed, size }
            }
            Source::File(reference) => {
                let path = scenario.path_of(reference);
                let hash = file::content_hash(FileMap::open(&path).ok()?.bytes()).ok()?;
                BodySource::File { path, hash, size }
            }
        })
    };
    scenario.parsed.parties.iter().map(of).collect()
}

impl EngineBuilder {
    /// Whoever does the jobs, ready for them.
    fn backend(&self, settings: &Settings, bodies: &Bodies) -> Result<Backend, Failure> {
        if self.in_process {
            return Ok(Backend::InProcess(Box::new(InProcessExecutor::with_room_for(
                &bodies.views()?,
            ))));
        }
        let cores = worker_cores(settings, &affinity::allowed_cores())?;
        pin_coordinator(settings)?;
        let options = self.options(settings, bodies, cores)?;
        Ok(Backend::Workers(Box::new(WorkerPool::start(bodies.store(), &options)?)))
    }

    /// What is not as it should be on this machine.
    fn remarks(&self, settings: &Settings, granted: &[usize]) -> Vec<String> {
        let processes = settings.workers + 1;
        if self.in_process {
            vec!["no workers: all jobs ran in the coordinator's process".to_owned()]
        } else if granted.len() < processes {
            let remark = format!("{processes} processes share {} cores", granted.len());
            tracing::info!("{remark}: the coordinator and some workers take turns");
            vec![remark]
        } else {
            Vec::new()
        }
    }

    fn options(
        &self,
        settings: &Settings,
        bodies: &Bodies,
        cores: Vec<Option<usize>>,
    ) -> Result<Options, Failure> {
        let instance = self.instance.clone();
        let instance = instance.unwrap_or_else(|| format!("p{}", std::process::id()));
        let usual = Options::new(instance, BUILD, cores);
        Ok(Options {
            program: self.program.clone().unwrap_or_else(|| usual.program.clone()),
            matching: dispatch_options::matching(settings),
            queues: self.dispatch_options.queues(settings)?,
            cache: self.dispatch_options.cache(settings.depth, &bodies.views()?)?,
            copies: self.dispatch_options.copies(),
            log: self.dispatch_options.log,
            ..usual
        })
    }
}

impl Run {
    /// Nothing done yet.
    fn new(engine: &EngineBuilder, settings: &Settings, bodies: &[(Meta, BodyView<'_>)]) -> Self {
        let cores_granted = affinity::allowed_cores();
        Self {
            build: BUILD,
            mode: if engine.in_process { Mode::InProcess } else { Mode::Workers },
            stages: Stages::default(),
            depth: settings.depth,
            tree: settings.build,
            scheme: settings.scheme,
            deadline: None,
            winner_certain: None,
            order_certain: None,
            bodies: bodies.len(),
            triangles: bodies.iter().map(|(_, body)| body.corners.len()).sum(),
            store_bytes: 0,
            remarks: engine.remarks(settings, &cores_granted),
            cores_granted,
            tasks: 0,
            jobs: 0,
            jobs_cut: 0,
            jobs_abandoned: 0,
            jobs_reissued: 0,
            nb_descent: 0,
            nb: 0,
            np: 0,
            messages: 0,
            message_bytes: 0,
            messages_rejected: 0,
            parts_fenced: 0,
            section_bytes: 0,
            section_bytes_unshared: 0,
            sections_evicted: 0,
            workers: Vec::new(),
        }
    }
}

/// Keeps this process on the core that is named for it.
///
/// # Errors
///
/// If this process may not use that core.
pub fn pin_coordinator(settings: &Settings) -> Result<(), Failure> {
    let Some(core) = settings.coordinator_core else { return Ok(()) };
    affinity::pin_self(usize::from(core)).map_err(|error| {
        Failure::setting(diagnostic::chain(&error))
            .with_remedy("choose a core that this process may use: taskset -p $$")
    })
}

/// The core of each worker; `None`: wherever the system puts it.
///
/// # Errors
///
/// If a core is named that this process may not use.
pub fn worker_cores(settings: &Settings, granted: &[usize]) -> Result<Vec<Option<usize>>, Failure> {
    match &settings.cores {
        Cores::Unpinned => Ok(vec![None; settings.workers]),
        Cores::Granted => Ok(affinity::in_turn(granted, settings.workers)),
        Cores::Listed(cores) => {
            let cores = cores.iter().map(|core| usize::from(*core));
            if let Some(core) = cores.clone().find(|core| !granted.contains(core)) {
                let what = format!("core {core} is not one that this process may use");
                return Err(Failure::setting(what).with_remedy(format!(
                    "cores granted here: {granted:?}; see taskset and cpusets"
                )));
            }
            Ok(cores.map(Some).collect())
        }
    }
}

#[cfg(test)]
mod tests;
