//! What is asked of workers at once: contacts in the ego's frame, and the persons at stake.

use crate::candidate_state::FirstContact;
use body::{BodyKind, Meta, Outlines, OwnParameters, Seat, Zones};
use damage::approach::STANDSTILL_M_S;
use damage::dynamics::delta_v_at_most;
use damage::party::is_fixed;
use damage::rule::Stake;
use damage::{
    Aboard, Approach, CollisionParty, Criteria, Encounter, Footprint, Front, Parameters, Plane,
    Stiffness, heading,
};
use diagnostic::Diagnostic;
use geometry::motion::PathError;
use geometry::support::DIRECTIONS;
use geometry::{DVec3, Directions, Pose, RelativePose, Supports};
use scenario::Name;
use smallvec::SmallVec;
use std::borrow::Cow;
use std::sync::OnceLock;

/// One contact, before any work: a candidate, as far as this request goes.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) name: Name,
    pub(crate) other_name: Name,
    pub(crate) model_a: u32,
    pub(crate) model_b: u32,
    /// B seen from A at the given pose.
    pub(crate) pose: RelativePose,
    pub(crate) approach: Approach,
    /// The bodies overlap from the start and stand: nothing can be evaluated.
    pub(crate) is_stuck: bool,
    /// The plane of the contact, once it is laid; none if it is stuck.
    pub(crate) plane: OnceLock<Plane>,
    pub(crate) a: CollisionParty,
    pub(crate) b: CollisionParty,
    pub(crate) probability: f64,
    /// B is of unknown kind: it is taken as fixed to the ground.
    pub(crate) is_assumed_fixed: bool,
    /// The first contact, at travel 0.
    pub(crate) first: FirstContact,
    pub(crate) wanted: Wanted,
}

/// What the survey of a contact is to find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// The hit sets at every pose, and the patch: all that is shown of a contact.
    Everything,
    /// Which of these zones, of A and of B, are hit: all that any figure of harm depends on. Of a
    /// member nothing else is shown.
    Zones([Zones; 2]),
}

impl Wanted {
    /// No zone counts.
    pub(crate) const NOTHING: Self = Self::Zones([Zones(0); 2]);

    /// The zones beside the persons of both parties, as far as the first contact does not hit them.
    pub(crate) fn beside(parties: [&CollisionParty; 2], first: &FirstContact) -> Self {
        let seats = parties.map(|party| party.persons.iter().filter_map(|person| person.seat));
        let all = seats.map(|seats| seats.fold(0, |bits, seat| bits | seat.zone_bit()));
        Self::Zones([0, 1].map(|side: usize| Zones(all[side] & !first.zones[side].0)))
    }

    /// Those of the zones found that count.
    pub(crate) fn of(&self, found: [u16; 2]) -> [u16; 2] {
        match self {
            Self::Everything => found,
            Self::Zones(wanted) => [0, 1].map(|side: usize| found[side] & wanted[side].0),
        }
    }
}

impl Candidate {
    /// Whether any impact at this speed could be heavy for the ego.
    pub(crate) fn may_be_heavy(&self, parameters: &Parameters) -> bool {
        let masses = [self.a.mass_kg, self.b.mass_kg];
        // No point of a body moves faster than this against its centre.
        let of_turning = |p: usize, supports: &Supports, party: &CollisionParty| {
            let d = &self.approach.directions.d;
            let far = (0..DIRECTIONS).map(|i| supports.0[i] - party.centre_m.dot(d[i]));
            2.0 * far.fold(0.0, f64::max) * self.approach.yaw_rad_s[p].abs()
        };
        let speed_m_s = self.approach.closing_m_s
            + of_turning(0, &self.approach.supports_a, &self.a)
            + of_turning(1, &self.approach.supports_b, &self.b);
        let pair = parameters.of_pair([&self.a.own, &self.b.own]);
        delta_v_at_most(speed_m_s, masses, &pair) >= damage::course::HEAVY_M_S
    }

    /// Lays the plane of the contact, from the outlines of both bodies, at the point where they
    /// touch first, unless it is laid. Returns whether it was not.
    pub(crate) fn lay_plane(&self, [a, b]: [&Outlines; 2]) -> bool {
        if self.is_stuck || self.plane.get().is_some() {
            return false;
        }
        let of_a = Footprint::of(a, None, &self.approach);
        let of_b = Footprint::of(b, Some(&self.pose), &self.approach);
        let fronts = [Front::of(&self.a), Front::of(&self.b)];
        let point = self.first.witness.point;
        let plane = Plane::of(&self.approach, [&of_a, &of_b], fronts, point);
        self.plane.set(plane).is_ok()
    }

    /// As [`damage::assess`] takes it, once its plane is laid.
    pub(crate) fn encounter(&self) -> Encounter<'_> {
        debug_assert!(self.is_stuck || self.plane.get().is_some(), "no plane is laid");
        Encounter {
            approach: &self.approach,
            plane: self.plane.get(),
            a: &self.a,
            b: &self.b,
            probability: self.probability,
        }
    }
}

/// A person at stake, by name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Person {
    pub(crate) party: Name,
    pub(crate) seat: Option<Seat>,
    pub(crate) stake: Stake,
}

/// The fixed list of persons; as many as a planner may name need no allocation.
pub(crate) type Persons = SmallVec<[Person; damage::party::IN_PLACE]>;

/// Everything that is asked, and what it is judged by.
#[derive(Clone, Debug)]
pub(crate) struct Request {
    /// Kilobytes each, and taken from list to list.
    pub(crate) candidates: Vec<Box<Candidate>>,
    pub(crate) persons: Persons,
    pub(crate) criteria: Criteria,
}

/// A request that cannot be worked on.
#[derive(Clone, Debug, thiserror::Error)]
pub enum RequestError {
    /// A candidate's motion or bodies cannot be used.
    #[error("candidate \"{name}\": {source}")]
    Approach {
        /// Which one.
        name: String,
        /// Why.
        source: damage::ApproachError,
    },
    /// A candidate cannot be assessed.
    #[error("candidate \"{name}\": {source}")]
    Assess {
        /// Which one.
        name: String,
        /// Why.
        source: damage::AssessError,
    },
    /// What is drawn for a member leads nowhere.
    #[error("a member of the scene leads nowhere: {source}")]
    Member {
        /// Why.
        source: PathError,
    },
    /// Nearly every member has two bodies in one place.
    #[error("the ego overlaps \"{party}\" at 0 s in {replaced} of 1024 draws of where they may be")]
    Overlap {
        /// The party of the last such draw.
        party: String,
        /// How many draws overlap.
        replaced: u32,
    },
    /// The candidates cannot be ranked.
    #[error(transparent)]
    Rank(#[from] damage::RankError),
}

impl RequestError {
    /// Whether another policy or other curves may do without it.
    pub(crate) fn is_of_criteria(&self) -> bool {
        matches!(self, Self::Assess { .. } | Self::Rank(_))
    }
}

impl Diagnostic for RequestError {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Refused
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(match self {
            Self::Overlap { .. } => {
                "correct where they are, or state smaller errors of both".into()
            }
            Self::Member { .. } => "state smaller errors, or members = 1".into(),
            _ => "correct the candidate, or leave it out".into(),
        })
    }
}

/// What a scenario says of a party beyond its body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StatedParty {
    pub(crate) is_unknown: bool,
    pub(crate) mass_kg: Option<f64>,
    pub(crate) crush: Option<[f64; 2]>,
}

/// A party as dynamics see it; `to_ego` is the pose in A's frame of a party that is not A.
pub(crate) fn party(
    meta: &Meta,
    stated: StatedParty,
    to_ego: Option<&RelativePose>,
    aboard: impl Iterator<Item = Aboard>,
) -> CollisionParty {
    let centre = DVec3::from_array(meta.centre_m);
    let (centre_m, forward) = match to_ego {
        None => (centre, DVec3::X),
        Some(pose) => {
            let r = &pose.rotation;
            let row = |i: usize| {
                ((r[i][0] * centre.x + r[i][1] * centre.y) + r[i][2] * centre.z)
                    + pose.translation[i]
            };
            (DVec3::new(row(0), row(1), row(2)), DVec3::new(r[0][0], r[1][0], r[2][0]))
        }
    };
    // Of an unknown body only the shape counts: all else is assumed to be that of a wall.
    let kind = if stated.is_unknown { BodyKind::Wall } else { meta.kind };
    CollisionParty {
        kind,
        mass_kg: if is_fixed(kind) { None } else { stated.mass_kg.or(meta.mass_kg) },
        gyration_m: meta.gyration_m,
        centre_m,
        forward,
        stiffness: stated.crush.map(|[a_n_m, b_n_m2]| Stiffness { a_n_m, b_n_m2 }),
        front_m: meta.front_height_m.filter(|_| !is_fixed(kind)),
        own: if stated.is_unknown { OwnParameters::default() } else { meta.impact },
        persons: aboard.collect(),
    }
}

/// How two bodies move at a moment, in the world: velocities of their centres of mass (m/s) and
/// rates at which they turn (rad/s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motions {
    pub(crate) velocities_m_s: [DVec3; 2],
    pub(crate) rates_rad_s: [DVec3; 2],
    /// Velocity of A against B at a point where they touch (m/s).
    pub(crate) at_contact_m_s: DVec3,
}

/// Two bodies on their way: `pose_a` in the world, `pose` of B in A's frame.
pub(crate) fn approach(
    (mut support_a, mut support_b): (impl FnMut(DVec3) -> f64, impl FnMut(DVec3) -> f64),
    (pose_a, pose): (&Pose, &RelativePose),
    motions: &Motions,
    (a, b): (&CollisionParty, &CollisionParty),
) -> Approach {
    let to_a = |v: DVec3| Pose::direction_to_body(pose_a, v);
    let up = to_a(DVec3::Z);
    let level = |v: DVec3| v - up * v.dot(up);
    let [of_a, of_b] = motions.velocities_m_s;
    let relative = level(to_a(of_a - of_b));
    // Bodies whose centres keep their distance may still turn into each other.
    let towards =
        if relative.length() < STANDSTILL_M_S { to_a(motions.at_contact_m_s) } else { relative };
    let directions = Directions::around(heading(towards, b.centre_m - a.centre_m, up), up);
    let t = DVec3::from_array(pose.translation);
    let mut supports_a = Supports::EMPTY;
    let mut supports_b = Supports::EMPTY;
    for i in 0..DIRECTIONS {
        let d = directions.d[i];
        supports_a.0[i] = support_a(d);
        supports_b.0[i] = support_b(pose.direction_to_b(d)) + d.dot(t);
    }
    Approach {
        directions,
        velocity_m_s: relative,
        closing_m_s: relative.length(),
        yaw_rad_s: motions.rates_rad_s.map(|rate| to_a(rate).dot(up)),
        supports_a,
        supports_b,
    }
}
