//! The texts of a request, each with its name: the scenario, and what it is judged by, named by a
//! scenario or a deployment, or built in.

use crate::Failure;
use crate::files::{self, InputKind};
use damage::injury::DEFAULT_CURVES;
use damage::parameters::DEFAULT_PARAMETERS;
use damage::policy::DEFAULT_POLICY;
use damage::{Criteria, Curves, Parameters, Policy};
use std::path::Path;
use std::sync::Arc;

/// A text and its name in messages.
///
/// ```
/// use trolley::{SourceText, read_text};
///
/// let name = "../../config/policies/default.toml";
/// let policy = SourceText { name: name.to_owned(), text: read_text(name.as_ref())? };
/// assert!(policy.text.contains("composition"));
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceText {
    /// Where it comes from, usually a path.
    pub name: String,
    /// The text.
    pub text: String,
}

/// The texts of a request, but for the paths that the scenario names.
///
/// ```
/// use trolley::{Scenario, SourceText, Texts, read_text};
///
/// let read = |path: &str| {
///     Ok::<_, trolley::Failure>(SourceText { name: path.into(), text: read_text(path.as_ref())? })
/// };
/// let texts = Texts {
///     scenario: read("../../config/scenarios/small.toml")?,
///     policy: read("../../config/policies/precaution.toml")?,
///     curves: read("../../config/curves/default.toml")?,
///     parameters: read("../../config/parameters/default.toml")?,
/// };
/// assert_eq!(Scenario::of_texts(texts, Vec::new())?.criteria().policy.name, "precaution");
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texts {
    /// Parties and candidates.
    pub scenario: SourceText,
    /// How candidates are compared.
    pub policy: SourceText,
    /// Injury risk curves.
    pub curves: SourceText,
    /// Parameters of contact and dynamics.
    pub parameters: SourceText,
}

/// A text that candidates are judged by.
pub(crate) struct Part {
    /// The key that names its file.
    pub(crate) key: &'static str,
    kind: InputKind,
    /// Name and text of the built-in one.
    shipped: (&'static str, &'static str),
}

pub(crate) const POLICY: Part = Part {
    key: "policy",
    kind: InputKind::Policy,
    shipped: ("config/policies/default.toml", DEFAULT_POLICY),
};

pub(crate) const CURVES: Part = Part {
    key: "curves",
    kind: InputKind::Curves,
    shipped: ("config/curves/default.toml", DEFAULT_CURVES),
};

pub(crate) const PARAMETERS: Part = Part {
    key: "parameters",
    kind: InputKind::Parameters,
    shipped: ("config/parameters/default.toml", DEFAULT_PARAMETERS),
};

impl Part {
    /// The built-in one.
    pub(crate) fn shipped(&self) -> SourceText {
        let (name, text) = self.shipped;
        SourceText { name: name.to_owned(), text: text.to_owned() }
    }

    /// The one in a file.
    pub(crate) fn read(&self, path: &Path) -> Result<SourceText, Failure> {
        let text = files::text(path, self.kind)?;
        Ok(SourceText { name: path.display().to_string(), text })
    }
}

impl Texts {
    pub(crate) fn criteria(&self) -> Result<Criteria, Failure> {
        criteria([&self.policy, &self.curves, &self.parameters])
    }
}

/// A policy, curves that cover it, and parameters, from their texts.
pub(crate) fn criteria(
    [policy, curves, parameters]: [&SourceText; 3],
) -> Result<Criteria, Failure> {
    let policy = Policy::parse(&policy.name, &policy.text)?;
    let curves = Curves::parse(&curves.name, &curves.text)?;
    let parameters = Parameters::parse(&parameters.name, &parameters.text)?;
    let covered = curves.covers(policy.outcome);
    covered.map_err(|missing| Failure::input(missing.to_string()))?;
    let (policy, curves) = (Arc::new(policy), Arc::new(curves));
    Ok(Criteria { policy, curves, parameters: Arc::new(parameters) })
}

/// Reads a text of the length of a scenario: see [`files::text`].
///
/// ```
/// let text = trolley::read_text("../../config/policies/default.toml".as_ref())?;
/// assert!(text.contains("schema"));
/// assert!(trolley::read_text("no-such-file.toml".as_ref()).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If it cannot be read, is no regular file, is too long, or is not text.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    files::text(path, InputKind::Scenario)
}
