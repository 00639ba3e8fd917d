//! Solutions of a planning problem (`CommonRoadSolution`): trajectories that planners chose for the
//! ego (CommonRoad documentation, *Solution file*; commonroad-io writes them).
//!
//! A state is the middle of the vehicle's rectangle, as CommonRoad's own collision check takes it,
//! for every vehicle model. Lists of inputs are refused: they say how to steer, not where one is.

use super::{COORDINATE_M, SPEED_M_S};
use crate::NamedText;
use crate::error::TrafficError;
use crate::outline::{Outline, Placed};
use crate::recording::{Planned, TimedState, wrapped};
use crate::xml::{Document, Element};

/// Length and width of CommonRoad's vehicles 1 to 3 (m): Ford Escort, BMW 320i, VW Vanagon
/// (Althoff, Würsching: CommonRoad: Vehicle Models, 2020, table of parameters).
const VEHICLES_M: [[f64; 2]; 3] = [[4.298, 1.674], [4.508, 1.610], [4.569, 1.844]];

/// Times closer than this are one (s).
const SAME_S: f64 = 1e-6;

/// Reads the trajectory for a planning problem, and the outline of the vehicle that it is for.
///
/// `benchmark` is the scenario that it must solve, `problem` the id of the planning problem, and
/// `start_s` when that begins (s).
pub(super) fn read(
    source: &NamedText<'_>,
    benchmark: Option<&str>,
    problem: Option<&str>,
    (start_s, step_s): (f64, f64),
) -> Result<(Planned, Option<Outline>), TrafficError> {
    let document = Document::parse(source.file, source.text)?;
    let root = document.root();
    if root.name() != "CommonRoadSolution" {
        return Err(root.fault(
            format!("this is <{}>, not <CommonRoadSolution>", root.name()),
            "give the file that a CommonRoad planner wrote as its solution",
        ));
    }
    let id = root.need_attribute("benchmark_id")?;
    let mut parts = id.split(':');
    let (vehicles, solved) = (parts.next().unwrap_or_default(), parts.nth(1));
    let Some(solved) = solved else {
        let fault = format!("benchmark_id {id:?} names no scenario");
        return Err(root.fault(fault, "write VEHICLE:COST:SCENARIO:VERSION"));
    };
    if benchmark.is_some_and(|benchmark| benchmark != solved) {
        let fault = format!("it solves {solved:?}, not {:?}", benchmark.unwrap_or_default());
        return Err(root.fault(fault, "give the solution of this scenario"));
    }
    let Some(problem) = problem else {
        let fault = "the ego is an obstacle, and a solution is of a planning problem";
        return Err(root.fault(fault, "choose a planning problem that has an id: --ego ID"));
    };
    let is_ours = |one: &Element<'_>| one.attribute("planningProblem") == Some(problem);
    let ours = root.children().enumerate().find(|(_, one)| is_ours(one));
    let Some((index, trajectory)) = ours else {
        let fault = format!("it has no trajectory for planning problem {problem:?}");
        return Err(root.fault(fault, "choose another planning problem: --ego ID"));
    };
    if !trajectory.name().ends_with("Trajectory") {
        let fault = "inputs say how to steer, not where one is";
        return Err(trajectory.fault(fault, "give a solution that has a trajectory"));
    }
    let mut went: Vec<TimedState> = Vec::new();
    for state in trajectory.children() {
        let moment = moment(state, step_s, went.last())?;
        if went.last().is_some_and(|last| last.time_s >= moment.time_s) {
            let help = "states stand in the order of their times, each time once";
            return Err(state.fault("its time is not after that of the state before", help));
        }
        if went.is_empty() && (moment.time_s - start_s).abs() > SAME_S {
            let fault = format!("it begins at {} s, the ego at {start_s} s", moment.time_s);
            return Err(state.fault(fault, "begin the trajectory where the problem begins"));
        }
        went.push(moment);
    }
    // A single state would be one who stands.
    if went.len() < 2 {
        let fault = "it has fewer than two states";
        return Err(trajectory.fault(fault, "give a solution that says where the ego goes"));
    }
    let name = source.file.rsplit(['/', '\\']).next().unwrap_or(source.file);
    let name = name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned();
    let vehicle = vehicles.trim_matches(['[', ']']).split(',').nth(index);
    let number = vehicle.and_then(|vehicle| vehicle.trim().chars().last()?.to_digit(10));
    let size = number.and_then(|number| VEHICLES_M.get(number.checked_sub(1)? as usize));
    Ok((Planned { name, went }, size.map(|[length, width]| Outline::rectangle(*length, *width))))
}

/// A state of any vehicle model: x and y, orientation or the two components of velocity, time.
fn moment(
    state: Element<'_>,
    step_s: f64,
    before: Option<&TimedState>,
) -> Result<TimedState, TrafficError> {
    let bounded = |name: &str, most: f64, unit: &str| -> Result<f64, TrafficError> {
        let part = state.need(name)?;
        let value = part.number()?;
        if value.abs() > most {
            let fault = format!("{name} is {value} {unit}");
            return Err(part.fault(fault, format!("at most {most} {unit}: a wrong unit?")));
        }
        Ok(value)
    };
    let at = [bounded("x", COORDINATE_M, "m")?, bounded("y", COORDINATE_M, "m")?];
    let time_s = state.need("time")?.number()? * step_s;
    let has = |name: &str| state.get(name).is_some();
    let (yaw, speed_m_s, slip) = if has("orientation") {
        let yaw = wrapped(state.need("orientation")?.number()?);
        let along = bounded("velocity", SPEED_M_S, "m/s")?;
        // The multi-body model states the velocity along and across the vehicle.
        let across = if has("yVelocity") { bounded("yVelocity", SPEED_M_S, "m/s")? } else { 0.0 };
        if has("slipAngle") {
            (yaw, along, wrapped(state.need("slipAngle")?.number()?))
        } else if across == 0.0 {
            (yaw, along, 0.0)
        } else {
            (yaw, libm::hypot(along, across), libm::atan2(across, along))
        }
    } else {
        // A point mass looks where it goes, and where it stands, where it looked before.
        let x = bounded("xVelocity", SPEED_M_S, "m/s")?;
        let y = bounded("yVelocity", SPEED_M_S, "m/s")?;
        let stands = x == 0.0 && y == 0.0;
        let yaw =
            if stands { before.map_or(0.0, |last| last.place.yaw) } else { libm::atan2(y, x) };
        (yaw, libm::hypot(x, y), 0.0)
    };
    Ok(TimedState { time_s, place: Placed { at, yaw }, speed_m_s, slip })
}

#[cfg(test)]
mod tests;
