//! What put one candidate before the next, as one sentence for people.

use super::{Ground, Measure, TieBreak};

impl Ground {
    /// One sentence for people, about candidates of these names.
    #[must_use]
    pub fn sentence(&self, first: &str, second: &str) -> String {
        match self {
            Self::Least { measure: Measure::Energy, first: a, second: b, .. } => format!(
                "{first} before {second}: no rule on persons separates them, and less property is \
                 damaged ({:.1} against {:.1} kJ)",
                a / 1000.0,
                b / 1000.0
            ),
            Self::Least { measure, first: a, second: b, rule, tolerance, .. } => {
                let name = measure.name();
                let by = rule.map_or(String::new(), |r| format!(", most of it by {}", r.name()));
                let within = if *tolerance > 0.0 {
                    format!(", more than {tolerance} apart from the least")
                } else {
                    String::new()
                };
                format!("{first} before {second}: {name} {a:.5} against {b:.5}{within}{by}")
            }
            Self::Accept { at_most, first: a, second: b, .. } => format!(
                "{first} before {second}: nobody's risk there passes {at_most} (at most {a:.5}, \
                 against {b:.5})"
            ),
            Self::TieBreak { by: TieBreak::Request, .. } => {
                format!("{first} before {second}: nothing separates them but the request's order")
            }
            Self::TieBreak { by: TieBreak::Energy, first: a, second: b } => format!(
                "{first} before {second}: equal under the policy; the tie-break takes the lower \
                 energy ({:.1} against {:.1} kJ)",
                a / 1000.0,
                b / 1000.0
            ),
            Self::TieBreak { by: TieBreak::High, first: a, second: b } => format!(
                "{first} before {second}: equal under the policy; the tie-break takes the lower \
                 upper end of the model range ({a:.5} against {b:.5})"
            ),
        }
    }
}
