//! A contact that comes next, as a candidate of a request: what comes about, and with which plane.

use super::Course;
use super::assessed_contact::contact;
use super::persons::People;
use super::way::{Begin, NextContact, Scenery};
use crate::request::{Candidate, RequestError};
use crate::workspace::BodySet;
use body::Outlines;
use bvh::support::{Extremes, support_from};
use damage::approach::STANDSTILL_M_S;
use damage::course::Severity;
use damage::{Basis, Criteria, Evidence, assess};
use geometry::DVec3;

/// A contact that comes next, and the same as a candidate of a request.
pub(super) type Found = (NextContact, Box<Candidate>);

/// What contacts are assembled from.
#[derive(Clone, Copy)]
pub(super) struct Assembly<'a, 'r> {
    pub(super) scenery: &'a Scenery<'r>,
    pub(super) people: &'a People,
    pub(super) stage: &'a BodySet<'r>,
    pub(super) criteria: &'a Criteria,
    /// Extremes of each body, if the stage has none; may be empty.
    pub(super) extremes: &'a [Extremes],
    /// Whether there is a deadline.
    pub(super) has_limit: bool,
}

/// How a course goes on at a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then {
    /// The contact has to be surveyed.
    Survey,
    /// The bodies part.
    Part,
    /// They were in contact before, and it stays as light as it was: no survey changes that.
    Pass,
}

impl Assembly<'_, '_> {
    /// What comes about where course `k` meets somebody next, and how it goes on.
    pub(super) fn contact(
        &self,
        k: usize,
        course: &Course<'_>,
        meeting: &NextContact,
    ) -> Result<(Box<Candidate>, Then), RequestError> {
        let Self { scenery, people, stage, extremes, has_limit, .. } = self;
        let support_of = |model: usize, direction: DVec3, near: &mut Option<[f32; 3]>| {
            let view = &stage.bodies[model].1;
            let extremes = stage.extremes.unwrap_or(extremes).get(model);
            support_from(extremes, view, direction, near)
        };
        let is_member = self.is_member(k);
        let contact = contact(scenery, people, course, meeting, &support_of, is_member)?;
        let contact = Box::new(contact);
        let approach = &contact.approach;
        let is_slow = approach.closing_m_s < STANDSTILL_M_S;
        let parts = !contact.is_stuck && (is_slow || !approach.is_closing());
        let then = match meeting.begin {
            Begin::AtStart if parts => Then::Part,
            Begin::Again if self.stays_light(&contact)? => Then::Pass,
            Begin::AtStart | Begin::Again | Begin::Touched => Then::Survey,
        };
        // After a deadline nothing may be left to do but to assess what was found.
        if then == Then::Survey && *has_limit {
            self.lay_plane(&contact);
        }
        Ok((contact, then))
    }

    /// Whether a course is followed in a member, not in the scene as stated.
    pub(super) fn is_member(&self, k: usize) -> bool {
        k >= self.scenery.scenario.candidates.len()
    }

    /// The outlines of both bodies of a contact.
    pub(super) fn outlines(&self, contact: &Candidate) -> [&Outlines; 2] {
        [contact.model_a, contact.model_b]
            .map(|model| &self.stage.bodies[model as usize].0.outlines)
    }

    /// Lays the plane of a contact, unless it is laid.
    pub(super) fn lay_plane(&self, contact: &Candidate) {
        contact.lay_plane(self.outlines(contact));
    }

    /// Whether a contact is light for the ego, which its plane alone decides.
    fn stays_light(&self, contact: &Candidate) -> Result<bool, RequestError> {
        let Criteria { curves, policy, parameters } = self.criteria;
        if !contact.may_be_heavy(parameters) {
            return Ok(true);
        }
        self.lay_plane(contact);
        let basis = Basis { curves, level: policy.outcome, parameters };
        let harm = assess(&contact.encounter(), &Evidence::none(), &basis)
            .map_err(|source| RequestError::Assess { name: contact.name.to_string(), source })?;
        Ok(harm.is_settled() && Severity::of(&harm).0 == Severity::Light)
    }
}
