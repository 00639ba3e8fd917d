//! Who is where and when, seen from above, and the bodies at each contact: what pictures of a
//! ranking are drawn from. It is copied from the courses that were followed, so reactions and
//! run-outs are in it.
//!
//! World frame: metres, x and y as in the scenario. Nothing here ranks.

use super::flags::Outlines;
use super::way::Scenery;
use super::{Course, Severity};
use crate::candidate_state::CandidateState;
use crate::request::Candidate;
use geometry::motion::MotionPath;
use geometry::{Pose, RelativePose};
use serde::Serialize;

/// Step of time between samples (s).
const STEP_S: f64 = 0.05;

/// A scene over time: all bodies in plan, and every candidate as it was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanScene {
    /// The end of all motions (s); they begin at 0.
    pub horizon_s: f64,
    /// The number of the ego in `parties`.
    pub ego: usize,
    /// All bodies, in the scenario's order.
    pub parties: Vec<PlanParty>,
    /// All candidates, in the scenario's order.
    pub courses: Vec<PlanCourse>,
}

/// A body in plan, and where it may go.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanParty {
    /// Its name.
    pub name: String,
    /// Corners of a convex outline in the body's frame (m), counter-clockwise.
    pub outline_m: Vec<[f64; 2]>,
    /// Its predicted paths, in the scenario's order; none of the ego.
    pub paths: Vec<PlanPath>,
    /// The number of the path in `paths` that was followed, unless it reacts.
    pub followed: usize,
}

/// A predicted path.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanPath {
    /// Its probability.
    pub probability: f64,
    /// Where the body is.
    pub track: Vec<PlanSample>,
}

/// A body at one time, written as `[time_s, x_m, y_m, cos, sin]`; between two it moves linearly,
/// and after the last it stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PlanSample(
    /// Time (s), origin of the body's frame (m), and its direction in plan: a unit vector.
    pub [f64; 5],
);

/// A candidate as it was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanCourse {
    /// Its name.
    pub name: String,
    /// The ego, until it stands after a run-out, the horizon, or `open_from_s`.
    pub ego: Vec<PlanSample>,
    /// From when on (s) it is not known what happens, if it is not.
    pub open_from_s: Option<f64>,
    /// When run-outs begin (s).
    pub run_outs_s: Vec<f64>,
    /// Parties that move otherwise than predicted: number and track.
    pub reactions: Vec<(usize, Vec<PlanSample>)>,
    /// Contacts in the order of time.
    pub contacts: Vec<PlanContact>,
    /// The bodies at each of them.
    #[serde(skip)]
    pub scenes: Vec<ContactScene>,
}

/// A contact of a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PlanContact {
    /// The party's number.
    pub party: usize,
    /// When (s).
    pub time_s: f64,
    /// Where (m).
    pub at_m: [f64; 2],
    /// Whether the ego leaves its path. The party's motion after that is not modelled: it is shown
    /// where it was struck.
    pub is_heavy: bool,
}

/// Two bodies where their contact patch is complete, and what is hit.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactScene {
    /// Numbers of the ego's and of the other's body among those of the request.
    pub models: [usize; 2],
    /// The other seen from the ego.
    pub pose: RelativePose,
    /// Triangles hit at any depth, as the bodies store them: of the ego, of the other.
    pub hits: [Vec<u32>; 2],
}

impl ContactScene {
    /// What a picture of a contact shows, as far as its survey is done.
    pub(super) fn of(candidate: &Candidate, state: &CandidateState) -> Self {
        let last = state.stops.last();
        let travel_m = last.map_or(0.0, |(stop, _)| stop.travel_m);
        let u = candidate.approach.directions.d[0];
        Self {
            models: [candidate.model_a as usize, candidate.model_b as usize],
            pose: candidate.pose.moved(-u * travel_m),
            hits: state.hit.triangles(),
        }
    }
}

/// What was followed, in plan.
pub(super) fn scene(scenery: &Scenery<'_>, courses: &[Course<'_>]) -> PlanScene {
    let scenario = scenery.scenario;
    let outlines = Outlines::of(scenery);
    let parties = scenario.parties.iter().enumerate().map(|(number, party)| PlanParty {
        name: party.name.to_string(),
        outline_m: outline(outlines.of_party(scenery, number).corners()),
        paths: party
            .predictions
            .iter()
            .map(|prediction| PlanPath {
                probability: prediction.probability,
                track: track_of(&prediction.motion.path, scenario.horizon_s),
            })
            .collect(),
        followed: if number == scenario.ego.0 { 0 } else { scenery.likeliest(number).0 },
    });
    let courses = scenario.candidates.iter().zip(courses).map(|(candidate, course)| {
        let reactions = candidate.reactions.iter();
        PlanCourse {
            name: candidate.name.to_string(),
            ego: ego_track(course),
            open_from_s: course.open_from_s(),
            run_outs_s: course.way.run_outs.iter().map(|leg| leg.from_s).collect(),
            reactions: reactions
                .map(|reaction| {
                    (reaction.party.0, track_of(&reaction.motion.path, scenario.horizon_s))
                })
                .collect(),
            contacts: contacts(course),
            scenes: course
                .contacts
                .iter()
                .filter_map(|one| one.scene.as_deref().cloned())
                .collect(),
        }
    });
    PlanScene {
        horizon_s: scenario.horizon_s,
        ego: scenario.ego.0,
        parties: parties.collect(),
        courses: courses.collect(),
    }
}

/// Corners, without those that are within 1 mm of the one before.
fn outline(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for corner in corners {
        let is_apart = |last: &[f64; 2]| (0..2).any(|k| (corner[k] - last[k]).abs() > 1e-3);
        if kept.last().is_none_or(is_apart) && (kept.len() < 3 || is_apart(&kept[0])) {
            kept.push(*corner);
        }
    }
    kept
}

fn contacts(course: &Course<'_>) -> Vec<PlanContact> {
    let contact = |contact: &super::AssessedContact| {
        let touching = &contact.meeting.touching;
        let pose = course.way.ego_at(touching.time_s);
        let ([[a, b, c], [d, e, f], _], p) = (pose.rotation, touching.point);
        PlanContact {
            party: contact.meeting.party,
            time_s: touching.time_s + 0.0,
            at_m: [
                a * p.x + b * p.y + c * p.z + pose.translation[0],
                d * p.x + e * p.y + f * p.z + pose.translation[1],
            ],
            is_heavy: contact.severity == Severity::Heavy,
        }
    };
    course.contacts.iter().map(contact).collect()
}

/// The ego at every step, at its contacts, and where it leaves its path.
fn ego_track(course: &Course<'_>) -> Vec<PlanSample> {
    let way = &course.way;
    let end_s = course.open_from_s().map_or(way.end_s, |open_s| open_s.min(way.end_s));
    let mut times = steps(end_s);
    times.extend(course.contacts.iter().map(|contact| contact.meeting.touching.time_s));
    times.extend(way.run_outs.iter().map(|leg| leg.from_s));
    times.retain(|time_s| *time_s <= end_s);
    track(times, |time_s| way.ego_at(time_s))
}

fn track_of(path: &MotionPath, end_s: f64) -> Vec<PlanSample> {
    track(steps(end_s), |time_s| path.pose_at(time_s))
}

/// Times from 0 to an end (s), which is one of them.
fn steps(end_s: f64) -> Vec<f64> {
    let count = (end_s / STEP_S).ceil() as usize;
    (0..=count).map(|step| (step as f64 * STEP_S).min(end_s)).collect()
}

/// Samples at these times, without those between equal ones.
fn track(mut times: Vec<f64>, pose_at: impl Fn(f64) -> Pose) -> Vec<PlanSample> {
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut samples: Vec<PlanSample> = Vec::with_capacity(times.len());
    for time_s in times {
        let next = sample(time_s, &pose_at(time_s));
        let stands = |sample: &PlanSample| sample.0[1..] == next.0[1..];
        if let [.., before, last] = samples.as_mut_slice()
            && stands(before)
            && stands(last)
        {
            *last = next;
        } else {
            samples.push(next);
        }
    }
    samples
}

fn sample(time_s: f64, pose: &Pose) -> PlanSample {
    let [cos, sin] = [pose.rotation[0][0], pose.rotation[1][0]];
    let length = (cos * cos + sin * sin).sqrt();
    let [cos, sin] = if length > 0.0 { [cos / length, sin / length] } else { [1.0, 0.0] };
    // Tenths of a millimetre: of that a picture shows nothing, and the text is a third as long.
    let short = |value: f64| (value * 1e4).round() / 1e4 + 0.0;
    let [x, y, _] = pose.translation;
    PlanSample([time_s + 0.0, short(x), short(y), short(cos), short(sin)])
}

#[cfg(test)]
mod tests;
