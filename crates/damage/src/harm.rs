//! The harm of one candidate: what its collision does to every person in it, with both intervals.
//!
//! What only grazes, and what only hits a mirror, exchanges no impulse. A candidate that
//! cannot be evaluated counts as `[0, 1]` for everyone in it, with the reason; it is never dropped.
//! These are immutable values: [`crate::assess()`] makes them, [`crate::rank()`] compares them.

use crate::contact::ContactPatch;
use crate::crush::Crush;
use crate::curve::Dose;
use crate::dynamics::Response;
use crate::injury::{Quantity, Victim};
use crate::interval::{Interval, Range};
use crate::party::PersonId;
use body::Seat;
use schemars::JsonSchema;
use serde::Serialize;
use std::sync::Arc;

/// What a collision does to one person.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonHarm {
    /// Who.
    pub id: PersonId,
    /// 0: with A, 1: with B.
    pub party: usize,
    /// Where; `None` on foot.
    pub seat: Option<Seat>,
    /// The kind of victim that the nominal curve takes this person for; the side struck is that of
    /// the nominal normal.
    pub victim: Victim,
    /// The nominal curve.
    pub curve: Arc<str>,
    /// The quantity it is a function of ...
    pub x: Quantity,
    /// ... and its value (m/s).
    pub x_m_s: Interval,
    /// The height of the edge of the front that strikes a person (m), else 0.
    pub front_m: f64,
    /// Probability of injury at the policy's level, given the collision.
    pub work: Interval,
    /// That probability, over the model range.
    pub range: Range,
    /// The least that the upper end of `range` can come down to when all work is done.
    pub high_at_least: f64,
    /// A zone beside this seat is hit: `range` reaches up to the worst side.
    pub intrusion: bool,
    /// x lies outside the range that the curve's sample supports.
    pub extrapolated: bool,
}

impl PersonHarm {
    /// What the nominal curve is a function of.
    #[must_use]
    pub fn dose(&self) -> Dose {
        Dose { speed_m_s: self.x_m_s.hi(), front_m: self.front_m }
    }
}

/// Change of velocity of one party (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct DeltaV {
    /// With nominal parameters.
    pub work: Interval,
    /// With restitution, friction, masses, gyration, speed and normal at their ends.
    pub range: Range,
}

/// Why a candidate cannot be evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Unevaluable {
    /// The bodies overlap before the path begins, or at standstill.
    AlreadyOverlapping,
}

/// The harm of one candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CandidateHarm {
    /// Probability of the collision, 1 unless the planner says otherwise.
    pub probability: f64,
    /// Horizontal closing speed of the centres of mass, |v_rel| (m/s).
    pub closing_m_s: f64,
    /// Closing speed along the normal at the point of contact, v_n (m/s), at least 0.
    pub normal_m_s: f64,
    /// Sliding speed across it, v_t (m/s), positive if A slides to the left of the normal.
    pub tangential_m_s: f64,
    /// What the contact is like; `None` if the candidate cannot be evaluated.
    pub contact: Option<ContactPatch>,
    /// Change of velocity: of A, of B.
    pub delta_v: [DeltaV; 2],
    /// Impulses and energy with nominal parameters.
    pub response: Response,
    /// From the centre of mass to the point of contact, along the normal and to its left (m): of A,
    /// of B.
    pub arms_m: [[f64; 2]; 2],
    /// Restitution and friction that the nominal computation took: e, and μ or, along a long flat
    /// face, the greatest ratio of both impulses.
    pub surface: [f64; 2],
    /// Yaw rates before and after (rad/s): of A, of B.
    pub yaw_rad_s: [[f64; 2]; 2],
    /// Crush by stiffness beside the depth; `None` where a stiffness is not configured.
    pub crush: Option<Crush>,
    /// Where the force comes from in each body's frame (degrees from forward, left positive).
    pub force_degrees: [f64; 2],
    /// The impulse on B with nominal parameters, that of `response`, in A's frame (N s); A has the
    /// opposite one.
    pub impulse_n_s: [f64; 3],
    /// Kinetic energy lost (J): the measure of property damage.
    pub energy_j: Interval,
    /// Everyone in either party; all other persons of the request are untouched.
    pub persons: Vec<PersonHarm>,
    /// Set if there are no figures for this candidate.
    pub unevaluable: Option<Unevaluable>,
    /// Work is still open: zones, the size of the patch, and with them the upper ends of ranges.
    pub is_open: bool,
}

impl CandidateHarm {
    /// Whether no open work can change any figure that ranks.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.unevaluable.is_none()
            && self.energy_j.is_settled()
            && self.persons.iter().all(|p| p.work.is_settled())
    }
}
