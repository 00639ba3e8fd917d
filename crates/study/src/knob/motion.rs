//! Motions in the text of a scenario, changed: a place, a state that goes on, or states in time.

use toml::{Table, Value};

/// States of a path at most, as a scenario has them.
const STATES_MAX: usize = scenario::PATH_STATES_MAX;

/// Where a motion is at time 0, and how fast it goes from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Begin {
    pub(super) position_m: [f64; 3],
    pub(super) yaw_rad: f64,
    /// In the ground plane (m/s).
    pub(super) velocity_m_s: [f64; 2],
}

/// A number of the text, whole or not.
pub(super) fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// A list of numbers.
pub(super) fn reals(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(number).collect()
}

pub(super) fn real(value: f64) -> Value {
    Value::Float(value)
}

/// A number of a table; `usual` if it is not there.
fn get(table: &Table, key: &str, usual: f64) -> f64 {
    table.get(key).and_then(number).unwrap_or(usual)
}

fn position(table: &Table) -> Result<[f64; 3], String> {
    let list = table.get("position_m").and_then(reals);
    list.and_then(|list| list.try_into().ok()).ok_or_else(|| "it has no position_m".to_owned())
}

fn plane(table: &Table, key: &str) -> Option<[f64; 2]> {
    table.get(key).and_then(reals)?.try_into().ok()
}

/// The states of a motion that has them: its own, or those of its path.
fn states(motion: &mut Table) -> Result<Option<&mut Vec<Value>>, String> {
    let holder = if motion.contains_key("path") {
        motion.get_mut("path").and_then(Value::as_table_mut)
    } else {
        Some(motion)
    };
    let Some(holder) = holder else { return Ok(None) };
    if holder.contains_key("csv") {
        return Err("its path is a CSV file, which no sweep can change: write its states".into());
    }
    Ok(holder.get_mut("states").and_then(Value::as_array_mut))
}

/// The table of a place, or of a state that goes on.
fn single<'m>(motion: &'m mut Table, key: &str) -> Option<&'m mut Table> {
    motion.get_mut(key).and_then(Value::as_table_mut)
}

/// Where a motion begins.
pub(super) fn begin(motion: &mut Table) -> Result<Begin, String> {
    for key in ["place", "state"] {
        let Some(table) = single(motion, key) else { continue };
        let yaw_rad = get(table, "yaw_deg", 0.0).to_radians();
        let speed = get(table, "speed_m_s", 0.0);
        let along = [speed * libm::cos(yaw_rad), speed * libm::sin(yaw_rad)];
        let velocity_m_s = plane(table, "velocity_m_s").unwrap_or(along);
        return Ok(Begin { position_m: position(table)?, yaw_rad, velocity_m_s });
    }
    let Some(states) = states(motion)? else { return Err("it has no motion".to_owned()) };
    let tables: Vec<&Table> = states.iter().filter_map(Value::as_table).collect();
    let times: Vec<f64> = tables.iter().map(|state| get(state, "t_s", 0.0)).collect();
    // The piece that time 0 is in, or the first one.
    let after = times.iter().position(|time_s| *time_s > 0.0).unwrap_or(times.len());
    let before = after.saturating_sub(1);
    let Some(first) = tables.get(before) else { return Err("it has no states".to_owned()) };
    let at_m = position(first)?;
    let yaw_deg = get(first, "yaw_deg", 0.0);
    let Some(next) = tables.get(after) else {
        let velocity_m_s = plane(first, "velocity_m_s").unwrap_or([0.0; 2]);
        let past_s = 0.0 - times[before];
        let position_m =
            [at_m[0] + velocity_m_s[0] * past_s, at_m[1] + velocity_m_s[1] * past_s, at_m[2]];
        return Ok(Begin { position_m, yaw_rad: yaw_deg.to_radians(), velocity_m_s });
    };
    let next_m = position(next)?;
    let length_s = times[after] - times[before];
    let share = (0.0 - times[before]) / length_s;
    let between = |k: usize| at_m[k] + share * (next_m[k] - at_m[k]);
    let turn_deg = (get(next, "yaw_deg", 0.0) - yaw_deg + 540.0).rem_euclid(360.0) - 180.0;
    Ok(Begin {
        position_m: [between(0), between(1), between(2)],
        yaw_rad: (yaw_deg + share * turn_deg).to_radians(),
        velocity_m_s: [0, 1].map(|k| (next_m[k] - at_m[k]) / length_s),
    })
}

/// Moves a motion in the ground plane (m).
pub(super) fn moved(motion: &mut Table, by_m: [f64; 2]) -> Result<(), String> {
    let shift = |table: &mut Table| -> Result<(), String> {
        let [x, y, z] = position(table)?;
        let moved = [x + by_m[0], y + by_m[1], z].map(real);
        table.insert("position_m".to_owned(), Value::Array(moved.to_vec()));
        Ok(())
    };
    for key in ["place", "state"] {
        if let Some(table) = single(motion, key) {
            return shift(table);
        }
    }
    let Some(states) = states(motion)? else { return Err("it has no motion".to_owned()) };
    states.iter_mut().filter_map(Value::as_table_mut).try_for_each(shift)
}

/// Lets a motion go the same way so many times as fast.
pub(super) fn faster(motion: &mut Table, times: f64) -> Result<(), String> {
    let speeds = |table: &mut Table| {
        for key in ["speed_m_s", "yaw_rate_deg_s"] {
            if let Some(speed) = table.get(key).and_then(number) {
                table.insert(key.to_owned(), real(speed * times));
            }
        }
        if let Some(velocity) = plane(table, "velocity_m_s") {
            let faster = velocity.map(|speed| real(speed * times));
            table.insert("velocity_m_s".to_owned(), Value::Array(faster.to_vec()));
        }
    };
    if single(motion, "place").is_some() {
        return Ok(());
    }
    if let Some(state) = single(motion, "state") {
        speeds(state);
        return Ok(());
    }
    let Some(states) = states(motion)? else { return Err("it has no motion".to_owned()) };
    for state in states.iter_mut().filter_map(Value::as_table_mut) {
        let time_s = get(state, "t_s", 0.0);
        state.insert("t_s".to_owned(), real(time_s / times));
        speeds(state);
    }
    Ok(())
}

/// Lets a motion begin so much later (s), where it is by then, straight on from where it is at 0.
/// States after the first one beyond the horizon say nothing any more, and are left out.
pub(super) fn later(motion: &mut Table, delay_s: f64, horizon_s: f64) -> Result<(), String> {
    if let Some(state) = single(motion, "state") {
        if get(state, "yaw_rate_deg_s", 0.0) == 0.0 {
            return Ok(());
        }
        return Err("it turns from its state on, and cannot begin later: write its path".into());
    }
    let begin = begin(motion)?;
    let [vx, vy] = begin.velocity_m_s;
    moved(motion, [vx * delay_s, vy * delay_s])?;
    let Some(states) = states(motion)? else { return Ok(()) };
    for state in states.iter_mut().filter_map(Value::as_table_mut) {
        let time_s = get(state, "t_s", 0.0);
        state.insert("t_s".to_owned(), real(time_s + delay_s));
    }
    // What was before 0 is not repeated: the body went straight on.
    states.retain(|state| state.as_table().is_none_or(|state| get(state, "t_s", 0.0) >= delay_s));
    let straight = |time_s: f64| {
        let [x, y, z] = begin.position_m;
        let position_m = [x + vx * time_s, y + vy * time_s, z].map(real);
        let mut state = Table::new();
        state.insert("t_s".to_owned(), real(time_s));
        state.insert("position_m".to_owned(), Value::Array(position_m.to_vec()));
        state.insert("yaw_deg".to_owned(), real(begin.yaw_rad.to_degrees()));
        Value::Table(state)
    };
    let is_there = states.first().and_then(Value::as_table);
    if is_there.is_none_or(|state| get(state, "t_s", 0.0) > delay_s + 1e-6) {
        states.insert(0, straight(delay_s));
    }
    states.insert(0, straight(0.0));
    let time_s = |state: &Value| state.as_table().map_or(0.0, |state| get(state, "t_s", 0.0));
    if let Some(last) = states.iter().position(|state| time_s(state) >= horizon_s) {
        states.truncate(last + 1);
    }
    while states.len() > STATES_MAX {
        thin(states);
    }
    Ok(())
}

/// Leaves out the state whose absence moves the body least: it is nearest to the straight line
/// between the states beside it, at its time.
fn thin(states: &mut Vec<Value>) {
    let placed = |state: &Value| {
        let table = state.as_table()?;
        let [x, y, _] = position(table).ok()?;
        Some([get(table, "t_s", 0.0), x, y])
    };
    let off_m = |number: usize| {
        let [a, b, c] = [number - 1, number, number + 1].map(|number| placed(&states[number]));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { return f64::INFINITY };
        let share = (b[0] - a[0]) / (c[0] - a[0]);
        let off = [1, 2].map(|k| b[k] - a[k] - share * (c[k] - a[k]));
        libm::hypot(off[0], off[1])
    };
    // The first two are where the body is now, and where it begins its way.
    let inner = 2..states.len().saturating_sub(1);
    let least = inner.min_by(|a, b| off_m(*a).total_cmp(&off_m(*b)));
    states.remove(least.unwrap_or(1));
}
