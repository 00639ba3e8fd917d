//! Rankings as Python has them: one by one, in sequences, and as a table.

use crate::errors::raise;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trolley::{Answer, Failure};

/// A ranking, ready to be handed to Python.
pub(crate) struct Outcome {
    /// The number of the scene, if several outcomes are of one.
    #[cfg_attr(not(feature = "arrow"), expect(dead_code, reason = "tables of Arrow have it"))]
    pub(crate) scene: Option<usize>,
    pub(crate) name: String,
    pub(crate) answer: Answer,
    /// The name of the curves.
    pub(crate) curves: String,
    pub(crate) json: String,
    pub(crate) explanation: Option<String>,
    /// How it was made, if by a ranking.
    pub(crate) run: Option<String>,
    pub(crate) record: Option<PathBuf>,
}

/// A scenario, ranked.
#[pyclass(name = "Ranking", module = "trolley_av", frozen)]
pub(crate) struct RankedScene {
    pub(crate) outcome: Arc<Outcome>,
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

    /// How the work was done: times and counts, different each time. None of an assessment.
    #[getter]
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.outcome.run.as_ref().map(|text| loads(py, text)).transpose()
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

    /// The name of the curves.
    #[getter]
    fn curves(&self) -> &str {
        &self.outcome.curves
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
