//! What put one candidate before the next, and as one sentence for people.

use super::{RankOrder, TieBreak};
use crate::party::PersonId;
use crate::policy::Step;
use crate::rule::{Measure, Rule};
use serde::Serialize;

/// What put one candidate before the next.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// A step of the policy kept the first and not the second.
    Least {
        /// Number of the step, from 0.
        step: usize,
        /// The measure that is lower for the first.
        measure: Measure,
        /// Its value for the first.
        first: f64,
        /// Its value for the second.
        second: f64,
        /// The tolerance: how far from the least still counts as least.
        tolerance: f64,
        /// In a weighted sum: the rule that separates them most.
        rule: Option<Rule>,
        /// The person whose risks differ most between the two; `None` for property damage.
        person: Option<PersonId>,
    },
    /// In the second, the upper end of someone's model range exceeds the accepted risk.
    Accept {
        /// Number of the step, from 0.
        step: usize,
        /// R_acc.
        at_most: f64,
        /// The greatest upper end in the first.
        first: f64,
        /// The greatest upper end in the second.
        second: f64,
    },
    /// No candidate is acceptable, and the policy then falls back on the first.
    FallBack {
        /// Number of the step, from 0.
        step: usize,
        /// R_acc.
        at_most: f64,
        /// The greatest upper end in the first.
        first: f64,
        /// The greatest upper end in the second.
        second: f64,
    },
    /// The policy holds both equal; the declared tie-break decided.
    TieBreak {
        /// By what.
        by: TieBreak,
        /// Its value for the first (place in the request, or in the policy's list).
        first: f64,
        /// Its value for the second.
        second: f64,
    },
}

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
                let is_share = !matches!(measure, Measure::Weighted(_));
                let within = match *tolerance {
                    0.0 => String::new(),
                    more if is_share => {
                        format!(", more than {} percentage points above the least", 100.0 * more)
                    }
                    more => format!(", more than {more} above the least"),
                };
                let [a, b] = if is_share { shares([*a, *b]) } else { figures([*a, *b]) };
                format!("{first} before {second}: {name} {a} against {b}{within}{by}")
            }
            Self::Accept { at_most, first: a, second: b, .. } => {
                let [a, b] = shares([*a, *b]);
                format!(
                    "{first} before {second}: nobody's risk exceeds {} % (at most {a} against {b})",
                    100.0 * at_most
                )
            }
            Self::FallBack { at_most, first: a, second: b, .. } => {
                let [a, b] = shares([*a, *b]);
                format!(
                    "{first} before {second}: nobody's risk is to exceed {} %, which no candidate \
                     keeps ({a} and {b}), and the policy falls back on it",
                    100.0 * at_most
                )
            }
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
            Self::TieBreak { by: TieBreak::High, first: a, second: b } => {
                let [a, b] = shares([*a, *b]);
                format!(
                    "{first} before {second}: equal under the policy; the tie-break takes the \
                     lower upper end of the model range ({a} against {b})"
                )
            }
        }
    }
}

impl RankOrder<'_> {
    /// Why `k` came before `l`, which fell out at a step, or at none.
    pub(super) fn ground(&self, k: usize, l: usize, fell: Option<usize>) -> Ground {
        match fell.map(|step| (step, &self.steps[step])) {
            Some((step, Step::Accept { at_most, .. })) => {
                let [first, second] = [k, l].map(|k| self.figures[k].greatest_high());
                let at_most = *at_most;
                if self.is_acceptable(k, at_most) {
                    Ground::Accept { step, at_most, first, second }
                } else {
                    Ground::FallBack { step, at_most, first, second }
                }
            }
            Some((step, Step::Least { measure, tolerance })) => Ground::Least {
                step,
                measure: measure.clone(),
                first: self.value(measure, k),
                second: self.value(measure, l),
                tolerance: *tolerance,
                rule: self.separating_rule(measure, k, l),
                person: match measure {
                    Measure::Energy => None,
                    _ => self.separating_person(k, l),
                },
            },
            None => {
                let differs = |t: &&TieBreak| {
                    self.tie_value(**t, k).total_cmp(&self.tie_value(**t, l)).is_ne()
                };
                let by = self.policy.tie_break.iter().find(differs);
                let by = by.copied().unwrap_or(TieBreak::Request);
                Ground::TieBreak { by, first: self.tie_value(by, k), second: self.tie_value(by, l) }
            }
        }
    }

    /// The rule of a weighted sum that puts `k` furthest before `l`.
    fn separating_rule(&self, measure: &Measure, k: usize, l: usize) -> Option<Rule> {
        let Measure::Weighted(terms) = measure else { return None };
        let gain = |rule: Rule, weight: f64| {
            let one = Measure::Rule(rule);
            weight * (self.value(&one, l) - self.value(&one, k))
        };
        let gains = terms.iter().map(|t| (gain(t.rule, t.weight), t.rule));
        gains.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(_, rule)| rule)
    }

    /// The person whose risks in `k` and `l` differ most; the first of several.
    fn separating_person(&self, k: usize, l: usize) -> Option<PersonId> {
        let (ours, theirs) = (&self.figures[k].risks, &self.figures[l].risks);
        let differences = ours.iter().zip(theirs).map(|(a, b)| (a.hi() - b.hi()).abs());
        let by_size = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0));
        differences.enumerate().max_by(by_size).map(|(i, _)| PersonId(i))
    }
}

/// Two shares in percent, as the tables beside them, with more digits where these tell them apart.
fn shares(both: [f64; 2]) -> [String; 2] {
    let said = |digits: usize| {
        // Tenths would add up to more than the figure that they stand for.
        let least = 1.0 / (0..digits).fold(1.0, |power, _| 10.0 * power);
        both.map(|share| match 100.0 * share {
            0.0 => "0 %".to_owned(),
            percent if percent > 0.0 && percent < least => format!("< {least:.digits$} %"),
            percent => format!("{percent:.digits$} %"),
        })
    };
    apart(said)
}

/// Two figures, with as many digits as tell them apart.
fn figures(both: [f64; 2]) -> [String; 2] {
    apart(|digits| both.map(|figure| format!("{figure:.digits$}")))
}

/// Both texts with the fewest digits that tell them apart, from two on.
fn apart(said: impl Fn(usize) -> [String; 2]) -> [String; 2] {
    (2..8).map(&said).find(|[a, b]| a != b).unwrap_or_else(|| said(8))
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
