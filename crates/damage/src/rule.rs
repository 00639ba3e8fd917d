//! The measures by which a policy compares candidates: numbers made from risks, lower is better.
//!
//! Risks are R_i = p·H_i of one fixed set of persons, untouched ones included with 0. For the rules
//! that rise in every R_i, an interval is the rule at both ends; equality does not, and gets its
//! own. A rule considers one candidate alone, so no candidate's figures depend on the others.

use crate::interval::Interval;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

/// A rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// ΣR/n.
    Bayes,
    /// Mean of |R_i − R_j| over all pairs; 0 for fewer than two persons.
    Equality,
    /// The greatest R; no threshold, no mask.
    Maximin,
    /// Σ(1−ρ_i)R_i/n.
    Responsibility,
    /// Mean R of the ego vehicle's occupants; 0 without any.
    EgoOnly,
}

/// A weighted rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Term {
    /// Which.
    pub rule: Rule,
    /// Its weight ≥ 0.
    pub weight: f64,
}

/// Weighted rules. There are five rules, so a policy's terms need no heap.
pub type WeightedRules = SmallVec<[Term; 5]>;

/// A measure of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// One rule.
    Rule(Rule),
    /// A weighted sum of rules.
    Weighted(WeightedRules),
    /// The k-th greatest risk, from 0.
    Worst(usize),
    /// Energy lost (J), for property damage.
    Energy,
}

/// What the request says of a person: only side and responsibility.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stake {
    /// An occupant of the ego vehicle.
    pub is_ego: bool,
    /// ρ in [0, 1]: how far this person is responsible for the danger, as stated by the planner.
    pub responsibility: f64,
}

/// A weighted sum with equality is monotone in exact arithmetic only: its ends move out by this,
/// above rounding and below any difference that ranks.
const SUM_SLACK: f64 = 1e-12;

impl Rule {
    /// The name as files write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bayes => "bayes",
            Self::Equality => "equality",
            Self::Maximin => "maximin",
            Self::Responsibility => "responsibility",
            Self::EgoOnly => "ego-only",
        }
    }

    /// Its value for risks of all persons.
    #[must_use]
    pub fn value(self, risks: &[f64], stakes: &[Stake]) -> f64 {
        self.of(risks.len(), |i| risks[i], stakes)
    }

    /// [`Rule::value`] of `n` risks given by a function: ranking needs it several times per result.
    fn of(self, n: usize, risk: impl Fn(usize) -> f64, stakes: &[Stake]) -> f64 {
        let mean = |sum: f64, n: f64| if n > 0.0 { sum / n } else { 0.0 };
        let risks = || (0..n).map(&risk);
        match self {
            Self::Bayes => mean(risks().sum(), n as f64),
            Self::Equality => pairs(n, |i, j| (risk(i) - risk(j)).abs()),
            Self::Maximin => risks().fold(0.0, f64::max),
            Self::Responsibility => {
                let rest = risks().zip(stakes).map(|(r, s)| (1.0 - s.responsibility) * r);
                mean(rest.sum(), n as f64)
            }
            Self::EgoOnly => {
                let ego = || risks().zip(stakes).filter(|(_, s)| s.is_ego).map(|(r, _)| r);
                mean(ego().sum(), ego().count() as f64)
            }
        }
    }
}

/// Mean over all pairs below n; 0 if there is none.
fn pairs(n: usize, of: impl Fn(usize, usize) -> f64) -> f64 {
    let count = n * n.saturating_sub(1) / 2;
    if count == 0 {
        return 0.0;
    }
    let sum: f64 =
        (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).map(|(i, j)| of(i, j)).sum();
    sum / count as f64
}

/// Number of persons stored in place, as many as a request of the service may name.
const PERSONS: usize = 64;

/// The k-th greatest of some risks, from 0; 0 beyond the last.
fn worst(risks: impl Iterator<Item = f64>, k: usize) -> f64 {
    let mut sorted: SmallVec<[f64; PERSONS]> = risks.collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    sorted.get(k).copied().unwrap_or(0.0)
}

impl Measure {
    /// The name for explanations.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Rule(rule) => rule.name().to_owned(),
            Self::Weighted(_) => "weighted sum".to_owned(),
            Self::Worst(0) => "worst-off person".to_owned(),
            Self::Worst(k) => format!("person {} from the worst-off", k + 1),
            Self::Energy => "property damage".to_owned(),
        }
    }

    /// Its value for risks of all persons and an energy (J).
    #[must_use]
    pub fn value(&self, risks: &[f64], energy_j: f64, stakes: &[Stake]) -> f64 {
        self.of(risks.len(), |i| risks[i], energy_j, stakes)
    }

    /// [`Measure::value`] of `n` risks given by a function.
    pub(crate) fn of(
        &self,
        n: usize,
        risk: impl Fn(usize) -> f64,
        energy_j: f64,
        stakes: &[Stake],
    ) -> f64 {
        match self {
            Self::Rule(rule) => rule.of(n, risk, stakes),
            Self::Weighted(terms) => {
                terms.iter().map(|t| t.weight * t.rule.of(n, &risk, stakes)).sum()
            }
            Self::Worst(k) => worst((0..n).map(risk), *k),
            Self::Energy => energy_j,
        }
    }

    /// Its upper end `high` if persons are there besides the `n` at stake, of whom nobody knows
    /// whether they are: their number, and the sum of their risks. Only means change: they are then
    /// those of everybody. The rest is as it was, and so is a mean that would be less.
    #[must_use]
    pub fn with_others(&self, high: f64, n: usize, (others, sum): (u32, f64)) -> f64 {
        let all = (n as f64 + f64::from(others)).max(1.0);
        let is_mean = |rule: Rule| matches!(rule, Rule::Bayes | Rule::Responsibility);
        match self {
            Self::Rule(rule) if is_mean(*rule) => ((high * n as f64 + sum) / all).max(high),
            Self::Weighted(terms) => {
                let means = terms.iter().filter(|term| is_mean(term.rule));
                high + means.map(|term| term.weight * sum / all).sum::<f64>()
            }
            Self::Rule(_) | Self::Worst(_) | Self::Energy => high,
        }
    }

    /// The interval of its values over all risks and energies within the given intervals.
    #[must_use]
    pub fn over(&self, risks: &[Interval], energy_j: Interval, stakes: &[Stake]) -> Interval {
        if let Self::Rule(Rule::Equality) = self {
            let end = |of: fn(Interval) -> f64| {
                pairs(risks.len(), |i, j| of(risks[i].distance(risks[j])))
            };
            return Interval::new(end(Interval::lo), end(Interval::hi));
        }
        let end =
            |of: fn(Interval) -> f64| self.of(risks.len(), |i| of(risks[i]), of(energy_j), stakes);
        let (lo, hi) = (end(Interval::lo), end(Interval::hi));
        match self {
            Self::Weighted(_) if risks.iter().any(|r| !r.is_settled()) => {
                Interval::new(lo - SUM_SLACK, hi + SUM_SLACK)
            }
            _ => Interval::new(lo, hi),
        }
    }
}

#[cfg(test)]
mod tests;
