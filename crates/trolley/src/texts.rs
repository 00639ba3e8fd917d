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
    /// Names and texts of all that ship.
    named: &'static [(&'static str, &'static str)],
}

pub(crate) const POLICY: Part = Part {
    key: "policy",
    kind: InputKind::Policy,
    shipped: ("config/policies/default.toml", DEFAULT_POLICY),
    named: &[
        ("default", DEFAULT_POLICY),
        ("acceptable-or-brake", include_str!("../config/policies/acceptable-or-brake.toml")),
        ("ego-only", include_str!("../config/policies/ego-only.toml")),
        ("precaution", include_str!("../config/policies/precaution.toml")),
        ("uninvolved-first", include_str!("../config/policies/uninvolved-first.toml")),
        ("vulnerable-first", include_str!("../config/policies/vulnerable-first.toml")),
        ("weighted", include_str!("../config/policies/weighted.toml")),
        ("worst-case-averse", include_str!("../config/policies/worst-case-averse.toml")),
        ("worst-off-first", include_str!("../config/policies/worst-off-first.toml")),
    ],
};

pub(crate) const CURVES: Part = Part {
    key: "curves",
    kind: InputKind::Curves,
    shipped: ("config/curves/default.toml", DEFAULT_CURVES),
    named: &[("default", DEFAULT_CURVES), ("levels", include_str!("../config/curves/levels.toml"))],
};

pub(crate) const PARAMETERS: Part = Part {
    key: "parameters",
    kind: InputKind::Parameters,
    shipped: ("config/parameters/default.toml", DEFAULT_PARAMETERS),
    named: &[("default", DEFAULT_PARAMETERS)],
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

    /// The one that ships under a name. A path, which has a dot or a slash, is no name.
    ///
    /// # Errors
    ///
    /// If what looks like a name is none, and no file either.
    pub(crate) fn of_name(&self, written: &Path) -> Result<Option<SourceText>, Failure> {
        let Some(name) = written.to_str().filter(|name| !name.contains(['.', '/'])) else {
            return Ok(None);
        };
        if let Some((_, text)) = self.named.iter().find(|(known, _)| *known == name) {
            let file = format!("{}/{name}.toml", self.folder());
            return Ok(Some(SourceText { name: file, text: (*text).to_owned() }));
        }
        if written.exists() {
            return Ok(None);
        }
        let known: Vec<&str> = self.named.iter().map(|(known, _)| *known).collect();
        let key = self.key;
        Err(Failure::input(format!(
            "no {key} of the name \"{name}\" ships, and there is no such file"
        ))
        .with_remedy(format!("write a path, or one of: {}", known.join(", "))))
    }

    /// The one in a file that a user names; if there is no such file, the one of that name.
    pub(crate) fn named_by_user(&self, path: &Path) -> Result<SourceText, Failure> {
        let named = if path.exists() { None } else { self.of_name(path)? };
        named.map_or_else(|| self.read(path), Ok)
    }

    /// Where what ships lies in a checkout.
    fn folder(&self) -> &'static str {
        self.shipped.0.rsplit_once('/').map_or("", |(folder, _)| folder)
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

/// The names of the policies that ship: what `policy = "…"` may say beside a path.
///
/// ```
/// assert!(trolley::policy_names().any(|name| name == "worst-off-first"));
/// ```
pub fn policy_names() -> impl Iterator<Item = &'static str> {
    POLICY.named.iter().map(|(name, _)| *name)
}

/// Reads the policy in a file; if there is no such file, the one that ships under this name.
///
/// ```
/// let policy = trolley::read_policy("worst-off-first".as_ref())?;
/// assert!(policy.text.contains("schema"));
/// assert!(trolley::read_policy("no-such-policy".as_ref()).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If there is neither, or it cannot be read.
pub fn read_policy(named: &Path) -> Result<SourceText, Failure> {
    POLICY.named_by_user(named)
}

/// Reads the curves in a file; if there is no such file, those that ship under this name.
///
/// ```
/// assert!(trolley::read_curves("levels".as_ref())?.text.contains("schema"));
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// As [`read_policy`].
pub fn read_curves(named: &Path) -> Result<SourceText, Failure> {
    CURVES.named_by_user(named)
}

/// Reads the parameters in a file; if there is no such file, those that ship under this name.
///
/// ```
/// assert!(trolley::read_parameters("default".as_ref())?.text.contains("schema"));
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// As [`read_policy`].
pub fn read_parameters(named: &Path) -> Result<SourceText, Failure> {
    PARAMETERS.named_by_user(named)
}

/// Checks that a policy, curves and parameters are valid, and go with each other.
///
/// ```
/// let policy = trolley::read_policy("default".as_ref())?;
/// let curves = trolley::read_curves("default".as_ref())?;
/// let parameters = trolley::read_parameters("default".as_ref())?;
/// trolley::check_criteria([&policy, &curves, &parameters])?;
/// assert!(trolley::check_criteria([&curves, &curves, &parameters]).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// The first fault that is found; one is that the curves lack the policy's outcome.
pub fn check_criteria(texts: [&SourceText; 3]) -> Result<(), Failure> {
    criteria(texts).map(drop)
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
