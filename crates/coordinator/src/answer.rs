//! The answer: order-free values only, so that equal input gives equal bytes whatever the backend.
//!
//! Hashes are wrapping sums of splitmix64 over source triangle ids, as 16 hexadecimal digits; that
//! of the pairs is taken over (id in A) << 32 | (id in B). Zeros are +0.

use crate::candidate_state::CandidateState;
use crate::request::{Candidate, Person};
use body::{BodyKind, BodyView, Meta};
use damage::{CandidateHarm, CollisionParty, Interval, Range};
use geometry::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// One person in one collision.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PersonRow {
    /// The party that the person belongs to.
    pub party: String,
    /// The seat; `None` on foot.
    pub seat: Option<&'static str>,
    /// The kind of victim that the curve takes the person for.
    pub victim: &'static str,
    /// The curve.
    pub curve: String,
    /// Probability of injury at the policy's level: [lo, hi].
    pub work: Interval,
    /// Probability of injury over the model range.
    pub range: Range,
    /// Whether a zone beside the seat is hit.
    pub intrusion: bool,
    /// Whether the speed lies outside the range of the curve's sample.
    pub extrapolated: bool,
}

/// The hit sets at one pose.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PoseRow {
    /// Travel from the given pose along the relative path (m).
    pub travel_m: f64,
    /// Triangles of the ego that are hit.
    pub hits_a: u64,
    /// Triangles of the other that are hit.
    pub hits_b: u64,
    /// Hash of the ego's hit triangles.
    pub hash_a: String,
    /// Hash of the other's hit triangles.
    pub hash_b: String,
    /// Number of intersecting pairs, at the depths that form the patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pairs: Option<u64>,
    /// Hash of the pairs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
}

/// The sentence about a party of unknown kind.
pub(crate) fn unknown_sentence(name: &str) -> String {
    format!("\"{name}\" is of unknown kind: assumed to be fixed to the ground, with nobody in it")
}

/// Names of the parts hit at any depth, in the bodies' order: of A, of B.
pub(crate) fn parts(
    state: &CandidateState,
    [(meta_a, a), (meta_b, b)]: [(&Meta, &BodyView<'_>); 2],
) -> [Vec<String>; 2] {
    let [parts_a, parts_b] = state.hit.parts(a, b);
    let names = |meta: &Meta, parts: BTreeSet<u16>| {
        let known = &meta.parts;
        parts.into_iter().filter_map(|part| known.get(usize::from(part)).cloned()).collect()
    };
    [names(meta_a, parts_a), names(meta_b, parts_b)]
}

/// The sides that the nominal normal passes through; ∥ where the bodies mostly slide past.
pub(crate) fn sides(candidate: &Candidate, harm: &CandidateHarm) -> String {
    let Some(patch) = &harm.contact else { return String::new() };
    let normal = DVec3::from_array(patch.normal);
    let up = candidate.approach.directions.d[damage::approach::UP];
    let side = |party: &CollisionParty, outward: DVec3| match party.kind {
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building if candidate.is_assumed_fixed => {
            "unknown"
        }
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => party.kind.name(),
        BodyKind::Pedestrian => "person",
        _ => match party.bearing(outward, up) {
            angle if angle.abs() <= 45.0 => "front",
            angle if angle.abs() >= 135.0 => "rear",
            angle if angle > 0.0 => "left",
            _ => "right",
        },
    };
    let slides = harm.normal_m_s < 0.25 * harm.closing_m_s;
    let sign = if slides { "∥" } else { "↔" };
    format!("{} {sign} {}", side(&candidate.a, normal), side(&candidate.b, -normal))
}

/// Everyone in a contact; `list` has all who are at stake.
pub(crate) fn persons(list: &[Person], harm: &CandidateHarm) -> Vec<PersonRow> {
    let row = |person: &damage::PersonHarm| PersonRow {
        party: list[person.id.0].party.to_string(),
        seat: person.seat.map(body::Seat::name),
        victim: person.victim.name(),
        curve: person.curve.to_string(),
        work: person.work,
        range: person.range,
        intrusion: person.intrusion,
        extrapolated: person.extrapolated,
    };
    harm.persons.iter().map(row).collect()
}

pub(crate) fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

pub(crate) fn poses(state: &CandidateState) -> Vec<PoseRow> {
    let row = |(stop, surveyed): &(damage::Stop, Option<crate::candidate_state::Surveyed>)| {
        let found = surveyed.as_ref()?;
        Some(PoseRow {
            travel_m: stop.travel_m,
            hits_a: found.sets.hits_a,
            hits_b: found.sets.hits_b,
            hash_a: hex(found.sets.hash_a),
            hash_b: hex(found.sets.hash_b),
            pairs: stop.patch.then_some(found.pairs),
            hash: stop.patch.then(|| hex(found.hash)),
        })
    };
    state.stops.iter().filter_map(row).collect()
}
