//! `Searched`: a scene that was searched once, and is assessed under many policies and curves.
//!
//! An assessment needs no engine, so it runs in threads of the call, with Python's lock released.

use crate::batch::threads;
use crate::errors::raise;
use crate::ranking::{Outcome, RankedScene, RankedScenes};
use crate::session::{drawn_worlds, raise_first};
use pyo3::prelude::*;
use std::ops::Range;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use trolley::{Failure, Judge, Scenario, Searched, SourceText, Worlds};

/// A scene, searched: whom every candidate meets, where and how, whatever the policy.
#[pyclass(name = "Searched", module = "trolley_av", frozen)]
pub(crate) struct SearchedScene {
    searched: Arc<Searched>,
    scenario: Arc<Scenario>,
}

/// What scenes are assessed by.
#[derive(FromPyObject)]
pub(crate) struct Asked {
    #[pyo3(item)]
    policies: Option<Vec<PathBuf>>,
    #[pyo3(item)]
    curves: Option<Vec<PathBuf>>,
    #[pyo3(item)]
    worlds: Option<i64>,
    #[pyo3(item)]
    worlds_seed: u32,
}

impl SearchedScene {
    pub(crate) fn new(searched: Searched, scenario: Scenario) -> Self {
        Self { searched: Arc::new(searched), scenario: Arc::new(scenario) }
    }

    fn outcome(&self, scene: usize, judge: &Judge, worlds: Worlds) -> Result<Outcome, Failure> {
        let criteria = judge.criteria(&self.scenario)?;
        let answer = self.searched.assess(&criteria, worlds)?;
        let json = serde_json::to_string(&answer);
        Ok(Outcome {
            scene: Some(scene),
            name: self.scenario.parsed().name.clone(),
            curves: criteria.curves.name.clone(),
            json: json.map_err(|error| Failure::internal(error.to_string()))?,
            explanation: None,
            run: None,
            answer,
            record: None,
        })
    }
}

#[pymethods]
impl SearchedScene {
    /// The name of the scenario.
    #[getter]
    fn scenario(&self) -> &str {
        &self.scenario.parsed().name
    }

    /// The names of its candidates.
    #[getter]
    fn candidates(&self) -> Vec<String> {
        let candidates = &self.scenario.parsed().candidates;
        candidates.iter().map(|candidate| candidate.name.to_string()).collect()
    }

    fn __repr__(&self) -> String {
        format!("<trolley_av.Searched \"{}\">", self.scenario())
    }

    /// Assess it under a policy and curves, without geometry.
    ///
    /// Args:
    ///     policy: a path, or the name of a policy that ships; None: that of the scenario.
    ///     curves: the path of a set of curves; None: those of the scenario.
    ///     worlds: number of worlds to draw where all work is done; 0: none; None: 200.
    ///     worlds_seed: which sequence they are points of.
    ///
    /// Returns:
    ///     `Ranking`: that of `Session.rank` with these, and without a deadline, byte for byte.
    #[pyo3(signature = (*, policy = None, curves = None, worlds = None, worlds_seed = 0))]
    fn assess(
        &self,
        py: Python<'_>,
        policy: Option<PathBuf>,
        curves: Option<PathBuf>,
        worlds: Option<i64>,
        worlds_seed: u32,
    ) -> PyResult<RankedScene> {
        let (policies, curves) = (policy.map(|one| vec![one]), curves.map(|one| vec![one]));
        let asked = Asked { policies, curves, worlds, worlds_seed };
        let outcome = py.detach(|| {
            let (judges, worlds) = asked.judges()?;
            self.outcome(0, &judges[0], worlds)
        });
        let outcome = outcome.map_err(|failure| raise(py, &failure))?;
        Ok(RankedScene { outcome: Arc::new(outcome) })
    }
}

impl Asked {
    /// A judge for every policy with every set of curves, and the worlds.
    fn judges(&self) -> Result<(Vec<Judge>, Worlds), Failure> {
        let policy = |path: &PathBuf| trolley::read_policy(path);
        let curves = |path: &PathBuf| {
            let (name, text) = (path.display().to_string(), trolley::read_text(path)?);
            Ok(SourceText { name, text })
        };
        let policies = read(self.policies.as_deref(), policy)?;
        let all_curves = read(self.curves.as_deref(), curves)?;
        let mut judges = Vec::new();
        for policy in &policies {
            for curves in &all_curves {
                judges.push(Judge::new(policy.as_ref(), curves.as_ref())?);
            }
        }
        let worlds = drawn_worlds(self.worlds, self.worlds_seed)?.unwrap_or(Worlds::USUAL);
        Ok((judges, worlds))
    }
}

/// The texts of files; without any, `None` for those of the scenario.
fn read(
    paths: Option<&[PathBuf]>,
    text: impl Fn(&PathBuf) -> Result<SourceText, Failure>,
) -> Result<Vec<Option<SourceText>>, Failure> {
    let Some(paths) = paths else { return Ok(vec![None]) };
    paths.iter().map(|path| text(path).map(Some)).collect()
}

/// Assesses every scene under every policy with every set of curves, in this order.
#[pyfunction]
pub(crate) fn assess_many(
    py: Python<'_>,
    searched: Vec<Bound<'_, SearchedScene>>,
    asked: Asked,
    keep_going: bool,
    threads_asked: usize,
) -> PyResult<RankedScenes> {
    let count = threads(py, threads_asked)?;
    let scenes: Vec<&SearchedScene> = searched.iter().map(Bound::get).collect();
    let (judges, worlds) =
        py.detach(|| asked.judges()).map_err(|failure: Failure| raise(py, &failure))?;
    let outcome = |number: usize| {
        let (scene, judge) = (number / judges.len(), number % judges.len());
        scenes[scene].outcome(scene, &judges[judge], worlds).map(Arc::new)
    };
    let all = scenes.len() * judges.len();
    let mut outcomes = Vec::with_capacity(all);
    for from in (0..all).step_by(BLOCK) {
        py.check_signals()?;
        let block = from..all.min(from + BLOCK);
        outcomes.extend(py.detach(|| in_threads(count, block, &outcome)));
    }
    if !keep_going {
        raise_first(py, "assessments", &outcomes)?;
    }
    Ok(RankedScenes { outcomes })
}

/// Assessments between two looks for signals, such as Ctrl-C.
const BLOCK: usize = 1_024;

/// What a function gives for each number, in their order.
fn in_threads<T: Send>(
    threads: usize,
    numbers: Range<usize>,
    done: &(impl Fn(usize) -> Result<T, Failure> + Sync),
) -> Vec<Result<T, Failure>> {
    let next = AtomicUsize::new(numbers.start);
    let work = || {
        let mut own = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= numbers.end {
                return own;
            }
            own.push((number, done(number)));
        }
    };
    let mut all: Vec<(usize, Result<T, Failure>)> = std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads.min(numbers.len())).map(|_| scope.spawn(work)).collect();
        let own = work();
        let others = others
            .into_iter()
            .flat_map(|other| other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        own.into_iter().chain(others).collect()
    });
    all.sort_by_key(|(number, _)| *number);
    all.into_iter().map(|(_, one)| one).collect()
}
