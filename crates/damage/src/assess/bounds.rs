//! What ranking needs of one candidate while work is open, and no more: computed after every
//! result.
//!
//! The figures equal those of [`super::assess`] bit for bit. What is only shown is left out, and so
//! is the model range, which samples parameters and curves: it is computed once a candidate is
//! done, or earlier for a policy that accepts by it.

use super::crash::{Crash, Drawn};
use super::{AssessError, Basis, Encounter, assess_in};
use crate::evidence::Evidence;
use crate::harm::{CandidateHarm, PersonHarm};
use crate::interval::{Interval, Range};
use crate::party::PersonId;

/// The risk of one person in one candidate, given the collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Risk {
    /// Who.
    pub id: PersonId,
    /// Probability of injury.
    pub work: Interval,
    /// Probability of injury over the model range; `[0, 1]` where not requested.
    pub range: Range,
    /// The upper end of that range when all work is done; `[0, 1]` where not requested.
    pub high: Interval,
}

/// The figures of one candidate by which it ranks.
#[derive(Clone, Debug, PartialEq)]
pub struct CandidateBounds {
    /// Probability of the collision.
    pub probability: f64,
    /// Kinetic energy lost (J).
    pub energy_j: Interval,
    /// Everybody in either party.
    pub persons: Vec<Risk>,
    /// No open work can change any figure.
    pub is_done: bool,
}

impl Risk {
    /// The risk of a person who was assessed in full.
    #[must_use]
    pub fn of(person: &PersonHarm) -> Self {
        Self {
            id: person.id,
            work: person.work,
            range: person.range,
            high: Interval::new(person.high_at_least, person.range.high()),
        }
    }
}

impl CandidateBounds {
    /// The ranking figures of a candidate that was assessed in full.
    #[must_use]
    pub fn of(harm: &CandidateHarm) -> Self {
        Self::with(harm, Vec::new())
    }

    fn with(harm: &CandidateHarm, mut persons: Vec<Risk>) -> Self {
        persons.extend(harm.persons.iter().map(Risk::of));
        Self {
            probability: harm.probability,
            energy_j: harm.energy_j,
            persons,
            is_done: harm.is_settled() && !harm.is_open,
        }
    }
}

/// Bounds the figures of one candidate by which it ranks. With `high`, the upper ends of the model
/// range are bounded too, otherwise only where no work is open.
///
/// # Errors
///
/// As [`super::assess`], except that masses, probabilities and persons are assumed to be checked.
pub fn bounds(
    encounter: &Encounter<'_>,
    evidence: &Evidence,
    basis: &Basis<'_>,
    high: bool,
) -> Result<CandidateBounds, AssessError> {
    bounds_in(encounter, evidence, basis, high, (&mut Vec::new(), Vec::new()))
}

/// [`bounds()`] that reuses lists, to avoid allocation: bounds are computed after every result.
///
/// # Errors
///
/// As [`bounds()`].
pub fn bounds_in(
    encounter: &Encounter<'_>,
    evidence: &Evidence,
    basis: &Basis<'_>,
    high: bool,
    (assessed, mut persons): (&mut Vec<PersonHarm>, Vec<Risk>),
) -> Result<CandidateBounds, AssessError> {
    persons.clear();
    let plane = match encounter.plane {
        Some(plane) if !high && evidence.is_open() => plane,
        _ => {
            let harm = assess_in(encounter, evidence, basis, core::mem::take(assessed))?;
            let bounds = CandidateBounds::with(&harm, persons);
            *assessed = harm.persons;
            return Ok(bounds);
        }
    };
    let crash = Crash::new(encounter, plane, basis.parameters, &Drawn::stated(encounter));
    crash.risks(basis, |id, work| {
        let (range, high) = (Range::new(0.0, 1.0), Interval::new(0.0, 1.0));
        persons.push(Risk { id, work, range, high });
    })?;
    Ok(CandidateBounds {
        probability: encounter.probability,
        energy_j: Interval::exactly(crash.nominal.energy_j),
        persons,
        is_done: false,
    })
}
