//! What a scenario states that is allowed and hardly true: a lorry of 25 kg, 5 m up in the air, or
//! 2 km away.
//!
//! ```text
//! Scenario + bodies --implausible--> before the ranking: masses, sizes, speeds, heights, distances
//! the ranking's first --unmet--> after it: a winner that comes near nobody
//! ```
//!
//! Each is mostly a wrong unit, a wrong sign or a slipped digit, and may have the wrong candidate
//! win. Nothing here ranks or refuses; the caller says it beside the answer, or refuses on demand.
//! Both are pure functions of their arguments.
//!
//! # What is taken for plausible `[A]`
//!
//! The ranges are generous: they hold what is registered, sold or measured, from a microcar to a
//! road train, with its load, so that what lies beyond is almost surely an error.
//!
//! - Mass: from an empty light one of its kind to what roads allow (lorries up to 60 t, European
//!   Modular System; buses 32 t; cars 3.5 t and, with a load or a battery, 5 t). A group on foot is
//!   as heavy as its persons.
//! - Length, width and height: from the smallest sold to 25.25 m, 3.2 m with mirrors, 4.6 m.
//! - Speed: 75 to 85 m/s for cars and motorcycles, 40 m/s for lorries and buses, which are limited
//!   to less, 25 m/s for bicycles, 12.5 m/s on foot (the fastest sprinters).
//! - Height: a party that is nearest to the ego stands on the ground that the ego stands on, give
//!   or take [`STEP_M`] and a slope of [`SLOPE`].
//! - Distance: what is never within [`SENSED_M`] of the ego is beyond what its sensors see.

use crate::scenario::{Motion, Name, Occupancy, Party, Scenario};
use body::BodyKind;
use geometry::Aabb;
use geometry::motion::{MotionPath, State};
use schemars::JsonSchema;
use serde::Serialize;

/// Steps between the grounds of two bodies that are usual (m): kerbs, ramps, a sloppy origin.
pub const STEP_M: f64 = 0.5;
/// The steepest slope between two bodies that is usual: 15 %.
pub const SLOPE: f64 = 0.15;
/// Beyond this distance (m) sensors of vehicles see nobody.
pub const SENSED_M: f64 = 250.0;
/// A winner that nobody comes this close to (m) may have been meant to hit somebody.
pub const NEAR_M: f64 = 10.0;

/// A body as it was loaded, as far as it can be doubted.
#[derive(Clone, Copy, Debug)]
pub struct LoadedBody {
    /// Its kind.
    pub kind: BodyKind,
    /// Its mass (kg), unless the party states another; `None`: fixed to the ground.
    pub mass_kg: Option<f64>,
    /// Its box in the body frame (m), after the party's size is applied.
    pub bounds: Aabb,
}

/// Something that is allowed and hardly true.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Implausible {
    /// The party that it is about; `None`: a candidate as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub party: Option<String>,
    /// The candidate in which it is so; `None`: in all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub candidate: Option<String>,
    /// What is hardly true, and what would be, in one sentence without a full stop.
    pub says: String,
}

impl Implausible {
    /// What is hardly true, as a sentence with its full stop or question mark.
    #[must_use]
    pub fn sentence(&self) -> String {
        let says = &self.says;
        if says.ends_with('?') { says.clone() } else { format!("{says}.") }
    }
}

/// Smallest and greatest values of a kind.
struct Usual {
    mass_kg: [f64; 2],
    /// Of length, width and height (m).
    size_m: [[f64; 2]; 3],
    speed_m_s: f64,
}

/// What is usual for a kind; `None`: it is fixed to the ground, and may be of any size.
fn usual(kind: BodyKind) -> Option<Usual> {
    let (mass_kg, size_m, speed_m_s) = match kind {
        BodyKind::Sedan => ([350.0, 5_000.0], [[2.2, 7.0], [1.1, 2.6], [0.9, 2.6]], 80.0),
        BodyKind::Suv => ([500.0, 5_500.0], [[2.4, 8.0], [1.2, 2.8], [1.2, 3.5]], 75.0),
        BodyKind::Truck => ([1_000.0, 60_000.0], [[3.5, 26.0], [1.4, 3.2], [1.5, 4.6]], 40.0),
        BodyKind::Bus => ([2_000.0, 32_000.0], [[4.5, 26.0], [1.6, 3.2], [1.9, 4.6]], 40.0),
        BodyKind::Motorcycle => ([40.0, 900.0], [[1.0, 3.5], [0.3, 2.2], [0.6, 2.3]], 85.0),
        BodyKind::Cyclist => ([20.0, 300.0], [[0.7, 3.2], [0.2, 1.6], [0.6, 2.4]], 25.0),
        BodyKind::Pedestrian => ([3.0, 250.0], [[0.1, 2.3], [0.1, 2.3], [0.15, 2.3]], 12.5),
        BodyKind::Wall | BodyKind::Pole | BodyKind::Building => return None,
    };
    Some(Usual { mass_kg, size_m, speed_m_s })
}

/// What is hardly true of a scenario's parties, in their order; `bodies[i]` is that of
/// `parties[i]`. Nothing, if there are not as many bodies as parties.
///
/// Parties of unknown kind are doubted only for where they are.
#[must_use]
pub fn implausible(scenario: &Scenario, bodies: &[LoadedBody]) -> Vec<Implausible> {
    if bodies.len() != scenario.parties.len() {
        return Vec::new();
    }
    let mut all = Vec::new();
    for (number, (party, body)) in scenario.parties.iter().zip(bodies).enumerate() {
        let is_ego = number == scenario.ego.0;
        let mut say = |candidate: Option<&Name>, says: String| {
            let party = Some(party.name.to_string());
            all.push(Implausible { party, candidate: candidate.map(Name::to_string), says });
        };
        if let Some(usual) = usual(body.kind).filter(|_| !party.is_unknown) {
            own(party, body, &usual, &mut |says| say(None, says));
            let most = usual.speed_m_s;
            for (candidate, motion) in motions(scenario, number) {
                let speed = greatest_speed_m_s(&motion.path);
                if speed > most {
                    let (name, kind) = (&party.name, body.kind);
                    let says = format!(
                        "\"{name}\" goes {speed:.0} m/s, a {kind} {most} m/s at most: is it in \
                         km/h?"
                    );
                    say(candidate, says);
                    break;
                }
            }
        }
        if !is_ego {
            let ego = &bodies[scenario.ego.0];
            whereabouts(scenario, number, [ego, body], &mut |says| say(None, says));
        }
    }
    all
}

/// What is hardly true of the first place of a ranking: it touches nobody, and comes near nobody.
/// `nearest` is the party that it comes nearest to, and how near (m).
#[must_use]
pub fn unmet(candidate: &str, nearest: Option<(&str, f64)>) -> Option<Implausible> {
    let (party, gap_m) = nearest.filter(|(_, gap_m)| *gap_m > NEAR_M)?;
    let says = format!(
        "\"{candidate}\" comes within {NEAR_M} m of nobody, and {gap_m:.0} m of \"{party}\": was \
         it meant to hit somebody?"
    );
    Some(Implausible { party: None, candidate: Some(candidate.into()), says })
}

/// Mass and size.
fn own(party: &Party, body: &LoadedBody, usual: &Usual, say: &mut dyn FnMut(String)) {
    let (name, kind) = (&party.name, body.kind);
    let is_group = kind == BodyKind::Pedestrian;
    let persons = match &party.occupancy {
        Occupancy::Stated(_) if is_group => party.occupancy.count().unwrap_or(1).max(1),
        _ => 1,
    };
    let [least, most] = usual.mass_kg;
    let most = most * f64::from(persons);
    if let Some(mass_kg) = party.mass_kg.or(body.mass_kg)
        && !(least..=most).contains(&mass_kg)
    {
        let unit = if mass_kg < least { ": is it in tonnes?" } else { "" };
        say(format!("\"{name}\" weighs {mass_kg} kg, a {kind} {least} to {most} kg{unit}"));
    }
    // Several persons that are one body take more room than one.
    if persons > 1 {
        return;
    }
    for (axis, what) in ["long", "wide", "high"].into_iter().enumerate() {
        let size_m = f64::from(body.bounds.max[axis]) - f64::from(body.bounds.min[axis]);
        let [least, most] = usual.size_m[axis];
        // Boxes are in f32, stated sizes are not.
        if !(least - 0.001..=most + 0.001).contains(&size_m) {
            say(format!("\"{name}\" is {size_m:.2} m {what}, a {kind} {least} to {most} m"));
            return;
        }
    }
}

/// The motions of a party, with the candidate in which it moves so, if not in all.
fn motions(scenario: &Scenario, party: usize) -> Vec<(Option<&Name>, &Motion)> {
    let predicted = scenario.parties[party].predictions.iter().map(|told| (None, &told.motion));
    let reactions = scenario.candidates.iter().flat_map(|candidate| {
        let of_party = candidate.reactions.iter().filter(|reaction| reaction.party.0 == party);
        of_party.map(|reaction| (Some(&candidate.name), &reaction.motion))
    });
    let ego = scenario.candidates.iter().filter(|_| party == scenario.ego.0);
    let ego = ego.map(|candidate| (Some(&candidate.name), &candidate.ego));
    predicted.chain(reactions).chain(ego).collect()
}

/// The greatest speed in the ground plane on a path (m/s).
fn greatest_speed_m_s(path: &MotionPath) -> f64 {
    let speed = |pair: &[State]| {
        let [from, to] = [&pair[0], &pair[1]];
        let moved = [0, 1].map(|axis| to.position_m[axis] - from.position_m[axis]);
        square(moved).sqrt() / (to.time_s - from.time_s)
    };
    // Two states that are hardly apart in time have the rounding of their positions for a speed.
    let apart = |pair: &&[State]| pair[1].time_s - pair[0].time_s > 1e-3;
    path.states().windows(2).filter(apart).map(speed).fold(0.0, f64::max)
}

/// Where two bodies are nearest to each other in plan.
#[derive(Clone, Copy)]
struct Nearest {
    /// Of their origins (m).
    apart_m: f64,
    /// Their poses then.
    states: [State; 2],
}

/// Distance and height of a party where it is nearest to the ego, over all candidates.
fn whereabouts(
    scenario: &Scenario,
    party: usize,
    [ego, body]: [&LoadedBody; 2],
    say: &mut dyn FnMut(String),
) {
    let mut nearest: Option<Nearest> = None;
    for candidate in &scenario.candidates {
        let reaction = candidate.reactions.iter().find(|reaction| reaction.party.0 == party);
        let predicted = scenario.parties[party].predictions.iter().map(|told| &told.motion);
        let ways: Vec<&Motion> = match reaction {
            Some(reaction) => vec![&reaction.motion],
            None => predicted.collect(),
        };
        for way in ways {
            let found = nearest_in_plan([&candidate.ego.path, &way.path]);
            if nearest.is_none_or(|known| found.apart_m < known.apart_m) {
                nearest = Some(found);
            }
        }
    }
    let Some(Nearest { apart_m, states: [of_ego, of_party] }) = nearest else { return };
    let name = &scenario.parties[party].name;
    let gap_m = apart_m - reach_m(&ego.bounds) - reach_m(&body.bounds);
    if gap_m > SENSED_M {
        say(format!(
            "\"{name}\" is never within {SENSED_M} m of the ego (nearest: {gap_m:.0} m): it plays \
             no part"
        ));
        return;
    }
    let [floor, _] = heights_m(&of_ego, &ego.bounds);
    let [low, high] = heights_m(&of_party, &body.bounds);
    let usual_m = STEP_M + SLOPE * apart_m;
    if low - floor > usual_m {
        say(format!(
            "\"{name}\" is {:.1} m up in the air, above what the ego stands on",
            low - floor
        ));
    } else if (if body.kind.is_fixed() { high } else { low }) < floor - usual_m {
        say(format!("\"{name}\" is {:.1} m below what the ego stands on", floor - low));
    }
}

/// The radius of a box around its origin in plan (m).
fn reach_m(bounds: &Aabb) -> f64 {
    let ends = [0, 1].map(|axis| [bounds.min[axis], bounds.max[axis]].map(f64::from));
    square(ends.map(|[low, high]| low.abs().max(high.abs()))).sqrt()
}

/// The lowest and the highest corner of a box in the world (m).
fn heights_m(state: &State, bounds: &Aabb) -> [f64; 2] {
    let up = state.orientation.rotation()[2];
    let mut heights = [state.position_m[2]; 2];
    for (axis, share) in up.into_iter().enumerate() {
        let ends = [bounds.min[axis], bounds.max[axis]].map(|end| share * f64::from(end));
        heights[0] += ends[0].min(ends[1]);
        heights[1] += ends[0].max(ends[1]);
    }
    heights
}

/// When the origins of two bodies are nearest in plan: in each piece both positions are linear in
/// time, so it is exact.
fn nearest_in_plan(paths: [&MotionPath; 2]) -> Nearest {
    let states = paths.map(MotionPath::states);
    let mut next = [1, 1];
    let mut from_s = states[0][0].time_s.max(states[1][0].time_s);
    let mut start = apart_at(states, next, from_s);
    let mut best = (square(start), from_s);
    loop {
        let ends = [0, 1].map(|side| states[side].get(next[side]).map(|state| state.time_s));
        let [Some(a_s), Some(b_s)] = ends else { break };
        let to_s = a_s.min(b_s);
        let end = apart_at(states, next, to_s);
        let way = [0, 1].map(|axis| end[axis] - start[axis]);
        let along = -(start[0] * way[0] + start[1] * way[1]);
        let mut look = |apart: [f64; 2], time_s: f64| {
            if square(apart) < best.0 {
                best = (square(apart), time_s);
            }
        };
        if along > 0.0 && along < square(way) {
            let share = along / square(way);
            look(
                [0, 1].map(|axis| start[axis] + way[axis] * share),
                from_s + (to_s - from_s) * share,
            );
        }
        look(end, to_s);
        for (side, end_s) in [a_s, b_s].into_iter().enumerate() {
            next[side] += usize::from(end_s <= to_s);
        }
        (start, from_s) = (end, to_s);
    }
    Nearest { apart_m: best.0.sqrt(), states: paths.map(|path| path.state_at(best.1)) }
}

/// From one body to the other in plan (m), at a time within the pieces that end with these states.
fn apart_at(states: [&[State]; 2], next: [usize; 2], time_s: f64) -> [f64; 2] {
    let [a, b] = [0, 1].map(|side| {
        let [from, to] = [&states[side][next[side] - 1], &states[side][next[side]]];
        let share = ((time_s - from.time_s) / (to.time_s - from.time_s)).clamp(0.0, 1.0);
        let (p, q) = (from.position_m, to.position_m);
        [0, 1].map(|axis| p[axis] + (q[axis] - p[axis]) * share)
    });
    [0, 1].map(|axis| b[axis] - a[axis])
}

fn square([x, y]: [f64; 2]) -> f64 {
    x * x + y * y
}

#[cfg(test)]
mod tests;
