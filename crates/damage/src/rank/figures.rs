//! The figures of one candidate that ranking uses: risks of all persons of the request, rounded.

use super::{Assessed, RankError};
use crate::assess::{CandidateBounds, Risk};
use crate::interval::Interval;
use crate::rule::Others;

/// Figures are rounded to this many parts per unit before they are compared: rounding of sums, and
/// the last bits in which equal crashes differ, must not order candidates.
const PARTS: f64 = 1e9;

/// A figure, rounded to 1e-9. Never falls when its argument rises.
pub(super) fn rounded(x: f64) -> f64 {
    (x * PARTS).round() / PARTS + 0.0
}

fn is_share(x: f64) -> bool {
    (0.0..=1.0).contains(&x)
}

/// One candidate, as ranking sees it; every list has one entry per person of the request.
#[derive(Clone, Debug, Default)]
pub(super) struct Figures {
    /// R = p·H over the work interval.
    pub(super) risks: Vec<Interval>,
    /// R over the model range. An `Interval` in form only: it passes through the same measures.
    pub(super) ranges: Vec<Interval>,
    /// The upper end of the model range, over what is open.
    pub(super) highs: Vec<Interval>,
    /// Energy lost (J).
    pub(super) energy_j: Interval,
    /// Persons who may be there besides.
    pub(super) others: Others,
}

impl Figures {
    /// Replaces these by the figures of candidate number `k`, among `n` persons.
    pub(super) fn bound(
        &mut self,
        k: usize,
        bounds: &CandidateBounds,
        n: usize,
    ) -> Result<(), RankError> {
        self.others = Others::default();
        self.fill((k, n), bounds.probability, bounds.energy_j, bounds.persons.iter().copied())
    }

    /// Replaces these by the figures of a candidate that was assessed in full.
    pub(super) fn assessed(
        &mut self,
        k: usize,
        harm: &impl Assessed,
        n: usize,
    ) -> Result<(), RankError> {
        self.others = harm.others();
        if !self.others.are_sound() {
            return Err(RankError::Figure(k));
        }
        self.fill((k, n), harm.probability(), harm.energy_j(), harm.risks())
    }

    fn fill(
        &mut self,
        (k, n): (usize, usize),
        probability: f64,
        energy: Interval,
        persons: impl Iterator<Item = Risk>,
    ) -> Result<(), RankError> {
        if !(is_share(probability) && energy.lo() >= 0.0 && energy.hi().is_finite()) {
            return Err(RankError::Figure(k));
        }
        let Self { risks, ranges, highs, .. } = self;
        for untouched in [&mut *risks, &mut *ranges, &mut *highs] {
            untouched.clear();
            untouched.resize(n, Interval::ZERO);
        }
        for person in persons {
            let i = person.id.0;
            if i >= n {
                return Err(RankError::UnknownPerson { candidate: k, person: person.id });
            }
            let (work, range, high) = (person.work, person.range, person.high);
            let ends = [work.lo(), work.hi(), range.low(), range.high(), high.lo(), high.hi()];
            if !ends.into_iter().all(is_share) {
                return Err(RankError::Figure(k));
            }
            let risk = |h: f64| rounded(probability * h);
            (risks[i], highs[i]) = (work.map(risk), high.map(risk));
            ranges[i] = Interval::new(risk(range.low()), risk(range.high()));
        }
        self.energy_j = energy.map(rounded);
        Ok(())
    }

    /// The greatest upper end of any person's model range.
    pub(super) fn greatest_high(&self) -> f64 {
        self.greatest_high_over().hi()
    }

    /// [`Figures::greatest_high`], over what is open.
    pub(super) fn greatest_high_over(&self) -> Interval {
        let greatest =
            |of: fn(Interval) -> f64| self.highs.iter().map(|h| of(*h)).fold(0.0, f64::max);
        Interval::new(greatest(Interval::lo), greatest(Interval::hi))
    }
}
