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
    /// Mean R of those outside of vehicles: [`Stake::is_vulnerable`]; 0 without any.
    Vulnerable,
    /// Mean R of those not involved: [`Stake::is_uninvolved`]; 0 without any.
    Uninvolved,
}

/// A weighted rule.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Term {
    /// Which.
    pub rule: Rule,
    /// Its weight ≥ 0.
    pub weight: f64,
}

/// Weighted rules. There are seven rules, so a policy's terms need no heap.
pub type WeightedRules = SmallVec<[Term; 7]>;

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

/// What the request says of a person: only side, shelter and responsibility.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stake {
    /// An occupant of the ego vehicle.
    pub is_ego: bool,
    /// Outside of a vehicle: on foot, on a bicycle or on a motorcycle. These are the vulnerable
    /// road users of Regulation (EU) 2019/2144, article 3.
    pub is_vulnerable: bool,
    /// ρ in [0, 1]: how far this person is responsible for the danger, as stated by the planner.
    pub responsibility: f64,
}

impl Stake {
    /// Whether this person is not involved: no occupant of the ego vehicle, and stated to have no
    /// responsibility for the danger. Where nothing is stated, that is 0.
    ///
    /// The ethics commission of the German ministry of transport (2017, rule 9) forbids that those
    /// who generate mobility risks sacrifice those who do not. Who generates risks by taking part
    /// in traffic at all is not known here: occupants of other vehicles count as not involved
    /// unless the planner states their responsibility.
    #[must_use]
    pub fn is_uninvolved(&self) -> bool {
        !self.is_ego && self.responsibility == 0.0
    }
}

/// Persons who may be there besides those at stake, of whom nobody knows whether they are: how
/// many, and the sum of the upper ends of their risks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Others {
    /// All of them.
    pub all: (u32, f64),
    /// Those outside of vehicles.
    pub vulnerable: (u32, f64),
    /// Those not involved.
    pub uninvolved: (u32, f64),
}

impl Others {
    /// Adds so many persons who would have this at stake, each with at most this risk.
    pub fn add(&mut self, stake: &Stake, count: u32, risk: f64) {
        let groups = [
            (&mut self.all, true),
            (&mut self.vulnerable, stake.is_vulnerable),
            (&mut self.uninvolved, stake.is_uninvolved()),
        ];
        for ((number, sum), _) in groups.into_iter().filter(|(_, is_in)| *is_in) {
            *number += count;
            *sum += f64::from(count) * risk;
        }
    }

    /// Whether every sum is a number.
    pub(crate) fn are_sound(&self) -> bool {
        let sums = [self.all.1, self.vulnerable.1, self.uninvolved.1];
        sums.iter().all(|sum| *sum >= 0.0 && sum.is_finite())
    }
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
            Self::Vulnerable => "vulnerable",
            Self::Uninvolved => "uninvolved",
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
        let mean_of = |is_in: fn(&Stake) -> bool| {
            let group = || risks().zip(stakes).filter(|(_, stake)| is_in(stake)).map(|(r, _)| r);
            mean(group().sum(), group().count() as f64)
        };
        match self {
            Self::Bayes => mean(risks().sum(), n as f64),
            Self::Equality => pairs(n, |i, j| (risk(i) - risk(j)).abs()),
            Self::Maximin => risks().fold(0.0, f64::max),
            Self::Responsibility => {
                let rest = risks().zip(stakes).map(|(r, s)| (1.0 - s.responsibility) * r);
                mean(rest.sum(), n as f64)
            }
            Self::EgoOnly => mean_of(|stake| stake.is_ego),
            Self::Vulnerable => mean_of(|stake| stake.is_vulnerable),
            Self::Uninvolved => mean_of(Stake::is_uninvolved),
        }
    }

    /// For a mean that [`Others`] may be in: over how many persons at stake it is taken, how many
    /// others there may be, and the sum of their risks.
    fn widened(self, stakes: &[Stake], others: &Others) -> Option<(f64, f64, f64)> {
        let (is_in, (more, sum)): (fn(&Stake) -> bool, _) = match self {
            Self::Bayes | Self::Responsibility => (|_| true, others.all),
            Self::Vulnerable => (|stake| stake.is_vulnerable, others.vulnerable),
            Self::Uninvolved => (Stake::is_uninvolved, others.uninvolved),
            Self::Equality | Self::Maximin | Self::EgoOnly => return None,
        };
        let n = stakes.iter().filter(|stake| is_in(stake)).count() as f64;
        Some((n, (n + f64::from(more)).max(1.0), sum))
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

    /// Its upper end `high` if persons are there besides those at stake, of whom nobody knows
    /// whether they are. Only means change: they are then those of everybody in their group. The
    /// rest is as it was, and so is a mean that would be less.
    #[must_use]
    pub fn with_others(&self, high: f64, stakes: &[Stake], others: &Others) -> f64 {
        match self {
            Self::Rule(rule) => match rule.widened(stakes, others) {
                Some((n, all, sum)) => ((high * n + sum) / all).max(high),
                None => high,
            },
            Self::Weighted(terms) => {
                let rise = |term: &Term| {
                    let (_, all, sum) = term.rule.widened(stakes, others)?;
                    Some(term.weight * sum / all)
                };
                high + terms.iter().filter_map(rise).sum::<f64>()
            }
            Self::Worst(_) | Self::Energy => high,
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
