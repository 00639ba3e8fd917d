//! Holds the model of impact and injury against crash tests, and against orderings that any sane
//! model satisfies.
//!
//! A file of crash tests (JSON) says what was driven into what, how fast, and the change of
//! velocity that was measured; each test becomes a scene that the whole engine ranks. A file of
//! orderings (TOML) has scenes and inequalities between figures of their answers, each with its
//! reason and its source; those that fail are shown as failing.
//!
//! Parameters were fitted on some of the same tests: for these, each test is also computed with the
//! parameter that fits the others best (leave one out).

use crate::progress::{Progress, SyncProgress};
use damage::parameters::DEFAULT_PARAMETERS;
use damage::{Criteria, Parameters, Policy};
use runtime::input::InputKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trolley::{Failure, SourceText, files};

mod crash_test;
mod object;
mod ordering;
mod report;

pub use crash_test::{Group, LeftOut, Validated};
pub use ordering::Ordered;
pub use report::ValidateReport;

/// What to validate.
#[derive(Clone, Debug, Default)]
pub struct ValidateOptions {
    /// Crash tests (`.json`), orderings (`.toml`) and folders of them.
    pub files: Vec<PathBuf>,
    /// Parameters of contact and dynamics; `None`: the shipped ones.
    pub parameters: Option<PathBuf>,
}

/// Validates. `told` is called with the number of scenes done.
///
/// # Errors
///
/// If a file cannot be read or is not valid, or a scene cannot be ranked. A figure that is far off,
/// and an ordering that fails, is no error: see [`ValidateReport::is_right`].
pub fn validate(
    options: &ValidateOptions,
    told: SyncProgress<'_>,
) -> Result<ValidateReport, Failure> {
    let source = match &options.parameters {
        None => SourceText {
            name: "config/parameters/default.toml".to_owned(),
            text: DEFAULT_PARAMETERS.to_owned(),
        },
        Some(path) => SourceText {
            name: path.display().to_string(),
            text: files::text(path, InputKind::Parameters)?,
        },
    };
    let parameters = Parameters::parse(&source.name, &source.text)?;
    let criteria = Criteria::with_policy(Policy::shipped()?)?;
    let criteria = Criteria { parameters: Arc::new(parameters), ..criteria };
    let mut tests = Vec::new();
    let mut orderings = Vec::new();
    for path in found(&options.files)? {
        let name = path.display().to_string();
        let text = files::text(&path, InputKind::Measurement)?;
        if is_orderings(&path) {
            orderings.extend(ordering::read(&name, &text)?);
        } else {
            tests.extend(crash_test::read(&name, &text)?);
        }
    }
    if tests.is_empty() && orderings.is_empty() {
        return Err(Failure::setting("there is nothing to validate")
            .with_remedy("name a file of crash tests (.json) or of orderings (.toml)"));
    }
    let bar = Progress::new((tests.len() + orderings.len()) as u64, told);
    let (tests, groups) = crash_test::run(&tests, &criteria, &bar)?;
    orderings.sort_by(|a, b| a.name.cmp(&b.name));
    let orderings = ordering::run(&orderings, &source, &bar)?;
    let parameters = criteria.parameters.name.clone();
    Ok(ValidateReport { schema: "trolley.validate/1", parameters, tests, groups, orderings })
}

fn is_orderings(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// The files named, and those in folders, sorted.
fn found(named: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for path in named {
        if !path.is_dir() {
            all.push(path.clone());
            continue;
        }
        let entries = std::fs::read_dir(path)
            .map_err(|error| Failure::input(error.to_string()).at(path.display()))?;
        let mut inside: Vec<PathBuf> = Vec::new();
        for entry in entries {
            let entry =
                entry.map_err(|error| Failure::input(error.to_string()).at(path.display()))?;
            inside.push(entry.path());
        }
        inside.retain(|path| is_orderings(path));
        inside.sort();
        all.append(&mut inside);
    }
    Ok(all)
}
