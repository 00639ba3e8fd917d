//! What traces of simulators have in common: at each moment, where everybody is. From that to a
//! recording.

use crate::ReadOptions;
use crate::commonroad::{COORDINATE_M, EXTENT_M, SPEED_M_S};
use crate::error::{TrafficError, TrafficPlace};
use crate::outline::{Outline, Placed};
use crate::recording::{
    Ego, Obstacle, Recording, StateSpread, TimedState, without_turns_about, wrapped,
};
use std::collections::BTreeMap;

/// Bodies of a trace, at most: more than any simulator moves, and a bound on what a file can cost.
const BODIES_MAX: usize = 20_000;
/// Speeds that differ by more than this from those of the places are noted (m/s), (share).
const FITS: [f64; 2] = [2.0, 0.1];
/// Somebody whose lower side is so much above or below the ego's is noted (m).
const LEVEL_M: f64 = 1.0;
/// How long who is seen once is taken to move as it does then (s).
const ONCE_S: f64 = 0.1;
/// So many bodies are listed in a note.
const LISTED_MAX: usize = 20;

/// What is wrong, and what to do about it.
pub(crate) type Fault = (String, String);

/// Somebody at one moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    /// Type in the library of bodies.
    pub(crate) kind: &'static str,
    /// Whether it was taken for that type by its size.
    pub(crate) is_guessed: bool,
    pub(crate) is_fixed: bool,
    /// Length, width, height (m).
    pub(crate) size_m: [f64; 3],
    /// The middle of its box in plan, and where its front points.
    pub(crate) place: Placed,
    /// The lower side of its box (m).
    pub(crate) bottom_m: f64,
    /// In the world (m/s), if it is stated.
    pub(crate) velocity_m_s: Option<[f64; 2]>,
}

/// Where everybody was, moment by moment.
#[derive(Debug, Default)]
pub(crate) struct Tracks {
    bodies: BTreeMap<String, Body>,
    /// Ids in the order in which they were seen first.
    order: Vec<String>,
    /// First and last moment, in the time of the file (s).
    times: Option<[f64; 2]>,
    moments: u64,
    repeated: u64,
}

#[derive(Debug)]
struct Body {
    first: Seen,
    track: Vec<TimedState>,
    /// The last moment in which it was seen.
    moment: u64,
    /// Moments in which it was missing between others.
    missing: u64,
    speedless: bool,
    is_resized: bool,
    /// The first time at which its speed did not fit its places (s).
    misfit_s: Option<f64>,
}

impl Tracks {
    /// Begins the next moment, at this time of the file (s). The same time again replaces what was
    /// said of it.
    pub(crate) fn begin(&mut self, time_s: f64) -> Result<(), Fault> {
        if !time_s.is_finite() {
            return Err(("its time is not a finite number".to_owned(), damaged()));
        }
        match &mut self.times {
            None => self.times = Some([time_s; 2]),
            Some([_, last]) if time_s == *last => self.repeated += 1,
            Some([_, last]) if time_s < *last => {
                let fault = format!("its time, {time_s} s, is before that of the one before it");
                let remedy = format!("times must rise; the one before it is at {last} s");
                return Err((fault, remedy));
            }
            Some([_, last]) => *last = time_s,
        }
        self.moments += 1;
        Ok(())
    }

    /// Somebody at the moment that was begun last.
    pub(crate) fn add(&mut self, id: &str, seen: Seen) -> Result<(), Fault> {
        check(id, &seen)?;
        let [first_s, now_s] = self.times.unwrap_or_default();
        let time_s = now_s - first_s;
        let state = state(time_s, &seen);
        let Some(body) = self.bodies.get_mut(id) else {
            if self.bodies.len() == BODIES_MAX {
                let fault = format!("more than {BODIES_MAX} objects");
                return Err((fault, "is this the right file? split it".to_owned()));
            }
            self.order.push(id.to_owned());
            let body = Body {
                first: seen,
                track: vec![state],
                moment: self.moments,
                missing: 0,
                speedless: seen.velocity_m_s.is_none(),
                is_resized: false,
                misfit_s: None,
            };
            self.bodies.insert(id.to_owned(), body);
            return Ok(());
        };
        if body.moment == self.moments {
            let fault = format!("object {id:?} stands there twice");
            return Err((fault, "give one of the two another id".to_owned()));
        }
        let gone = self.moments - body.moment - 1;
        body.moment = self.moments;
        if body.first.is_fixed {
            return Ok(());
        }
        let apart = |(a, b): (&f64, &f64)| (a - b).abs() > 0.01;
        body.is_resized |= body.first.size_m.iter().zip(&seen.size_m).any(apart);
        body.speedless |= seen.velocity_m_s.is_none();
        // The last moment may be this one, said again.
        if body.track.last().is_some_and(|last| last.time_s >= time_s) {
            body.track.pop();
        } else {
            body.missing += gone;
        }
        if let (Some(last), None) = (body.track.last(), body.misfit_s)
            && !body.speedless
            && !fits(last, &state)
        {
            body.misfit_s = Some(time_s);
        }
        body.track.push(state);
        Ok(())
    }

    /// The recording: who the ego is, its id says.
    pub(crate) fn recording(
        mut self,
        name: &str,
        ego: &str,
        options: &ReadOptions<'_>,
    ) -> Result<Recording, Fault> {
        if let Some(unknown) = options.without.iter().find(|id| !self.bodies.contains_key(*id)) {
            let fault = format!("there is no object {unknown:?} to leave out");
            return Err((fault, format!("objects here: {}", self.known())));
        }
        let Some(own) = self.bodies.get(ego).filter(|body| !body.first.is_fixed) else {
            let fault = format!("there is no moving object {ego:?}, which is to be the ego");
            return Err((fault, format!("name another: --ego ID. Objects here: {}", self.known())));
        };
        let (level_m, mut notes) = (own.first.bottom_m, Vec::new());
        if !["car", "suv"].contains(&own.first.kind) {
            let kind = own.first.kind;
            notes.push(format!(
                "the ego is a {kind} there: it has the library's body \"ego\", with its own length \
                 and width"
            ));
        }
        if self.repeated > 0 {
            notes.push(format!("{} moments are stated again: the later one counts", self.repeated));
        }
        let (mut of_ego, mut others) = (None, Vec::new());
        let (mut guessed, mut off_level) = (Vec::new(), Vec::new());
        for id in self.order {
            if options.without.contains(&id) && id != ego {
                continue;
            }
            let Some(body) = self.bodies.remove(&id) else { continue };
            body.say(&id, &mut notes);
            let first = body.first;
            if first.is_guessed {
                let [length, width, height] = first.size_m;
                guessed.push(format!("{id} a {} ({length} × {width} × {height} m)", first.kind));
            }
            if (first.bottom_m - level_m).abs() > LEVEL_M {
                off_level.push(id.clone());
            }
            let outline = Outline::rectangle(first.size_m[0], first.size_m[1]);
            let mut track = body.track();
            notes.extend(without_turns_about(&mut track, &format!("object {id}")));
            if id == ego {
                let (start, outline) = (track[0], Some(outline));
                of_ego = Some(Ego { start, outline, went: track, spread: StateSpread::default() });
            } else {
                let (kind, spread) = (first.kind.to_owned(), StateSpread::default());
                others.push(Obstacle { id, kind, outline, track, spread });
            }
        }
        if !guessed.is_empty() {
            notes.push(format!(
                "kinds are not stated: by its size, {} is taken for {}",
                if guessed.len() > 1 { "each" } else { "it" },
                listed(guessed.iter().map(String::as_str))
            ));
        }
        if !off_level.is_empty() {
            notes.push(format!(
                "everybody is taken to be on the level of the ego; more than {LEVEL_M} m above or \
                 below it: {}",
                listed(off_level.iter().map(String::as_str))
            ));
        }
        let Some(ego) = of_ego else {
            return Err(("the ego is left out".to_owned(), "drop that --without".to_owned()));
        };
        Ok(Recording { name: name.to_owned(), ego, planned: Vec::new(), others, notes })
    }

    /// The ids of all objects, or of the first few.
    pub(crate) fn known(&self) -> String {
        listed(self.order.iter().map(String::as_str))
    }

    /// Whether nothing was seen.
    pub(crate) fn is_empty(&self) -> bool {
        self.moments == 0
    }
}

impl Body {
    fn say(&self, id: &str, notes: &mut Vec<String>) {
        if self.speedless && self.track.len() > 1 {
            notes.push(format!("object {id}: velocities are not stated; its places give them"));
        }
        if self.is_resized {
            notes.push(format!("object {id}: its size changes; the first one is taken"));
        }
        if self.missing > 0 {
            let times = self.missing;
            notes.push(format!("object {id} is missing in {times} moments: straight between"));
        }
        if let Some(time_s) = self.misfit_s {
            notes.push(format!(
                "object {id}: its velocity does not fit its places, first after {time_s:.2} s"
            ));
        }
    }

    /// Its track; one moment for what is fixed.
    fn track(mut self) -> Vec<TimedState> {
        if self.first.is_fixed {
            self.track[0].speed_m_s = 0.0;
            return self.track;
        }
        if self.speedless {
            for index in 0..self.track.len() {
                let next = (index + 1).min(self.track.len() - 1);
                let before = next.saturating_sub(1);
                let velocity = between(&self.track[before], &self.track[next]);
                moving(&mut self.track[index], velocity);
            }
        }
        if let [only] = self.track[..] {
            let velocity = only.velocity_m_s();
            let at = [0, 1].map(|axis| only.place.at[axis] + ONCE_S * velocity[axis]);
            let place = Placed { at, ..only.place };
            self.track.push(TimedState { time_s: only.time_s + ONCE_S, place, ..only });
        }
        self.track
    }
}

/// The velocity with which one place is reached from another (m/s).
fn between(a: &TimedState, b: &TimedState) -> [f64; 2] {
    let time_s = b.time_s - a.time_s;
    let along = |axis: usize| (b.place.at[axis] - a.place.at[axis]) / time_s;
    if time_s > 0.0 { [along(0), along(1)] } else { [0.0; 2] }
}

/// Whether the places of two states fit their velocities.
fn fits(a: &TimedState, b: &TimedState) -> bool {
    let found = between(a, b);
    let (before, after) = (a.velocity_m_s(), b.velocity_m_s());
    let off = [0, 1].map(|axis| found[axis] - 0.5 * (before[axis] + after[axis]));
    let speed_m_s = libm::hypot(found[0], found[1]);
    libm::hypot(off[0], off[1]) <= FITS[0] + FITS[1] * speed_m_s
}

/// Sets speed and direction of travel; whose front points against it goes backwards.
fn moving(state: &mut TimedState, [x, y]: [f64; 2]) {
    let speed_m_s = libm::hypot(x, y);
    if speed_m_s == 0.0 {
        (state.speed_m_s, state.slip) = (0.0, 0.0);
        return;
    }
    let slip = wrapped(libm::atan2(y, x) - state.place.yaw);
    if slip.abs() <= core::f64::consts::FRAC_PI_2 {
        (state.speed_m_s, state.slip) = (speed_m_s, slip);
    } else {
        (state.speed_m_s, state.slip) = (-speed_m_s, wrapped(slip + core::f64::consts::PI));
    }
}

fn state(time_s: f64, seen: &Seen) -> TimedState {
    let place = Placed { yaw: wrapped(seen.place.yaw), ..seen.place };
    let mut state = TimedState { time_s, place, speed_m_s: 0.0, slip: 0.0 };
    moving(&mut state, seen.velocity_m_s.unwrap_or_default());
    state
}

fn check(id: &str, seen: &Seen) -> Result<(), Fault> {
    let [x, y] = seen.place.at;
    let [vx, vy] = seen.velocity_m_s.unwrap_or_default();
    for (name, value) in [
        ("x", x),
        ("y", y),
        ("yaw", seen.place.yaw),
        ("the height of its lower side", seen.bottom_m),
        ("its velocity in x", vx),
        ("its velocity in y", vy),
    ] {
        if !value.is_finite() {
            return Err((format!("object {id:?}: {name} is {value}"), damaged()));
        }
    }
    let [least, most] = EXTENT_M;
    for (name, value) in ["length", "width"].into_iter().zip(seen.size_m) {
        if !(least..=most).contains(&value) {
            let fault = format!("object {id:?}: its {name} is {value} m");
            let remedy = format!("{least} to {most} m are read: a wrong unit? Or --without {id}");
            return Err((fault, remedy));
        }
    }
    if x.abs().max(y.abs()) > COORDINATE_M {
        let fault = format!("object {id:?} is at {x}, {y} m");
        return Err((fault, format!("at most {COORDINATE_M} m from the origin are read")));
    }
    let speed_m_s = libm::hypot(vx, vy);
    if speed_m_s > SPEED_M_S {
        let fault = format!("object {id:?}: its speed is {speed_m_s} m/s");
        return Err((fault, format!("at most {SPEED_M_S} m/s are read: a wrong unit?")));
    }
    Ok(())
}

fn damaged() -> String {
    "the file is damaged, or what wrote it is at fault".to_owned()
}

/// Ids, or what else is short: the first few.
pub(crate) fn listed<'i>(all: impl Iterator<Item = &'i str> + Clone) -> String {
    let more = if all.clone().count() > LISTED_MAX { ", …" } else { "" };
    let shown: Vec<&str> = all.take(LISTED_MAX).collect();
    format!("{}{more}", shown.join(", "))
}

/// The type of a road user of this size (m), where nothing else is known of it.
pub(crate) fn kind_by_size([length, width, height]: [f64; 3]) -> &'static str {
    match (length, width) {
        (length, width) if length <= 1.2 && width <= 1.2 => "pedestrian",
        (length, width) if length < 2.0 && width < 1.1 => "bicycle",
        (length, width) if length <= 2.7 && width < 1.1 => "motorcycle",
        _ => car_by_size([length, width, height]),
    }
}

/// The type of a motor vehicle with four wheels or more.
pub(crate) fn car_by_size([length, _, height]: [f64; 3]) -> &'static str {
    if length > 6.5 || height > 2.4 {
        "truck"
    } else if height > 1.6 {
        "suv"
    } else {
        "car"
    }
}

/// A fault of a whole file.
pub(crate) fn whole(file: &str, (what, remedy): Fault) -> TrafficError {
    TrafficError { file: file.to_owned(), place: TrafficPlace::Whole, what, remedy }
}

#[cfg(test)]
mod tests;
