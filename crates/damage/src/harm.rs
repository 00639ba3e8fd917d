//! The harm of one candidate: what its collision does to every person in it, with both intervals.
//!
//! Without contact everything is exactly 0, whatever boxes or hulls suggest. A candidate that
//! cannot be evaluated counts as `[0, 1]` for everyone in it, with the reason; it is never dropped.
//! These are immutable values: [`crate::assess()`] makes them, [`crate::rank()`] compares them.

use crate::contact::Contact;
use crate::crush::Crush;
use crate::dynamics::Response;
use crate::evidence::Touch;
use crate::injury::{Quantity, Victim};
use crate::interval::{Interval, Range};
use crate::party::PersonId;
use body::Seat;
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

/// Change of velocity of one party (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DeltaV {
    /// With nominal parameters.
    pub work: Interval,
    /// With restitution, friction, masses, gyration, speed and normal at their ends.
    pub range: Range,
}

/// Why a candidate cannot be evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
    /// Horizontal closing speed |v_rel| (m/s).
    pub closing_m_s: f64,
    /// Closing speed along the nominal normal, v_n (m/s).
    pub normal_m_s: Interval,
    /// Sliding speed across it, v_t (m/s).
    pub tangential_m_s: Interval,
    /// What the contact is like.
    pub contact: Contact,
    /// Change of velocity: of A, of B.
    pub delta_v: [DeltaV; 2],
    /// Impulses and energy with nominal parameters, at the end of open work that does most.
    pub response: Response,
    /// Lever arms h across and q along the nominal normal (m), those of `response`: of A, of B.
    pub levers_m: [[f64; 2]; 2],
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
    /// The limit on poses made the path coarse.
    pub coarse_path: bool,
    /// A body is concave: the normal is u, and the model range begins at 0.
    pub concave: bool,
    /// Set if there are no figures for this candidate.
    pub unevaluable: Option<Unevaluable>,
    /// Work is still open.
    pub is_open: bool,
}

impl CandidateHarm {
    /// Whether no open work can change any figure that ranks.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.unevaluable.is_none()
            && self.contact.touch != Touch::Unknown
            && self.energy_j.is_settled()
            && self.persons.iter().all(|p| p.work.is_settled())
    }
}
