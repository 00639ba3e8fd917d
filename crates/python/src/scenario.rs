//! `Scenario`: a scene with its candidates, from a file, a text, a dict, or recorded traffic.

use crate::errors::{raise, refuse};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use trolley::traffic::{self, TrafficOptions};
use trolley::{Failure, References, Scenario, policy};

/// A scene with its candidates, its policy and its curves. It never changes: what replaces
/// something returns a new one.
#[pyclass(name = "Scenario", module = "trolley_av", frozen)]
pub(crate) struct ScenarioText {
    pub(crate) scenario: Scenario,
    text: String,
}

fn references(allow_outside: bool) -> References {
    if allow_outside { References::Anywhere } else { References::Inside }
}

#[pymethods]
impl ScenarioText {
    /// Open a scenario (TOML), or recorded traffic: CommonRoad (.xml), or a trace of a simulator.
    ///
    /// Args:
    ///     path: the file.
    ///     allow_outside: whether it may name files outside of its folder.
    ///     ego: of traffic, the name of the ego; None: the one that the file says.
    ///     at_s: of traffic, when the manoeuvres begin (s); None: 1 s before it meets somebody.
    ///     horizon_s: of traffic, how far manoeuvres go (s).
    #[staticmethod]
    #[pyo3(signature = (path, *, allow_outside = false, ego = None, at_s = None, horizon_s = None))]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        allow_outside: bool,
        ego: Option<String>,
        at_s: Option<f64>,
        horizon_s: Option<f64>,
    ) -> PyResult<Self> {
        let references = references(allow_outside);
        let opened = py.detach(|| -> Result<Self, Failure> {
            if !traffic::is_traffic(&path) {
                if ego.is_some() || at_s.is_some() || horizon_s.is_some() {
                    let what = "ego, at_s and horizon_s are about recorded traffic";
                    let failure = Failure::setting(what).at(path.display());
                    return Err(failure.with_remedy("leave them out: a scenario states its own"));
                }
                let text = trolley::read_text(&path).unwrap_or_default();
                return Ok(Self { scenario: Scenario::open_with(&path, references)?, text });
            }
            let options =
                TrafficOptions { ego, at_s, horizon_s, references, ..TrafficOptions::default() };
            let text = traffic::import(&path, &options)?.text;
            let name = path.display().to_string();
            // Its models are those of the library, which was asked already.
            let scenario = Scenario::parse_with(&name, &text, References::Anywhere)?;
            Ok(Self { scenario, text })
        });
        opened.map_err(|failure| raise(py, &failure))
    }

    /// Parse a scenario from TOML. Files that it names are sought beside `name`.
    #[staticmethod]
    #[pyo3(signature = (text, *, name = "scenario.toml", allow_outside = false))]
    fn parse(py: Python<'_>, text: String, name: &str, allow_outside: bool) -> PyResult<Self> {
        let scenario = py.detach(|| Scenario::parse_with(name, &text, references(allow_outside)));
        let scenario = scenario.map_err(|failure| raise(py, &failure))?;
        Ok(Self { scenario, text })
    }

    /// Make a scenario of a dict with the keys of the file: `trolley help keys` lists them.
    ///
    /// Arrays and numbers of numpy may stand in it. Messages name lines of `Scenario.text`.
    #[staticmethod]
    #[pyo3(signature = (scenario, *, name = "scenario.toml", allow_outside = false))]
    fn from_dict(
        py: Python<'_>,
        scenario: &Bound<'_, PyDict>,
        name: &str,
        allow_outside: bool,
    ) -> PyResult<Self> {
        let text = py.import("trolley_av._plain")?.call_method1("toml", (scenario,));
        let text = text.map_err(|error| {
            let remedy = "a scenario has strings, numbers, booleans, lists and dicts, and no None";
            refuse(py, "scenario", &error.value(py).to_string(), remedy)
        })?;
        let text = text.extract()?;
        Self::parse(py, text, name, allow_outside)
    }

    /// Replace the policy: by one in a file, or one that ships (`policy_names`).
    fn with_policy(&self, py: Python<'_>, policy: PathBuf) -> PyResult<Self> {
        self.judged_by(&policy).map_err(|failure| raise(py, &failure))
    }

    /// Replace the curves by those in a file.
    fn with_curves(&self, py: Python<'_>, curves: PathBuf) -> PyResult<Self> {
        let changed = trolley::read_text(&curves).and_then(|text| {
            let name = curves.display().to_string();
            self.scenario.clone().with_curves(trolley::SourceText { name, text })
        });
        let scenario = changed.map_err(|failure| raise(py, &failure))?;
        Ok(Self { scenario, text: self.text.clone() })
    }

    /// Take parties of unknown kind as fixed to the ground, with nobody in them.
    fn assuming_unknown_is_fixed(&self) -> Self {
        let scenario = self.scenario.clone().assuming_unknown_is_fixed();
        Self { scenario, text: self.text.clone() }
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.scenario.parsed().name
    }

    /// The name of its file, for messages.
    #[getter]
    fn file(&self) -> &str {
        self.scenario.file()
    }

    /// Its text (TOML); of traffic, that which was made of it.
    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    /// The name of its policy.
    #[getter]
    fn policy(&self) -> String {
        self.scenario.criteria().policy.name.clone()
    }

    /// The names of its candidates.
    #[getter]
    fn candidates(&self) -> Vec<String> {
        let candidates = &self.scenario.parsed().candidates;
        candidates.iter().map(|candidate| candidate.name.to_string()).collect()
    }

    /// The names of its parties, the ego among them.
    #[getter]
    fn parties(&self) -> Vec<String> {
        self.scenario.parsed().parties.iter().map(|party| party.name.to_string()).collect()
    }

    fn __repr__(&self) -> String {
        let parsed = self.scenario.parsed();
        let (parties, candidates) = (parsed.parties.len(), parsed.candidates.len());
        format!(
            "<trolley_av.Scenario \"{}\": {parties} parties, {candidates} candidates>",
            parsed.name
        )
    }
}

impl ScenarioText {
    /// The same scene under another policy: one that ships, or one in a file.
    pub(crate) fn judged_by(&self, policy: &Path) -> Result<Self, Failure> {
        let policy = trolley::read_policy(policy)?;
        let scenario = self.scenario.clone().with_policy(policy)?;
        Ok(Self { scenario, text: self.text.clone() })
    }
}

/// The names of the policies that ship.
#[pyfunction]
pub(crate) fn policy_names() -> Vec<&'static str> {
    trolley::policy_names().collect()
}

/// What policies and sets of curves say, or what is wrong with them, as JSON.
#[pyfunction]
#[pyo3(signature = (files, *, curves = None))]
pub(crate) fn check_policies(
    py: Python<'_>,
    files: Vec<PathBuf>,
    curves: Option<PathBuf>,
) -> PyResult<String> {
    let checked = py.detach(|| {
        let checked = policy::check(&files, curves.as_deref())?;
        serde_json::to_string(&checked).map_err(|error| Failure::internal(error.to_string()))
    });
    checked.map_err(|failure| raise(py, &failure))
}
