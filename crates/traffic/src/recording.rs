//! Who is where, and when: the common form of all file formats.

use crate::outline::{Outline, Placed};

/// Traffic around an ego.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The name that the file gives itself.
    pub name: String,
    /// The automated vehicle.
    pub ego: Ego,
    /// Ways that planners chose for the ego from its start on; first moment first.
    pub planned: Vec<Planned>,
    /// All other road users and objects that may be hit, in the order of the file.
    pub others: Vec<Obstacle>,
    /// What was taken for something else, in whole sentences.
    pub notes: Vec<String>,
}

/// The automated vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Ego {
    /// Where it starts and how it moves there.
    pub start: TimedState,
    /// Its outline; `None`: not stated in the file.
    pub outline: Option<Outline>,
    /// Where it went, if the file lists it among the obstacles; first moment first.
    pub went: Vec<TimedState>,
}

/// A way that a planner chose for the ego.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its name: that of its file, without folder and ending.
    pub name: String,
    /// Where the ego goes; first moment first, times rise.
    pub went: Vec<TimedState>,
}

/// A road user or object that may be hit.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Its id or name in the file.
    pub id: String,
    /// Its type in the file: "car", "parkedVehicle".
    pub kind: String,
    /// Its outline.
    pub outline: Outline,
    /// Where it is when; one moment: always there. Times rise.
    pub track: Vec<TimedState>,
}

/// Where a body is at a time and how it moves there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedState {
    /// From the start of the recording (s).
    pub time_s: f64,
    /// Where it is.
    pub place: Placed,
    /// Speed (m/s); negative: backwards.
    pub speed_m_s: f64,
    /// From the heading to the direction of travel (rad).
    pub slip: f64,
}

impl TimedState {
    /// Velocity in the world (m/s).
    #[must_use]
    pub fn velocity_m_s(&self) -> [f64; 2] {
        let course = self.place.yaw + self.slip;
        [self.speed_m_s * libm::cos(course), self.speed_m_s * libm::sin(course)]
    }
}

impl Obstacle {
    /// Where it is at a time; `None` before it comes and after it went.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Option<TimedState> {
        at(&self.track, time_s)
    }

    /// Whether it never moves.
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.track.len() == 1
    }
}

/// A track at a time: straight between moments, the shorter way round for angles. A single moment
/// holds forever.
pub(crate) fn at(track: &[TimedState], time_s: f64) -> Option<TimedState> {
    let after = track.partition_point(|moment| moment.time_s <= time_s + 1e-9);
    let before = track.get(after.checked_sub(1)?)?;
    if track.len() == 1 {
        return Some(TimedState { time_s, ..*before });
    }
    let Some(next) = track.get(after) else {
        // The last moment itself still counts.
        return (time_s <= before.time_s + 1e-9).then_some(*before);
    };
    let share = (time_s - before.time_s) / (next.time_s - before.time_s);
    let mix = |a: f64, b: f64| a + share * (b - a);
    let (a, b) = (before.place, next.place);
    Some(TimedState {
        time_s,
        place: Placed {
            at: [mix(a.at[0], b.at[0]), mix(a.at[1], b.at[1])],
            yaw: a.yaw + share * wrapped(b.yaw - a.yaw),
        },
        speed_m_s: mix(before.speed_m_s, next.speed_m_s),
        slip: before.slip + share * wrapped(next.slip - before.slip),
    })
}

/// An angle in −π..π (rad).
pub(crate) fn wrapped(angle: f64) -> f64 {
    libm::atan2(libm::sin(angle), libm::cos(angle))
}
