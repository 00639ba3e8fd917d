//! Failures of the library as exceptions of Python, with their place and remedy.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use trolley::{Failure, FailureKind};

/// Where the classes of exceptions are defined, in Python.
const MODULE: &str = "trolley_av._errors";

/// A failure as an exception: `InputError` if what was given is at fault, which is a `ValueError`,
/// else `TrolleyError`.
pub(crate) fn raise(py: Python<'_>, failure: &Failure) -> PyErr {
    let class = match failure.kind() {
        FailureKind::Input | FailureKind::Configuration | FailureKind::Refused => "InputError",
        _ => "TrolleyError",
    };
    made(py, class, failure).unwrap_or_else(|error| error)
}

fn made(py: Python<'_>, class: &str, failure: &Failure) -> PyResult<PyErr> {
    let fields = PyDict::new(py);
    fields.set_item("remedy", failure.remedy())?;
    fields.set_item("exit_code", failure.kind().exit_code())?;
    let class = py.import(MODULE)?.getattr(class)?;
    Ok(PyErr::from_value(class.call((failure.what(),), Some(&fields))?))
}

/// The refusal of an argument, at its place within it.
pub(crate) fn refuse(py: Python<'_>, place: &str, what: &str, remedy: &str) -> PyErr {
    raise(py, &Failure::input(format!("{place}: {what}")).with_remedy(remedy))
}

/// What a crate of the library says, as an exception.
pub(crate) fn raise_diagnostic(py: Python<'_>, error: impl Into<Failure>) -> PyErr {
    raise(py, &error.into())
}
