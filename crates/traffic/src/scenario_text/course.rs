//! Where a body is until the horizon: what a track says of that, in as many states as a path holds.
//!
//! Times are counted from when manoeuvres begin. A course begins at 0 and ends at the horizon, or
//! before if the track does; it then goes on as in its last state. Between states position is
//! linear in time and heading turns steadily, in a track as in a path of a scenario, so a state
//! that lies on the way between its neighbours can go, as far as digits are written.

use crate::outline::{Outline, distance};
use crate::recording::{TimedState, at, wrapped};
use crate::write::middle;
use scenario::PATH_STATES_MAX;

/// Moments closer than this are one (s): ten times what a path tells apart. At the greatest speed
/// of a path it is 10 mm of way, and the 0.1 mm of rounding are 1 m/s.
const STEP_S: f64 = 1e-4;
/// What rounding changes in a position (m) and in a heading (rad): 0.05 mm, 0.00005°.
const ROUNDING: [f64; 2] = [5e-5, 8.7e-7];
/// At most so many states are taken for one straight way: bounds the search.
const WINDOW: usize = 512;

/// Where the middle of an outline is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// From the begin of manoeuvres (s).
    pub(super) time_s: f64,
    /// In the world, moved as the scenario is (m).
    pub(super) at: [f64; 2],
    /// From x towards y (rad).
    pub(super) yaw: f64,
    /// In the world (m/s).
    pub(super) velocity_m_s: [f64; 2],
}

/// What a track says from the begin of manoeuvres to the horizon.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Extent {
    /// It ended before.
    Gone,
    /// It begins after the horizon.
    Later,
    /// Where the body is.
    There {
        /// At least one, the first at 0; times rise.
        moments: Vec<TimedState>,
        /// When the track begins, if that is after 0 (s): until then the body is taken to come as
        /// it goes then.
        comes_s: Option<f64>,
        /// When the track ends, if that is before the horizon (s).
        ends_s: Option<f64>,
    },
}

/// Where a body is from 0 to the horizon.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Course {
    /// 1 to [`PATH_STATES_MAX`], the first at 0; times rise.
    pub(super) knots: Vec<Knot>,
    /// Whether it goes on as in its last state, which is before the horizon.
    pub(super) goes_on: bool,
    /// How far apart the states are that were left of too many, at most (s).
    pub(super) thinned_s: Option<f64>,
}

impl Extent {
    /// The part of a track from `began_s` on, for `horizon_s` seconds. One moment holds forever,
    /// and stands still.
    pub(super) fn new(track: &[TimedState], began_s: f64, horizon_s: f64) -> Self {
        let shifted =
            |moment: &TimedState| TimedState { time_s: moment.time_s - began_s, ..*moment };
        let (Some(first), Some(last)) = (track.first(), track.last()) else { return Self::Gone };
        if track.len() == 1 {
            let still = TimedState { time_s: 0.0, speed_m_s: 0.0, ..*first };
            return Self::There { moments: vec![still], comes_s: None, ends_s: None };
        }
        let mut comes_s = None;
        let start = match at(track, began_s) {
            Some(moment) => TimedState { time_s: 0.0, ..moment },
            None if last.time_s < began_s => return Self::Gone,
            None if first.time_s - began_s >= horizon_s => return Self::Later,
            None => {
                let first = shifted(first);
                comes_s = Some(first.time_s);
                let mut before = TimedState { time_s: 0.0, ..first };
                for (at, speed) in before.place.at.iter_mut().zip(first.velocity_m_s()) {
                    *at -= speed * first.time_s;
                }
                before
            }
        };
        let mut moments = vec![start];
        let mut next_s = STEP_S;
        for moment in track.iter().map(shifted) {
            if next_s <= moment.time_s && moment.time_s <= horizon_s - STEP_S {
                next_s = moment.time_s + STEP_S;
                moments.push(moment);
            }
        }
        let end = at(track, began_s + horizon_s);
        moments.extend(end.map(|moment| TimedState { time_s: horizon_s, ..moment }));
        let ends_s = end.is_none().then_some(last.time_s - began_s);
        Self::There { moments, comes_s, ends_s }
    }
}

impl Course {
    /// The course of the middle of an outline, moved by `moved` (m).
    pub(super) fn new(
        moments: &[TimedState],
        outline: &Outline,
        moved: [f64; 2],
        horizon_s: f64,
    ) -> Self {
        let knot = |moment: &TimedState| {
            let place = middle(moment, outline);
            let at = [place.at[0] - moved[0], place.at[1] - moved[1]];
            let velocity_m_s = moment.velocity_m_s();
            Knot { time_s: moment.time_s, at, yaw: place.yaw, velocity_m_s }
        };
        let all: Vec<Knot> = moments.iter().map(knot).collect();
        let goes_on = all.last().is_some_and(|last| last.time_s < horizon_s);
        let knots = without_midway(&all);
        if knots.len() <= PATH_STATES_MAX {
            return Self { knots, goes_on, thinned_s: None };
        }
        let thinned = thinned(&all, PATH_STATES_MAX);
        let gaps = thinned.windows(2).map(|pair| pair[1].time_s - pair[0].time_s);
        let thinned_s = Some(gaps.fold(0.0, f64::max));
        Self { knots: without_midway(&thinned), goes_on, thinned_s }
    }

    /// Where the middle is at a time from 0 to the horizon (m).
    fn at(&self, time_s: f64) -> [f64; 2] {
        let after = self.knots.partition_point(|knot| knot.time_s <= time_s);
        let before = &self.knots[after.saturating_sub(1)];
        match self.knots.get(after) {
            Some(next) => between(before, next, time_s).0,
            None => {
                [0, 1].map(|i| before.at[i] + before.velocity_m_s[i] * (time_s - before.time_s))
            }
        }
    }

    /// The least distance between the middles of two bodies from 0 to the horizon (m). Between
    /// states both move in straight lines, and so does one as seen from the other.
    pub(super) fn nearest_m(&self, other: &Self, horizon_s: f64) -> f64 {
        let knots = self.knots.iter().chain(&other.knots).map(|knot| knot.time_s);
        let mut times: Vec<f64> =
            knots.chain([0.0, horizon_s]).filter(|time_s| *time_s <= horizon_s).collect();
        times.sort_by(f64::total_cmp);
        let apart = |time_s: &f64| {
            let (a, b) = (self.at(*time_s), other.at(*time_s));
            [b[0] - a[0], b[1] - a[1]]
        };
        let ways: Vec<[f64; 2]> = times.iter().map(apart).collect();
        let nearest = ways.windows(2).map(|way| distance([0.0; 2], [way[0], way[1]]));
        nearest.fold(f64::INFINITY, f64::min)
    }
}

/// Place and heading at a time between two states (m, rad).
fn between(a: &Knot, b: &Knot, time_s: f64) -> ([f64; 2], f64) {
    let share = (time_s - a.time_s) / (b.time_s - a.time_s);
    let at = [0, 1].map(|i| a.at[i] + share * (b.at[i] - a.at[i]));
    (at, a.yaw + share * wrapped(b.yaw - a.yaw))
}

/// The states without those that lie on the way between the ones that stay.
fn without_midway(knots: &[Knot]) -> Vec<Knot> {
    let [first, .., last] = knots else { return knots.to_vec() };
    let mut kept = vec![*first];
    let mut from = 0;
    for next in 2..knots.len() {
        let (a, b) = (&knots[from], &knots[next]);
        let is_midway = |knot: &Knot| {
            let (at, yaw) = between(a, b, knot.time_s);
            let off_m = libm::hypot(knot.at[0] - at[0], knot.at[1] - at[1]);
            off_m <= ROUNDING[0] && wrapped(knot.yaw - yaw).abs() <= ROUNDING[1]
        };
        if next - from > WINDOW || !knots[from + 1..next].iter().all(is_midway) {
            from = next - 1;
            kept.push(knots[from]);
        }
    }
    kept.push(*last);
    kept
}

/// So many states of more, evenly chosen, the first and the last among them.
fn thinned(knots: &[Knot], count: usize) -> Vec<Knot> {
    let (pieces, last) = (count - 1, knots.len() - 1);
    (0..count).map(|k| knots[(k * last + pieces / 2) / pieces]).collect()
}
