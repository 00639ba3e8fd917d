//! What is certain of an order while work is open: computed after every result, so from bounds
//! alone.

use super::{Each, RankError, RankOrder, Scratch, taken};
use crate::assess::CandidateBounds;
use crate::interval::Interval;
use crate::policy::{Policy, Step};
use crate::rule::Stake;

/// Who can still win, and how sure the order is by now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Candidates that can still win, in the order of the request.
    pub possible: Vec<usize>,
    /// Number of leading places that no open work can change.
    pub settled: usize,
    /// The candidate that would be first in an answer given now.
    pub incumbent: usize,
    /// Per candidate: what the first undecided step of the policy compares, over open work.
    pub compared: Vec<Interval>,
}

/// What is certain so far, as [`super::rank()`] finds it.
///
/// # Errors
///
/// As [`super::rank()`].
pub fn standing(
    policy: &Policy,
    stakes: &[Stake],
    bounds: &[CandidateBounds],
) -> Result<Standing, RankError> {
    let mut standing = Standing::default();
    standing_in(&mut Scratch::default(), policy, stakes, bounds, &mut standing)?;
    Ok(standing)
}

/// [`standing()`] in reused buffers, to avoid allocation: it is called after every result. The
/// contents of `standing` are replaced unless there is an error.
///
/// # Errors
///
/// As [`super::rank()`].
pub fn standing_in(
    scratch: &mut Scratch,
    policy: &Policy,
    stakes: &[Stake],
    bounds: &[CandidateBounds],
    standing: &mut Standing,
) -> Result<(), RankError> {
    if bounds.is_empty() {
        return Err(RankError::NoCandidates);
    }
    let Scratch { figures, steps, .. } = scratch;
    let figures = taken(figures, bounds.len());
    for (k, (figures, bounds)) in figures.iter_mut().zip(bounds).enumerate() {
        figures.bound(k, bounds, stakes.len())?;
    }
    policy.write_steps(stakes.len(), steps);
    let order = RankOrder { policy, stakes, steps, figures };
    let (possible, settled) = order.settled(|k| bounds[*k].is_done);
    let all: Each<usize> = (0..bounds.len()).collect();
    order.compare(&possible, &mut standing.compared);
    standing.incumbent = order.round(&all).winner;
    standing.settled = settled;
    standing.possible.clear();
    standing.possible.extend_from_slice(&possible);
    Ok(())
}

/// Whether a policy compares upper ends of the model range.
#[must_use]
pub fn needs_high(policy: &Policy) -> bool {
    policy.levels.iter().any(|step| matches!(step, Step::Accept { .. }))
}

impl RankOrder<'_> {
    /// What is compared by the first step that does not find all possible winners equal and
    /// settled.
    fn compare(&self, possible: &[usize], last: &mut Vec<Interval>) {
        last.clear();
        for step in self.steps {
            let compared_by_step = |k: usize| match step {
                Step::Least { measure, .. } => self.over(measure, k),
                Step::Accept { .. } => self.figures[k].greatest_high_over(),
            };
            last.clear();
            last.extend((0..self.figures.len()).map(compared_by_step));
            let first = possible.first().map(|k| last[*k]);
            let is_open = |k: &usize| !last[*k].is_settled() || Some(last[*k]) != first;
            if possible.iter().any(is_open) {
                break;
            }
        }
    }
}
