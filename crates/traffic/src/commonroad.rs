//! CommonRoad XML, versions 2018b and 2020a (Althoff, Koschi, Manzinger: CommonRoad, IV 2017; the
//! schema and manual of each version).
//!
//! Read are obstacles and a planning problem, whose initial state is the ego's; lanes, signs and
//! goals are not: they do not change who is hit. States may be exact or intervals, of
//! which the middle is taken and noted; the first state of somebody also says how well it is known.
//! Occupancy sets are refused: a set of positions is not a position.

use crate::ReadOptions;
use crate::error::TrafficError;
use crate::outline::{Outline, Placed};
use crate::recording::{
    Ego, Obstacle, Planned, Recording, StateSpread, TimedState, without_turns_about, wrapped,
};
use crate::xml::Element;
use place::{position, shape};

mod place;
mod solution;
mod track;

pub(crate) use place::{COORDINATE_M, EXTENT_M};

/// Types of obstacles in both versions.
pub(crate) const TYPES: [&str; 17] = [
    "unknown",
    "car",
    "truck",
    "bus",
    "motorcycle",
    "bicycle",
    "pedestrian",
    "priorityVehicle",
    "train",
    "taxi",
    "parkedVehicle",
    "constructionZone",
    "roadBoundary",
    "building",
    "pillar",
    "median_strip",
    "vehicle",
];

/// Greatest speed (m/s): 540 km/h, as in a scenario.
pub(crate) const SPEED_M_S: f64 = 150.0;
/// An obstacle that starts as near to the ego as this is the ego: (m), (rad), (m/s).
const SAME: [f64; 3] = [0.1, 0.05, 0.2];

/// Reads a file whose root is `commonRoad`.
pub(crate) fn read(
    root: Element<'_>,
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    let without = options.without;
    let version = root.need_attribute("commonRoadVersion")?;
    if !["2018b", "2020a"].contains(&version) {
        return Err(root.fault(
            format!("version {version:?} is not known"),
            "versions 2018b and 2020a are read; convert with commonroad-io",
        ));
    }
    let step_s = match root.need_attribute("timeStepSize")?.trim().parse::<f64>() {
        Ok(step) if step > 0.0 && step <= 10.0 => step,
        _ => return Err(root.fault("timeStepSize is not in (0, 10] s", "write it in seconds")),
    };
    let mut reader = Reader { step_s, notes: Vec::new(), sets: sets(root, without) };
    let mut others = Vec::new();
    let mut phantoms = 0;
    let mut seen: Vec<&str> = Vec::new();
    for element in root.children() {
        let is_fixed = match element.name() {
            "staticObstacle" | "environmentObstacle" => true,
            "dynamicObstacle" => false,
            "obstacle" => match element.need("role")?.text() {
                "static" => true,
                "dynamic" => false,
                other => {
                    let fault = format!("role {other:?} is not known");
                    return Err(element.fault(fault, "write static or dynamic"));
                }
            },
            "phantomObstacle" => {
                phantoms += 1;
                continue;
            }
            _ => continue,
        };
        let id = element.need_attribute("id")?;
        if seen.contains(&id) {
            return Err(element.fault("two obstacles have this id", "give one another id"));
        }
        seen.push(id);
        if !without.iter().any(|left_out| left_out == id) {
            others.push(reader.obstacle(element, id, is_fixed)?);
        }
    }
    if let Some(unknown) = without.iter().find(|id| !seen.contains(&id.as_str())) {
        let fault = format!("there is no obstacle {unknown:?} to leave out");
        return Err(root.fault(fault, listed(&seen)));
    }
    if phantoms > 0 {
        reader.notes.push(format!("{phantoms} phantom obstacles represent nobody: left out"));
    }
    let (mut ego, problem) = reader.ego(root, options.ego, &mut others)?;
    let benchmark = root.attribute("benchmarkID");
    let mut planned: Vec<Planned> = Vec::new();
    for source in options.solutions {
        let times = (ego.start.time_s, step_s);
        let (way, outline) = solution::read(source, benchmark, problem, times)?;
        if planned.iter().any(|other| other.name == way.name) {
            return Err(root.fault(
                format!("two solutions are called {:?}", way.name),
                "a solution is called like its file: rename one",
            ));
        }
        let size = |outline: &Outline| {
            let [length, width] = outline.size();
            format!("{length:.3} × {width:.3} m")
        };
        match (&ego.outline, outline) {
            (None, Some(outline)) => ego.outline = Some(outline),
            (Some(ours), Some(outline)) if ours.size() == outline.size() => {}
            (Some(ours), Some(outline)) => reader.notes.push(format!(
                "the solution \"{}\" is of a vehicle of {}: the ego is taken as {}",
                way.name,
                size(&outline),
                size(ours)
            )),
            (_, None) => reader.notes.push(format!(
                "the solution \"{}\" is of a vehicle of unknown size: the ego's is taken",
                way.name
            )),
        }
        planned.push(way);
    }
    let name = benchmark.unwrap_or("CommonRoad").to_owned();
    Ok(Recording { name, ego, planned, others, notes: reader.notes })
}

/// Obstacles whose future is a set of places, but for those that are left out.
fn sets(root: Element<'_>, without: &[String]) -> Vec<String> {
    let of_sets = root.children().filter(|one| one.get("occupancySet").is_some());
    let ids = of_sets.filter_map(|one| one.attribute("id")).map(str::to_owned);
    ids.filter(|id| !without.contains(id)).collect()
}

fn listed(ids: &[&str]) -> String {
    let shown: Vec<&str> = ids.iter().take(20).copied().collect();
    let more = if ids.len() > shown.len() { ", …" } else { "" };
    format!("obstacles here: {}{more}", shown.join(", "))
}

struct Reader {
    step_s: f64,
    notes: Vec<String>,
    /// Obstacles with an occupancy set.
    sets: Vec<String>,
}

impl Reader {
    /// The ego, and the id of the planning problem that is its own.
    fn ego<'d>(
        &mut self,
        root: Element<'d>,
        asked: Option<&str>,
        others: &mut Vec<Obstacle>,
    ) -> Result<(Ego, Option<&'d str>), TrafficError> {
        let problems: Vec<Element<'_>> = root.all("planningProblem").collect();
        let is_asked = |problem: &&Element<'_>| asked.is_some() && problem.attribute("id") == asked;
        let problem = problems.iter().find(is_asked);
        if let (Some(asked), None) = (asked, problem) {
            let Some(index) = others.iter().position(|obstacle| obstacle.id == asked) else {
                let ids: Vec<&str> = others.iter().map(|obstacle| obstacle.id.as_str()).collect();
                let fault = format!("there is no obstacle or planning problem {asked:?}");
                return Err(root.fault(fault, listed(&ids)));
            };
            let ego = others.remove(index);
            let start = ego.track[0];
            let (outline, spread) = (Some(ego.outline), ego.spread);
            return Ok((Ego { start, outline, went: ego.track, spread }, None));
        }
        let Some(problem) = problem.or(problems.first()) else {
            let moving: Vec<&str> =
                others.iter().filter(|one| !one.is_static()).map(|one| &*one.id).collect();
            if moving.is_empty() {
                let fault = "a map alone: it has no planning problem, and no obstacle that moves";
                return Err(root.fault(fault, "give a scenario, with traffic"));
            }
            let remedy =
                format!("name the obstacle that is the ego: --ego ID; {}", listed(&moving));
            return Err(root.fault("no <planningProblem> says where the ego starts", remedy));
        };
        let id = problem.attribute("id");
        if asked.is_none() && problems.len() > 1 {
            self.notes.push(format!(
                "{} planning problems: the first, {}, is taken as the ego; --ego ID takes \
                 another",
                problems.len(),
                id.unwrap_or("?")
            ));
        }
        let state = problem.need("initialState")?;
        let (start, open) = self.moment(state, true)?;
        let spread = open.spread;
        if spread != StateSpread::default() {
            self.notes.push(format!(
                "the ego's first state is known up to intervals: {}",
                spread.taken()
            ));
        }
        let is_ego = |obstacle: &Obstacle| {
            !obstacle.is_static()
                && obstacle.at(start.time_s).is_some_and(|moment| same(&moment, &start))
        };
        let Some(index) = others.iter().position(is_ego) else {
            return Ok((Ego { start, outline: None, went: Vec::new(), spread }, id));
        };
        let ego = others.remove(index);
        self.notes.push(format!(
            "obstacle {} starts where the ego does: it is the ego, with its shape and its way",
            ego.id
        ));
        Ok((Ego { start, outline: Some(ego.outline), went: ego.track, spread }, id))
    }

    fn obstacle(
        &mut self,
        element: Element<'_>,
        id: &str,
        is_fixed: bool,
    ) -> Result<Obstacle, TrafficError> {
        let kind = element.need("type")?;
        if !TYPES.contains(&kind.text()) {
            let fault = format!("obstacle type {:?} is not known", kind.text());
            return Err(kind.fault(fault, format!("known are {}", TYPES.join(", "))));
        }
        let outline = shape(element.need("shape")?)?;
        let mut track: Vec<TimedState> = Vec::new();
        let mut opens: Vec<Open> = Vec::new();
        let mut repeated = 0;
        let initial = if element.name() == "environmentObstacle" {
            let place = Placed { at: [0.0; 2], yaw: 0.0 };
            track.push(TimedState { time_s: 0.0, place, speed_m_s: 0.0, slip: 0.0 });
            opens.push(Open::default());
            None
        } else {
            Some(element.need("initialState")?)
        };
        let later = if is_fixed { Vec::new() } else { self.trajectory(element)? };
        for state in initial.into_iter().chain(later) {
            let (moment, open) = self.moment(state, false)?;
            if is_fixed && open.headless {
                return Err(headless(state));
            }
            if track.last() == Some(&moment) {
                repeated += 1;
                continue;
            }
            if track.last().is_some_and(|last| last.time_s >= moment.time_s) {
                let help = "states stand in the order of their times, each time once";
                return Err(state.fault("its time is not after that of the state before", help));
            }
            track.push(moment);
            opens.push(open);
        }
        let spread = opens[0].spread;
        if is_fixed {
            track[0].speed_m_s = 0.0;
        } else {
            self.mend(element, id, &mut track, &opens)?;
        }
        if repeated > 0 {
            self.notes.push(format!("obstacle {id}: {repeated} of its states stand twice"));
        }
        let intervals = opens.iter().filter(|open| open.interval).count();
        if intervals > 0 {
            let known = if spread == StateSpread::default() {
                String::new()
            } else {
                format!("; of the first: {}", spread.taken())
            };
            self.notes.push(format!(
                "obstacle {id}: {intervals} of its states are intervals; their middles are \
                 taken{known}"
            ));
        }
        let (id, kind) = (id.to_owned(), kind.text().to_owned());
        Ok(Obstacle { id, kind, outline, track, spread })
    }

    /// Adds what the states of an obstacle that moves leave open.
    fn mend(
        &mut self,
        element: Element<'_>,
        id: &str,
        track: &mut Vec<TimedState>,
        opens: &[Open],
    ) -> Result<(), TrafficError> {
        if track.len() == 1 {
            let fault = "only its first state is stated, without";
            if opens[0].speedless {
                return Err(element.fault(format!("{fault} <velocity>"), "say where it goes"));
            }
            if opens[0].headless {
                return Err(element.fault(format!("{fault} <orientation>"), "say where it goes"));
            }
            track.push(track::straight_on(&track[0], self.step_s));
            self.notes.push(format!(
                "obstacle {id}: nothing says where it goes: it is taken to go straight on, as fast \
                 as in its first state"
            ));
            return Ok(());
        }
        if opens.iter().any(|open| open.headless) {
            let missing: Vec<bool> = opens.iter().map(|open| open.headless).collect();
            if !track::headings_from_places(track, &missing) {
                return Err(headless(element));
            }
            self.notes
                .push(format!("obstacle {id}: orientations are not stated; its places give them"));
        }
        if opens.iter().any(|open| open.speedless) {
            track::speeds_from_places(track);
            self.notes.push(format!("obstacle {id}: speeds are not stated; its places give them"));
        }
        self.notes.extend(without_turns_about(track, &format!("obstacle {id}")));
        Ok(())
    }

    /// The states after the first one; none where the file says nothing of them.
    fn trajectory<'d>(&self, element: Element<'d>) -> Result<Vec<Element<'d>>, TrafficError> {
        if let Some(set) = element.get("occupancySet") {
            let all: Vec<String> =
                self.sets.iter().take(20).map(|id| format!("--without {id}")).collect();
            return Err(set.fault(
                "an occupancy set says where it may be, not where it is",
                format!(
                    "give all such obstacles a <trajectory>, or leave them out: {}",
                    all.join(" ")
                ),
            ));
        }
        let Some(trajectory) = element.get("trajectory") else { return Ok(Vec::new()) };
        let states: Vec<Element<'d>> = trajectory.all("state").collect();
        if states.is_empty() {
            let help = "add the states of the recording, or make it a static obstacle";
            return Err(element.fault("its trajectory has no states", help));
        }
        Ok(states)
    }

    /// A state, and what it left open.
    fn moment(&self, state: Element<'_>, is_ego: bool) -> Result<(TimedState, Open), TrafficError> {
        let mut open = Open::default();
        let (at, region) = position(state.need("position")?)?;
        let mut value = |name: &str| -> Result<Option<[f64; 2]>, TrafficError> {
            let Some(element) = state.get(name) else { return Ok(None) };
            let [value, half] = middle_and_half(element)?;
            open.interval |= half > 0.0;
            Ok(Some([value, half]))
        };
        let yaw = value("orientation")?;
        let time = value("time")?;
        let mut speed = value("velocity")?;
        let across = value("velocityY")?;
        let slip = value("slipAngle")?;
        let Some([time, _]) = time else {
            return Err(state.fault("<time> is missing", "state the time step"));
        };
        // A point mass has velocities along the axes of the map, and no orientation.
        let mut yaw = yaw;
        if let (None, Some([vx, half]), Some([vy, _])) = (yaw, speed, across)
            && (vx != 0.0 || vy != 0.0)
        {
            yaw = Some([libm::atan2(vy, vx), 0.0]);
            speed = Some([libm::hypot(vx, vy), half]);
        }
        if yaw.is_none() && is_ego {
            return Err(headless(state));
        }
        if speed.is_none() && is_ego {
            return Err(state.fault("<velocity> is missing", "state how fast the ego is"));
        }
        let [speed_m_s, speed_half_m_s] = speed.unwrap_or_default();
        if speed_m_s.abs() > SPEED_M_S {
            let fault = format!("its velocity is {speed_m_s} m/s");
            return Err(state.fault(fault, format!("at most {SPEED_M_S} m/s: a wrong unit?")));
        }
        open.interval |= region.is_some();
        (open.speedless, open.headless) = (speed.is_none(), yaw.is_none());
        let [yaw, yaw_half] = yaw.unwrap_or_default();
        let yaw = wrapped(yaw);
        open.spread = StateSpread::within(region.as_ref(), yaw, yaw_half, speed_half_m_s);
        let place = Placed { at, yaw };
        let time_s = time * self.step_s;
        let slip = slip.map_or(0.0, |[slip, _]| slip);
        Ok((TimedState { time_s, place, speed_m_s, slip }, open))
    }
}

fn headless(element: Element<'_>) -> TrafficError {
    element.fault("<orientation> is missing", "state where its front points")
}

/// What a state left open.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    interval: bool,
    speedless: bool,
    headless: bool,
    spread: StateSpread,
}

fn same(a: &TimedState, b: &TimedState) -> bool {
    let apart = libm::hypot(a.place.at[0] - b.place.at[0], a.place.at[1] - b.place.at[1]);
    apart <= SAME[0]
        && wrapped(a.place.yaw - b.place.yaw).abs() <= SAME[1]
        && (a.speed_m_s - b.speed_m_s).abs() <= SAME[2]
}

/// A value, and 0; or the middle of an interval, and half of its length.
fn middle_and_half(element: Element<'_>) -> Result<[f64; 2], TrafficError> {
    if let Some(exact) = element.get("exact") {
        return Ok([exact.number()?, 0.0]);
    }
    match (element.get("intervalStart"), element.get("intervalEnd")) {
        (Some(start), Some(end)) => {
            let [start, end] = [start.number()?, end.number()?];
            Ok([0.5 * (start + end), 0.5 * (end - start).abs()])
        }
        _ => {
            let help = "write <exact>, or <intervalStart> and <intervalEnd>";
            Err(element.fault("it has neither an exact value nor an interval", help))
        }
    }
}

#[cfg(test)]
mod tests;
