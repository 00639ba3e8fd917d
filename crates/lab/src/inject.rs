//! Injects faults into real workers during requests, and reports the outcome of each.
//!
//! ```text
//! plan ──▶ faults in a seeded order ──▶ a request with some of them ──▶ answer: same as without?
//!          signals, orders, messages       pool of real processes     ──▶ seen when? whole when?
//!          whole runs of their own         children that rank ──▶ right, refused, left behind?
//! ```
//!
//! The reference is the answer of this process without workers. A complete answer must equal it
//! byte for byte; the intervals of a degraded one must hold its values; anything else must be a
//! reported error.

mod arm;
mod calls;
mod child;
mod full;
mod kind;
mod live;
mod live_pool;
mod management;
mod plan;
mod public;
mod report;
mod run;
mod serving;
mod signals;
mod strangers;
mod worker_pool;

use crate::progress::{Progress, SyncProgress};
use body::Shells;
use coordinator::{
    Answer, Backend, BodySet, CourseRequest, InProcessExecutor, RequestLimits, rank_courses,
};
use geometry::rng::Rng;
use kind::Kind;
use plan::Plan;
use report::Report;
use runtime::{Poller, Wake};
use serving::Serving;
use std::path::{Path, PathBuf};
use trolley::bodies::{Bodies, SILENT};
use trolley::{Engine, Failure, Limits, References, Scenario, files};

pub use report::Injected;

/// Which faults, and which program ranks.
#[derive(Clone, Debug)]
pub struct InjectOptions {
    /// Plan, TOML: which faults, how often, against which scenario.
    pub plan: PathBuf,
    /// Which files the scenario may name.
    pub references: References,
    /// Seed of the order and places of the faults; equal seeds give equal plans, not equal times.
    pub seed: u64,
    /// Where to write the report as JUnit XML, with a test case for each kind of fault.
    pub junit: Option<PathBuf>,
    /// The program for faults that take a whole run: `PROGRAM -q rank FILE --json ...`.
    pub program: PathBuf,
}

/// Executes a plan. `told` is called with the faults done.
///
/// # Errors
///
/// If the plan or its scenario cannot be read, or the machine refuses what workers need. The
/// effects of faults are no error: see [`Injected::is_survived`].
pub fn inject(options: &InjectOptions, told: SyncProgress<'_>) -> Result<Injected, Failure> {
    let mut told_to_end = ToldToEnd::listen()?;
    let plan = Plan::read(&options.plan)?;
    options.junit.as_deref().map(|path| files::check(path, None)).transpose()?;
    let scenario = Scenario::open_with(&plan.scenario, options.references)?;
    let bodies = Bodies::of_scenario(&scenario, SILENT)?;
    let views = bodies.views()?;
    let shells: Vec<Shells> = views.iter().map(|(_, view)| Shells::of(view.corners)).collect();
    let models: Vec<usize> = (0..views.len()).collect();
    let request = CourseRequest {
        scenario: scenario.parsed(),
        models: &models,
        shells: &shells,
        criteria: scenario.criteria().clone(),
        members: scenario.parsed().members(),
        worlds: scenario::Worlds::USUAL,
        history: false,
        explanation: false,
        scene: false,
    };
    let body_set = BodySet { bodies: &views, extremes: None, depth: plan.depth };
    let mut alone = Backend::InProcess(Box::new(InProcessExecutor::with_room_for(&views)));
    let limits = RequestLimits::default();
    let reference = rank_courses(&body_set, &request, limits, &mut alone)?.answer;

    let limits = match plan.deadline_ms {
        Some(ms) => Limits::default().with_deadline_ms(f64::from(ms))?,
        None => Limits::default(),
    };
    let limits = limits.request_limits(None);

    let begun_ns = runtime::clock::now_ns();
    let mut report = Report::new(options.seed);
    report.deadline_ms = plan.deadline_ms;
    let mut all = plan.shuffled(options.seed);
    if all.iter().any(|kind| kind.traces()) && !runtime::process::may_trace() {
        for kind in all.extract_if(.., |kind| kind.traces()) {
            report.skip(kind, "this machine does not permit ptrace");
        }
    }
    let (runs, live): (Vec<_>, Vec<_>) = all.into_iter().partition(|kind| kind.is_whole_run());
    let progress = Progress::new((runs.len() + live.len()) as u64, told);
    let store = bodies.store();
    report.is_interrupted = told_to_end.yet()?;
    if !live.is_empty() && !report.is_interrupted {
        let stage = live_pool::Stage {
            plan: &plan,
            store,
            body_set: &body_set,
            request: &request,
            limits,
            reference: &reference,
        };
        live::run(&stage, &live, options.seed, &mut report, &progress)?;
    }
    let mut asked = None;
    let rank = run::Rank { program: &options.program, plan: &plan, references: options.references };
    for (number, kind) in runs.iter().enumerate() {
        report.is_interrupted |= told_to_end.yet()?;
        if report.is_interrupted {
            break;
        }
        if kind.is_of_service() {
            let asked = match &mut asked {
                Some(asked) => asked,
                none => none.insert(Asked::open(&plan.asked, options.references)?),
            };
            let seed = options.seed ^ (number as u64) << 20;
            service_fault(&rank, asked, *kind, Rng::new(seed), &mut report)?;
            progress.add(1);
            continue;
        }
        let known = (&reference, store);
        child::run(&rank, *kind, options.seed, number as u64, known, &mut report)?;
        progress.add(1);
    }
    report.left_behind += child::left_behind(&rank)?;
    report.seconds = (runtime::clock::now_ns() - begun_ns) as f64 / 1e9;
    report.replay = format!("trolley inject {} --seed {}", options.plan.display(), options.seed);
    let injected = report.document();
    if let Some(path) = &options.junit {
        files::replace(path, report::junit(&injected).as_bytes())?;
    }
    Ok(injected)
}

/// The signals that end a program: a campaign ends after the fault that is being injected, so that
/// what it made in shared memory is removed, and what is finished is reported.
struct ToldToEnd(Poller);

impl ToldToEnd {
    /// Listens from now on, and before any thread is started, which would die of a signal.
    fn listen() -> Result<Self, Failure> {
        let mut signals = Poller::new()?;
        signals.catch_signals()?;
        Ok(Self(signals))
    }

    /// Whether one has come.
    fn yet(&mut self) -> Result<bool, Failure> {
        Ok(self.0.wait(Some(0))?.any(|wake| matches!(wake, Wake::Signal(_))))
    }
}

/// What clients ask a service, and what the answer is.
struct Asked {
    scenario: Scenario,
    reference: Answer,
}

impl Asked {
    fn open(path: &Path, references: References) -> Result<Self, Failure> {
        let scenario = Scenario::open_with(path, references)?;
        let mut engine = Engine::builder().in_process().build()?;
        let limits = Limits::default().with_members(serving::MEMBERS, None)?;
        let reference = engine.rank(&scenario, &limits)?.answer;
        Ok(Self { scenario, reference })
    }
}

/// Injects one fault into a service.
fn service_fault(
    rank: &run::Rank<'_>,
    Asked { scenario, reference }: &Asked,
    kind: Kind,
    rng: Rng,
    report: &mut Report,
) -> Result<(), Failure> {
    let Some(mut serving) = Serving::prepare(rank, scenario)? else {
        report.skip(kind, "not all bodies of the scenario are generated");
        return Ok(());
    };
    match kind {
        Kind::FullShm if !child::is_granted(Kind::SmallShm)? => {
            report.skip(kind, "this machine does not permit to mount file systems");
            Ok(())
        }
        Kind::FullShm => full::strike(&mut serving, rng, reference, report),
        Kind::StrangersFiles => strangers::strike(&mut serving, rng, reference, report),
        Kind::FlipPublic => public::flip(&mut serving, rng, reference, report),
        _ => management::flip(&mut serving, rng, reference, report),
    }
}
