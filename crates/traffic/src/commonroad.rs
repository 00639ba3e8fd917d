//! CommonRoad XML, versions 2018b and 2020a (Althoff, Koschi, Manzinger: CommonRoad, IV 2017; the
//! schema and manual of each version).
//!
//! Read are obstacles and a planning problem, whose initial state is the ego's; lanes, signs and
//! goals are not: they do not change who is hit. States may be exact or intervals, of
//! which the middle is taken and noted. Occupancy sets are refused: a set of positions is not a
//! position.

use crate::ReadOptions;
use crate::error::TrafficError;
use crate::outline::{Outline, OutlinePart, Placed, corners};
use crate::recording::{Ego, Obstacle, Planned, Recording, TimedState, wrapped};
use crate::xml::Element;

mod solution;

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

/// Least and greatest extent of a shape (m): a hand, and the longest train at a platform. Beyond
/// lies a wrong unit.
pub(crate) const EXTENT_M: [f64; 2] = [0.05, 500.0];
/// Greatest distance from the origin (m): coordinates of maps have up to seven digits.
pub(crate) const COORDINATE_M: f64 = 1e8;
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
    let mut reader = Reader { step_s, notes: Vec::new() };
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

fn listed(ids: &[&str]) -> String {
    let shown: Vec<&str> = ids.iter().take(20).copied().collect();
    let more = if ids.len() > shown.len() { ", …" } else { "" };
    format!("obstacles here: {}{more}", shown.join(", "))
}

struct Reader {
    step_s: f64,
    notes: Vec<String>,
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
            return Ok((Ego { start, outline: Some(ego.outline), went: ego.track }, None));
        }
        let Some(problem) = problem.or(problems.first()) else {
            return Err(root.fault(
                "no <planningProblem> says where the ego starts",
                "name the obstacle that is the ego: --ego ID",
            ));
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
        let start = self.moment(state, true)?;
        let (start, _) = start;
        let is_ego = |obstacle: &Obstacle| {
            !obstacle.is_static()
                && obstacle.at(start.time_s).is_some_and(|moment| same(&moment, &start))
        };
        let Some(index) = others.iter().position(is_ego) else {
            return Ok((Ego { start, outline: None, went: Vec::new() }, id));
        };
        let ego = others.remove(index);
        self.notes.push(format!(
            "obstacle {} starts where the ego does: it is the ego, with its shape and its way",
            ego.id
        ));
        Ok((Ego { start, outline: Some(ego.outline), went: ego.track }, id))
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
        let mut track = Vec::new();
        let mut intervals = 0;
        let mut speeds_missing = 0;
        if element.name() == "environmentObstacle" {
            let place = Placed { at: [0.0; 2], yaw: 0.0 };
            track.push(TimedState { time_s: 0.0, place, speed_m_s: 0.0, slip: 0.0 });
        } else {
            let initial = element.need("initialState")?;
            let mut states = vec![initial];
            if !is_fixed {
                states.extend(trajectory(element)?);
            }
            for state in states {
                let (moment, was) = self.moment(state, false)?;
                intervals += usize::from(was.interval);
                speeds_missing += usize::from(was.speedless && !is_fixed);
                if track.last().is_some_and(|last: &TimedState| last.time_s >= moment.time_s) {
                    let help = "states stand in the order of their times, each time once";
                    return Err(state.fault("its time is not after that of the state before", help));
                }
                track.push(moment);
            }
        }
        if is_fixed {
            track[0].speed_m_s = 0.0;
        } else if speeds_missing > 0 {
            speeds_from_places(&mut track);
            self.notes.push(format!("obstacle {id}: speeds are not stated; its places give them"));
        }
        if intervals > 0 {
            self.notes.push(format!(
                "obstacle {id}: {intervals} of its states are intervals; their middles are taken"
            ));
        }
        Ok(Obstacle { id: id.to_owned(), kind: kind.text().to_owned(), outline, track })
    }

    /// A state, and what it left open.
    fn moment(&self, state: Element<'_>, is_ego: bool) -> Result<(TimedState, Open), TrafficError> {
        let mut open = Open::default();
        let (at, is_region) = position(state.need("position")?)?;
        open.interval |= is_region;
        let mut value = |name: &str| -> Result<Option<f64>, TrafficError> {
            let Some(element) = state.get(name) else { return Ok(None) };
            let (value, is_interval) = exact_or_middle(element)?;
            open.interval |= is_interval;
            Ok(Some(value))
        };
        let yaw = value("orientation")?;
        let time = value("time")?;
        let speed = value("velocity")?;
        let slip = value("slipAngle")?;
        let Some(yaw) = yaw else {
            return Err(state.fault("<orientation> is missing", "state where its front points"));
        };
        let Some(time) = time else {
            return Err(state.fault("<time> is missing", "state the time step"));
        };
        if speed.is_none() && is_ego {
            return Err(state.fault("<velocity> is missing", "state how fast the ego is"));
        }
        if speed.is_some_and(|speed| speed.abs() > SPEED_M_S) {
            let fault = format!("its velocity is {} m/s", speed.unwrap_or_default());
            return Err(state.fault(fault, format!("at most {SPEED_M_S} m/s: a wrong unit?")));
        }
        open.speedless = speed.is_none();
        let place = Placed { at, yaw: wrapped(yaw) };
        let time_s = time * self.step_s;
        let slip = slip.unwrap_or(0.0);
        Ok((TimedState { time_s, place, speed_m_s: speed.unwrap_or(0.0), slip }, open))
    }
}

/// What a state left open.
#[derive(Clone, Copy, Debug, Default)]
struct Open {
    interval: bool,
    speedless: bool,
}

fn same(a: &TimedState, b: &TimedState) -> bool {
    let apart = libm::hypot(a.place.at[0] - b.place.at[0], a.place.at[1] - b.place.at[1]);
    apart <= SAME[0]
        && wrapped(a.place.yaw - b.place.yaw).abs() <= SAME[1]
        && (a.speed_m_s - b.speed_m_s).abs() <= SAME[2]
}

fn speeds_from_places(track: &mut [TimedState]) {
    for index in 0..track.len() {
        let (a, b) = if index + 1 < track.len() { (index, index + 1) } else { (index - 1, index) };
        let (p, q) = (track[a], track[b]);
        let apart = libm::hypot(q.place.at[0] - p.place.at[0], q.place.at[1] - p.place.at[1]);
        track[index].speed_m_s = apart / (q.time_s - p.time_s);
    }
}

fn trajectory<'d>(element: Element<'d>) -> Result<Vec<Element<'d>>, TrafficError> {
    if let Some(set) = element.get("occupancySet") {
        return Err(set.fault(
            "an occupancy set says where it may be, not where it is",
            "give it a <trajectory>, or leave it out: --without ID",
        ));
    }
    let states: Vec<Element<'d>> = element.need("trajectory")?.all("state").collect();
    if states.is_empty() {
        let help = "add the states of the recording, or make it a static obstacle";
        return Err(element.fault("its trajectory has no states", help));
    }
    Ok(states)
}

/// A value, and whether it is the middle of an interval.
fn exact_or_middle(element: Element<'_>) -> Result<(f64, bool), TrafficError> {
    if let Some(exact) = element.get("exact") {
        return Ok((exact.number()?, false));
    }
    match (element.get("intervalStart"), element.get("intervalEnd")) {
        (Some(start), Some(end)) => Ok((0.5 * (start.number()? + end.number()?), true)),
        _ => {
            let help = "write <exact>, or <intervalStart> and <intervalEnd>";
            Err(element.fault("it has neither an exact value nor an interval", help))
        }
    }
}

/// A place, and whether it is the middle of a region.
fn position(element: Element<'_>) -> Result<([f64; 2], bool), TrafficError> {
    if let Some(at) = element.get("point") {
        return Ok((point(at)?, false));
    }
    if element.get("lanelet").is_some() {
        let help = "give a point or a region in coordinates";
        return Err(element.fault("a lanelet says no place", help));
    }
    Ok((shape(element)?.middle(), true))
}

fn point(element: Element<'_>) -> Result<[f64; 2], TrafficError> {
    let mut at = [0.0; 2];
    for (value, name) in at.iter_mut().zip(["x", "y"]) {
        let part = element.need(name)?;
        *value = part.number()?;
        if value.abs() > COORDINATE_M {
            let fault = format!("{name} is {value} m");
            return Err(part.fault(fault, format!("at most {COORDINATE_M} m from the origin")));
        }
    }
    Ok(at)
}

/// Rectangles, circles and polygons, one or several.
fn shape(element: Element<'_>) -> Result<Outline, TrafficError> {
    let mut parts = Vec::new();
    for part in element.children() {
        let extent = |name: &str| -> Result<f64, TrafficError> {
            let element = part.need(name)?;
            let value = element.number()?;
            let [least, most] = EXTENT_M;
            if !(least..=most).contains(&value) {
                let fault = format!("a {name} of {value} m");
                return Err(element.fault(fault, format!("{least} to {most} m: a wrong unit?")));
            }
            Ok(value)
        };
        let centre = || part.get("center").map_or(Ok([0.0; 2]), point);
        parts.push(match part.name() {
            "rectangle" => {
                let yaw = part.get("orientation").map_or(Ok(0.0), |yaw| yaw.number())?;
                OutlinePart::Polygon(corners(extent("length")?, extent("width")?, centre()?, yaw))
            }
            "circle" => OutlinePart::Circle(centre()?, extent("radius")?),
            "polygon" => polygon(part)?,
            other => {
                let fault = format!("shape <{other}> is not known");
                return Err(part.fault(fault, "known are rectangle, circle and polygon"));
            }
        });
    }
    if parts.is_empty() {
        return Err(element.fault("it has no shape", "add a rectangle, circle or polygon"));
    }
    Ok(Outline { parts })
}

fn polygon(element: Element<'_>) -> Result<OutlinePart, TrafficError> {
    let points = element.all("point").map(point).collect::<Result<Vec<_>, _>>()?;
    let part = OutlinePart::Polygon(points);
    let outline = Outline { parts: vec![part] };
    let [length, width] = outline.size();
    let [least, most] = EXTENT_M;
    let Some(part) = outline.parts.into_iter().next() else {
        return Err(element.fault("it has no corners", "give at least three"));
    };
    match &part {
        OutlinePart::Polygon(points) if points.len() < 3 => {
            Err(element.fault("it has fewer than three corners", "give at least three"))
        }
        _ if !(length.min(width) >= least && length.max(width) <= most) => {
            let fault = format!("a polygon of {length:.3} × {width:.3} m");
            Err(element.fault(fault, format!("{least} to {most} m each way: a wrong unit?")))
        }
        _ => Ok(part),
    }
}

#[cfg(test)]
mod tests;
