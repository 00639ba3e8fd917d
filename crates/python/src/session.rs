//! `Session`: engines that rank, each in a thread of its own, with the bodies that they keep.
//!
//! ```text
//! rank, rank_many --Batch--> the engines' threads: each takes the next task --> Outcome
//! ```
//!
//! An engine lives where it was made. What a thread finds is text by the time it comes back, so
//! Python's lock is held only to hand it over.

use crate::errors::{raise, refuse};
use crate::scenario::ScenarioText;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use trolley::{Answer, Engine, Failure, FailureKind, Limits, Record, Scenario, Until};

/// Most engines of a session.
const ENGINES_MAX: usize = 64;

/// How long to wait for outcomes until the next look for signals, such as Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Rankings to be made, by whichever engine is free.
struct Batch {
    scenarios: Vec<Scenario>,
    limits: Limits,
    record: Option<PathBuf>,
    next: AtomicUsize,
    is_stopped: AtomicBool,
    done: Sender<(usize, Result<Outcome, Failure>)>,
}

/// A ranking, ready to be handed to Python.
pub(crate) struct Outcome {
    pub(crate) name: String,
    pub(crate) answer: Answer,
    json: String,
    explanation: Option<String>,
    run: String,
    record: Option<PathBuf>,
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
        let outcomes = self.run(py, all, limits, record)?;
        let failed = |(number, one): (usize, &Result<Outcome, Failure>)| {
            let failure = one.as_ref().err()?.clone();
            Some(if outcomes.len() > 1 {
                failure.at(format!("scenarios[{number}]"))
            } else {
                failure
            })
        };
        if !keep_going && let Some(failure) = outcomes.iter().enumerate().find_map(failed) {
            return Err(raise(py, &failure));
        }
        let shared = |one: Result<Outcome, Failure>| one.map(Arc::new);
        Ok(RankedScenes { outcomes: outcomes.into_iter().map(shared).collect() })
    }
}

impl Wanted {
    fn limits(&self) -> Result<Limits, Failure> {
        let until = match self.until.as_str() {
            "complete" => Until::Complete,
            "ordered" => Until::Ordered,
            "certified" => Until::Certified,
            other => {
                let failure = Failure::setting(format!("until: \"{other}\" is no such moment"));
                return Err(failure.with_remedy("\"complete\", \"ordered\" or \"certified\""));
            }
        };
        let mut limits = Limits::default().until(until);
        if let Some(ms) = self.deadline_ms {
            limits = limits.with_deadline_ms(ms)?;
        }
        if let Some(members) = self.members {
            limits = limits.with_members(members, self.members_max)?;
        }
        Ok(match (&self.record, self.explain) {
            (Some(_), _) => limits.with_record(),
            (None, true) => limits.with_explanation(),
            (None, false) => limits,
        })
    }
}

impl RankingSession {
    fn run(
        &self,
        py: Python<'_>,
        scenarios: Vec<Scenario>,
        limits: Limits,
        record: Option<PathBuf>,
    ) -> PyResult<Vec<Result<Outcome, Failure>>> {
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
        let batch = Arc::new(Batch { scenarios, limits, record, next, is_stopped, done });
        for engine in self.engines.iter().take(count) {
            // An engine that ended takes no tasks: the others do them, or none are done below.
            engine.send(Arc::clone(&batch)).ok();
        }
        let mut found: Vec<Option<Result<Outcome, Failure>>> = (0..count).map(|_| None).collect();
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
        let ended = || Err(Failure::internal("an engine ended without an answer"));
        Ok(found.into_iter().map(|one| one.unwrap_or_else(ended)).collect())
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

/// Makes rankings until none is left or somebody stops it.
fn serve(engine: &mut Engine, batch: &Batch) {
    while !batch.is_stopped.load(Ordering::Relaxed) {
        let number = batch.next.fetch_add(1, Ordering::Relaxed);
        let Some(scenario) = batch.scenarios.get(number) else { break };
        let outcome = rank(engine, scenario, &batch.limits, batch.record.as_deref());
        if batch.done.send((number, outcome)).is_err() {
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
        name: scenario.parsed().name.clone(),
        json: serde_json::to_string(&ranking.answer).map_err(internal)?,
        explanation: explanation.map_err(internal)?,
        run: serde_json::to_string(&ranking.run).map_err(internal)?,
        answer: ranking.answer,
        record,
    })
}

/// A scenario, ranked.
#[pyclass(name = "Ranking", module = "trolley_av", frozen)]
pub(crate) struct RankedScene {
    outcome: Arc<Outcome>,
}

fn loads<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

#[pymethods]
impl RankedScene {
    /// The name of the scenario.
    #[getter]
    fn scenario(&self) -> &str {
        &self.outcome.name
    }

    /// The answer as JSON: what `trolley rank --json` prints as "answer", without white space.
    #[getter]
    fn json<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.outcome.json.as_bytes())
    }

    /// The answer as a new dict, with the keys of `json`.
    #[getter]
    fn answer<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        loads(py, &self.outcome.json)
    }

    /// Every figure from contact to rank, if it was asked for.
    #[getter]
    fn explanation<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.outcome.explanation.as_ref().map(|text| loads(py, text)).transpose()
    }

    /// How the work was done: times and counts, different each time.
    #[getter]
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        loads(py, &self.outcome.run)
    }

    /// The path of the decision record, if one was asked for.
    #[getter]
    fn record(&self) -> Option<&Path> {
        self.outcome.record.as_deref()
    }

    /// "complete", "certified" (what is open cannot change the winner), "degraded" or "refused".
    #[getter]
    fn state(&self) -> &'static str {
        self.outcome.answer.state.name()
    }

    /// The name of the policy.
    #[getter]
    fn policy(&self) -> &str {
        &self.outcome.answer.policy
    }

    /// The name of the candidate of least harm; None if there is none.
    #[getter]
    fn best(&self) -> Option<&str> {
        self.outcome.answer.best().map(|best| best.name.as_str())
    }

    fn __repr__(&self) -> String {
        let best = self.best().unwrap_or("nobody");
        let (state, policy) = (self.state(), self.policy());
        format!(
            "<trolley_av.Ranking of \"{}\" under {policy}: {state}, best: {best}>",
            self.scenario()
        )
    }
}

/// Scenarios, ranked, in their order: a sequence of `Ranking`, and an Arrow table of candidates.
///
/// pyarrow, Polars, pandas and DuckDB read it in place: ``pyarrow.table(rankings)`` has a row for
/// each candidate. `work_lo` and `work_hi` bound the policy's leading measure by what is known of
/// the work, `range_low` and `range_high` by what the model does not know; times are in s.
#[pyclass(name = "Rankings", module = "trolley_av", frozen)]
pub(crate) struct RankedScenes {
    pub(crate) outcomes: Vec<Result<Arc<Outcome>, Failure>>,
}

#[pymethods]
impl RankedScenes {
    fn __len__(&self) -> usize {
        self.outcomes.len()
    }

    fn __getitem__(&self, py: Python<'_>, index: isize) -> PyResult<RankedScene> {
        let number = if index < 0 { index + self.outcomes.len() as isize } else { index };
        let outcome = usize::try_from(number).ok().and_then(|number| self.outcomes.get(number));
        match outcome {
            None => Err(PyIndexError::new_err(format!("there is no ranking {index}"))),
            Some(Err(failure)) => Err(raise(py, failure)),
            Some(Ok(outcome)) => Ok(RankedScene { outcome: Arc::clone(outcome) }),
        }
    }

    /// Number and message of each scenario that could not be ranked.
    #[getter]
    fn failures(&self) -> Vec<(usize, String)> {
        let failure = |(number, one): (usize, &Result<Arc<Outcome>, Failure>)| {
            Some((number, one.as_ref().err()?.to_string()))
        };
        self.outcomes.iter().enumerate().filter_map(failure).collect()
    }

    #[cfg(feature = "arrow")]
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, pyo3::types::PyCapsule>> {
        // A reader that cannot take what it gets casts it itself: the protocol allows that.
        let _ = requested_schema;
        crate::table::stream(py, self)
    }
}
