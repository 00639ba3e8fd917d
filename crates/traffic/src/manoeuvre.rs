//! What the ego could do.
//!
//! A manoeuvre brakes at b and steers with a lateral acceleration a, held until the ego stands.
//! Tyres give at most `grip` in all (Kamm's circle), so a is scaled by √(1 − (b/grip)²); the yaw
//! rate is a/v, and no curve is tighter than a car's turning circle. Speed and heading are held
//! through a step and change at its end, as those of a planner with a clock do: a braking ego is
//! ahead of a continuous one by at most b·t·step/2.

use crate::outline::{Outline, Placed, overlap};
use crate::recording::{Ego, Obstacle, Recording, TimedState, at};

/// Which manoeuvres are tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Manoeuvres {
    /// Decelerations (m/s²), each at most [`Self::grip_m_s2`], in the order of trial.
    pub brakes_m_s2: Vec<f64>,
    /// Lateral accelerations (m/s²), in the order of trial; positive: to the left.
    pub laterals_m_s2: Vec<f64>,
    /// Total acceleration that the tyres allow (m/s²).
    pub grip_m_s2: f64,
    /// The horizon (s).
    pub horizon_s: f64,
    /// Step of the ways (s).
    pub step_s: f64,
    /// When the manoeuvres begin, after the ego's start (s). Until then the ego goes as recorded.
    pub after_s: f64,
}

impl Default for Manoeuvres {
    /// Full and half braking and coasting, each straight, with a firm and with a hard turn either
    /// way; grip of a dry road; three seconds, after which a plan is a guess. All of them assumed.
    ///
    /// Of manoeuvres that do equal harm the earlier one wins, and no recording says where the road
    /// ends: so what stops soonest and stays where it is comes first.
    fn default() -> Self {
        Self {
            brakes_m_s2: vec![8.0, 4.0, 0.0],
            laterals_m_s2: vec![0.0, -3.0, 3.0, -6.0, 6.0],
            grip_m_s2: 9.0,
            horizon_s: 3.0,
            step_s: 0.02,
            after_s: 0.0,
        }
    }
}

impl Manoeuvres {
    /// Deceleration and lateral acceleration of every arc (m/s²), in the order of trial.
    pub(crate) fn arcs(&self) -> impl Iterator<Item = [f64; 2]> {
        let laterals = &self.laterals_m_s2;
        self.brakes_m_s2
            .iter()
            .flat_map(move |brake| laterals.iter().map(move |lateral| [*brake, *lateral]))
    }
}

/// Tightest curve (1/m): a car's turning circle has a radius of about 5 m.
const CURVATURE_MAX: f64 = 0.2;
/// Width and length of an ego of which nothing is said (m): a medium car, CommonRoad's vehicle 2.
pub(crate) const EGO_M: [f64; 2] = [4.508, 1.610];

/// What the ego does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Manoeuvre {
    /// What it did in the recording.
    Recorded,
    /// Braking and steering, constant.
    Arc {
        /// Deceleration (m/s²).
        brake_m_s2: f64,
        /// Lateral acceleration asked for (m/s²); positive: to the left.
        lateral_m_s2: f64,
    },
}

impl Manoeuvre {
    /// As one would say it: "brake 8, left 3".
    #[must_use]
    pub fn name(&self) -> String {
        let Self::Arc { brake_m_s2, lateral_m_s2 } = *self else {
            return "as recorded".to_owned();
        };
        let pedal =
            if brake_m_s2 > 0.0 { format!("brake {brake_m_s2}") } else { "go on".to_owned() };
        if lateral_m_s2 == 0.0 {
            return format!("{pedal}, straight");
        }
        let side = if lateral_m_s2 > 0.0 { "left" } else { "right" };
        format!("{pedal}, {side} {}", lateral_m_s2.abs())
    }
}

impl Recording {
    /// The outline of the ego: as stated, otherwise a medium car.
    #[must_use]
    pub fn ego_outline(&self) -> Outline {
        self.ego.outline.clone().unwrap_or_else(|| Outline::rectangle(EGO_M[0], EGO_M[1]))
    }

    /// When the outline of the recorded ego first overlaps that of an obstacle, at steps of
    /// `step_s` counted from its start (s); `None`: never, or nothing is recorded of it. It says
    /// when something happens in a long recording, and not who touches whom.
    #[must_use]
    pub fn recorded_meeting_s(&self, step_s: f64) -> Option<f64> {
        let outline = self.ego_outline();
        let last = self.ego.went.last()?;
        let steps = ((last.time_s - self.ego.start.time_s) / step_s).floor() as u32;
        (1..=steps).map(|n| f64::from(n) * step_s).find(|after_s| {
            let time_s = self.ego.start.time_s + after_s;
            let ego = at(&self.ego.went, time_s);
            ego.is_some_and(|ego| overlaps(&outline, ego.place, &self.others, time_s))
        })
    }
}

/// Where the ego is when manoeuvres begin: as recorded, and after that, or if nothing is recorded,
/// straight on.
pub(crate) fn began(ego: &Ego, time_s: f64) -> TimedState {
    if let Some(moment) = at(&ego.went, time_s) {
        return moment;
    }
    let start = *ego.went.last().filter(|last| last.time_s < time_s).unwrap_or(&ego.start);
    let [x, y] = start.velocity_m_s();
    let after_s = time_s - start.time_s;
    let moved = [start.place.at[0] + x * after_s, start.place.at[1] + y * after_s];
    TimedState { time_s, place: Placed { at: moved, ..start.place }, ..start }
}

/// Whether the ego overlaps an obstacle.
fn overlaps(outline: &Outline, place: Placed, others: &[Obstacle], time_s: f64) -> bool {
    others.iter().any(|obstacle| {
        let moment = obstacle.at(time_s);
        moment.is_some_and(|moment| overlap(outline, place, &obstacle.outline, moment.place))
    })
}

/// Share of the lateral acceleration that is left to tyres that brake.
pub(crate) fn left_of_grip(brake_m_s2: f64, grip_m_s2: f64) -> f64 {
    let used = (brake_m_s2 / grip_m_s2).clamp(0.0, 1.0);
    (1.0 - used * used).sqrt()
}

/// The ego's way, one moment a step, the first of them a step after `start`.
pub(crate) fn arc(
    start: &TimedState,
    brake_m_s2: f64,
    lateral_m_s2: f64,
    manoeuvres: &Manoeuvres,
    steps: u32,
) -> Vec<TimedState> {
    let dt = manoeuvres.step_s;
    let lateral = lateral_m_s2 * left_of_grip(brake_m_s2, manoeuvres.grip_m_s2);
    let direction = if start.speed_m_s < 0.0 { -1.0 } else { 1.0 };
    let mut now = TimedState { slip: 0.0, ..*start };
    let mut way = Vec::with_capacity(steps as usize);
    for n in 1..=steps {
        let speed = now.speed_m_s.abs();
        let curvature = if speed > 0.0 {
            (lateral / (speed * speed)).clamp(-CURVATURE_MAX, CURVATURE_MAX)
        } else {
            0.0
        };
        let run = direction * speed * dt;
        now.place.at[0] += run * libm::cos(now.place.yaw);
        now.place.at[1] += run * libm::sin(now.place.yaw);
        now.place.yaw += run * curvature;
        now.speed_m_s = direction * (speed - brake_m_s2 * dt).max(0.0);
        now.time_s = start.time_s + f64::from(n) * dt;
        way.push(now);
    }
    way
}

#[cfg(test)]
mod tests;
