//! The commands of the laboratory: flags, one call of the crate `lab`, print.

pub(crate) mod calibrate;
pub(crate) mod certify;
pub(crate) mod inject;
pub(crate) mod measure;
pub(crate) mod simulate;

use crate::output::Output;
use crate::print;
use clap::builder::{PossibleValuesParser, TypedValueParser};
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

/// Reads one of these, by its name.
fn named<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name)).try_map(move |word: String| {
        all.into_iter().find(|one| name(*one) == word).ok_or("there is nothing of that name")
    })
}
