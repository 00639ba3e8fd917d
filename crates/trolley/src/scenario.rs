//! What is asked: a scenario with the policy and the curves that judge it, as texts with their
//! names and as checked values.
//!
//! Texts come from files, from a caller or from a decision record; all are read and checked alike.

use crate::{Failure, FailureKind};
use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use scenario::FileRef;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The scenario that `trolley demo` ranks; its bodies are generated.
const DEMO: &str = include_str!("../config/scenarios/demo.toml");
/// Its name.
const DEMO_NAME: &str = "config/scenarios/demo.toml";

/// A text and the name to blame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// Where it is from: a path, usually.
    pub name: String,
    /// The text.
    pub text: String,
}

/// The three texts of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texts {
    /// Parties and candidates.
    pub scenario: SourceText,
    /// By what candidates are compared.
    pub policy: SourceText,
    /// Injury risk curves.
    pub curves: SourceText,
}

/// What is to be ranked, and by what it will be judged: read and checked.
#[derive(Clone, Debug)]
pub struct Scenario {
    pub(crate) texts: Texts,
    pub(crate) parsed: scenario::Scenario,
    pub(crate) policy: Arc<Policy>,
    pub(crate) curves: Arc<Curves>,
    pub(crate) unknown_is_fixed: bool,
}

impl Scenario {
    /// The scenario that comes with the program: seven crashes between generated bodies.
    ///
    /// # Errors
    ///
    /// Never: tests see to that.
    pub fn demo() -> Result<Self, Failure> {
        Self::parse(DEMO_NAME, DEMO)
    }

    /// Reads a scenario file, and the policy and curves that it names.
    ///
    /// # Errors
    ///
    /// If a file cannot be read or is not sound: file, place, fault and remedy.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Failure> {
        let path = path.as_ref();
        Self::parse(&path.display().to_string(), &read_text(path)?)
    }

    /// Reads a scenario's text. Files that it names are found from the folder of `name`; where it
    /// names none, the policy and the curves are those that come with the program.
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn parse(name: &str, text: &str) -> Result<Self, Failure> {
        let parsed = scenario::Scenario::parse(name, text)?;
        let or_shipped = |reference: &Option<FileRef>, shipped: &str, text: &str| match reference {
            Some(reference) => named(Path::new(name), reference),
            None => Ok(SourceText { name: shipped.to_owned(), text: text.to_owned() }),
        };
        let texts = Texts {
            policy: or_shipped(&parsed.policy, "config/policies/default.toml", DEFAULT_POLICY)?,
            curves: or_shipped(&parsed.curves, "config/curves/default.toml", DEFAULT_CURVES)?,
            scenario: SourceText { name: name.to_owned(), text: text.to_owned() },
        };
        Self::of_texts(texts)
    }

    /// Reads and checks all three texts.
    ///
    /// # Errors
    ///
    /// As [`Scenario::open`].
    pub fn of_texts(texts: Texts) -> Result<Self, Failure> {
        let parsed = scenario::Scenario::parse(&texts.scenario.name, &texts.scenario.text)?;
        let policy = Policy::parse(&texts.policy.name, &texts.policy.text)?;
        let curves = Curves::parse(&texts.curves.name, &texts.curves.text)?;
        let covered = curves.covers(policy.outcome);
        covered.map_err(|missing| Failure::input(missing.to_string()))?;
        let (policy, curves) = (Arc::new(policy), Arc::new(curves));
        Ok(Self { texts, parsed, policy, curves, unknown_is_fixed: false })
    }

    /// The same, taking parties of unknown kind as fixed to the ground, with nobody in them; the
    /// answer says so.
    #[must_use]
    pub fn assuming_unknown_is_fixed(self) -> Self {
        Self { unknown_is_fixed: true, ..self }
    }

    /// What the file says.
    #[must_use]
    pub fn parsed(&self) -> &scenario::Scenario {
        &self.parsed
    }

    /// The name of the file, for messages.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.texts.scenario.name
    }

    /// By what candidates are compared, and the curves for it.
    #[must_use]
    pub fn rules(&self) -> (Arc<Policy>, Arc<Curves>) {
        (self.policy.clone(), self.curves.clone())
    }

    /// Where a model file that the scenario names is.
    #[must_use]
    pub fn path_of(&self, reference: &FileRef) -> PathBuf {
        beside(Path::new(self.file()), &reference.path)
    }

    /// Refuses what nobody knows, unless something may be assumed of it.
    pub(crate) fn check_unknown(&self) -> Result<(), Failure> {
        let Some(party) = self.parsed.parties.iter().find(|party| party.is_unknown) else {
            return Ok(());
        };
        if self.unknown_is_fixed {
            return Ok(self.parsed.check_fixed(self.file())?);
        }
        let fault = format!("\"{}\" is of unknown kind", party.name);
        Err(Failure::new(FailureKind::Refused, fault)
            .at(format!("{}:{}", self.file(), party.place))
            .with_remedy(
                "say what it is, or let it be taken as fixed to the ground with nobody in it: \
                 --assume unknown=fixed",
            ))
    }
}

/// A path that a file names, relative to the folder of that file.
fn beside(file: &Path, path: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(path)
}

/// Reads a text file that a person wrote.
///
/// # Errors
///
/// If it cannot be read, is too long for what a person writes, or is no text.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(path.display());
    let length = std::fs::metadata(path).map_err(wrong)?.len();
    if length > scenario::TEXT_BYTES_MAX as u64 {
        return Err(Failure::input(format!("{length} bytes are too many"))
            .at(path.display())
            .with_remedy("is this the right file?"));
    }
    std::fs::read_to_string(path).map_err(wrong)
}

/// The text of a file that the scenario names.
fn named(scenario: &Path, reference: &FileRef) -> Result<SourceText, Failure> {
    let path = beside(scenario, &reference.path);
    let place = format!("{}:{}", scenario.display(), reference.place);
    let text = read_text(&path).map_err(|failure| failure.at(place))?;
    Ok(SourceText { name: path.display().to_string(), text })
}
