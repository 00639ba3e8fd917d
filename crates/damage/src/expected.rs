//! Expected harm: the mean over members, how far it can be trusted, and who is best in how many.
//!
//! Each *person's* risk is averaged over the members first, then the policy's rules are applied:
//! a mean of worst-off persons would be of nobody. An interval of a mean is the mean of intervals,
//! so it stays proven.
//!
//! The sampling error is s/√N, of independent draws: members are drawn more evenly than that, so
//! it is rather too large than too small.

use crate::assess::Risk;
use crate::course::CourseHarm;
use crate::interval::{Interval, Range};
use crate::policy::Policy;
use crate::rank::{RankError, Scratch, best_in, leading_in};
use crate::rule::{Others, Stake};
use schemars::JsonSchema;
use serde::Serialize;

/// How the leading measure of a candidate is spread over members.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Sampling error of its mean.
    pub error: f64,
    /// What it is below in 5, 50 and 95 % of the members.
    pub quantiles: [f64; 3],
    /// The share of members in which this candidate is best under the whole policy; where several
    /// are equally good, each has its part.
    pub best: f64,
    /// How much more it is than that of the best of each member, in the mean.
    pub regret: f64,
}

/// By how much the best two differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Lead {
    /// The mean of the second's leading measure less the first's.
    pub mean: f64,
    /// Its sampling error, of the paired difference.
    pub error: f64,
}

/// By which share a mean has to be below its sampling error to be nearer to 0: far above the
/// rounding of both, so that rounding does not decide where they are equal, as they are where one
/// member alone tells two candidates apart.
const SLACK: f64 = 1e-9;

impl Lead {
    /// Of these differences, one per member.
    fn of(apart: &[f64]) -> Self {
        let (mean, error) = sampled(apart);
        Self { mean, error }
    }

    /// Whether the two are too close to call.
    #[must_use]
    pub fn is_close(&self) -> bool {
        self.mean.abs() < self.error * (1.0 - SLACK)
    }
}

/// The spread of every candidate, and the lead of the first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spreads {
    /// Per candidate, in the order of the request.
    pub candidates: Vec<Spread>,
    /// `None` of a single candidate.
    pub lead: Option<Lead>,
    /// Per candidate: its leading measure in each member.
    pub leading: Vec<Vec<f64>>,
}

/// The mean of courses of one candidate, added one after the other: whatever is open in one is open
/// in the mean.
#[derive(Clone, Debug, Default)]
pub struct Mean {
    sum: CourseHarm,
    count: u32,
}

impl Mean {
    /// Adds a course.
    pub fn add(&mut self, course: &CourseHarm) {
        let Self { sum, count } = self;
        *count += 1;
        for risk in &course.persons {
            let at = sum.persons.partition_point(|known| known.id < risk.id);
            match sum.persons.get_mut(at).filter(|known| known.id == risk.id) {
                Some(known) => *known = plus(known, risk),
                None => sum.persons.insert(at, *risk),
            }
        }
        sum.energy_j = added(sum.energy_j, course.energy_j);
        let Others { all, vulnerable, uninvolved } = &mut sum.others;
        let groups = [all, vulnerable, uninvolved];
        let more = [course.others.all, course.others.vulnerable, course.others.uninvolved];
        for (group, more) in groups.into_iter().zip(more) {
            *group = (group.0.max(more.0), group.1 + more.1);
        }
        sum.is_open |= course.is_open;
        sum.is_unevaluable |= course.is_unevaluable;
    }

    /// The mean of what was added; of nothing, a course without contact; of one, that one itself.
    #[must_use]
    pub fn finish(self) -> CourseHarm {
        let Self { mut sum, count } = self;
        if count <= 1 {
            return sum;
        }
        let share = 1.0 / f64::from(count);
        let scaled = |interval: Interval, most: f64| interval.map(|x| (x * share).min(most));
        for risk in &mut sum.persons {
            let work = scaled(risk.work, 1.0);
            let [low, high] = [risk.range.low(), risk.range.high()].map(|x| (x * share).min(1.0));
            *risk = Risk {
                work,
                range: Range::new(low, high.max(low)).around(work),
                high: scaled(risk.high, 1.0),
                ..*risk
            };
        }
        sum.energy_j = scaled(sum.energy_j, f64::INFINITY);
        for group in [&mut sum.others.all, &mut sum.others.vulnerable, &mut sum.others.uninvolved] {
            group.1 *= share;
        }
        sum
    }
}

/// The [`Mean`] of some courses.
#[must_use]
pub fn mean<'h>(courses: impl Iterator<Item = &'h CourseHarm>) -> CourseHarm {
    let mut mean = Mean::default();
    courses.for_each(|course| mean.add(course));
    mean.finish()
}

fn added(a: Interval, b: Interval) -> Interval {
    Interval::new(a.lo() + b.lo(), a.hi() + b.hi())
}

fn plus(a: &Risk, b: &Risk) -> Risk {
    Risk {
        id: a.id,
        work: added(a.work, b.work),
        range: Range::new(a.range.low() + b.range.low(), a.range.high() + b.range.high()),
        high: added(a.high, b.high),
    }
}

/// Mean and sampling error of some figures.
fn sampled(figures: &[f64]) -> (f64, f64) {
    let count = figures.len() as f64;
    let mean = figures.iter().sum::<f64>() / count;
    if figures.len() < 2 {
        return (mean, 0.0);
    }
    let squares: f64 = figures.iter().map(|x| (x - mean) * (x - mean)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}

/// The figure that a share of them is at most, of figures in ascending order.
fn quantile(ascending: &[f64], share: f64) -> f64 {
    let at = (share * ascending.len() as f64).ceil() as usize;
    ascending[at.clamp(1, ascending.len()) - 1]
}

/// How candidates are spread over members. `harms[m][k]` is candidate k in member m, with nothing
/// open; `order` has the candidates in the order of their means.
///
/// # Errors
///
/// As [`crate::rank()`].
///
/// # Panics
///
/// If there is no member, or members have other numbers of candidates.
pub fn spreads(
    policy: &Policy,
    stakes: &[Stake],
    harms: &[Vec<CourseHarm>],
    order: &[usize],
) -> Result<Spreads, RankError> {
    let (count, candidates) = (harms.len(), order.len());
    let mut leading = vec![Vec::with_capacity(count); candidates];
    let mut best = vec![0.0; candidates];
    let mut regret = vec![0.0; candidates];
    let (mut scratch, mut measures) = (Scratch::default(), Vec::new());
    for harms in harms {
        let winners = best_in(&mut scratch, policy, stakes, harms, &mut measures)?;
        for winner in &winners {
            best[*winner] += 1.0 / winners.len() as f64;
        }
        let least = measures.iter().map(|of| of.hi()).fold(f64::INFINITY, f64::min);
        for (k, measure) in measures.iter().enumerate() {
            leading[k].push(measure.hi());
            regret[k] += measure.hi() - least;
        }
    }
    let count = count as f64;
    let spread = |k: usize| {
        let mut ascending = leading[k].clone();
        ascending.sort_by(f64::total_cmp);
        Spread {
            error: sampled(&leading[k]).1,
            quantiles: [0.05, 0.5, 0.95].map(|share| quantile(&ascending, share)),
            best: best[k] / count,
            regret: regret[k] / count,
        }
    };
    let lead = match order {
        [first, second, ..] => {
            let pairs = leading[*first].iter().zip(&leading[*second]);
            Some(Lead::of(&pairs.map(|(first, second)| second - first).collect::<Vec<f64>>()))
        }
        _ => None,
    };
    Ok(Spreads { candidates: (0..candidates).map(spread).collect(), lead, leading })
}

/// Which candidates' leads from the first one may turn out too close to call, whatever open work
/// finds: by candidate. `harms` as for [`spreads`], but for what is open.
///
/// Of differences x, the mean is nearer to 0 than its sampling error s/√N just if (Σx)² < Σx². If
/// the sum of their lower ends is L ≥ 0 and L² is at least the sum of their squares, then L is at
/// least each of them, so no difference can grow without (Σx)² − Σx² doing so: the lower ends
/// decide, however much is open above them. So do the upper ends if all is the other way around.
///
/// # Errors
///
/// As [`crate::rank()`].
pub fn may_be_close(
    policy: &Policy,
    stakes: &[Stake],
    harms: &[Vec<CourseHarm>],
    first: usize,
) -> Result<Vec<bool>, RankError> {
    let candidates = harms.first().map_or(0, Vec::len);
    // Per candidate: sum and sum of squares of the lower ends, then of the upper ends.
    let mut sums = vec![[(0.0, 0.0); 2]; candidates];
    let (mut scratch, mut leading) = (Scratch::default(), Vec::new());
    for harms in harms {
        leading_in(&mut scratch, policy, stakes, harms, &mut leading)?;
        for (sums, of) in sums.iter_mut().zip(&leading) {
            let ends = [of.lo() - leading[first].hi(), of.hi() - leading[first].lo()];
            for ((sum, squares), end) in sums.iter_mut().zip(ends) {
                *sum += end;
                *squares += end * end;
            }
        }
    }
    let is_clear = |[(low, low_squares), (high, high_squares)]: [(f64, f64); 2]| {
        low >= 0.0 && low * low >= low_squares || high <= 0.0 && high * high >= high_squares
    };
    Ok(sums.into_iter().enumerate().map(|(k, sums)| k != first && !is_clear(sums)).collect())
}

/// The lead of one candidate over another, with nothing open in either. `harms` as for [`spreads`].
///
/// # Errors
///
/// As [`crate::rank()`].
pub fn lead(
    policy: &Policy,
    stakes: &[Stake],
    harms: &[Vec<CourseHarm>],
    [first, second]: [usize; 2],
) -> Result<Lead, RankError> {
    let (mut scratch, mut leading) = (Scratch::default(), Vec::new());
    let apart = harms.iter().map(|harms| {
        leading_in(&mut scratch, policy, stakes, harms, &mut leading)?;
        Ok(leading[second].hi() - leading[first].hi())
    });
    Ok(Lead::of(&apart.collect::<Result<Vec<f64>, _>>()?))
}

#[cfg(test)]
mod tests;
