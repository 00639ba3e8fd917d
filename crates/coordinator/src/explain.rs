//! The explanation of an answer: every figure from contact to rank, and what it is made from.
//!
//! A reader can check each step with a pocket calculator: speeds and lever arms give impulses,
//! impulses give changes of velocity, a curve with its source gives a probability, a rule of the
//! policy gives the term that ranks. Values are copies of those that decided, never recomputed;
//! where work is still open they are the upper ends, as in the order itself.
//!
//! It depends only on what the answer depends on.

use crate::candidate_state::CandidateState;
use crate::request::{Candidate, Person, Request};
use damage::curve::{CurveUnit, Dose};
use damage::dynamics::Response;
use damage::injury::Quantity;
use damage::plane::{PlaneOrigin, Ride};
use damage::{CandidateHarm, Ground, Interval, PersonId};
use serde::Serialize;

/// One contact from speeds to the risks of persons. Pairs are of the ego and of the other.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactChain {
    /// The other party's name.
    pub other: String,
    /// What makes the plane of the contact.
    pub origin: Option<PlaneOrigin>,
    /// Which party has the long flat face along which the other is turned: 0 the ego, 1 the other.
    pub long_face_of: Option<usize>,
    /// How both are met in height.
    pub rides: [Ride; 2],
    /// Closing speed of the centres of mass (m/s).
    pub closing_m_s: f64,
    /// Angle of the contact normal from the closing direction (degrees, left positive).
    pub normal_degrees: Option<f64>,
    /// v_n: closing speed along the normal at the point of contact (m/s). Where bodies turn it may
    /// be above that of the centres.
    pub normal_m_s: f64,
    /// v_t: sliding speed across it (m/s), positive to the left of the normal.
    pub tangential_m_s: f64,
    /// Masses (kg); `None`: fixed to the ground.
    pub mass_kg: [Option<f64>; 2],
    /// Yaw radii of gyration k (m).
    pub gyration_m: [f64; 2],
    /// From the centre of mass to the point of contact, along the normal and to its left (m).
    pub arms_m: [[f64; 2]; 2],
    /// Restitution e, and friction μ or, along a long flat face, the greatest ratio of the
    /// impulses.
    pub surface: [f64; 2],
    /// Yaw rates before and after (rad/s).
    pub yaw_rad_s: [[f64; 2]; 2],
    /// Impulses, changes of velocity, energy.
    pub response: Response,
    /// Principal direction of force in each body's frame (degrees from forward, left positive).
    pub force_degrees: [f64; 2],
    /// Probability of the collision, as the planner states it.
    pub probability: f64,
    /// Everyone in it.
    pub persons: Vec<PersonChain>,
    /// Travel and intersecting pairs of triangles at each depth that forms the patch.
    pub poses: Vec<(f64, u64)>,
    /// Lengths of the patch across the normal, along it and upwards, and the depth (m).
    pub patch_m: [f64; 4],
}

/// The person whose risk differs most between a candidate and the next.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Separation {
    /// Party.
    pub party: String,
    /// Seat; none on foot.
    pub seat: Option<&'static str>,
    /// Risk in the candidate.
    pub here: f64,
    /// Risk in the next one.
    pub there: f64,
    /// In a weighted sum: the rule that separates them most.
    pub rule: Option<&'static str>,
}

/// One person from speed to risk.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonChain {
    /// Party.
    pub party: String,
    /// Seat; none on foot.
    pub seat: Option<&'static str>,
    /// The kind of victim that the curve takes the person for.
    pub victim: &'static str,
    /// The curve's id.
    pub curve: String,
    /// The quantity it takes.
    pub x: Quantity,
    /// Its value (m/s).
    pub x_m_s: f64,
    /// Its value in the curve's own unit.
    pub x_in_unit: f64,
    /// That unit.
    pub unit: CurveUnit,
    /// Height of the edge of the front that strikes (m), else 0.
    pub front_m: f64,
    /// What is anchored, borrowed or doubtful about the curve; may be empty.
    pub note: String,
    /// P(x) = 1/(1+exp(-z)), as published.
    pub published: f64,
    /// P(0), which anchoring removes.
    pub at_rest: f64,
    /// H = (P(x) - P(0))/(1 - P(0)), over open work.
    pub harm: Interval,
    /// R = p H, the risk that ranks.
    pub risk: f64,
    /// The model range of H, and the curves and factors at its ends.
    pub range: damage::Range,
    /// "curves × factor" of the lower and of the upper end.
    pub ends: [String; 2],
}

/// One step of the policy for one candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolicyStep {
    /// What is compared.
    pub step: String,
    /// Its value, over open work.
    pub value: Interval,
}

/// Pairs at the depths of the patch.
fn poses(state: &CandidateState) -> Vec<(f64, u64)> {
    let of_patch = state.stops.iter().filter(|(stop, _)| stop.patch);
    of_patch.filter_map(|(stop, found)| Some((stop.travel_m, found.as_ref()?.pairs))).collect()
}

/// The steps of a policy with their values for a candidate.
pub(crate) fn policy_steps(steps: &[String], values: &[Interval]) -> Vec<PolicyStep> {
    let values = steps.iter().zip(values);
    values.map(|(step, value)| PolicyStep { step: step.clone(), value: *value }).collect()
}

/// From speeds to risks.
pub(crate) fn contact_chain(
    request: &Request,
    candidate: &Candidate,
    harm: &CandidateHarm,
    state: &CandidateState,
) -> ContactChain {
    let parties = [&candidate.a, &candidate.b];
    let patch = harm.contact.as_ref();
    ContactChain {
        other: candidate.other_name.to_string(),
        origin: patch.map(|patch| patch.origin),
        long_face_of: patch.and_then(|patch| patch.long_face_of),
        rides: patch.map_or_else(Default::default, |patch| patch.rides),
        closing_m_s: harm.closing_m_s,
        normal_degrees: patch.map(|patch| patch.normal_degrees),
        normal_m_s: harm.normal_m_s,
        tangential_m_s: harm.tangential_m_s,
        mass_kg: parties.map(|party| party.mass_kg),
        gyration_m: parties.map(|party| party.gyration_m),
        arms_m: harm.arms_m,
        surface: harm.surface,
        yaw_rad_s: harm.yaw_rad_s,
        response: harm.response,
        force_degrees: harm.force_degrees,
        probability: harm.probability,
        persons: harm.persons.iter().map(|p| person(request, harm, p)).collect(),
        poses: poses(state),
        patch_m: patch.map_or([0.0; 4], |patch| {
            let [width, span, height] =
                [patch.width_m, patch.span_m, patch.height_m].map(Interval::hi);
            [width, span, height, patch.depth_m]
        }),
    }
}

/// The person who decided between two candidates, if a rule on persons did. `risks` are those of a
/// person in both.
pub(crate) fn separation(
    persons: &[Person],
    ground: &Ground,
    risks: impl Fn(PersonId) -> [f64; 2],
) -> Option<Separation> {
    let Ground::Least { person: Some(id), rule, .. } = ground else { return None };
    let person = persons.get(id.0)?;
    let [here, there] = risks(*id);
    Some(Separation {
        party: person.party.to_string(),
        seat: person.seat.map(body::Seat::name),
        here,
        there,
        rule: rule.map(|rule| rule.name()),
    })
}

fn person(request: &Request, harm: &CandidateHarm, person: &damage::PersonHarm) -> PersonChain {
    let curves = &request.criteria.curves;
    let rung = curves.rung(person.victim, request.criteria.policy.outcome).ok();
    let curve = rung.map(|rung| curves.nominal(rung));
    let unit = curve.map_or(CurveUnit::MetresPerSecond, |curve| curve.unit);
    let x_m_s = person.x_m_s.hi();
    let published = |dose: Dose| curve.map_or(0.0, |curve| curve.published(dose));
    let end = |end: &damage::injury::RangeEnd| {
        let ids: Vec<&str> = end.curves.iter().map(|c| &*curves.curves[*c].id).collect();
        format!("{} at {} x {}", ids.join(", "), end.times, end.x.name())
    };
    PersonChain {
        party: request.persons[person.id.0].party.to_string(),
        seat: person.seat.map(body::Seat::name),
        victim: person.victim.name(),
        curve: person.curve.to_string(),
        x: person.x,
        x_m_s,
        x_in_unit: unit.of(x_m_s),
        unit,
        published: published(person.dose()),
        at_rest: published(Dose { speed_m_s: 0.0, ..person.dose() }),
        front_m: person.front_m,
        note: curve.map_or_else(String::new, |curve| curve.note.clone()),
        harm: person.work,
        risk: harm.probability * person.work.hi(),
        range: person.range,
        ends: rung.map_or_else(Default::default, |rung| [end(&rung.low), end(&rung.high)]),
    }
}
