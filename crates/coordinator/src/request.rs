//! A request as the engine takes it: every candidate in the ego's frame, and the persons at stake.

use crate::candidate_state::FirstContact;
use body::{BodyKind, BodyView, Meta, Seat};
use bvh::support::{Extremes, support};
use damage::party::{is_concave, is_fixed};
use damage::rule::Stake;
use damage::{
    Aboard, Approach, CollisionParty, Curves, Encounter, Meeting, Parameters, PersonId, Policy,
    Stiffness, heading, occupants, plan,
};
use diagnostic::Diagnostic;
use geometry::support::DIRECTIONS;
use geometry::{DVec3, Directions, Pose, RelativePose, Supports};
use scenario::{Name, Scenario};
use smallvec::SmallVec;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

/// One candidate, before any work.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) name: Name,
    pub(crate) other_name: Name,
    pub(crate) model_a: u32,
    pub(crate) model_b: u32,
    /// B seen from A at the given pose.
    pub(crate) pose: RelativePose,
    pub(crate) approach: Approach,
    pub(crate) meeting: Meeting,
    pub(crate) a: CollisionParty,
    pub(crate) b: CollisionParty,
    pub(crate) probability: f64,
    /// B is of unknown kind: it is taken as fixed to the ground.
    pub(crate) is_assumed_fixed: bool,
    /// The first contact, at travel 0, where it is known; `None`: it is to be sought.
    pub(crate) first: Option<FirstContact>,
}

impl Candidate {
    /// Whether any impact at this speed could be heavy for the ego.
    pub(crate) fn may_be_heavy(&self, parameters: &Parameters) -> bool {
        let masses = [self.a.mass_kg, self.b.mass_kg];
        damage::course::delta_v_at_most(self.approach.closing_m_s, masses, parameters)
            >= damage::course::HEAVY_M_S
    }

    /// As [`damage::assess`] takes it.
    pub(crate) fn encounter(&self) -> Encounter<'_> {
        Encounter {
            approach: &self.approach,
            meeting: &self.meeting,
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

/// Which persons of the list are with each party.
type Aboards = SmallVec<[Range<usize>; PARTIES]>;

/// Number of parties stored in place.
const PARTIES: usize = 17;

/// Buffers for the candidates of a request, kept from an earlier one.
#[derive(Debug, Default)]
pub struct Candidates(Vec<Candidate>);

/// Everything that is asked, and the policy and curves that judge it.
#[derive(Clone, Debug)]
pub struct Request {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) persons: Persons,
    pub(crate) policy: Arc<Policy>,
    pub(crate) curves: Arc<Curves>,
    pub(crate) parameters: Parameters,
}

/// A request that cannot be worked on.
#[derive(Debug, thiserror::Error)]
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
    /// The candidates cannot be ranked.
    #[error(transparent)]
    Rank(#[from] damage::RankError),
}

impl Diagnostic for RequestError {
    fn kind(&self) -> diagnostic::FailureKind {
        diagnostic::FailureKind::Refused
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some("correct the candidate, or leave it out".into())
    }
}

impl Request {
    /// Puts a scenario into the ego's frame. `bodies` are those of its parties, in their order.
    ///
    /// # Errors
    ///
    /// If a candidate's approach is unusable. A party of unknown kind is taken as fixed to the
    /// ground: a caller who does not want that must refuse the scenario first.
    ///
    /// # Panics
    ///
    /// If there are fewer bodies than parties.
    pub fn new(
        scenario: &Scenario,
        bodies: &[(Meta, BodyView<'_>)],
        policy: impl Into<Arc<Policy>>,
        curves: impl Into<Arc<Curves>>,
    ) -> Result<Self, RequestError> {
        let models: Vec<usize> = (0..scenario.parties.len()).collect();
        let rules = (policy.into(), curves.into());
        Self::with_models(scenario, bodies, (&models, None), rules, Candidates::default())
    }

    /// [`Request::new`] for bodies that many requests share: party i has body `models[i]`, and
    /// `extremes` are those of the bodies, if known. The list of candidates is that of an earlier
    /// request, reused.
    ///
    /// # Errors
    ///
    /// As [`Request::new`].
    ///
    /// # Panics
    ///
    /// If there is no model for a party, or no such body.
    pub fn with_models(
        scenario: &Scenario,
        bodies: &[(Meta, BodyView<'_>)],
        (models, extremes): (&[usize], Option<&[Extremes]>),
        (policy, curves): (Arc<Policy>, Arc<Curves>),
        Candidates(mut candidates): Candidates,
    ) -> Result<Self, RequestError> {
        let support = |model: usize, direction: DVec3| match extremes {
            Some(extremes) => extremes[model].support(&bodies[model].1, direction),
            None => support(&bodies[model].1, direction),
        };
        let body = |party: usize| &bodies[models[party]];
        let (persons, aboard) = persons(scenario, &body);
        candidates.clear();
        for candidate in &scenario.candidates {
            let (ego, other) = (scenario.ego.0, candidate.other.party.0);
            let (state_a, state_b) = (&candidate.ego, &candidate.other.state);
            let pose = RelativePose::between(&state_a.pose, &state_b.pose);
            let party = |number: usize, to_ego: Option<&RelativePose>| {
                let seat = |id: usize| Aboard { id: PersonId(id), seat: persons[id].seat };
                let aboard = aboard[number].clone().map(seat);
                let stated = &scenario.parties[number];
                let stated = StatedParty {
                    is_unknown: stated.is_unknown,
                    mass_kg: stated.mass_kg,
                    crush: stated.crush,
                };
                party(&body(number).0, stated, to_ego, aboard)
            };
            let (a, b) = (party(ego, None), party(other, Some(&pose)));
            let supports = (
                |direction| support(models[ego], direction),
                |direction| support(models[other], direction),
            );
            let velocities = [state_a.velocity_m_s, state_b.velocity_m_s];
            let approach = approach(supports, (&state_a.pose, &pose), velocities, (&a, &b));
            let meeting = plan(&approach).map_err(|source| RequestError::Approach {
                name: candidate.name.to_string(),
                source,
            })?;
            candidates.push(Candidate {
                name: candidate.name.clone(),
                other_name: scenario.parties[other].name.clone(),
                model_a: models[ego] as u32,
                model_b: models[other] as u32,
                pose,
                approach,
                meeting,
                a,
                b,
                probability: candidate.probability,
                is_assumed_fixed: scenario.parties[other].is_unknown,
                first: None,
            });
        }
        Ok(Self { candidates, persons, policy, curves, parameters: Parameters::default() })
    }

    /// The buffers, for the next request.
    #[must_use]
    pub fn into_buffers(self) -> Candidates {
        Candidates(self.candidates)
    }

    /// The policy.
    #[must_use]
    pub fn policy(&self) -> &Policy {
        &self.policy
    }
}

/// The fixed list of persons, and which of them are with each party.
fn persons<'b>(
    scenario: &Scenario,
    body: &impl Fn(usize) -> &'b (Meta, BodyView<'b>),
) -> (Persons, Aboards) {
    let mut persons = Persons::new();
    let mut aboard = Aboards::new();
    for (number, party) in scenario.parties.iter().enumerate() {
        let meta = &body(number).0;
        let is_ego = number == scenario.ego.0;
        let states = scenario.candidates.iter().filter_map(|candidate| {
            let is_other = candidate.other.party.0 == number;
            if is_ego { Some(&candidate.ego) } else { is_other.then_some(&candidate.other.state) }
        });
        let speed = states.map(|state| state.velocity_m_s.length()).fold(0.0, f64::max);
        let stated = party.persons.as_deref().or(meta.occupants.as_deref());
        let stake = Stake { is_ego, responsibility: party.responsibility };
        let first = persons.len();
        if !party.is_unknown {
            let seats = occupants(meta.kind, speed, stated).into_iter();
            persons.extend(seats.map(|seat| Person { party: party.name.clone(), seat, stake }));
        }
        aboard.push(first..persons.len());
    }
    (persons, aboard)
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
        concave: is_concave(kind),
        persons: aboard.collect(),
    }
}

/// Two bodies on their way: `pose_a` in the world, `pose` of B in A's frame, velocities in the
/// world
/// of A and of B (m/s).
pub(crate) fn approach(
    (support_a, support_b): (impl Fn(DVec3) -> f64, impl Fn(DVec3) -> f64),
    (pose_a, pose): (&Pose, &RelativePose),
    [velocity_a, velocity_b]: [DVec3; 2],
    (a, b): (&CollisionParty, &CollisionParty),
) -> Approach {
    let to_a = |v: DVec3| Pose::direction_to_body(pose_a, v);
    let relative = to_a(velocity_a - velocity_b);
    let up = to_a(DVec3::Z);
    let u = heading(relative, b.centre_m - a.centre_m, up);
    let directions = Directions::around(u, up);
    let level = relative - up * relative.dot(up);
    let t = DVec3::from_array(pose.translation);
    let mut supports_a = Supports::EMPTY;
    let mut supports_b = Supports::EMPTY;
    for i in 0..DIRECTIONS {
        let d = directions.d[i];
        supports_a.0[i] = support_a(d);
        supports_b.0[i] = support_b(pose.direction_to_b(d)) + d.dot(t);
    }
    Approach { directions, closing_m_s: level.length(), supports_a, supports_b }
}
