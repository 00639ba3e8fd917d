//! The settings of an engine, and what they make: workers with cores, or this process.

use super::applied;
use super::body_cache::BodyCache;
use super::cores::{pin_coordinator, worker_cores};
use super::{Engine, Settings};
use crate::bodies::Bodies;
use crate::dispatch_options::{self, DispatchOptions};
use crate::{BUILD, Failure};
use body::Build;
use coordinator::{
    Backend, InProcessExecutor, Options, RequestLimits, Until, VirtualCores, WorkerPool,
};
use record::Mode;
use runtime::affinity;
use scenario::Overrides;
use std::path::PathBuf;

/// Settings for an [`Engine`], from [`Engine::builder`].
///
/// ```
/// use trolley::{Engine, kernel::Build};
///
/// let engine = Engine::builder().workers(2).depth(5).tree(Build::Sah).build()?;
/// assert!(engine.worker_pids().is_empty(), "workers start with the first scenario");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct EngineBuilder {
    pub(super) overrides: Overrides,
    in_process: bool,
    instance: Option<String>,
    program: Option<PathBuf>,
    dispatch_options: DispatchOptions,
    cache_bytes: usize,
}

impl EngineBuilder {
    /// Sets the number of worker processes, 1 to 16, in place of the scenario's.
    ///
    /// ```
    /// let engine = trolley::Engine::builder().workers(4).build()?;
    /// assert!(trolley::Engine::builder().workers(17).build().is_err());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn workers(mut self, workers: usize) -> Self {
        self.overrides.workers = Some(workers as i64);
        self
    }

    /// Runs all jobs in the calling process: no process is started, no shared memory is used.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let mut engine = trolley::Engine::builder().in_process().build()?;
    /// let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
    /// assert!(run.workers.is_empty());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn in_process(self) -> Self {
        Self { in_process: true, ..self }
    }

    /// Sets the distribution depth: the levels of both trees that the coordinator descends itself.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let mut engine = trolley::Engine::builder().in_process().depth(2).build()?;
    /// let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
    /// assert_eq!(run.depth, 2);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn depth(mut self, levels: u32) -> Self {
        self.overrides.depth = Some(i64::from(levels));
        self
    }

    /// Sets how trees are built.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// use trolley::kernel::Build;
    ///
    /// let mut engine = trolley::Engine::builder().in_process().tree(Build::Sah).build()?;
    /// let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
    /// assert_eq!(run.tree, Build::Sah);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn tree(mut self, build: Build) -> Self {
        self.overrides.build = Some(build.name().to_owned());
        self
    }

    /// Sets every engine setting that a scenario may state, in place of the scenario's. Settings
    /// made earlier with [`workers`](Self::workers), [`depth`](Self::depth) and
    /// [`tree`](Self::tree) are discarded.
    ///
    /// ```
    /// # use scenario::Overrides;
    /// let overrides = Overrides { workers: Some(2), leaf_size: Some(8), ..Overrides::default() };
    /// let engine = trolley::Engine::builder().overrides(overrides).build()?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn overrides(self, overrides: Overrides) -> Self {
        Self { overrides, ..self }
    }

    /// Sets the name of this instance in shared memory: 1 to 12 of a-z, 0-9 and `-`. The default is
    /// made from the process id.
    ///
    /// ```
    /// let engine = trolley::Engine::builder().workers(2).instance("planner-1").build()?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn instance(self, name: impl Into<String>) -> Self {
        Self { instance: Some(name.into()), ..self }
    }

    /// Sets the program that plays the workers. The default is this program: see
    /// [`play_worker`](crate::play_worker). It must be of the same [build](BUILD).
    ///
    /// ```
    /// let engine = trolley::Engine::builder().worker_program("/usr/bin/trolley").build()?;
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn worker_program(self, program: impl Into<PathBuf>) -> Self {
        Self { program: Some(program.into()), ..self }
    }

    /// Sets how jobs reach the workers, for measurements.
    ///
    /// ```
    /// use trolley::dispatch_options::DispatchOptions;
    ///
    /// let options = DispatchOptions { log: true, ..DispatchOptions::default() };
    /// let engine = trolley::Engine::builder().dispatch_options(options).build()?;
    /// assert!(engine.job_log().is_empty(), "nothing was ranked yet");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn dispatch_options(self, dispatch_options: DispatchOptions) -> Self {
        Self { dispatch_options, ..self }
    }

    /// Keeps bodies up to this number of bytes of model files, 80 to 125 a triangle, whichever
    /// scenarios they were loaded for; the default is 0. Answers do not depend on it. Without it an
    /// engine keeps the bodies of its last scenario alone.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let mut engine = trolley::Engine::builder().in_process().body_cache(64 << 20).build()?;
    /// engine.rank(&scenario, &trolley::Limits::default())?;
    /// let (bodies, bytes) = engine.cached_bodies();
    /// assert!(bodies == 5 && bytes <= 64 << 20);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn body_cache(self, bytes_max: usize) -> Self {
        Self { cache_bytes: bytes_max, ..self }
    }

    /// Makes the engine. Workers are started with the first scenario, whose bodies they need.
    ///
    /// ```
    /// assert!(trolley::Engine::builder().workers(2).build().is_ok());
    /// assert!(trolley::Engine::builder().depth(1000).build().is_err());
    /// ```
    ///
    /// # Errors
    ///
    /// If a setting is out of range or contradicts another.
    pub fn build(self) -> Result<Engine, Failure> {
        applied(&Settings::DEFAULT, &self.overrides)?;
        if self.dispatch_options.virtual_cores.is_some() && !self.in_process {
            let failure = Failure::setting("workers have real cores, not virtual ones");
            return Err(failure.with_remedy("work in this process, or leave virtual cores out"));
        }
        let cache = BodyCache::of_bytes(self.cache_bytes);
        Ok(Engine { settings: self, loaded: None, cache })
    }
}

/// The shortest time that workers get to start (ns), whatever the deadline of the first request.
const START_NS: u64 = 2_000_000_000;

impl EngineBuilder {
    /// What runs the jobs, ready to start. Workers that make visible progress may take as long to
    /// start as the first request may take (ns), but no less than those that make none.
    pub(super) fn backend(
        &self,
        settings: &Settings,
        bodies: &Bodies,
        deadline_ns: Option<u64>,
    ) -> Result<Backend, Failure> {
        if self.in_process {
            let executor = InProcessExecutor::with_room_for(&bodies.views()?);
            return Ok(match self.dispatch_options.virtual_cores {
                Some(setup) => Backend::Virtual(Box::new(VirtualCores::new(setup, executor))),
                None => Backend::InProcess(Box::new(executor)),
            });
        }
        let cores = worker_cores(settings, &affinity::allowed_cores())?;
        pin_coordinator(settings)?;
        let mut options = self.options(settings, bodies, cores)?;
        let patience = &mut options.start_patience;
        let deadline_ns = deadline_ns.unwrap_or(patience.longest_ns);
        patience.longest_ns =
            deadline_ns.clamp(START_NS.min(patience.longest_ns), patience.longest_ns);
        Ok(Backend::Workers(Box::new(WorkerPool::start(bodies.store(), &options)?)))
    }

    /// Refuses what virtual cores cannot do: their time is not that of the clock, and the order of
    /// their work is not recorded.
    pub(super) fn check_limits(
        &self,
        limits: &RequestLimits,
        is_recorded: bool,
    ) -> Result<(), Failure> {
        let is_limited = limits.deadline_ns.is_some() || limits.until != Until::Complete;
        if self.dispatch_options.virtual_cores.is_some() && (is_limited || is_recorded) {
            let what = "a ranking on virtual cores has no deadline, no early end and no record";
            return Err(Failure::setting(what).with_remedy("leave these out"));
        }
        Ok(())
    }

    /// Who does the jobs.
    pub(super) fn mode(&self) -> Mode {
        if self.in_process { Mode::InProcess } else { Mode::Workers }
    }

    /// What could be better on this machine.
    pub(super) fn remarks(&self, settings: &Settings, granted: &[usize]) -> Vec<String> {
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
