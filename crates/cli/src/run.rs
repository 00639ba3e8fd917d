//! How the work was done: everything beside the answer, which does not depend on it.

use crate::BUILD;
use crate::args::EngineArgs;
use crate::failure::{Code, Failure};
use crate::terms::{Certain, Kept};
use crate::transfer;
use body::{BodyView, Meta};
use coordinator::{Crew, Options, Work, WorkerReport, run_here};
use runtime::error::chain;
use runtime::{SealedMemory, affinity, clock};
use scenario::{Cores, Engine};
use serde::Serialize;

/// Times of the stages, in milliseconds.
#[derive(Clone, Debug, Default, Serialize)]
pub(crate) struct Stages {
    /// Reading or generating bodies, building trees, sealing the store.
    pub(crate) load_ms: f64,
    /// Hulls and paths.
    pub(crate) plan_ms: f64,
    /// Starting workers and waiting for their greetings.
    pub(crate) start_ms: f64,
    /// Descending, intersecting, folding.
    pub(crate) work_ms: f64,
    /// Harm and ranking.
    pub(crate) assess_ms: f64,
    /// Stopping workers and cleaning up.
    pub(crate) stop_ms: f64,
}

/// What it took.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Run {
    pub(crate) build: &'static str,
    pub(crate) mode: &'static str,
    pub(crate) stages: Stages,
    pub(crate) depth: u32,
    pub(crate) tree: body::Build,
    pub(crate) scheme: &'static str,
    /// How the deadline was kept, if there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) deadline: Option<Kept>,
    /// When no open work could change the winner any more; absent if that never was so.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) winner_certain: Option<Certain>,
    /// The same of the whole order, if somebody waited for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) order_certain: Option<Certain>,
    pub(crate) bodies: usize,
    pub(crate) triangles: usize,
    pub(crate) store_bytes: usize,
    pub(crate) cores_granted: Vec<usize>,
    /// Plain statements on what is not as it should be.
    pub(crate) remarks: Vec<String>,
    pub(crate) tasks: u64,
    pub(crate) jobs: u64,
    pub(crate) jobs_cut: u64,
    pub(crate) jobs_abandoned: u64,
    pub(crate) jobs_reissued: u64,
    /// Box tests of the coordinator's descent, then box and triangle tests of the jobs.
    pub(crate) nb_descent: u64,
    pub(crate) nb: u64,
    pub(crate) np: u64,
    pub(crate) messages: u64,
    pub(crate) message_bytes: u64,
    pub(crate) messages_rejected: u64,
    pub(crate) parts_fenced: u64,
    /// Bytes of sections that a core did not hold yet, and if none were ever held.
    pub(crate) section_bytes: u64,
    pub(crate) section_bytes_unshared: u64,
    pub(crate) sections_evicted: u64,
    pub(crate) workers: Vec<WorkerReport>,
}

pub(crate) fn milliseconds(ns: u64) -> f64 {
    ns as f64 / 1e6
}

fn blank(bodies: &[(Meta, BodyView<'_>)], engine: &Engine, mode: &'static str) -> Run {
    Run {
        build: BUILD,
        mode,
        stages: Stages::default(),
        depth: engine.depth,
        tree: engine.build,
        scheme: engine.scheme.name(),
        deadline: None,
        winner_certain: None,
        order_certain: None,
        bodies: bodies.len(),
        triangles: bodies.iter().map(|(_, body)| body.corners.len()).sum(),
        store_bytes: 0,
        cores_granted: affinity::allowed_cores(),
        remarks: Vec::new(),
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

fn with_effort(run: Run, work: &Work<'_>) -> Run {
    let effort = work.effort();
    Run {
        tasks: effort.tasks,
        nb_descent: effort.descent.nb,
        nb: effort.jobs.nb,
        np: effort.jobs.np,
        ..run
    }
}

/// Does all the work in this process.
pub(crate) fn here<'w>(
    mut work: Work<'w>,
    engine: &Engine,
    bodies: &'w [(Meta, BodyView<'w>)],
    stages: &mut Stages,
) -> (Work<'w>, Run) {
    let begun_ns = clock::now_ns();
    let jobs = run_here(&mut work, bodies);
    stages.work_ms = milliseconds(clock::now_ns() - begun_ns);
    let mut run = blank(bodies, engine, "in-process");
    run.remarks.push("no workers: all jobs ran in the coordinator's process".to_owned());
    let run = Run { jobs, ..with_effort(run, &work) };
    (work, run)
}

/// Ends the workers, if there are any.
pub(crate) fn stop(crew: Option<Crew>, stages: &mut Stages) -> Option<Crew> {
    let begun_ns = clock::now_ns();
    drop(crew);
    stages.stop_ms = milliseconds(clock::now_ns() - begun_ns);
    None
}

/// Does the work with a crew of worker processes, which live on until the crew is dropped.
pub(crate) fn crew<'w>(
    mut work: Work<'w>,
    engine: &Engine,
    bodies: &'w [(Meta, BodyView<'w>)],
    store: &SealedMemory,
    options: &EngineArgs,
    stages: &mut Stages,
) -> Result<(Work<'w>, Run, Crew), Failure> {
    let mut run = blank(bodies, engine, "workers");
    let granted = run.cores_granted.clone();
    let cores = worker_cores(engine, &granted)?;
    pin_coordinator(engine)?;
    if granted.len() < cores.len() + 1 {
        let processes = cores.len() + 1;
        let remark = format!("{processes} processes share {} cores", granted.len());
        tracing::info!("{remark}: the coordinator and some workers take turns");
        run.remarks.push(remark);
    }
    let begun_ns = clock::now_ns();
    let handing = &options.transfer;
    let instance = options.instance.clone().unwrap_or_else(|| format!("p{}", std::process::id()));
    let options = Options {
        matching: transfer::matching(engine.scheme, engine.alpha, engine.seed)?,
        queues: handing.queues(engine)?,
        cache: handing.cache(engine.depth, bodies)?,
        copies: handing.copies(),
        log: handing.job_log.is_some(),
        ..Options::new(instance, BUILD, cores)
    };
    let mut crew = Crew::start(store, &options)?;
    let started_ns = clock::now_ns();
    let report = crew.run(&mut work)?;
    let worked_ns = clock::now_ns();
    if let Some(path) = &handing.job_log {
        transfer::write_log(path, crew.log())?;
    }
    stages.start_ms = milliseconds(started_ns - begun_ns);
    stages.work_ms = milliseconds(worked_ns - started_ns);
    let counts = report.counts;
    let run = Run {
        store_bytes: store.bytes().len(),
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
        ..with_effort(run, &work)
    };
    Ok((work, run, crew))
}

/// Keeps this process on the core that is named for it.
pub(crate) fn pin_coordinator(engine: &Engine) -> Result<(), Failure> {
    let Some(core) = engine.coordinator_core else { return Ok(()) };
    affinity::pin_self(usize::from(core)).map_err(|error| {
        Failure::new(Code::Configuration, chain(&error))
            .help("choose a core that this process may use: taskset -p $$")
    })
}

/// The core of each worker.
pub(crate) fn worker_cores(
    engine: &Engine,
    granted: &[usize],
) -> Result<Vec<Option<usize>>, Failure> {
    match &engine.cores {
        Cores::Unpinned => Ok(vec![None; engine.workers]),
        Cores::Granted => Ok(affinity::in_turn(granted, engine.workers)),
        Cores::Listed(cores) => {
            let cores = cores.iter().map(|core| usize::from(*core));
            if let Some(core) = cores.clone().find(|core| !granted.contains(core)) {
                let fault = format!("core {core} is not one that this process may use");
                let help = format!("cores granted here: {granted:?}; see taskset and cpusets");
                return Err(Failure::new(Code::Configuration, fault).help(help));
            }
            Ok(cores.map(Some).collect())
        }
    }
}
