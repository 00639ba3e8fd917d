//! From states, as a person or a program writes them, to paths from 0 to the horizon.

use super::{CIRCLE_ERROR_M, GivenMotion, GivenState, Motion};
use crate::document::TextPosition;
use crate::error::Misfit;
use crate::limit::{self, Show};
use geometry::DVec3;
use geometry::motion::{MotionPath, Orientation, PathError, State};

/// What is wrong with the states of a path.
#[derive(Debug)]
pub(crate) struct RowFault {
    /// With which row; `None`: with all of them.
    pub(crate) row: Option<usize>,
    /// Its setting is the key that is wrong, as in the states of a scenario.
    pub(crate) misfit: Misfit,
}

/// A path from 0 to the horizon, and when its states ended if that was earlier.
pub(super) type Followed = (MotionPath, Option<f64>);

fn wrong<T>(
    row: Option<usize>,
    setting: &'static str,
    what: String,
    help: &str,
) -> Result<T, RowFault> {
    Err(RowFault { row, misfit: Misfit::new(setting, what, help) })
}

/// The motion that was given, whose numbers are in their ranges, until the horizon.
pub(crate) fn motion(
    given: GivenMotion,
    horizon_s: f64,
    place: TextPosition,
) -> Result<Motion, RowFault> {
    let (path, ends_s) = match &given {
        GivenMotion::Place { position_m, angles_deg: [yaw, pitch, roll] } => {
            let orientation = Orientation::from_degrees(*yaw, *pitch, *roll);
            let still = MotionPath::still(*position_m, orientation, [0.0, horizon_s]);
            (still.map_err(leads_astray)?, None)
        }
        GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s } => {
            let onward =
                onward(*position_m, *angles_deg, *velocity_m_s, *yaw_rate_deg_s, horizon_s);
            (onward.map_err(|misfit| RowFault { row: None, misfit })?, None)
        }
        GivenMotion::States(rows) => through(rows, horizon_s)?,
    };
    Ok(Motion { place, given, path, ends_s })
}

/// The path through these states, cut or continued.
pub(super) fn through(rows: &[GivenState], horizon_s: f64) -> Result<Followed, RowFault> {
    let (states, velocity) = followed(rows, horizon_s)?;
    until(states, velocity, horizon_s).map_err(leads_astray)
}

/// The states that a path goes through, and the velocity (m/s) with which it goes on.
fn followed(rows: &[GivenState], horizon_s: f64) -> Result<(Vec<State>, DVec3), RowFault> {
    let kept = without_repeats(rows)?;
    let &[(_, first), .., (last_index, last)] = &kept[..] else {
        return match kept[..] {
            [(index, only)] => from_one(index, only, horizon_s),
            _ => wrong(None, "states", "the path has no state".to_owned(), NO_STATES),
        };
    };
    let mut velocity = DVec3::ZERO;
    for pair in kept.windows(2) {
        velocity = piece(&pair[0], &pair[1])?;
    }
    begins_and_lasts(first.time_s, kept[0].0, last.time_s, last_index)?;
    if let Some([x, y]) = last.velocity_m_s {
        velocity = DVec3::new(x, y, velocity.z);
    }
    Ok((kept.iter().map(|(_, row)| row.state(horizon_s)).collect(), velocity))
}

const NO_STATES: &str = "write states = [{ t_s = 0, position_m = [x, y, z] }, …]";

/// The states with their numbers, each once; times rise.
fn without_repeats(rows: &[GivenState]) -> Result<Vec<(usize, GivenState)>, RowFault> {
    let mut kept: Vec<(usize, GivenState)> = Vec::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        if let Some((_, before)) = kept.last() {
            if before == row {
                continue;
            }
            if row.time_s - before.time_s < limit::PATH_STEP_S {
                let (now, then) = (row.time_s.show(), before.time_s.show());
                let fault = format!("t_s is {now}, after {then} in the state before");
                let help = "times rise, by at least 0.00001 s; a state that is repeated is the \
                            same in every number";
                return wrong(Some(index), "t_s", fault, help);
            }
        }
        kept.push((index, *row));
    }
    Ok(kept)
}

/// Whether a body could move from one state to the next; the velocity with which it does (m/s).
fn piece(
    (a_index, a): &(usize, GivenState),
    (b_index, b): &(usize, GivenState),
) -> Result<DVec3, RowFault> {
    let lasts_s = b.time_s - a.time_s;
    let moved = DVec3::from_array(b.position_m) - DVec3::from_array(a.position_m);
    let velocity = moved * (1.0 / lasts_s);
    let span = format!("from {} s to {} s", a.time_s.show(), b.time_s.show());
    if velocity.length() > limit::PATH_SPEED_M_S.most {
        let fault = format!("{span} the body would move at {:.0} m/s", velocity.length());
        let help = format!(
            "a body moves by at most {} m/s: are positions in metres and times in seconds?",
            limit::PATH_SPEED_M_S.most
        );
        return wrong(Some(*b_index), "position_m", fault, &help);
    }
    let rate = a.orientation().angle_to(&b.orientation()).to_degrees() / lasts_s;
    if rate > limit::TURN_RATE_DEG_S.most {
        let fault = format!("{span} the body would turn by {rate:.0} degrees/s");
        let help = format!(
            "a body turns by at most {} degrees/s: are angles in degrees, times in seconds?",
            limit::TURN_RATE_DEG_S.most
        );
        return wrong(Some(*b_index), "yaw_deg", fault, &help);
    }
    let may = limit::VELOCITY_OFF_M_S + limit::VELOCITY_OFF_M_S2 * lasts_s;
    for (index, row) in [(a_index, a), (b_index, b)] {
        let Some([x, y]) = row.velocity_m_s else { continue };
        if (DVec3::new(x, y, 0.0) - DVec3::new(velocity.x, velocity.y, 0.0)).length() > may {
            let fault = format!(
                "the velocity is [{}, {}] m/s, but {span} the body moves at [{:.1}, {:.1}] m/s",
                x.show(),
                y.show(),
                velocity.x,
                velocity.y
            );
            let help = "velocities are in the world, not along the heading, and in m/s; or leave \
                        them out";
            return wrong(Some(*index), "velocity_m_s", fault, help);
        }
    }
    Ok(velocity)
}

/// Whether states from `first_s` to `last_s` say where the body is at 0.
fn begins_and_lasts(
    first_s: f64,
    first_index: usize,
    last_s: f64,
    last_index: usize,
) -> Result<(), RowFault> {
    if first_s > limit::PATH_SNAP_S {
        let fault = format!("the path begins at {} s", first_s.show());
        let help = "time 0 is now, and a path says where the body is from then on: begin at t_s = \
                    0 or before";
        return wrong(Some(first_index), "t_s", fault, help);
    }
    if last_s < -limit::PATH_SNAP_S {
        let fault = format!("the path ends at {} s", last_s.show());
        let help = "time 0 is now, and a path says where the body is from then on: end after 0";
        return wrong(Some(last_index), "t_s", fault, help);
    }
    Ok(())
}

/// A single state, which must give its velocity.
fn from_one(
    index: usize,
    row: GivenState,
    horizon_s: f64,
) -> Result<(Vec<State>, DVec3), RowFault> {
    begins_and_lasts(row.time_s, index, row.time_s, index)?;
    let Some([x, y]) = row.velocity_m_s else {
        let fault = "a path of one state does not say how the body moves".to_owned();
        let help = "add velocity_m_s, or a second state";
        return wrong(Some(index), "velocity_m_s", fault, help);
    };
    Ok((vec![row.state(horizon_s)], DVec3::new(x, y, 0.0)))
}

fn leads_astray(error: PathError) -> RowFault {
    RowFault { row: None, misfit: astray(error) }
}

/// What each state was checked for cannot be: so it is where the motion leads.
pub(super) fn astray(error: PathError) -> Misfit {
    let help = format!(
        "coordinates stay within {} until the horizon: move the origin nearer",
        limit::POSITION_M.range()
    );
    Misfit::new("path", format!("the motion leads nowhere: {error}"), help)
}

/// States from 0 or before as a path from 0 to the horizon; after the last it goes on with this
/// velocity (m/s).
fn until(mut states: Vec<State>, velocity: DVec3, horizon_s: f64) -> Result<Followed, PathError> {
    let last = states[states.len() - 1];
    let ends_s = (last.time_s < horizon_s).then_some(last.time_s);
    if let Some(ends_s) = ends_s {
        let position = DVec3::from_array(last.position_m) + velocity * (horizon_s - ends_s);
        states.push(State { time_s: horizon_s, position_m: position.to_array(), ..last });
    }
    let whole = MotionPath::new(&states)?;
    if whole.from_s() == 0.0 && whole.to_s() == horizon_s {
        return Ok((whole, ends_s));
    }
    let within = states.into_iter().filter(|state| 0.0 < state.time_s && state.time_s < horizon_s);
    let ends = [0.0, horizon_s].map(|time_s| whole.state_at(time_s));
    let cut: Vec<State> = [ends[0]].into_iter().chain(within).chain([ends[1]]).collect();
    Ok((MotionPath::new(&cut)?, ends_s))
}

/// The path of a motion that is faster by a factor from time 0 on: what it did at a time t it does
/// at t over the factor.
pub(crate) fn faster(
    motion: &Motion,
    factor: f64,
    horizon_s: f64,
) -> Result<MotionPath, PathError> {
    if factor == 1.0 {
        return Ok(motion.path.clone());
    }
    let too_fast = |_fault: Misfit| PathError::Fast(0);
    match &motion.given {
        GivenMotion::Place { .. } => Ok(motion.path.clone()),
        GivenMotion::Onward { position_m, angles_deg, velocity_m_s, yaw_rate_deg_s } => onward(
            *position_m,
            *angles_deg,
            velocity_m_s.map(|speed| speed * factor),
            yaw_rate_deg_s * factor,
            horizon_s,
        )
        .map_err(too_fast),
        GivenMotion::States(rows) => {
            // They were followed when the scenario was read.
            let (kept, velocity) = followed(rows, horizon_s).map_err(|_fault| PathError::Short)?;
            let sooner = |state: State| State { time_s: state.time_s / factor, ..state };
            let states = kept.into_iter().map(sooner).collect();
            Ok(until(states, velocity * factor, horizon_s)?.0)
        }
    }
}

/// The path of a body that goes on as it moves now.
///
/// With the yaw rate ω it is on a circle: from time 0 to t it moves by the chord R(ωt/2) v t ·
/// sin(ωt/2)/(ωt/2). Each piece is so short that the circle is within [`CIRCLE_ERROR_M`] of it, v ω
/// δ²/8, and that no piece turns by half a circle, where the shorter way is not known.
pub(super) fn onward(
    position_m: [f64; 3],
    [yaw_deg, pitch_deg, roll_deg]: [f64; 3],
    [x, y]: [f64; 2],
    yaw_rate_deg_s: f64,
    horizon_s: f64,
) -> Result<MotionPath, Misfit> {
    const TURN_DEG: f64 = 90.0;
    let lateral_m_s2 = (x * x + y * y).sqrt() * yaw_rate_deg_s.to_radians().abs();
    if lateral_m_s2 > limit::LATERAL_M_S2 {
        let fault = format!("speed and yaw rate make {lateral_m_s2:.0} m/s² sideways");
        let help = format!(
            "they make at most {} m/s²: is the yaw rate in degrees per second?",
            limit::LATERAL_M_S2
        );
        return Err(Misfit::new("yaw_rate_deg_s", fault, help));
    }
    let turned_deg = yaw_rate_deg_s * horizon_s;
    let pieces = (horizon_s * (lateral_m_s2 / (8.0 * CIRCLE_ERROR_M)).sqrt())
        .max(turned_deg.abs() / TURN_DEG)
        .ceil()
        .max(1.0);
    // The limits of lateral acceleration, turn rate and horizon bound it: 3,355.
    let states = (0..=pieces as u32).map(|k| {
        // The last share is 1, so the last time is the horizon in every bit.
        let share = f64::from(k) / pieces;
        let [time_s, turn_deg] = [horizon_s, turned_deg].map(|all| all * share);
        // The x axis of half the turn is (cos, sin, 0), the same on every machine.
        let half = Orientation::from_degrees(turn_deg * 0.5, 0.0, 0.0).rotation();
        let (cos, sin) = (half[0][0], half[1][0]);
        let angle = (turn_deg * 0.5).to_radians();
        let length = if angle == 0.0 { time_s } else { time_s * (sin / angle) };
        let moved = [(x * cos - y * sin) * length, (x * sin + y * cos) * length, 0.0];
        State {
            time_s,
            position_m: core::array::from_fn(|axis| position_m[axis] + moved[axis]),
            orientation: Orientation::from_degrees(yaw_deg + turn_deg, pitch_deg, roll_deg),
        }
    });
    MotionPath::new(&states.collect::<Vec<_>>()).map_err(astray)
}

impl GivenState {
    fn orientation(&self) -> Orientation {
        let [yaw, pitch, roll] = self.angles_deg;
        Orientation::from_degrees(yaw, pitch, roll)
    }

    /// As a state; a time that is 0 or the horizon but for rounding is made so.
    fn state(&self, horizon_s: f64) -> State {
        let near = |time_s: f64| (self.time_s - time_s).abs() <= limit::PATH_SNAP_S;
        let known = [horizon_s, 0.0].into_iter().find(|time_s| near(*time_s));
        State {
            time_s: known.unwrap_or(self.time_s),
            position_m: self.position_m,
            orientation: self.orientation(),
        }
    }
}

#[cfg(test)]
mod tests;
