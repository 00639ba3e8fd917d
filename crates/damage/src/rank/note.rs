//! What an answer says besides its order.

use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

/// A remark that an answer makes besides its order.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Note {
    /// No candidate keeps everybody at or below the accepted risk; that step was passed over.
    NobodyAcceptable {
        /// R_acc.
        at_most: f64,
    },
    /// No candidate keeps everybody at or below the accepted risk, and the policy then lets none be
    /// chosen: there is no winner.
    Refused {
        /// R_acc.
        at_most: f64,
        /// The candidate that the policy falls back on, if it names one: it is not there.
        missing: Option<Arc<str>>,
    },
    /// No candidate keeps everybody at or below the accepted risk, and the policy then falls back
    /// on this one, which comes first.
    FellBack {
        /// R_acc.
        at_most: f64,
        /// Its name.
        on: Arc<str>,
    },
    /// Some rule of the policy considers the ego vehicle's occupants only.
    EgoOnly,
}

impl Note {
    /// Whether it says that no candidate may be chosen.
    #[must_use]
    pub fn is_refusal(&self) -> bool {
        matches!(self, Self::Refused { .. })
    }

    /// The remark as one sentence for people.
    #[must_use]
    pub fn sentence(&self) -> String {
        let none = |at_most: &f64| {
            format!("no candidate keeps everybody's risk at or below {at_most}, upper end included")
        };
        match self {
            Self::NobodyAcceptable { at_most } => {
                format!("{}: the policy's next rule decides", none(at_most))
            }
            Self::Refused { at_most, missing: None } => {
                format!("none is acceptable under the policy, so none wins: {}", none(at_most))
            }
            Self::Refused { at_most, missing: Some(name) } => format!(
                "none is acceptable under the policy, so none wins: {}, and its fall-back \
                 \"{name}\" is not among them",
                none(at_most)
            ),
            Self::FellBack { at_most, on } => {
                format!("{}: the policy falls back on \"{on}\"", none(at_most))
            }
            Self::EgoOnly => "some rule of the policy looks at the ego vehicle's occupants alone \
                              and at nobody else"
                .to_owned(),
        }
    }
}
