//! The engine: it owns the sealed bodies and the workers, and ranks.
//!
//! ```text
//! Scenario --Bodies::of_scenario--> sealed store --Backend--> rank_courses --> Ranking
//! ```
//!
//! Bodies, trees and workers are kept while scenarios name the same bodies with the same
//! settings, so ranking many variants of a scene pays for them once. With
//! [`EngineBuilder::body_cache`], bodies are kept though others join or leave the scene.

use crate::Failure;
use crate::bodies::{Bodies, OnProgress};
use crate::run::{Run, milliseconds};
use crate::texts::{SourceText, Texts};
use coordinator::{Backend, CourseHistory, VirtualTime, WorkerPool};
use dispatch::LogEntry;
use runtime::{affinity, clock};
use scenario::{EngineSettings as Settings, Overrides};

mod body_cache;
mod builder;
mod cores;
mod loaded;
mod ranking;

pub use builder::EngineBuilder;
pub use cores::{pin_coordinator, worker_cores};
pub use ranking::{Ranking, Searched};

use body_cache::BodyCache;
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
    cache: BodyCache,
}

/// What a record holds besides answer, explanation and run.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    pub(crate) texts: Texts,
    /// The other texts that the scenario names.
    pub(crate) files: Vec<SourceText>,
    pub(crate) unknown_is_fixed: bool,
    pub(crate) members: scenario::Members,
    pub(crate) history: CourseHistory,
    pub(crate) settings: Settings,
    pub(crate) bodies: Vec<record::RecordedBody>,
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

    /// Loads the bodies, unless they are kept, and readies what runs jobs.
    fn begin(
        &mut self,
        subject: &Subject<'_>,
        settings: &Settings,
        deadline_ns: Option<u64>,
        progress: OnProgress<'_>,
    ) -> Result<Begun<'_>, Failure> {
        let loaded = loaded(&mut self.loaded, &mut self.cache, subject, settings, progress)?;
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

    /// Returns the bodies of the last scenario, each once; `None` before the first ranking.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # let mut engine = trolley::Engine::builder().in_process().build()?;
    /// engine.rank(&scenario, &trolley::Limits::default())?;
    /// let views = engine.bodies().map(|bodies| bodies.views()).transpose()?;
    /// assert_eq!(views.map(|views| views.len()), Some(5));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn bodies(&self) -> Option<&Bodies> {
        self.loaded.as_ref().map(|loaded| &loaded.bodies)
    }

    /// Returns how many bodies the [cache](EngineBuilder::body_cache) has, and the bytes of their
    /// model files.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// let builder = trolley::Engine::builder().in_process().body_cache(64 << 20);
    /// let mut engine = builder.build()?;
    /// engine.rank(&scenario, &trolley::Limits::default())?;
    /// assert_eq!(engine.cached_bodies().0, 5);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn cached_bodies(&self) -> (usize, usize) {
        self.cache.size()
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

    /// Returns which worker got which job in the last round of contacts of the last ranking, if
    /// [`DispatchOptions::log`](crate::dispatch_options::DispatchOptions::log) is set. Numbers of
    /// jobs begin anew with each round.
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

    /// Returns how long the last ranking took on virtual cores, if
    /// [`DispatchOptions::virtual_cores`](crate::dispatch_options::DispatchOptions::virtual_cores)
    /// is set.
    ///
    /// ```
    /// # use trolley::{Engine, Limits, Scenario};
    /// use trolley::dispatch_options::{DispatchOptions, MessageCosts, VirtualSetup};
    ///
    /// # let scenario = Scenario::open("../../config/scenarios/small.toml")?;
    /// let setup = VirtualSetup { workers: 4, is_shared: false, costs: MessageCosts::default() };
    /// let options = DispatchOptions { virtual_cores: Some(setup), ..DispatchOptions::default() };
    /// let mut engine = Engine::builder().in_process().dispatch_options(options).build()?;
    /// engine.rank(&scenario, &Limits::default())?;
    /// let busy = engine.virtual_time().map(|time| time.busy_ns.len());
    /// assert_eq!(busy, Some(4));
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn virtual_time(&self) -> Option<&VirtualTime> {
        self.loaded.as_ref()?.backend.as_ref()?.virtual_time()
    }
}

/// The settings with some replaced; a replacement that does not fit is a configuration error.
fn applied(settings: &Settings, overrides: &Overrides) -> Result<Settings, Failure> {
    let applied = settings.apply(overrides);
    applied.map_err(|misfit| Failure::from(misfit).of_kind(crate::FailureKind::Configuration))
}

#[cfg(test)]
mod tests;
