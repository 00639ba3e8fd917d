//! What a person wrote for one request: scenario, policy, curves, as texts with their names.
//!
//! Texts come from files, or from a decision record; both are read and checked alike.

use damage::injury::DEFAULT_CURVES;
use damage::policy::DEFAULT_POLICY;
use damage::{Curves, Policy};
use diagnostic::Failure;
use scenario::{FileRef, Scenario};
use std::path::Path;

/// A text and the name to blame.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    pub(crate) name: String,
    pub(crate) text: String,
}

/// The three texts of a request.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    pub(crate) scenario: Text,
    pub(crate) policy: Text,
    pub(crate) curves: Text,
}

/// The same, read and checked.
pub(crate) struct Read {
    pub(crate) scenario: Scenario,
    pub(crate) policy: Policy,
    pub(crate) curves: Curves,
}

impl Inputs {
    /// A scenario, and what it names beside itself or, where it names nothing, what is shipped.
    pub(crate) fn of(path: &Path, text: &str) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let scenario = Scenario::parse(&name, text)?;
        let or_shipped = |reference: &Option<FileRef>, name: &str, text: &str| match reference {
            Some(reference) => named(path, reference),
            None => Ok(Text { name: name.to_owned(), text: text.to_owned() }),
        };
        Ok(Self {
            policy: or_shipped(&scenario.policy, "config/policies/default.toml", DEFAULT_POLICY)?,
            curves: or_shipped(&scenario.curves, "config/curves/default.toml", DEFAULT_CURVES)?,
            scenario: Text { name, text: text.to_owned() },
        })
    }

    /// Reads and checks all three.
    pub(crate) fn read(&self) -> Result<Read, Failure> {
        let scenario = Scenario::parse(&self.scenario.name, &self.scenario.text)?;
        let policy = Policy::parse(&self.policy.name, &self.policy.text)?;
        let curves = Curves::parse(&self.curves.name, &self.curves.text)?;
        curves.covers(policy.outcome)?;
        Ok(Read { scenario, policy, curves })
    }
}

/// Reads a text file that a person wrote.
pub(crate) fn text(path: &Path) -> Result<String, Failure> {
    let about = std::fs::metadata(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    if about.len() > scenario::TEXT_BYTES_MAX as u64 {
        let fault = format!("{}: {} bytes are too many", path.display(), about.len());
        return Err(Failure::input(fault).with_remedy("is this the right file?"));
    }
    std::fs::read_to_string(path)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))
}

/// The text of a file that the scenario names.
fn named(path: &Path, reference: &FileRef) -> Result<Text, Failure> {
    let name = path.parent().unwrap_or(Path::new("")).join(&reference.path);
    let place = || format!("{}:{}", path.display(), reference.place);
    let text = text(&name).map_err(|failure| failure.at(place()))?;
    Ok(Text { name: name.display().to_string(), text })
}
