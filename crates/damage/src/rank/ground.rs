//! What put one candidate before the next, as one sentence for people.

use super::{Ground, Measure, Rule, TieBreak};

impl Ground {
    /// The reason as one sentence for people, with the names of both candidates.
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
                let name = measure_in_words(measure);
                let by = rule
                    .map_or_else(String::new, |r| format!(", mostly from {}", rule_in_words(r)));
                let within = if *tolerance > 0.0 {
                    format!(", more than {tolerance} above the least")
                } else {
                    String::new()
                };
                format!("{first} before {second}: {name} {a:.5} against {b:.5}{within}{by}")
            }
            Self::Accept { at_most, first: a, second: b, .. } => format!(
                "{first} before {second}: nobody's risk exceeds {at_most} (at most {a:.5} \
                 against {b:.5})"
            ),
            Self::FallBack { at_most, first: a, second: b, .. } => format!(
                "{first} before {second}: nobody's risk is to exceed {at_most}, which no candidate \
                 keeps ({a:.5} and {b:.5}), and the policy falls back on it"
            ),
            Self::TieBreak { by: TieBreak::BrakeInLane, .. } => format!(
                "{first} before {second}: equal under the policy; the tie-break prefers it by name"
            ),
            Self::TieBreak { by: TieBreak::Request, .. } => {
                format!("{first} before {second}: only their order in the request separates them")
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

/// What a rule compares, in plain words.
fn rule_in_words(rule: Rule) -> &'static str {
    match rule {
        Rule::Bayes => "mean risk",
        Rule::Equality => "mean difference in risk",
        Rule::Maximin => "greatest risk",
        Rule::Responsibility => "mean risk weighted by responsibility",
        Rule::EgoOnly => "mean risk of the ego vehicle's occupants",
        Rule::Vulnerable => "mean risk of those outside of vehicles",
        Rule::Uninvolved => "mean risk of those not involved",
    }
}

/// What a measure compares, in plain words.
fn measure_in_words(measure: &Measure) -> String {
    match measure {
        Measure::Rule(rule) => rule_in_words(*rule).to_owned(),
        Measure::Worst(0) => "risk of the worst-off person".to_owned(),
        Measure::Worst(k) => format!("risk of person {} from the worst-off", k + 1),
        Measure::Weighted(_) | Measure::Energy => measure.name(),
    }
}
