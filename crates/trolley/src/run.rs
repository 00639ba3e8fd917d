//! How the work was done. The answer does not depend on it.
//!
//! ```
//! # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
//! # let mut engine = trolley::Engine::builder().in_process().build()?;
//! let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
//! println!("{} jobs with {} triangle tests", run.jobs, run.np);
//! assert!(run.jobs > 0);
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::BUILD;
use body::{BodyView, Build, Meta};
use coordinator::{CourseEffort, EncounterEffort, WorkerPoolReport, WorkerReport};
use core::time::Duration;
use record::Mode;
use scenario::{EngineSettings, Scheme};
use serde::Serialize;

/// Times of the stages, in milliseconds.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
/// println!("bodies in {} ms, work in {} ms", run.stages.load_ms, run.stages.work_ms);
/// assert!(run.stages.load_ms > 0.0);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Default, Serialize)]
pub struct Stages {
    /// Reading or generating bodies, building trees, sealing the store.
    pub load_ms: f64,
    /// Drawing members, and the search for contacts.
    pub plan_ms: f64,
    /// Starting workers and waiting for their greetings.
    pub start_ms: f64,
    /// Descending, intersecting, folding.
    pub work_ms: f64,
    /// Harm of contacts and courses, and ranking.
    pub assess_ms: f64,
    /// Worlds that the model allows.
    pub worlds_ms: f64,
    /// Stopping workers and cleaning up.
    pub stop_ms: f64,
}

/// How a scenario was ranked: times, counts, workers.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let run = engine.rank(&scenario, &trolley::Limits::default())?.run;
/// assert_eq!(run.build, trolley::BUILD);
/// assert_eq!((run.bodies, run.triangles), (5, 5900));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// Name of the build.
    pub build: &'static str,
    /// Whether workers or this process did the jobs.
    pub mode: Mode,
    /// Times of the stages.
    pub stages: Stages,
    /// Distribution depth.
    pub depth: u32,
    /// How the trees were built.
    pub tree: Build,
    /// How jobs were matched to workers.
    pub scheme: Scheme,
    /// How the deadline was kept, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deadline: Option<Kept>,
    /// Candidates that were not followed to their end, as that could not change what was asked for.
    pub spared: u64,
    /// Bodies in the store.
    pub bodies: usize,
    /// Their triangles.
    pub triangles: usize,
    /// Bytes of the store; 0 without workers.
    pub store_bytes: usize,
    /// Cores that this process may use.
    pub cores_granted: Vec<usize>,
    /// What could be better, in sentences.
    pub remarks: Vec<String>,
    /// The search for contacts.
    pub search: EncounterEffort,
    /// Rounds of contacts; workers are those of the last one.
    pub rounds: u64,
    /// Questions about poses.
    pub tasks: u64,
    /// Node pairs given to the kernel.
    pub jobs: u64,
    /// Jobs that were no longer needed.
    pub jobs_cut: u64,
    /// Jobs given up.
    pub jobs_abandoned: u64,
    /// Jobs handed out again.
    pub jobs_reissued: u64,
    /// Box tests of the coordinator's descent.
    pub nb_descent: u64,
    /// Box tests of the jobs.
    pub nb: u64,
    /// Triangle tests of the jobs.
    pub np: u64,
    /// Messages to and from workers.
    pub messages: u64,
    /// Bytes of these, headers included.
    pub message_bytes: u64,
    /// Messages rejected: foreign, stale or corrupt.
    pub messages_rejected: u64,
    /// Parts of results that came too late or twice.
    pub parts_fenced: u64,
    /// Bytes of the sections that cores needed and did not hold yet.
    pub section_bytes: u64,
    /// Bytes of all sections that cores needed, held or not.
    pub section_bytes_unshared: u64,
    /// Sections that made room for others.
    pub sections_evicted: u64,
    /// What each worker did.
    pub workers: Vec<WorkerReport>,
}

/// How a deadline was kept.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default().with_deadline_ms(50.0)?;
/// if let Some(kept) = engine.rank(&scenario, &limits)?.run.deadline {
///     println!("answered after {} of {} ms", kept.answered_ms, kept.due_ms);
///     assert_eq!(kept.late_ms > 0.0, kept.answered_ms > kept.due_ms);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// When the answer was due, after the request was accepted.
    pub due_ms: f64,
    /// When it was made.
    pub answered_ms: f64,
    /// How late that was; 0 if in time.
    pub late_ms: f64,
}

pub(crate) fn milliseconds(ns: u64) -> f64 {
    ns as f64 / 1e6
}

impl Kept {
    /// How an answer that took this long (ns) kept its deadline.
    pub(crate) fn of(due: Duration, answered_ns: u64) -> Self {
        let (due_ms, answered_ms) = (due.as_secs_f64() * 1e3, milliseconds(answered_ns));
        Self { due_ms, answered_ms, late_ms: (answered_ms - due_ms).max(0.0) }
    }
}

impl Run {
    /// A run with nothing done yet, on the cores granted; remarks are what could be better there.
    pub(crate) fn new(
        mode: Mode,
        settings: &EngineSettings,
        bodies: &[(Meta, BodyView<'_>)],
        (cores_granted, remarks): (Vec<usize>, Vec<String>),
    ) -> Self {
        Self {
            build: BUILD,
            mode,
            stages: Stages::default(),
            depth: settings.depth,
            tree: settings.build,
            scheme: settings.scheme,
            deadline: None,
            spared: 0,
            bodies: bodies.len(),
            triangles: bodies.iter().map(|(_, body)| body.corners.len()).sum(),
            store_bytes: 0,
            remarks,
            cores_granted,
            search: EncounterEffort::default(),
            rounds: 0,
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

    /// Adds what following courses took. `reports` are those of the workers, one a round.
    pub(crate) fn with_courses(
        self,
        effort: &CourseEffort,
        reports: Vec<WorkerPoolReport>,
        store_bytes: usize,
    ) -> Self {
        let surveys = effort.surveys;
        let mut run = Self {
            tasks: surveys.tasks,
            nb_descent: surveys.descent.nb,
            nb: surveys.jobs.nb,
            np: surveys.jobs.np,
            spared: effort.spared,
            search: effort.search,
            rounds: effort.rounds,
            ..self
        };
        if reports.is_empty() {
            run.jobs = effort.jobs_in_process;
        }
        for report in reports {
            let before = run.clone();
            run = run.with_worker_pool(report, store_bytes);
            run.jobs += before.jobs;
            run.jobs_cut += before.jobs_cut;
            run.jobs_abandoned += before.jobs_abandoned;
            run.jobs_reissued += before.jobs_reissued;
            run.messages += before.messages;
            run.message_bytes += before.message_bytes;
            run.messages_rejected += before.messages_rejected;
            run.parts_fenced += before.parts_fenced;
            run.section_bytes += before.section_bytes;
            run.section_bytes_unshared += before.section_bytes_unshared;
            run.sections_evicted += before.sections_evicted;
            for (worker, before) in run.workers.iter_mut().zip(before.workers) {
                worker.include(before);
            }
        }
        // Looks for contacts are counted with these.
        run.jobs = run.jobs.saturating_sub(run.search.jobs);
        run
    }

    /// Adds what the workers and the channels to them counted.
    fn with_worker_pool(self, report: WorkerPoolReport, store_bytes: usize) -> Self {
        let counts = report.counts;
        Self {
            store_bytes,
            jobs: counts.jobs,
            jobs_cut: counts.cut,
            jobs_abandoned: counts.abandoned,
            jobs_reissued: counts.reissued,
            messages: report.workers.iter().map(|worker| worker.batches + worker.results).sum(),
            message_bytes: report.workers.iter().map(|w| w.batch_bytes + w.result_bytes).sum(),
            messages_rejected: report.rejected,
            parts_fenced: counts.fence.sum(),
            section_bytes: report.transfer.section_bytes,
            section_bytes_unshared: report.transfer.unshared_bytes,
            sections_evicted: report.transfer.evicted,
            workers: report.workers,
            ..self
        }
    }
}
