//! From contact to harm: dynamics and injury curves at both ends of everything that is open.
//!
//! The work interval takes nominal parameters, and lever arms and normals over all that open jobs
//! may find; the model range takes parameters, normals, sides and curves at their worst ends
//! besides. Every input is monotone ([`crate::dynamics`]), so end points suffice.
//!
//! Nothing here compares candidates; of a policy, only the severity level matters here.

use crate::approach::Approach;
use crate::contact::{Contact, Normals, PerNormal, Places};
use crate::curve::Level;
use crate::dynamics::{ParameterError, Parameters, Response};
use crate::evidence::{Evidence, Touch};
use crate::harm::{CandidateHarm, DeltaV, PersonHarm, Unevaluable};
use crate::injury::{Curves, MissingCurve};
use crate::interval::{Interval, Range};
use crate::party::{CollisionParty, PartyError, PersonId};
use crate::path::Meeting;
use crash::Crash;

pub use bounds::{CandidateBounds, Risk, bounds, bounds_in};

mod bounds;
mod crash;
mod person;
#[cfg(test)]
mod tests;

/// One candidate: two parties on their way towards each other.
#[derive(Clone, Copy, Debug)]
pub struct Encounter<'a> {
    /// Hulls and relative motion.
    pub approach: &'a Approach,
    /// What [`crate::plan`] made of them.
    pub meeting: &'a Meeting,
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
    /// A parameter is unusable.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// A person has no curve.
    #[error(transparent)]
    Curve(#[from] MissingCurve),
}

/// Computes the harm of one candidate from what is known of its contact.
///
/// If `meeting` says that the bodies never meet, `evidence` is ignored.
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
    check(encounter, basis)?;
    let nothing = Evidence::none((0.0, 0.0));
    let crash = crash(encounter, evidence, &nothing, basis);
    let Encounter { approach, meeting, a, b, probability } = *encounter;
    let (evidence, touch, concave) = (crash.evidence, crash.touch, crash.concave);
    let parameters = basis.parameters;
    let gap = approach.nearest().gap_m;
    let near_miss = touch == Touch::No && gap < parameters.pose_error_m;
    // Bodies that may yet pass without contact may pass that near.
    let missed = (touch == Touch::Unknown && gap < parameters.pose_error_m).then(|| crash.missed());
    let mut harm = CandidateHarm {
        probability,
        closing_m_s: approach.closing_m_s + 0.0,
        normal_m_s: Interval::ZERO,
        tangential_m_s: Interval::ZERO,
        contact: Contact { touch, near_miss, hull_gap_m: gap + 0.0, patch: None },
        delta_v: [DeltaV::default(); 2],
        response: Response::default(),
        levers_m: [[0.0; 2]; 2],
        crush: None,
        force_degrees: [0.0; 2],
        impulse_n_s: [0.0; 3],
        energy_j: Interval::ZERO,
        persons,
        coarse_path: matches!(meeting, Meeting::Path(path) if path.coarse),
        concave,
        unevaluable: None,
        is_open: evidence.is_open(),
    };
    if *meeting == Meeting::AlreadyOverlapping {
        harm.unevaluable = Some(Unevaluable::AlreadyOverlapping);
        harm.energy_j = Interval::new(0.0, crash.energy_at_most());
    } else if touch != Touch::No {
        crash.describe(&mut harm);
    } else if near_miss {
        harm.delta_v =
            [0, 1].map(|p| DeltaV { work: Interval::ZERO, range: crash.delta_v_range(p) });
    }
    for (party, body) in [a, b].into_iter().enumerate() {
        for person in &body.persons {
            let mut one = crash.person(party, person, basis)?;
            if let Some(missed) = &missed {
                let high = missed.person(party, person, basis)?.range.high();
                one.range = Range::new(one.range.low(), one.range.high().max(high));
            }
            if harm.unevaluable.is_some() {
                (one.work, one.range) = (Interval::new(0.0, 1.0), Range::new(0.0, 1.0));
                one.high_at_least = 0.0;
            } else if touch == Touch::No && !near_miss {
                (one.range, one.high_at_least, one.intrusion) = (Range::ZERO, 0.0, false);
            }
            harm.persons.push(one);
        }
    }
    Ok(harm)
}

/// Everything that the figures are computed from. `nothing` is the evidence of bodies that stay
/// apart.
fn crash<'a>(
    encounter: &Encounter<'a>,
    evidence: &'a Evidence,
    nothing: &'a Evidence,
    basis: &Basis<'a>,
) -> Crash<'a> {
    let Encounter { approach, meeting, a, b, .. } = *encounter;
    let parameters = basis.parameters;
    let (evidence, touch) = match meeting {
        Meeting::Path(_) => (evidence, evidence.touch()),
        Meeting::Never(_) => (nothing, Touch::No),
        Meeting::AlreadyOverlapping => (nothing, Touch::Unknown),
    };
    let concave = a.concave || b.concave;
    let (places, raise) = match (meeting, touch) {
        (Meeting::Path(path), Touch::Yes | Touch::Unknown) => {
            (Places::along(path, evidence.first_m()), 0.0)
        }
        _ => (Places::missed(approach, parameters.pose_error_m), parameters.pose_error_m),
    };
    let normals = if concave {
        Normals::head_on()
    } else {
        let r = places.patch_end;
        Normals::between(approach, r.lo(), r.hi(), raise)
    };
    let reach = approach.reach(places.first.lo(), places.patch_end.hi());
    let crash = Crash {
        approach,
        evidence,
        parties: [a, b],
        parameters,
        normals,
        places,
        reach,
        touch,
        concave,
        ends: PerNormal::new(),
    };
    crash.with_ends()
}

fn check(encounter: &Encounter<'_>, basis: &Basis<'_>) -> Result<(), AssessError> {
    let Encounter { approach, a, b, probability, .. } = *encounter;
    approach.check()?;
    basis.parameters.check()?;
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
