//! Prints the laboratory's reports.

use crate::output::Output;
use crate::print;
use serde::Serialize;
use std::process::ExitCode;
use trolley::Failure;

/// Prints a report, as JSON or as text.
pub(crate) fn show(
    report: &impl Serialize,
    text: impl FnOnce() -> String,
    output: &Output,
) -> Result<ExitCode, Failure> {
    if output.json { print::out(&print::json(report)?) } else { print::lines(&text()) }
}
