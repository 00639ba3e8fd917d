//! What is said about a candidate beside its harm: how near the ego comes to others, what is ahead
//! of it at the end of its way, and whom it would meet if others moved otherwise.
//!
//! Nothing here ranks. Distances are of outlines in plan, at steps of 50 ms.

use super::way::{Scenery, Way};
use bvh::support::{Extremes, support_from};
use executor::encounter::{Encounters, Look, LookOutcome};
use geometry::plan::ConvexOutline;
use geometry::{DVec3, Pose};
use scenario::Candidate;
use schemars::JsonSchema;
use serde::Serialize;
use std::ops::ControlFlow;

/// Step of time at which distances are looked at (s).
const STEP_S: f64 = 0.05;
/// Beyond this time after the end of a way (s) nothing is said.
const AHEAD_S: f64 = 10.0;
/// Outlines nearer than this (m) count as in contact beyond the horizon.
const CONTACT_M: f64 = 0.01;
/// Steps towards a contact beyond the horizon, at most.
const STEPS_MAX: usize = 64;

/// The party that comes nearest without contact.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct NearestRow {
    /// Which.
    pub party: String,
    /// The distance of the outlines in plan (m), not more than that of the bodies; 0 where they
    /// overlap in plan.
    pub gap_m: f64,
    /// When (s).
    pub time_s: f64,
}

/// What is ahead of the ego at the end of its way.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AtHorizon {
    /// The end of the way: the horizon, or the end of a run-out before (s).
    pub time_s: f64,
    /// The ego's speed there (m/s).
    pub speed_m_s: f64,
    /// The nearest party there, and how far away it is in plan (m).
    pub nearest: Option<(String, f64)>,
    /// If everybody went straight on as then: whom the ego would meet first, and after how many
    /// seconds; `None`: nobody within ten.
    pub next_contact: Option<(String, f64)>,
}

/// A predicted motion that was not followed, on which the ego would meet the party.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Alternative {
    /// Which party.
    pub party: String,
    /// The number of its path in the scenario, from 1.
    pub path: usize,
    /// Its probability.
    pub probability: f64,
    /// When the ego would meet it on its planned path (s).
    pub time_s: f64,
    /// Whether that is certain; else it was not decided.
    pub is_certain: bool,
}

/// Outlines of all bodies of a request, by number of the body.
#[derive(Debug)]
pub(super) struct Outlines(Vec<ConvexOutline>);

impl Outlines {
    /// `extremes` of each body; fewer: the rest is found in the trees, to the same bits.
    pub(super) fn of(scenery: &Scenery<'_>, extremes: &[Extremes]) -> Self {
        let outline = |(number, (_, view)): (usize, &(body::Meta, body::BodyView<'_>))| {
            let mut near = None;
            ConvexOutline::of(|[x, y]| {
                let direction = DVec3::new(x, y, 0.0);
                support_from(extremes.get(number), view, direction, &mut near)
            })
        };
        Self(scenery.bodies.iter().enumerate().map(outline).collect())
    }

    pub(super) fn of_party(&self, scenery: &Scenery<'_>, party: usize) -> &ConvexOutline {
        &self.0[scenery.models[party]]
    }
}

/// The ego and a party in plan.
struct Pair<'o> {
    outlines: [&'o ConvexOutline; 2],
}

impl Pair<'_> {
    /// The distance at two poses (m), if it is less than `limit_m`.
    fn gap_m(&self, [a, b]: [&Pose; 2], limit_m: f64) -> Option<f64> {
        let [of_a, of_b] = self.outlines;
        if of_a.apart_at_least_m(of_b, [a, b]) >= limit_m {
            return None;
        }
        Some(of_a.placed(a).distance_m(&of_b.placed(b))).filter(|gap| *gap < limit_m)
    }
}

impl Pair<'_> {
    /// After how many seconds circles around the outlines meet; `None`: never, as they go.
    fn circles_meet_after(&self, [a, b]: [&Pose; 2], relative: DVec3) -> Option<f64> {
        let reach = self.outlines[0].radius_m() + self.outlines[1].radius_m();
        let (at, v) = (DVec3::from(b.translation) - DVec3::from(a.translation), relative);
        let (at, v) = (at.truncate(), v.truncate());
        // |at + v t| = reach.
        let (square, along) = (at.dot(at) - reach * reach, at.dot(v));
        if square <= 0.0 {
            return Some(0.0);
        }
        let speed = v.dot(v);
        let under = along * along - speed * square;
        let is_met = along < 0.0 && under >= 0.0 && speed > 0.0;
        is_met.then(|| (-along - under.sqrt()) / speed)
    }
}

/// Where the parties are at every step of time, as they are predicted.
#[derive(Debug)]
pub(super) struct Predicted(Vec<Vec<Pose>>);

impl Predicted {
    pub(super) fn of(scenery: &Scenery<'_>) -> Self {
        let ego = scenery.scenario.ego.0;
        let steps = (scenery.scenario.horizon_s / STEP_S).ceil() as usize;
        let poses = |party: usize| {
            let path = &scenery.likeliest(party).1.path;
            (0..=steps).map(|step| path.pose_at(step as f64 * STEP_S)).collect()
        };
        let count = scenery.scenario.parties.len();
        Self((0..count).map(|party| if party == ego { Vec::new() } else { poses(party) }).collect())
    }
}

/// The party that comes nearest to the ego on its way, of those that it does not touch; of the same
/// distance, the first in time.
///
/// Outlines are compared where boxes around them come nearest first, and no longer once these are
/// farther apart than the nearest outlines.
pub(super) fn nearest(
    (scenery, outlines, predicted): (&Scenery<'_>, &Outlines, &Predicted),
    (way, candidate): (&Way<'_>, &Candidate),
    is_met: impl Fn(usize) -> bool,
) -> Option<NearestRow> {
    let ego = scenery.scenario.ego.0;
    let last = (way.end_s / STEP_S).ceil() as usize;
    let time_of = |step: usize| (step as f64 * STEP_S).min(way.end_s);
    let egos: Vec<Pose> = (0..=last).map(|step| way.ego_at(time_of(step))).collect();
    let other = |party: usize, step: usize| {
        let reacts = candidate.reactions.iter().any(|reaction| reaction.party.0 == party);
        if reacts || step == last {
            return scenery.motion(candidate, party).path.pose_at(time_of(step));
        }
        predicted.0[party][step]
    };
    let own = outlines.of_party(scenery, ego);
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for party in scenery.others().filter(|party| !is_met(*party)) {
        let outline = outlines.of_party(scenery, party);
        for (step, pose) in egos.iter().enumerate() {
            let apart_m = own.apart_at_least_m(outline, [pose, &other(party, step)]);
            order.push((apart_m, step, party));
        }
    }
    let by_gap = |a: &(f64, usize, usize), b: &(f64, usize, usize)| {
        a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2)))
    };
    order.sort_unstable_by(by_gap);
    let mut best: Option<(f64, usize, usize)> = None;
    for (least_m, step, party) in order {
        if best.is_some_and(|(gap_m, ..)| least_m > gap_m) {
            break;
        }
        let far = outlines.of_party(scenery, party).placed(&other(party, step));
        let next = (own.placed(&egos[step]).distance_m(&far), step, party);
        if best.is_none_or(|best| by_gap(&next, &best).is_lt()) {
            best = Some(next);
        }
        // Outlines that overlap in plan come no nearer.
        if next.0 == 0.0 {
            break;
        }
    }
    best.map(|(gap_m, step, party)| NearestRow {
        party: scenery.scenario.parties[party].name.to_string(),
        gap_m,
        time_s: time_of(step),
    })
}

/// What is ahead at the end of the way.
pub(super) fn at_horizon(
    (scenery, outlines): (&Scenery<'_>, &Outlines),
    (way, candidate): (&Way<'_>, &Candidate),
    is_met: impl Fn(usize) -> bool,
) -> AtHorizon {
    let ego = scenery.scenario.ego.0;
    let time_s = way.end_s;
    let pose = way.ego_at(time_s);
    let origin = [0.0; 3];
    let velocity = match way.run_outs.last() {
        // A run-out that ended before the horizon stands.
        Some(leg) if leg.from_s + leg.run_out.lasts_s() <= time_s => DVec3::ZERO,
        _ => way.ego_path().velocity_before(time_s, origin).0,
    };
    let mut nearest: Option<(usize, f64)> = None;
    let mut next: Option<(usize, f64)> = None;
    for party in scenery.others().filter(|party| !is_met(*party)) {
        let path = &scenery.motion(candidate, party).path;
        let other = path.pose_at(time_s);
        let pair = Pair { outlines: [ego, party].map(|party| outlines.of_party(scenery, party)) };
        let limit_m = nearest.map_or(f64::INFINITY, |(_, gap_m)| gap_m);
        if let Some(gap_m) = pair.gap_m([&pose, &other], limit_m) {
            nearest = Some((party, gap_m));
        }
        let relative = path.velocity_before(time_s, origin).0 - velocity;
        let limit_s = next.map_or(AHEAD_S, |(_, time_s)| time_s);
        if let Some(after_s) = meets_after(&pair, [&pose, &other], relative, limit_s) {
            next = Some((party, after_s));
        }
    }
    let named =
        |(party, value): (usize, f64)| (scenery.scenario.parties[party].name.to_string(), value);
    AtHorizon {
        time_s,
        speed_m_s: velocity.truncate().length(),
        nearest: nearest.map(named),
        next_contact: next.map(named),
    }
}

/// After how many seconds, less than `limit_s`, outlines meet that move on straight; `relative` is
/// the velocity of B seen from A (m/s). Conservative advancement: each step is as long as the gap
/// allows (B. Mirtich, *Impulse-based dynamic simulation*, 1996).
fn meets_after(pair: &Pair<'_>, [a, b]: [&Pose; 2], relative: DVec3, limit_s: f64) -> Option<f64> {
    let speed = relative.truncate().length();
    let mut after_s =
        pair.circles_meet_after([a, b], relative).filter(|after_s| *after_s < limit_s)?;
    let (of_a, of_b) = (pair.outlines[0].placed(a), pair.outlines[1].placed(b));
    for _ in 0..STEPS_MAX {
        let by = [relative.x * after_s, relative.y * after_s];
        let gap_m = of_a.distance_m(&of_b.moved(by));
        if gap_m < CONTACT_M {
            return Some(after_s);
        }
        after_s += gap_m / speed;
        if !(after_s < limit_s) {
            return None;
        }
    }
    Some(after_s)
}

/// Predicted motions that were not followed, on which the ego meets the party on its planned path.
pub(super) fn alternatives(
    scenery: &Scenery<'_>,
    (way, candidate): (&Way<'_>, &Candidate),
    encounters: &mut Encounters,
) -> Vec<Alternative> {
    let scenario = scenery.scenario;
    let until_s = way.run_outs.first().map_or(scenario.horizon_s, |leg| leg.from_s);
    let mut all = Vec::new();
    if !(until_s > 0.0) {
        return all;
    }
    for party in scenery.others() {
        let reacts = candidate.reactions.iter().any(|reaction| reaction.party.0 == party);
        let predictions = &scenario.parties[party].predictions;
        if reacts || predictions.len() < 2 {
            continue;
        }
        let (followed, _) = scenery.likeliest(party);
        for (number, prediction) in predictions.iter().enumerate() {
            if number == followed || !(prediction.probability > 0.0) {
                continue;
            }
            let ways = scenery.ways(party, [&candidate.ego.path, &prediction.motion.path]);
            let resolution_m = scenario.resolution_m;
            let look = Look { ways, from_s: 0.0, end_s: until_s, resolution_m, may_touch: false };
            let mut watch = |_| ControlFlow::Continue(());
            let (time_s, is_certain) = match encounters.look(&look, &mut watch) {
                Ok((LookOutcome::Contact(touching) | LookOutcome::Still(touching), _)) => {
                    (touching.time_s, touching.is_certain)
                }
                Ok((LookOutcome::Never | LookOutcome::Hidden, _)) => continue,
                Err(_) => (0.0, false),
            };
            all.push(Alternative {
                party: scenario.parties[party].name.to_string(),
                path: number + 1,
                probability: prediction.probability,
                time_s,
                is_certain,
            });
        }
    }
    all
}
