//! The answer: order-free values only, so that equal input gives equal bytes whatever the backend.
//!
//! Hashes are wrapping sums of splitmix64 over source triangle ids, as 16 hexadecimal digits; that
//! of the pairs is taken over (id in A) << 32 | (id in B). Zeros are +0.

use crate::candidate_state::{CandidateState, SearchStage};
use crate::request::{Candidate, Request};
use body::{BodyKind, BodyView, Meta};
use damage::{
    AnswerState, CandidateHarm, CollisionParty, Contact, DeltaV, Interval, Note, Place, Range,
    RankedCandidates, Unevaluable,
};
use geometry::DVec3;
use serde::Serialize;
use std::collections::BTreeSet;

/// The answer to a request, with a row of its form per candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer<R = Row> {
    /// How complete it is.
    pub state: AnswerState,
    /// The policy's name.
    pub policy: String,
    /// Candidates, least harm first.
    pub ranking: Vec<R>,
    /// Names of the candidates that the model cannot tell from the first, itself included.
    pub tie_class: Vec<String>,
    /// Further remarks on the ranking.
    pub notes: Vec<Note>,
    /// What was assumed for lack of data, in sentences.
    pub assumptions: Vec<String>,
    /// Number of leading places that no open work can change.
    pub settled_places: usize,
    /// What is missing: one sentence per candidate that is not fully known.
    pub missing: Vec<String>,
}

/// One candidate in its place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Its name.
    pub name: String,
    /// The opposing party's name.
    pub other: String,
    /// The policy's leading measure, over the work interval: [lo, hi].
    pub work: Interval,
    /// The policy's leading measure, over the model range: [low, high].
    pub range: Range,
    /// Whether the model is sure that it comes before the next.
    pub certain: bool,
    /// Why it comes before the next, in one sentence.
    pub why: Option<String>,
    /// Which sides meet, for people: "front ↔ rear", or "left ∥ wall" where they mostly slide.
    pub sides: String,
    /// Whether the other party is fixed to the ground.
    pub is_other_fixed: bool,
    /// What the contact is like.
    pub contact: Contact,
    /// Number of triangles hit from first contact to e: of the ego, of the other.
    pub hits: [u64; 2],
    /// Hashes of the sets of hit triangles.
    pub hashes: [String; 2],
    /// Names of the parts hit from first contact to e, in the bodies' order: of the ego, of the
    /// other.
    pub parts: [Vec<String>; 2],
    /// Crush by stiffness beside the depth, where a stiffness is configured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crush: Option<damage::Crush>,
    /// Closing speed (m/s).
    pub closing_m_s: f64,
    /// Change of velocity of the ego and of the other (m/s).
    pub delta_v_m_s: [DeltaV; 2],
    /// Kinetic energy lost (J).
    pub energy_j: Interval,
    /// Everyone in this collision.
    pub persons: Vec<PersonRow>,
    /// Why there are no figures, if there are none.
    pub unevaluable: Option<Unevaluable>,
    /// Whether the limit on poses made the path coarse.
    pub coarse_path: bool,
    /// Poses from first contact on; empty without contact.
    pub poses: Vec<PoseRow>,
}

/// One person in one collision.
#[derive(Clone, Debug, PartialEq, Serialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize)]
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
    /// Number of intersecting pairs, at the poses that form the patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pairs: Option<u64>,
    /// Hash of the pairs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hash: Option<String>,
}

impl<R> Answer<R> {
    /// The candidate of least harm; `None` if there are no candidates or no bound can be given.
    #[must_use]
    pub fn best(&self) -> Option<&R> {
        if self.state == AnswerState::Refused { None } else { self.ranking.first() }
    }
}

impl Answer {
    pub(crate) fn new(
        request: &Request,
        ranking: &RankedCandidates,
        harms: &[CandidateHarm],
        candidate_states: &[CandidateState],
        bodies: &[(Meta, BodyView<'_>)],
    ) -> Self {
        let name = |number: usize| request.candidates[number].name.to_string();
        let rows = ranking.places.iter().enumerate().map(|(at, place)| {
            let next = ranking.places.get(at + 1).map(|next| next.candidate);
            let (harm, state) = (&harms[place.candidate], &candidate_states[place.candidate]);
            row(request, place, next, harm, state, bodies)
        });
        let missing = (0..candidate_states.len())
            .filter(|number| harms[*number].is_open || harms[*number].unevaluable.is_some());
        Self {
            state: ranking.state,
            policy: request.policy.name.clone(),
            ranking: rows.collect(),
            tie_class: ranking.tie_class.iter().map(|number| name(*number)).collect(),
            notes: ranking.notes.clone(),
            assumptions: assumptions(request),
            settled_places: ranking.settled,
            missing: missing
                .map(|number| format!("{}: {}", name(number), open(&candidate_states[number])))
                .collect(),
        }
    }
}

/// What is not known of a candidate.
fn open(state: &CandidateState) -> String {
    match &state.stage {
        SearchStage::Settled => "the bodies overlap at the start of the path".to_owned(),
        SearchStage::Searching { bracket, .. } => {
            // Not "-0.000".
            let [from, to] = [bracket.from_m, bracket.to_m].map(|m| (m * 1e3).round() / 1e3 + 0.0);
            let touch = if bracket.has_touched { "begins" } else { "would begin" };
            format!("where contact {touch}: between {from:.3} m and {to:.3} m of travel")
        }
        SearchStage::Surveying { stops, .. } => {
            let open = stops.iter().filter(|(_, surveyed)| surveyed.is_none()).count();
            format!("{open} of {} poses from first contact onwards", stops.len())
        }
    }
}

/// One sentence per party of unknown kind.
pub(crate) fn assumptions(request: &Request) -> Vec<String> {
    let unknown = request.candidates.iter().filter(|candidate| candidate.is_assumed_fixed);
    let names: BTreeSet<&str> = unknown.map(|candidate| candidate.other_name.as_str()).collect();
    names.into_iter().map(unknown_sentence).collect()
}

/// The sentence about a party of unknown kind.
pub(crate) fn unknown_sentence(name: &str) -> String {
    format!("\"{name}\" is of unknown kind: assumed to be fixed to the ground, with nobody in it")
}

fn row(
    request: &Request,
    place: &Place,
    next: Option<usize>,
    harm: &CandidateHarm,
    state: &CandidateState,
    bodies: &[(Meta, BodyView<'_>)],
) -> Row {
    let candidate = &request.candidates[place.candidate];
    let why = place
        .why
        .as_ref()
        .zip(next)
        .map(|(ground, next)| ground.sentence(&candidate.name, &request.candidates[next].name));
    let [(meta_a, a), (meta_b, b)] =
        [candidate.model_a, candidate.model_b].map(|model| &bodies[model as usize]);
    let hit = state.hit.summary(a, b);
    Row {
        name: candidate.name.to_string(),
        other: candidate.other_name.to_string(),
        work: place.work,
        range: place.range,
        certain: place.certain,
        why,
        sides: sides(candidate, harm),
        is_other_fixed: candidate.b.mass_kg.is_none(),
        contact: harm.contact.clone(),
        hits: [hit.hits_a, hit.hits_b],
        hashes: [hit.hash_a, hit.hash_b].map(hex),
        parts: parts(state, [(meta_a, a), (meta_b, b)]),
        crush: harm.crush,
        closing_m_s: harm.closing_m_s,
        delta_v_m_s: harm.delta_v,
        energy_j: harm.energy_j,
        persons: persons(request, harm),
        unevaluable: harm.unevaluable,
        coarse_path: harm.coarse_path,
        poses: poses(state),
    }
}

/// Names of the parts hit from first contact to e, in the bodies' order: of A, of B.
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
    let Some(patch) = &harm.contact.patch else { return String::new() };
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
    let slides = harm.normal_m_s.hi() < 0.25 * harm.closing_m_s;
    let sign = if slides { "∥" } else { "↔" };
    format!("{} {sign} {}", side(&candidate.a, normal), side(&candidate.b, -normal))
}

pub(crate) fn persons(request: &Request, harm: &CandidateHarm) -> Vec<PersonRow> {
    let row = |person: &damage::PersonHarm| PersonRow {
        party: request.persons[person.id.0].party.to_string(),
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
    let SearchStage::Surveying { stops, .. } = &state.stage else { return Vec::new() };
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
    stops.iter().filter_map(row).collect()
}

/// Why the first comes before the second; `None` if there is only one.
#[must_use]
pub fn explain(answer: &Answer) -> Option<&str> {
    answer.ranking.first().and_then(|row| row.why.as_deref())
}
