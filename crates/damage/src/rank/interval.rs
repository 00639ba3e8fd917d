//! Which candidates can still win, whatever open work finds.
//!
//! Let K be the candidates that the finished run would keep after a step. Two sets enclose it, S ⊆
//! K ⊆ P, from all candidates on. At a step with tolerance, the least value m of the finished run
//! lies between the least lower end over P and the least upper end over S (if S is empty, the
//! greatest upper end over P). So P keeps whose lower end may be within tolerance of m, and S whose
//! upper end must be.
//!
//! A step that accepts a risk, and falls back on a named candidate if there is none, encloses K as
//! the union of both cases while it is open which one it is. A policy that refuses all instead is
//! in its order as one that goes on; but no place is certain while the refusal is not.
//!
//! At the end every possible winner is in P. If P has one member it is the winner. So is a finished
//! member of S that the tie-break takes from P whatever the open members of P turn out to be:
//! because it is in K, and best of a set that holds K.

use super::{Each, RankOrder, rounded};
use crate::interval::Interval;
use crate::policy::{Otherwise, Step, TieBreak};
use core::cmp::Ordering;

/// What encloses the candidates that the finished run would keep.
pub(super) struct Outlook {
    /// P: no other candidate can win.
    pub(super) possible: Each<usize>,
    /// S: kept for sure.
    pub(super) sure: Each<usize>,
    /// Open work can change whether the policy refuses all of them.
    pub(super) may_refuse: bool,
}

impl Outlook {
    /// Whether the sets enclose anything less than they did.
    fn retain(&mut self, possible: impl Fn(usize) -> bool, sure: impl Fn(usize) -> bool) {
        self.possible.retain(|k| possible(*k));
        self.sure.retain(|k| sure(*k));
    }
}

impl RankOrder<'_> {
    /// Who can still win, and how many of the first places no open work can change.
    ///
    /// Ranks are found one by one, as in the order itself: once the first is certain it is removed,
    /// and the next one is sought among the rest.
    pub(super) fn settled(&self, is_done: impl Fn(&usize) -> bool) -> (Each<usize>, usize) {
        let mut left: Each<usize> = (0..self.figures.len()).collect();
        let mut possible = None;
        let mut settled = 0;
        while !left.is_empty() {
            let outlook = self.outlook(&left);
            let winner = self.certain(&outlook, &is_done);
            // What is refused, all together are.
            let may_refuse = possible.is_none() && outlook.may_refuse;
            possible.get_or_insert(outlook.possible);
            let Some(winner) = winner.filter(|_| !may_refuse) else { break };
            left.retain(|k| *k != winner);
            settled += 1;
        }
        (possible.unwrap_or_default(), settled)
    }

    /// The certain winner, if there is one.
    fn certain(&self, outlook: &Outlook, is_done: &impl Fn(&usize) -> bool) -> Option<usize> {
        if let [only] = outlook.possible[..] {
            return Some(only);
        }
        let sure: Each<usize> = outlook.sure.iter().copied().filter(|k| is_done(k)).collect();
        let winner = sure.first().map(|_| self.tie_winner(&sure))?;
        let loses = |k: &usize| *k == winner || self.wins_tie(winner, *k, is_done(k));
        outlook.possible.iter().all(loses).then_some(winner)
    }

    /// Whether the tie-break takes the finished `k` before `l`, whatever open work finds of `l`.
    fn wins_tie(&self, k: usize, l: usize, is_done: bool) -> bool {
        for by in &self.policy.tie_break {
            let first = self.tie_value(*by, k);
            let second = if is_done { self.tie_value(*by, l) } else { self.tie_at_least(*by, l) };
            match first.total_cmp(&second) {
                Ordering::Less => return true,
                Ordering::Greater => return false,
                // Open work can only raise the other one's.
                Ordering::Equal => {}
            }
        }
        k < l
    }

    /// What open work cannot bring a [`RankOrder::tie_value`] below.
    fn tie_at_least(&self, by: TieBreak, k: usize) -> f64 {
        match by {
            TieBreak::BrakeInLane => self.preference(k),
            TieBreak::Energy => self.figures[k].energy_j.lo(),
            TieBreak::High => self.leading(k).0.lo(),
            TieBreak::Request => k as f64,
        }
    }

    /// Takes all steps on intervals, among the candidates left.
    pub(super) fn outlook(&self, left: &[usize]) -> Outlook {
        let mut outlook = Outlook { possible: left.into(), sure: left.into(), may_refuse: false };
        for step in self.steps {
            match step {
                Step::Least { measure, tolerance } => {
                    let over: Each<Interval> =
                        (0..self.figures.len()).map(|k| self.over(measure, k)).collect();
                    least(&mut outlook, &over, *tolerance);
                }
                Step::Accept { at_most, otherwise } => {
                    let highs: Each<Interval> =
                        self.figures.iter().map(|f| f.greatest_high_over()).collect();
                    accept(&mut outlook, &highs, rounded(*at_most), otherwise);
                }
            }
        }
        outlook
    }
}

/// A step that keeps what is within `tolerance` of the least; `over` is by candidate.
pub(super) fn least(outlook: &mut Outlook, over: &[Interval], tolerance: f64) {
    let least = |of: fn(Interval) -> f64, among: &[usize]| {
        among.iter().map(|k| of(over[*k])).fold(f64::INFINITY, f64::min)
    };
    let m_lo = least(Interval::lo, &outlook.possible);
    let m_hi = if outlook.sure.is_empty() {
        let ends = outlook.possible.iter().map(|k| over[*k].hi());
        ends.fold(f64::NEG_INFINITY, f64::max)
    } else {
        least(Interval::hi, &outlook.sure)
    };
    let (may, must) = (rounded(m_hi + tolerance), rounded(m_lo + tolerance));
    outlook.retain(|k| over[k].lo() <= may, |k| over[k].hi() <= must);
}

/// A step that keeps what is acceptable; if nothing is, the candidate to fall back on, or else
/// everything.
fn accept(outlook: &mut Outlook, highs: &[Interval], at_most: f64, otherwise: &Otherwise) {
    let fits = |of: fn(Interval) -> f64| move |k: usize| of(highs[k]) <= at_most;
    let some_surely = outlook.sure.iter().any(|k| fits(Interval::hi)(*k));
    let some_possibly = outlook.possible.iter().any(|k| fits(Interval::lo)(*k));
    if some_surely {
        // Some candidate is surely acceptable, so only acceptable ones are kept.
        outlook.retain(fits(Interval::lo), fits(Interval::hi));
        return;
    }
    let back = otherwise.fall_back().filter(|back| outlook.possible.contains(back));
    let is_sure = back.is_some_and(|back| outlook.sure.contains(&back));
    outlook.may_refuse |= match (otherwise, back) {
        (Otherwise::NextRule, _) => false,
        (_, Some(_)) => !is_sure,
        (_, None) => some_possibly,
    };
    let is_back = |k: usize| back == Some(k);
    match (some_possibly, back) {
        // Perhaps one: then only acceptable ones are kept, or else the one to fall back on.
        (true, Some(_)) if is_sure => {
            outlook.retain(|k| fits(Interval::lo)(k) || is_back(k), fits(Interval::hi));
        }
        // Perhaps: then any candidate may be kept, but only the acceptable ones must be.
        (true, _) => outlook.retain(|_| true, fits(Interval::hi)),
        (false, Some(_)) => outlook.retain(|k| is_back(k) || !is_sure, is_back),
        // Surely none: the step is skipped.
        (false, None) => {}
    }
}
