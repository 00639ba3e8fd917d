//! Who is where and when, seen from above, and the bodies at each contact: what pictures of a
//! ranking are drawn from. It is copied from the courses that were followed, so reactions and
//! run-outs are in it.
//!
//! World frame: metres, x and y as in the scenario. Nothing here ranks.

use super::flags::Outlines;
use super::way::Scenery;
use super::{Course, CourseRow, NearestRow, Severity};
use crate::candidate_state::CandidateState;
use crate::request::Candidate;
use geometry::motion::MotionPath;
use geometry::{Pose, RelativePose};
use schemars::JsonSchema;
use serde::Serialize;

/// Step of time between samples (s).
const STEP_S: f64 = 0.05;
/// How far the line of a member may lie from its motion (m), before it is rounded.
const LINE_M: f64 = 0.04;

/// A scene over time: all bodies in plan, and every candidate as it was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanScene {
    /// The end of all motions (s); they begin at 0.
    pub horizon_s: f64,
    /// The number of the ego in `parties`.
    pub ego: usize,
    /// All bodies, in the scenario's order.
    pub parties: Vec<PlanParty>,
    /// All candidates, in the scenario's order.
    pub courses: Vec<PlanCourse>,
    /// Where everybody goes in each member that harm is the mean of; empty without members.
    pub members: Vec<PlanMember>,
}

/// Where everybody goes in one member. Tracks are within 5 cm of the motions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanMember {
    /// Per party: its motion in candidates to which it does not react; empty for the ego.
    pub parties: Vec<Vec<PlanPoint>>,
    /// Per candidate, in the scenario's order.
    pub courses: Vec<PlanMemberCourse>,
}

/// A candidate as it was followed in a member.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanMemberCourse {
    /// The ego, until it stands after a run-out, the horizon, or where it is not known what
    /// happens.
    pub ego: Vec<PlanPoint>,
    /// Parties that react: number and track.
    pub reactions: Vec<(usize, Vec<PlanPoint>)>,
    /// Contacts in the order of time.
    pub contacts: Vec<PlanContact>,
}

/// The origin of a body at one time, written as `[time_s, x_m, y_m]`; between two it moves
/// linearly, and after the last it stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanPoint(
    /// Time (s) and place (m).
    pub [f64; 3],
);

/// A body in plan, and where it may go.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanPath {
    /// Its probability.
    pub probability: f64,
    /// Where the body is.
    pub track: Vec<PlanSample>,
}

/// A body at one time, written as `[time_s, x_m, y_m, cos, sin]`; between two it moves linearly,
/// and after the last it stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct PlanSample(
    /// Time (s), origin of the body's frame (m), and its direction in plan: a unit vector.
    pub [f64; 5],
);

/// A candidate as it was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
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
    /// Where it comes nearest to somebody, if it meets nobody and all is known.
    pub nearest: Option<PlanNearest>,
}

/// Where a candidate comes nearest to a party that it does not meet.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PlanNearest {
    /// The party's number.
    pub party: usize,
    /// When (s).
    pub time_s: f64,
    /// The distance of the outlines in plan (m).
    pub gap_m: f64,
    /// The bodies then.
    #[serde(skip)]
    pub scene: ContactScene,
}

/// A contact of a candidate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
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

/// What was followed, in plan: in the scene as stated, and in the members that are drawn, as many
/// courses for each as there are candidates. `rows` are those of the answer.
pub(super) fn scene(
    scenery: &Scenery<'_>,
    courses: &[Course<'_>],
    drawn: &[Course<'_>],
    rows: &[CourseRow],
) -> PlanScene {
    let scenario = scenery.scenario;
    let outlines = Outlines::of(scenery, &[]);
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
            nearest: rows
                .iter()
                .find(|row| row.name == *candidate.name && row.contacts.is_empty())
                .and_then(|row| nearest(scenery, (course, candidate), row.nearest.as_ref()?)),
        }
    });
    PlanScene {
        horizon_s: scenario.horizon_s,
        ego: scenario.ego.0,
        parties: parties.collect(),
        courses: courses.collect(),
        members: drawn
            .chunks_exact(scenario.candidates.len().max(1))
            .map(|courses| member(scenery, courses))
            .collect(),
    }
}

/// The bodies where a candidate comes nearest to a party.
fn nearest(
    scenery: &Scenery<'_>,
    (course, candidate): (&Course<'_>, &scenario::Candidate),
    row: &NearestRow,
) -> Option<PlanNearest> {
    let parties = &scenery.scenario.parties;
    let party = parties.iter().position(|party| party.name == *row.party)?;
    let other = scenery.motion(candidate, party).path.pose_at(row.time_s);
    let models = [scenery.scenario.ego.0, party].map(|party| scenery.models[party]);
    Some(PlanNearest {
        party,
        time_s: row.time_s,
        gap_m: row.gap_m,
        scene: ContactScene {
            models,
            pose: RelativePose::between(&course.way.ego_at(row.time_s), &other),
            hits: [Vec::new(), Vec::new()],
        },
    })
}

/// Where everybody goes in the member of these courses, one per candidate.
fn member(scenery: &Scenery<'_>, courses: &[Course<'_>]) -> PlanMember {
    let scenario = scenery.scenario;
    let way = |path: &MotionPath| line(&track_of(path, scenario.horizon_s));
    let party = |party: usize| {
        let path = courses.first().and_then(|course| course.way.member().party(party));
        path.map_or_else(Vec::new, way)
    };
    let course = |course: &Course<'_>| {
        let number = course.candidate;
        let candidate = &scenario.candidates[number];
        let reacting = candidate.reactions.iter().map(|reaction| reaction.party.0);
        let path = |party: usize| course.way.member().other((number, candidate), party);
        PlanMemberCourse {
            ego: line(&ego_track(course)),
            reactions: reacting.map(|party| (party, way(path(party)))).collect(),
            contacts: contacts(course),
        }
    };
    PlanMember {
        parties: (0..scenario.parties.len()).map(party).collect(),
        courses: courses.iter().map(course).collect(),
    }
}

/// The samples of a track that are needed to be within [`LINE_M`] of all of them.
fn line(track: &[PlanSample]) -> Vec<PlanPoint> {
    let point = |sample: &PlanSample| {
        let [time_s, x, y, ..] = sample.0;
        // Centimetres and milliseconds: of less a thin line shows nothing.
        let short = |value: f64, by: f64| (value * by).round() / by + 0.0;
        PlanPoint([short(time_s, 1e3), short(x, 1e2), short(y, 1e2)])
    };
    let is_near = |first: usize, last: usize| {
        let (a, b) = (track[first].0, track[last].0);
        track[first + 1..last].iter().all(|sample| {
            let [time_s, x, y, ..] = sample.0;
            let share = (time_s - a[0]) / (b[0] - a[0]);
            let apart = |k: usize, is: f64| a[k] + share * (b[k] - a[k]) - is;
            apart(1, x).hypot(apart(2, y)) <= LINE_M
        })
    };
    let Some(begin) = track.first() else { return Vec::new() };
    let (mut kept, mut from) = (vec![point(begin)], 0);
    for next in 1..track.len() {
        if next + 1 == track.len() || !is_near(from, next + 1) {
            kept.push(point(&track[next]));
            from = next;
        }
    }
    kept
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
