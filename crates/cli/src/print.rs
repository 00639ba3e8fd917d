//! The only place that writes to stdout and stderr.

use report::text::{COLUMNS, fold, wrap};
use serde::Serialize;
use std::io::{IsTerminal as _, Write as _};
use std::process::ExitCode;
use trolley::{Failure, FailureKind};

/// Prints a result and a line feed.
pub(crate) fn out(text: &str) -> Result<ExitCode, Failure> {
    out_bytes(format!("{}\n", text.trim_end()).as_bytes())
}

/// Prints sentences: lines break at the width of the terminal, or at [`COLUMNS`].
pub(crate) fn text(text: &str) -> Result<ExitCode, Failure> {
    let columns = columns().unwrap_or(COLUMNS);
    out(&text.split('\n').map(|line| wrap(line, columns)).collect::<Vec<_>>().join("\n"))
}

/// Prints lines of labels and values; they break at the width of the terminal, if there is one.
pub(crate) fn lines(text: &str) -> Result<ExitCode, Failure> {
    out(&folded(text))
}

/// Lines of labels and values, broken as by [`lines`].
pub(crate) fn folded(text: &str) -> String {
    columns().map_or_else(|| text.to_owned(), |columns| fold(text, columns))
}

/// The width of the terminal that reads stdout: `COLUMNS`, if that is set; `None` if no terminal
/// reads it.
pub(crate) fn columns() -> Option<usize> {
    /// Narrower, no table can be read; wider, no line.
    const RANGE: [usize; 2] = [40, 120];
    let said = std::env::var_os("COLUMNS").and_then(|said| said.to_str()?.parse::<usize>().ok());
    let term = || console::Term::stdout().size_checked().map(|(_, columns)| columns.into());
    let columns = said.filter(|columns| *columns > 0).or_else(term)?;
    Some(columns.clamp(RANGE[0], RANGE[1]))
}

/// A document as readable JSON.
pub(crate) fn json(document: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(document).map_err(|error| Failure::internal(error.to_string()))
}

/// A document as JSON on one line, for programs.
pub(crate) fn line(document: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(document).map_err(|error| Failure::internal(error.to_string()))
}

/// Prints a result as it is. A closed pipe is no error.
pub(crate) fn out_bytes(bytes: &[u8]) -> Result<ExitCode, Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(ExitCode::SUCCESS),
        Err(error) => Err(failed(error)),
        Ok(()) => Ok(ExitCode::SUCCESS),
    }
}

/// Prints a page of many; returns whether somebody reads on: a closed pipe is no error.
pub(crate) fn page(text: &str) -> Result<bool, Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(failed(error)),
        Ok(()) => Ok(true),
    }
}

/// The failure to write to stdout.
pub(crate) fn failed(error: std::io::Error) -> Failure {
    Failure::new(FailureKind::System, format!("cannot write the output: {error}"))
}

/// Prints a line for the person at the terminal.
pub(crate) fn err(text: &str) {
    // If stderr is gone, there is nowhere to report it.
    let _gone = writeln!(std::io::stderr().lock(), "{text}");
}

/// Whether stderr supports colours: it is a terminal, and NO_COLOR is not set.
pub(crate) fn is_colourful() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}
