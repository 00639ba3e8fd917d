//! How reports of the laboratory are printed.

use crate::output::Output;
use crate::print;
use serde::Serialize;
use std::process::ExitCode;
use trolley::Failure;

/// Prints a report, as a document or as text.
pub(crate) fn show(
    report: &impl Serialize,
    text: impl FnOnce() -> String,
    output: &Output,
) -> Result<ExitCode, Failure> {
    print::out(&if output.json { print::json(report)? } else { text() })
}
