//! What ranking needs of a candidate, of one contact or of several.

use crate::assess::Risk;
use crate::harm::CandidateHarm;
use crate::interval::Interval;
use crate::rule::Others;

/// What ranking needs of a candidate.
pub trait Assessed {
    /// Probability that all of it happens, given the choice.
    fn probability(&self) -> f64;
    /// Energy lost (J).
    fn energy_j(&self) -> Interval;
    /// The persons whom anything may happen to; everybody else is untouched.
    fn risks(&self) -> impl Iterator<Item = Risk>;
    /// Who may be there besides those at stake, in all parties of the request: how many, and the
    /// upper ends of the model range of those of them who are in a contact, summed.
    fn others(&self) -> Others;
    /// Whether no open work can change any of this.
    fn is_done(&self) -> bool;
    /// Whether there are no figures.
    fn is_unevaluable(&self) -> bool;
}

impl Assessed for CandidateHarm {
    fn probability(&self) -> f64 {
        self.probability
    }

    fn energy_j(&self) -> Interval {
        self.energy_j
    }

    fn risks(&self) -> impl Iterator<Item = Risk> {
        self.persons.iter().map(Risk::of)
    }

    fn others(&self) -> Others {
        Others::default()
    }

    fn is_done(&self) -> bool {
        self.is_settled() && !self.is_open
    }

    fn is_unevaluable(&self) -> bool {
        self.unevaluable.is_some()
    }
}
