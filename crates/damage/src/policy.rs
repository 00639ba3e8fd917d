//! A policy: how a board of experts wants collisions compared. It is data, never code.
//!
//! Every composition reduces to steps that are taken in turn ([`Policy::steps`]): keep those whose
//! measure is least, within a tolerance, or keep those that are acceptable for everyone. Property
//! damage is only ever the last step, and before it all steps on persons are taken again without
//! tolerance; so it can never outweigh a person.
//!
//! A policy changes the order, never a figure. Age, sex and condition of persons are not known
//! here: files that name them are refused (`policy/load.rs`).

use crate::curve::Level;
use crate::rule::{Measure, Rule, Term};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

pub mod dossier;
mod load;
#[cfg(test)]
mod tests;

/// The policy in force unless another is named: `config/policies/default.toml`.
pub const DEFAULT_POLICY: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/config/policies/default.toml"));

/// One step of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// Keep those within `tolerance` of the least.
    Least {
        /// Of what.
        measure: Measure,
        /// How far from the least still counts as least.
        tolerance: f64,
    },
    /// Keep those where no upper end of a model range exceeds this risk.
    Accept {
        /// R_acc.
        at_most: f64,
        /// What if there is none.
        otherwise: Otherwise,
    },
}

/// What a policy says if no candidate is acceptable. Only the first step of a policy may say other
/// than [`Otherwise::NextRule`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Otherwise {
    /// Keep all: the next rule decides.
    NextRule,
    /// No candidate may be chosen. They are in order still, as by the next rules.
    Refuse,
    /// This candidate comes first; if it is not among them, no candidate may be chosen.
    FallBack(NamedCandidate),
}

/// A candidate that a policy names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NamedCandidate {
    /// Its name, exactly as requests write it; in those of the service "0", "1" and so on.
    pub name: Arc<str>,
    /// Its number in the request: see [`Policy::among`]. `None`: it is not there.
    pub number: Option<usize>,
}

impl NamedCandidate {
    /// A candidate of no request.
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.into(), number: None }
    }
}

impl Otherwise {
    /// The number of the candidate to fall back on, if it is there.
    pub(crate) fn fall_back(&self) -> Option<usize> {
        match self {
            Self::FallBack(named) => named.number,
            Self::NextRule | Self::Refuse => None,
        }
    }
}

/// How the rules are put together, after the policy's levels.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Composition {
    /// The levels alone decide.
    Lexicographic,
    /// Then the least weighted sum.
    Weighted {
        /// Its terms; weights sum to 1.
        terms: Vec<Term>,
        /// How far from the least still counts as least.
        tolerance: f64,
    },
    /// Then the worst-off person, the second worst-off, and so on.
    Leximin {
        /// How far from the least still counts as least, at each person.
        tolerance: f64,
    },
}

/// Whether property damage counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// After all persons.
    Last,
    /// Not at all, except as a tie-break where that is declared.
    Ignored,
}

/// What decides between candidates that the policy holds equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TieBreak {
    /// The candidate that comes first in [`Policy::preferred`]: usually to brake in lane.
    BrakeInLane,
    /// Less energy lost.
    Energy,
    /// The lower upper end of the model range of the leading measure.
    High,
    /// Earlier in the request. Always the last.
    Request,
}

/// A checked policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Policy {
    /// Name.
    pub name: String,
    /// Who answers for it.
    pub board: String,
    /// Severity that counts.
    pub outcome: Level,
    /// What comes first, in turn.
    pub levels: Vec<Step>,
    /// How rules are combined after the levels.
    pub composition: Composition,
    /// Property damage.
    pub property: Property,
    /// What decides last; ends with [`TieBreak::Request`].
    pub tie_break: Vec<TieBreak>,
    /// The candidates that [`TieBreak::BrakeInLane`] takes, in turn.
    pub preferred: Vec<NamedCandidate>,
    /// Who signed it, until when, and what must stay as it is; `None`: nobody signed it.
    pub dossier: Option<Arc<dossier::Dossier>>,
}

impl Policy {
    /// The steps of a comparison among candidates that concern `n` persons.
    #[must_use]
    pub fn steps(&self, n: usize) -> Vec<Step> {
        let mut steps = Vec::new();
        self.write_steps(n, &mut steps);
        steps
    }

    /// [`Policy::steps`] into a reused list.
    pub(crate) fn write_steps(&self, n: usize, steps: &mut Vec<Step>) {
        steps.clone_from(&self.levels);
        match &self.composition {
            Composition::Lexicographic => {}
            Composition::Weighted { terms, tolerance } => steps.push(Step::Least {
                measure: Measure::Weighted(terms.as_slice().into()),
                tolerance: *tolerance,
            }),
            Composition::Leximin { tolerance } => steps.extend(
                (0..n.max(1))
                    .map(|k| Step::Least { measure: Measure::Worst(k), tolerance: *tolerance }),
            ),
        }
        if self.property == Property::Last {
            for number in 0..steps.len() {
                let strict = steps[number].without_tolerance();
                steps.extend(strict);
            }
            steps.push(Step::Least { measure: Measure::Energy, tolerance: 0.0 });
        }
    }

    /// This policy for a request of candidates with these names: it knows their numbers.
    #[must_use]
    pub fn among<'n>(self: &Arc<Self>, names: impl Iterator<Item = &'n str> + Clone) -> Arc<Self> {
        let falls_back =
            |step: &Step| matches!(step, Step::Accept { otherwise: Otherwise::FallBack(_), .. });
        if self.preferred.is_empty() && !self.levels.iter().any(falls_back) {
            return self.clone();
        }
        let mut policy = Self::clone(self);
        let levels = policy.levels.iter_mut().filter_map(|step| match step {
            Step::Accept { otherwise: Otherwise::FallBack(named), .. } => Some(named),
            Step::Accept { .. } | Step::Least { .. } => None,
        });
        for named in levels.chain(&mut policy.preferred) {
            named.number = names.clone().position(|name| *name == *named.name);
        }
        Arc::new(policy)
    }

    /// Whether some rule considers the ego vehicle's occupants only: the answer must say so.
    #[must_use]
    pub fn is_ego_only(&self) -> bool {
        let in_levels = self
            .levels
            .iter()
            .any(|step| matches!(step, Step::Least { measure: Measure::Rule(Rule::EgoOnly), .. }));
        let in_terms = match &self.composition {
            Composition::Weighted { terms, .. } => {
                terms.iter().any(|t| t.rule == Rule::EgoOnly && t.weight > 0.0)
            }
            Composition::Lexicographic | Composition::Leximin { .. } => false,
        };
        in_levels || in_terms
    }
}

/// For lists: "least bayes", "least maximin, within 0.01".
impl core::fmt::Display for Step {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Accept { at_most, otherwise } => {
                write!(f, "nobody's upper end above {at_most}")?;
                match otherwise {
                    Otherwise::NextRule => Ok(()),
                    Otherwise::Refuse => f.write_str(", or no candidate at all"),
                    Otherwise::FallBack(named) => write!(f, ", or \"{}\"", named.name),
                }
            }
            Self::Least { measure, tolerance } if *tolerance > 0.0 => {
                write!(f, "least {}, within {tolerance}", measure.name())
            }
            Self::Least { measure, .. } => write!(f, "least {}", measure.name()),
        }
    }
}

impl Step {
    /// This step without its tolerance; `None` if it has none.
    fn without_tolerance(&self) -> Option<Self> {
        match self {
            Self::Least { measure, tolerance } if *tolerance > 0.0 => {
                Some(Self::Least { measure: measure.clone(), tolerance: 0.0 })
            }
            Self::Least { .. } | Self::Accept { .. } => None,
        }
    }
}
