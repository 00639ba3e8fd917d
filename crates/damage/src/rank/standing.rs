//! What is certain of an order while work is open: asked after every result, so from bounds alone.

use super::figures::Figures;
use super::{Order, RankError};
use crate::assess::Bounds;
use crate::interval::Work;
use crate::policy::{Policy, Step};
use crate::rule::Stake;

/// Who can still win, and how sure the order is by now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Candidates that can still win, in the order of the request.
    pub possible: Vec<usize>,
    /// So many of the first places no open work can change.
    pub settled: usize,
    /// Who would stand first in an answer given now.
    pub incumbent: usize,
    /// Per candidate: what the first undecided step of the policy compares, over open work.
    pub compared: Vec<Work>,
}

/// What is certain by now, as [`super::rank()`] finds it.
///
/// # Errors
///
/// As [`super::rank()`].
pub fn standing(
    policy: &Policy,
    stakes: &[Stake],
    bounds: &[Bounds],
) -> Result<Standing, RankError> {
    let figures = bounds.iter().enumerate().map(|(k, b)| Figures::of(k, b, stakes.len()));
    let figures: Vec<Figures> = figures.collect::<Result<_, _>>()?;
    if figures.is_empty() {
        return Err(RankError::NoCandidates);
    }
    let order = Order { policy, stakes, steps: policy.steps(stakes.len()), figures: &figures };
    let (possible, settled) = order.settled(|k| bounds[*k].is_done);
    let all: Vec<usize> = (0..figures.len()).collect();
    let incumbent = order.round(&all).winner;
    Ok(Standing { compared: order.compared(&possible), possible, settled, incumbent })
}

/// Whether a policy compares upper ends of the model range.
#[must_use]
pub fn needs_high(policy: &Policy) -> bool {
    policy.levels.iter().any(|step| matches!(step, Step::Accept { .. }))
}

impl Order<'_> {
    /// What the first step compares that does not find all possible winners equal and settled.
    fn compared(&self, possible: &[usize]) -> Vec<Work> {
        let over = |step: &Step| -> Vec<Work> {
            let one = |k: usize| match step {
                Step::Least { measure, .. } => self.over(measure, k),
                Step::Accept { .. } => self.figures[k].greatest_high_over(),
            };
            (0..self.figures.len()).map(one).collect()
        };
        let mut last = Vec::new();
        for step in &self.steps {
            last = over(step);
            let first = possible.first().map(|k| last[*k]);
            let is_open = |k: &usize| !last[*k].is_settled() || Some(last[*k]) != first;
            if possible.iter().any(is_open) {
                break;
            }
        }
        last
    }
}
