//! Studies: the functions that every engine calls, each about the folder of a study.
//!
//! What they return is JSON, which the Python part reads.

use crate::errors::raise;
use pyo3::prelude::*;
use serde::Serialize;
use std::num::NonZeroU64;
use std::path::PathBuf;
use trolley::Failure;

/// What a function found, as JSON, with Python's lock released while it works.
fn told<T: Serialize>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> PyResult<String> {
    let text = py.detach(|| {
        let found = work()?;
        serde_json::to_string(&found).map_err(|error| Failure::internal(error.to_string()))
    });
    text.map_err(|failure| raise(py, &failure))
}

/// Plans a study, and says how far it is.
#[pyfunction]
pub(crate) fn study_plan(py: Python<'_>, spec: PathBuf, folder: PathBuf) -> PyResult<String> {
    told(py, || {
        study::plan(&spec, &folder)?;
        study::status(&folder)
    })
}

/// How far a study is.
#[pyfunction]
pub(crate) fn study_status(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    told(py, || study::status(&folder))
}

/// Holds every byte against what was written.
#[pyfunction]
pub(crate) fn study_check(
    py: Python<'_>,
    folder: PathBuf,
    redo: bool,
    ranked_every: Option<NonZeroU64>,
) -> PyResult<String> {
    told(py, || study::check(&folder, redo, ranked_every, &|_, _| {}))
}

/// Runs a shard.
#[pyfunction]
pub(crate) fn study_run_shard(py: Python<'_>, folder: PathBuf, shard: u32) -> PyResult<String> {
    told(py, || study::run_shard(&folder, shard))
}
