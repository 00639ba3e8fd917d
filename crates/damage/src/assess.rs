//! From contact to harm: impulse and injury curves.
//!
//! Outlines give the plane of the contact, and with it the nominal figures, before any job. What
//! open jobs may still find are zones beside seats: these lift the upper end of the model range.
//! The work interval of a contact therefore has width 0; those of a course are open while contacts
//! on it are sought.
//!
//! The model range samples friction, the radius of gyration and the normal, as ΔV is not monotone
//! in them, and takes restitution, masses and speed at their ends, where it is. It is an expert
//! range, sound on the samples; only the work interval is proven.
//!
//! Nothing here compares candidates; of a policy, only the severity level matters here.

use crate::approach::Approach;
use crate::contact::describe;
use crate::curve::Level;
use crate::dynamics::Response;
use crate::evidence::Evidence;
use crate::harm::{CandidateHarm, DeltaV, PersonHarm, Unevaluable};
use crate::injury::{Curves, MissingCurve};
use crate::interval::{Interval, Range};
use crate::parameters::Parameters;
use crate::party::{CollisionParty, PartyError, PersonId};
use crate::plane::Plane;
use crash::Crash;

pub(crate) use crash::Drawn;

pub use bounds::{CandidateBounds, Risk, bounds, bounds_in};

mod bounds;
mod crash;
mod person;
#[cfg(test)]
mod tests;

/// One candidate: two parties at the moment of first contact.
#[derive(Clone, Copy, Debug)]
pub struct Encounter<'a> {
    /// Extents and relative motion.
    pub approach: &'a Approach,
    /// The plane of the contact; `None`: they overlap from the start and stand, which cannot be
    /// evaluated.
    pub plane: Option<&'a Plane>,
    /// The ego vehicle.
    pub a: &'a CollisionParty,
    /// What it meets.
    pub b: &'a CollisionParty,
    /// Probability that this happens, given the choice.
    pub probability: f64,
}

/// The curves, severity level and parameters that harm is computed with.
#[derive(Clone, Copy, Debug)]
pub struct Basis<'a> {
    /// Injury curves.
    pub curves: &'a Curves,
    /// Severity that counts: the policy's.
    pub level: Level,
    /// Parameters of contact and dynamics.
    pub parameters: &'a Parameters,
}

/// A candidate that is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AssessError {
    /// A party is unusable.
    #[error("party {0}: {1}")]
    Party(char, PartyError),
    /// Neither party can move.
    #[error("both parties are fixed to the ground: at least one needs a mass")]
    BothFixed,
    /// Not a probability.
    #[error("collision probability is not in [0, 1]")]
    Probability,
    /// The approach is unusable.
    #[error(transparent)]
    Approach(#[from] crate::approach::ApproachError),
    /// A person has no curve.
    #[error(transparent)]
    Curve(#[from] MissingCurve),
}

/// Computes the harm of one candidate from what is known of its contact.
///
/// # Errors
///
/// Masses or gyration that are not above 0, both parties fixed, a person twice, persons in a fixed
/// object, a probability outside [0, 1], a person without a curve: see [`AssessError`].
pub fn assess(
    encounter: &Encounter<'_>,
    evidence: &Evidence,
    basis: &Basis<'_>,
) -> Result<CandidateHarm, AssessError> {
    assess_in(encounter, evidence, basis, Vec::new())
}

/// [`assess()`] that reuses a list of persons, to avoid allocation.
///
/// # Errors
///
/// As [`assess()`].
pub fn assess_in(
    encounter: &Encounter<'_>,
    evidence: &Evidence,
    basis: &Basis<'_>,
    mut persons: Vec<PersonHarm>,
) -> Result<CandidateHarm, AssessError> {
    persons.clear();
    check(encounter)?;
    let Encounter { approach, plane, a, b, probability } = *encounter;
    let yaw = approach.yaw_rad_s;
    let mut harm = CandidateHarm {
        probability,
        closing_m_s: approach.closing_m_s + 0.0,
        normal_m_s: 0.0,
        tangential_m_s: 0.0,
        contact: None,
        delta_v: [DeltaV::default(); 2],
        response: Response::default(),
        arms_m: [[0.0; 2]; 2],
        surface: [0.0; 2],
        yaw_rad_s: yaw.map(|rate| [rate, rate]),
        crush: None,
        force_degrees: [0.0; 2],
        impulse_n_s: [0.0; 3],
        energy_j: Interval::ZERO,
        persons,
        unevaluable: None,
        is_open: evidence.is_open(),
    };
    // A plane of any kind serves to name the curve of a person where nothing can be evaluated.
    let head_on = Plane::across_motion(approach, [a.centre_m, b.centre_m]);
    let plane_or_any = plane.unwrap_or(&head_on);
    let crash = Crash::new(encounter, plane_or_any, basis.parameters, &Drawn::stated(encounter));
    if plane.is_some() {
        let patch = describe(approach, evidence, crash.plane, crash.long_face_of());
        crash.describe(&mut harm, &patch);
        harm.contact = Some(patch);
    } else {
        harm.unevaluable = Some(Unevaluable::AlreadyOverlapping);
        harm.energy_j = Interval::new(0.0, crash.energy_at_most());
    }
    for (party, body) in [a, b].into_iter().enumerate() {
        for person in &body.persons {
            let mut one = crash.person(party, person, evidence, basis)?;
            if harm.unevaluable.is_some() {
                (one.work, one.range) = (Interval::new(0.0, 1.0), Range::new(0.0, 1.0));
                one.high_at_least = 0.0;
            }
            harm.persons.push(one);
        }
    }
    Ok(harm)
}

/// The nominal risk of everybody in a contact, as [`assess()`] has it, and the energy lost (J).
/// Nothing is computed but that: for assessments by the thousand. A contact that cannot be
/// evaluated has none.
///
/// # Errors
///
/// A person without a curve, or in a fixed object; masses, probabilities and persons are assumed to
/// be checked.
pub fn nominal(
    encounter: &Encounter<'_>,
    basis: &Basis<'_>,
    take: impl FnMut(PersonId, f64),
) -> Result<f64, AssessError> {
    nominal_of(encounter, &Drawn::stated(encounter), basis, take)
}

/// [`nominal()`] with these masses and parameters in place of what the parties state.
pub(crate) fn nominal_of(
    encounter: &Encounter<'_>,
    drawn: &Drawn,
    basis: &Basis<'_>,
    mut take: impl FnMut(PersonId, f64),
) -> Result<f64, AssessError> {
    let Some(plane) = encounter.plane else { return Ok(0.0) };
    let crash = Crash::new(encounter, plane, basis.parameters, drawn);
    crash.risks(basis, |id, risk| take(id, risk.hi()))?;
    Ok(crash.nominal.energy_j)
}

fn check(encounter: &Encounter<'_>) -> Result<(), AssessError> {
    let Encounter { approach, a, b, probability, .. } = *encounter;
    approach.check()?;
    for (name, party) in [('A', a), ('B', b)] {
        party.check().map_err(|error| AssessError::Party(name, error))?;
    }
    if a.mass_kg.is_none() && b.mass_kg.is_none() {
        return Err(AssessError::BothFixed);
    }
    let twice = |id: PersonId| AssessError::Party('B', PartyError::Twice(id));
    match b.persons.iter().find(|p| a.persons.iter().any(|q| q.id == p.id)) {
        Some(person) => return Err(twice(person.id)),
        None if !(0.0..=1.0).contains(&probability) => return Err(AssessError::Probability),
        None => {}
    }
    Ok(())
}
