//! `Session`: engines that rank, each in a thread of its own, with the bodies that they keep.
//!
//! ```text
//! rank, rank_many --Batch--> the engines' threads: each takes the next task --> Outcome
//! ```
//!
//! An engine lives where it was made. What a thread finds is text by the time it comes back, so
//! Python's lock is held only to hand it over.

use crate::errors::{raise, refuse};
use crate::ranking::{Outcome, RankedScenes};
use crate::scenario::ScenarioText;
use crate::searched::SearchedScene;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use trolley::{Engine, Failure, FailureKind, Limits, Record, Scenario, Searched, Until, Worlds};

/// Most engines of a session.
const ENGINES_MAX: usize = 64;

/// How long to wait for outcomes until the next look for signals, such as Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Work on scenarios, by whichever engine is free.
struct Batch {
    scenarios: Vec<Scenario>,
    limits: Limits,
    task: Task,
    next: AtomicUsize,
    is_stopped: AtomicBool,
    done: Sender<(usize, Result<Found, Failure>)>,
}

/// What is done with a scenario.
enum Task {
    /// It is ranked, and recorded in a folder.
    Rank(Option<PathBuf>),
    /// It is searched for every policy.
    Search,
}

/// What came of it.
enum Found {
    Ranked(Box<Outcome>),
    Searched(Box<Searched>),
}

/// Engines with the bodies that they keep.
#[pyclass(name = "Session", module = "trolley_av", frozen)]
pub(crate) struct RankingSession {
    engines: Vec<Sender<Arc<Batch>>>,
    /// Threads do not survive a fork.
    process: u32,
}

/// When to stop, and what to say.
#[derive(FromPyObject)]
struct Wanted {
    #[pyo3(item)]
    until: String,
    #[pyo3(item)]
    members: Option<i64>,
    #[pyo3(item)]
    members_max: Option<i64>,
    #[pyo3(item)]
    deadline_ms: Option<f64>,
    #[pyo3(item)]
    explain: bool,
    #[pyo3(item)]
    record: Option<PathBuf>,
    #[pyo3(item)]
    worlds: Option<i64>,
    #[pyo3(item)]
    worlds_seed: u32,
}

#[pymethods]
impl RankingSession {
    #[new]
    #[pyo3(signature = (*, threads = 1, cache_mb = 512))]
    fn new(py: Python<'_>, threads: usize, cache_mb: usize) -> PyResult<Self> {
        if !(1..=ENGINES_MAX).contains(&threads) {
            let what = format!("{threads} is not 1 to {ENGINES_MAX}");
            return Err(refuse(py, "threads", &what, "give one for each core to be used"));
        }
        let bytes = cache_mb.saturating_mul(1 << 20) / threads;
        let engine = |_| start(bytes).map_err(|failure| raise(py, &failure));
        let engines = (0..threads).map(engine).collect::<PyResult<_>>()?;
        Ok(Self { engines, process: std::process::id() })
    }

    /// Ranks scenarios, in any order of time, and returns them in their order.
    fn ranked(
        &self,
        py: Python<'_>,
        scenarios: Vec<Bound<'_, ScenarioText>>,
        policies: Option<Vec<PathBuf>>,
        wanted: Wanted,
        keep_going: bool,
    ) -> PyResult<RankedScenes> {
        let record = wanted.record.clone();
        let limits = wanted.limits().map_err(|failure| raise(py, &failure))?;
        let mut all = Vec::new();
        for scenario in &scenarios {
            let scenario = scenario.get();
            match &policies {
                None => all.push(scenario.scenario.clone()),
                Some(policies) => {
                    for policy in policies {
                        let judged = scenario.judged_by(policy);
                        all.push(judged.map_err(|failure| raise(py, &failure))?.scenario);
                    }
                }
            }
        }
        if let Some(folder) = &record {
            Record::prepare(folder).map_err(|failure| raise(py, &failure))?;
        }
        let ranked = |found| match found {
            Found::Ranked(outcome) => Some(Arc::new(*outcome)),
            Found::Searched(_) => None,
        };
        let outcomes = self.run(py, all, limits, Task::Rank(record), ranked)?;
        if !keep_going {
            raise_first(py, "scenarios", &outcomes)?;
        }
        Ok(RankedScenes { outcomes })
    }

    /// Searches scenarios, and returns them in their order.
    fn searched(
        &self,
        py: Python<'_>,
        scenarios: Vec<Bound<'_, ScenarioText>>,
        members: Option<i64>,
        members_max: Option<i64>,
    ) -> PyResult<Vec<SearchedScene>> {
        let limits = match members {
            None => Ok(Limits::default()),
            Some(members) => Limits::default().with_members(members, members_max),
        };
        let limits = limits.map_err(|failure| raise(py, &failure))?;
        let all: Vec<Scenario> = scenarios.iter().map(|one| one.get().scenario.clone()).collect();
        let searched = |found| match found {
            Found::Searched(searched) => Some(*searched),
            Found::Ranked(_) => None,
        };
        let found = self.run(py, all.clone(), limits, Task::Search, searched)?;
        raise_first(py, "scenarios", &found)?;
        let found = found.into_iter().flatten().zip(all);
        Ok(found.map(|(searched, scenario)| SearchedScene::new(searched, scenario)).collect())
    }
}

/// Raises the first failure, with its place in a list, if it has others.
pub(crate) fn raise_first<T>(
    py: Python<'_>,
    list: &str,
    found: &[Result<T, Failure>],
) -> PyResult<()> {
    let failed = |(number, one): (usize, &Result<T, Failure>)| {
        let failure = one.as_ref().err()?.clone();
        Some(if found.len() > 1 { failure.at(format!("{list}[{number}]")) } else { failure })
    };
    match found.iter().enumerate().find_map(failed) {
        Some(failure) => Err(raise(py, &failure)),
        None => Ok(()),
    }
}

impl Wanted {
    fn limits(&self) -> Result<Limits, Failure> {
        let until = Until::ALL.into_iter().find(|until| until.name() == self.until);
        let until = until.ok_or_else(|| {
            let failure = Failure::setting(format!("until: \"{}\" is no such moment", self.until));
            failure.with_remedy("\"complete\", \"ordered\" or \"certified\"")
        })?;
        let mut limits = Limits::default().until(until);
        if let Some(ms) = self.deadline_ms {
            limits = limits.with_deadline_ms(ms)?;
        }
        if let Some(members) = self.members {
            limits = limits.with_members(members, self.members_max)?;
        }
        if let Some(worlds) = drawn_worlds(self.worlds, self.worlds_seed)? {
            limits = limits.with_worlds(worlds);
        }
        Ok(match (&self.record, self.explain) {
            (Some(_), _) => limits.with_record(),
            (None, true) => limits.with_explanation(),
            (None, false) => limits,
        })
    }
}

/// The worlds of a seed; `None`: the usual ones.
pub(crate) fn drawn_worlds(count: Option<i64>, seed: u32) -> Result<Option<Worlds>, Failure> {
    if count.is_none() && seed == 0 {
        return Ok(None);
    }
    let count = count.unwrap_or(i64::from(Worlds::USUAL.count));
    Ok(Some(Worlds::new(count, seed)?))
}

impl RankingSession {
    fn run<T>(
        &self,
        py: Python<'_>,
        scenarios: Vec<Scenario>,
        limits: Limits,
        task: Task,
        wanted: impl Fn(Found) -> Option<T>,
    ) -> PyResult<Vec<Result<T, Failure>>> {
        if self.process != std::process::id() {
            let failure = Failure::new(FailureKind::System, "a session does not survive a fork");
            let remedy = "make a Session in the child, or start it with the method \"spawn\"";
            return Err(raise(py, &failure.with_remedy(remedy)));
        }
        let count = scenarios.len();
        let (done, outcomes) = mpsc::channel();
        // The lock lends it to a thread without Python's; nobody else ever waits for it.
        let outcomes = Mutex::new(outcomes);
        let (next, is_stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        let batch = Arc::new(Batch { scenarios, limits, task, next, is_stopped, done });
        for engine in self.engines.iter().take(count) {
            // An engine that ended takes no tasks: the others do them, or none are done below.
            engine.send(Arc::clone(&batch)).ok();
        }
        let mut found: Vec<Option<Result<Found, Failure>>> = (0..count).map(|_| None).collect();
        let mut missing = count;
        // The sender in the batch goes with the last engine that has it.
        let stop = Arc::downgrade(&batch);
        drop(batch);
        while missing > 0 {
            if let Err(interrupt) = py.check_signals() {
                if let Some(batch) = stop.upgrade() {
                    batch.is_stopped.store(true, Ordering::Relaxed);
                }
                return Err(interrupt);
            }
            let receive =
                || outcomes.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK);
            let received = py.detach(receive);
            match received {
                Ok((number, outcome)) => {
                    found[number] = Some(outcome);
                    missing -= 1;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        let ended = || Failure::internal("an engine ended without an answer");
        let taken = |one: Option<Result<Found, Failure>>| {
            one.unwrap_or_else(|| Err(ended())).and_then(|found| wanted(found).ok_or_else(ended))
        };
        Ok(found.into_iter().map(taken).collect())
    }
}

/// Starts the thread of an engine, which ends with its session.
fn start(cache_bytes: usize) -> Result<Sender<Arc<Batch>>, Failure> {
    let (sender, batches) = mpsc::channel::<Arc<Batch>>();
    let builder = Engine::builder().in_process().body_cache(cache_bytes);
    let serve = move || {
        let Ok(mut engine) = builder.build() else { return };
        for batch in batches {
            serve(&mut engine, &batch);
        }
    };
    let started = std::thread::Builder::new().name("trolley".to_owned()).spawn(serve);
    let failed = |error| {
        let failure = Failure::new(FailureKind::Resources, format!("no thread: {error}"));
        failure.with_remedy("use fewer threads")
    };
    started.map(|_| sender).map_err(failed)
}

/// Does the tasks of a batch until none is left or somebody stops it.
fn serve(engine: &mut Engine, batch: &Batch) {
    while !batch.is_stopped.load(Ordering::Relaxed) {
        let number = batch.next.fetch_add(1, Ordering::Relaxed);
        let Some(scenario) = batch.scenarios.get(number) else { break };
        let found = match &batch.task {
            Task::Rank(record) => rank(engine, scenario, &batch.limits, record.as_deref())
                .map(|outcome| Found::Ranked(Box::new(outcome))),
            Task::Search => engine
                .search(scenario, &batch.limits)
                .map(|searched| Found::Searched(Box::new(searched))),
        };
        if batch.done.send((number, found)).is_err() {
            break;
        }
    }
}

fn rank(
    engine: &mut Engine,
    scenario: &Scenario,
    limits: &Limits,
    record: Option<&Path>,
) -> Result<Outcome, Failure> {
    let ranking = engine.rank(scenario, limits)?;
    let internal = |error: serde_json::Error| Failure::internal(error.to_string());
    let record = record.map(|folder| Record::write(folder, &ranking)).transpose()?;
    let explanation = ranking.explanation.as_ref().map(serde_json::to_string).transpose();
    Ok(Outcome {
        scene: None,
        name: scenario.parsed().name.clone(),
        curves: scenario.criteria().curves.name.clone(),
        json: serde_json::to_string(&ranking.answer).map_err(internal)?,
        explanation: explanation.map_err(internal)?,
        run: Some(serde_json::to_string(&ranking.run).map_err(internal)?),
        answer: ranking.answer,
        record,
    })
}
