//! What of a contact does not depend on policy and curves: it is assessed again from this, in other
//! worlds or under other criteria, without geometry.

use crate::request::Candidate;
use damage::{Approach, CollisionParty, Encounter, Plane};
use scenario::Name;

/// A contact, once its plane is laid.
#[derive(Clone, Debug)]
pub(super) struct ContactFacts {
    /// The name of its candidate.
    pub(super) candidate: Name,
    /// The numbers of the ego and of the other party.
    pub(super) parties: [usize; 2],
    approach: Approach,
    /// None if the bodies overlap from the start and stand.
    plane: Option<Plane>,
    a: CollisionParty,
    b: CollisionParty,
    probability: f64,
}

impl ContactFacts {
    /// Those of a candidate of a request whose plane is laid, unless it is stuck.
    pub(super) fn of(candidate: &Candidate, parties: [usize; 2]) -> Self {
        let Candidate { name, approach, plane, a, b, probability, .. } = candidate;
        Self {
            candidate: name.clone(),
            parties,
            approach: approach.clone(),
            plane: plane.get().copied(),
            a: a.clone(),
            b: b.clone(),
            probability: *probability,
        }
    }

    /// As [`damage::assess`] takes it.
    pub(super) fn encounter(&self) -> Encounter<'_> {
        let Self { approach, plane, a, b, probability, .. } = self;
        Encounter { approach, plane: plane.as_ref(), a, b, probability: *probability }
    }
}
