//! One contact of a course: as a candidate of a request, assessed, and what it does to the course.

use super::contact_facts::ContactFacts;
use super::persons::People;
use super::plan_scene::ContactScene;
use super::way::{Begin, NextContact, Scenery};
use super::{Course, Stuck};
use crate::answer::{self, PersonRow, PoseRow};
use crate::candidate_state::FirstContact;
use crate::explain::ContactChain;
use crate::request::{
    Candidate, Motions, Request, RequestError, StatedParty, Wanted, approach, party,
};
use crate::work::SurveyRun;
use body::Zones;
use bvh::Witness;
use damage::approach::STANDSTILL_M_S;
use damage::course::{PASSED_M, RunOut, Severity};
use damage::{CandidateHarm, Evidence};
use geometry::motion::MotionPath;
use geometry::{DVec3, RelativePose, Supports};
use std::sync::OnceLock;

/// A contact of a candidate, assessed.
#[derive(Clone, Debug)]
pub(super) struct AssessedContact {
    pub(super) meeting: NextContact,
    /// When the bodies first touched in this crash (s).
    pub(super) first_touch_s: f64,
    pub(super) harm: CandidateHarm,
    pub(super) severity: Severity,
    /// The model range of the ego's change of velocity crosses the threshold.
    pub(super) may_be_other: bool,
    /// What the answer shows of it besides.
    pub(super) sides: String,
    pub(super) is_other_fixed: bool,
    pub(super) hits: [u64; 2],
    pub(super) hashes: [String; 2],
    pub(super) parts: [Vec<String>; 2],
    pub(super) persons: Vec<PersonRow>,
    pub(super) poses: Vec<PoseRow>,
    /// What is assessed again in other worlds and under other criteria, if that is wanted.
    pub(super) facts: Option<Box<ContactFacts>>,
    /// What its survey has found, if it is to be assessed under other criteria.
    pub(super) evidence: Option<Box<Evidence>>,
    /// If the answer is explained.
    pub(super) chain: Option<Box<ContactChain>>,
    /// If a picture is wanted.
    pub(super) scene: Option<Box<ContactScene>>,
}

/// How both bodies move just before a contact.
fn motions(scenery: &Scenery<'_>, course: &Course<'_>, meeting: &NextContact) -> Motions {
    let ways = course.way.ways(meeting.party);
    let parties = [scenery.scenario.ego.0, meeting.party];
    let time_s = meeting.touching.time_s;
    let motion = |side: usize, point_m: [f64; 3]| {
        let path: &MotionPath = ways.paths[side];
        path.velocity_before(time_s, point_m)
    };
    let of_centres = [0, 1].map(|side: usize| motion(side, scenery.body(parties[side]).0.centre_m));
    let pose_a = ways.paths[0].pose_at(time_s);
    let pose_b = RelativePose::between(&pose_a, &ways.paths[1].pose_at(time_s));
    let point = meeting.touching.point;
    let point_b = pose_b.direction_to_b(point - DVec3::from_array(pose_b.translation));
    let [(on_a, _), (on_b, _)] = [motion(0, point.to_array()), motion(1, point_b.to_array())];
    Motions {
        velocities_m_s: of_centres.map(|(velocity, _)| velocity),
        rates_rad_s: of_centres.map(|(_, rate)| rate),
        at_contact_m_s: on_a - on_b,
    }
}

/// A contact as a candidate of a request: its first contact is known, its plane is not laid yet.
pub(super) fn contact(
    scenery: &Scenery<'_>,
    people: &People,
    course: &Course<'_>,
    meeting: &NextContact,
    support_of: &impl Fn(usize, DVec3, &mut Option<[f32; 3]>) -> f64,
    is_member: bool,
) -> Result<Candidate, RequestError> {
    let scenario = scenery.scenario;
    let name = &scenario.candidates[course.candidate].name;
    let (ego, other) = (scenario.ego.0, meeting.party);
    let ways = course.way.ways(other);
    let [pose_a, pose_b] = ways.paths.map(|path| path.pose_at(meeting.touching.time_s));
    let pose = RelativePose::between(&pose_a, &pose_b);
    let side = |number: usize, to_ego: Option<&RelativePose>| {
        let stated = &scenario.parties[number];
        let stated = StatedParty {
            is_unknown: stated.is_unknown,
            mass_kg: stated.mass_kg,
            crush: stated.crush,
        };
        party(&scenery.body(number).0, stated, to_ego, people.aboard(number))
    };
    let (a, b) = (side(ego, None), side(other, Some(&pose)));
    let models = [ego, other].map(|number| scenery.models[number]);
    let (mut near_a, mut near_b) = (None, None);
    let supports = (
        |d: DVec3| support_of(models[0], d, &mut near_a),
        |d: DVec3| support_of(models[1], d, &mut near_b),
    );
    let motions = motions(scenery, course, meeting);
    let approach = approach(supports, (&pose_a, &pose), &motions, (&a, &b));
    let refused = |source| RequestError::Approach { name: name.to_string(), source };
    approach.check().map_err(refused)?;
    let stands = approach.closing_m_s < STANDSTILL_M_S;
    let is_start = meeting.begin == Begin::AtStart && meeting.touching.time_s <= 0.0;
    let touching = &meeting.touching;
    let witness = Witness {
        travel_m: 0.0,
        ids: touching.ids,
        triangles: touching.triangles,
        point: touching.point,
    };
    let mut supports = Supports::EMPTY;
    supports.add(&approach.directions, touching.point);
    let bodies = ways.bodies;
    let zones = [0, 1].map(|side: usize| {
        let zone = bodies[side].zones.get(touching.triangles[side] as usize);
        zone.copied().unwrap_or(Zones(0))
    });
    let first = FirstContact { witness, zones, supports };
    let wanted = if is_member { Wanted::beside([&a, &b], &first) } else { Wanted::Everything };
    Ok(Candidate {
        name: name.clone(),
        other_name: scenario.parties[other].name.clone(),
        model_a: models[0] as u32,
        model_b: models[1] as u32,
        pose,
        approach,
        is_stuck: is_start && stands,
        plane: OnceLock::new(),
        a,
        b,
        probability: 1.0,
        is_assumed_fixed: scenario.parties[other].is_unknown,
        first,
        wanted,
    })
}

/// What is known of a contact when its round is over.
pub(super) fn assessed(
    contacts: &Request,
    work: &SurveyRun<'_>,
    number: usize,
    meeting: NextContact,
    harm: CandidateHarm,
) -> AssessedContact {
    let candidate = &contacts.candidates[number];
    let state = &work.candidate_states()[number];
    let [a, b] = [candidate.model_a, candidate.model_b].map(|model| work.body_of(model));
    let hit = state.hit.summary(&a.1, &b.1);
    let (severity, may_be_other) = Severity::of(&harm);
    AssessedContact {
        meeting,
        first_touch_s: meeting.touching.time_s,
        severity,
        may_be_other,
        sides: answer::sides(candidate, &harm),
        is_other_fixed: candidate.b.mass_kg.is_none(),
        hits: [hit.hits_a, hit.hits_b],
        hashes: [hit.hash_a, hit.hash_b].map(answer::hex),
        parts: answer::parts(state, [(&a.0, &a.1), (&b.0, &b.1)]),
        persons: answer::persons(&contacts.persons, &harm),
        poses: answer::poses(state),
        facts: None,
        evidence: None,
        chain: None,
        scene: None,
        harm,
    }
}

/// Lets a course go on after a contact, or end there.
pub(super) fn settle(
    course: &mut Course<'_>,
    candidate: &Candidate,
    mut assessed: AssessedContact,
) {
    let meeting = assessed.meeting;
    if !assessed.harm.is_settled() || assessed.harm.is_open {
        // Where the ego goes from here is not known.
        course.stuck = Some(Stuck {
            party: meeting.party,
            time_s: meeting.touching.time_s,
            unevaluable: assessed.harm.unevaluable,
        });
        if meeting.begin != Begin::Again {
            course.contacts.push(assessed);
        }
        return;
    }
    let approach = &candidate.approach;
    match assessed.severity {
        Severity::Light => {
            let extent_m = approach.extent_up_to(PASSED_M);
            course.way.pass(&meeting, approach.closing_m_s, extent_m);
            if meeting.begin != Begin::Again {
                course.contacts.push(assessed);
            }
        }
        Severity::Heavy => {
            let at_s = meeting.touching.time_s;
            let rotation = course.way.ego_path().pose_at(at_s).rotation;
            let impulse = DVec3::from_array(assessed.harm.impulse_n_s);
            let row = |i: usize| DVec3::from_array(rotation[i]).dot(impulse);
            let on_ego = -DVec3::new(row(0), row(1), row(2));
            let (before, _) =
                course.way.ego_path().velocity_before(at_s, candidate.a.centre_m.to_array());
            // The ego has a mass: it is a vehicle.
            let mass_kg = candidate.a.mass_kg.unwrap_or(f64::INFINITY);
            let run_out = course.way.run_out(RunOut::after(before, on_ego, mass_kg));
            course.way.leave(&meeting, run_out);
            // A first, light touch was the begin of this crash.
            if meeting.begin == Begin::Again {
                let same = |contact: &AssessedContact| contact.meeting.party == meeting.party;
                if let Some(first) = course.contacts.iter().rposition(same) {
                    assessed.first_touch_s = course.contacts.remove(first).first_touch_s;
                }
            }
            course.contacts.push(assessed);
        }
    }
}
