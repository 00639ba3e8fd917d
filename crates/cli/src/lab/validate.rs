//! `trolley validate`: holds figures against crash tests and orderings.

use super::shown::show;
use crate::output::Output;
use ::lab::validate::{ValidateOptions, validate};
use std::path::PathBuf;
use std::process::ExitCode;
use trolley::{Failure, FailureKind, files};

pub(crate) const EXAMPLES: &str = "\
Examples:
  trolley validate config/orderings
  trolley validate config/orderings --parameters config/parameters/default.toml --json
  trolley validate TESTS.json config/orderings --page impact.md

A file of crash tests is JSON: a list of tests with id, group, size_m [length, width], mass_kg,
speed_m_s, dv_m_s (measured), and angle_deg along a barrier, or object and overlap. A file of
orderings is TOML: see those in config/orderings.

Exit codes: 0 every group is within a bias of 10 % and an rms of 30 %, and all orderings hold;
1 not so.";

#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ValidateArgs {
    /// Crash tests (.json), orderings (.toml), folders of orderings.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Parameters of contact and dynamics [default: those of the program].
    #[arg(long, value_name = "FILE")]
    parameters: Option<PathBuf>,
    /// Also write a page (Markdown) and, beside it, its figure (PNG).
    #[arg(long, value_name = "FILE")]
    page: Option<PathBuf>,
}

pub(crate) fn run(args: &ValidateArgs, output: &Output) -> Result<ExitCode, Failure> {
    let ValidateArgs { files: named, parameters, page } = args.clone();
    let figure = page.as_ref().map(|page| page.with_extension("png"));
    for target in [&page, &figure].into_iter().flatten() {
        files::check(target, None)?;
    }
    let progress = output.progress("scenes");
    let told = |done, total| progress.set(done, total);
    let options = ValidateOptions { files: named, parameters };
    let report = validate(&options, &told)?;
    if let (Some(page), Some(figure)) = (&page, &figure) {
        let named: Vec<String> = options.files.iter().map(|path| short(path)).collect();
        let command = format!("trolley validate {} --page {}", named.join(" "), short(page));
        let link = figure.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let (text, drawn) = report.page(&command, &link)?;
        files::replace(page, text.as_bytes())?;
        if let Some(drawn) = drawn {
            files::replace(figure, &drawn)?;
        }
    }
    let shown = show(&report, || report.text(), output)?;
    Ok(if report.is_right() { shown } else { FailureKind::CheckFailed.into() })
}

/// A path as a page names it: relative ones as they are, others by their name alone.
fn short(path: &std::path::Path) -> String {
    let is_here = path.is_relative() && !path.starts_with("..");
    let name = || path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if is_here { path.display().to_string() } else { name() }
}
