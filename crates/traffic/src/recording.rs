//! Who is where, and when: the common form of all file formats.

use crate::outline::{Outline, Placed};
use core::f64::consts::PI;

/// A heading that turns by more than this from one state to the next is that of the rear (rad):
/// nothing turns by 144° in a step, and simulators that take the heading of what crawls from its
/// velocity exchange the two.
const TURNED_RAD: f64 = 0.8 * PI;
/// States that are further apart than this may be those of a body that did turn (s).
const STEP_S: f64 = 0.5;

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
    /// How well its start is known, where the file says so.
    pub spread: StateSpread,
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
    /// How well its first moment is known, where the file says so.
    pub spread: StateSpread,
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

/// How well the state of a body is known: standard deviations, of what a file states as an interval
/// or a region; 0: it states a value, and not how well that is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateSpread {
    /// Along its heading (m).
    pub longitudinal_m: f64,
    /// To its left (m).
    pub lateral_m: f64,
    /// Of its heading (rad).
    pub yaw: f64,
    /// Of its speed (m/s).
    pub speed_m_s: f64,
}

impl StateSpread {
    /// Of values that are anywhere in a region of places (around a heading), and within half of an
    /// interval of headings (rad) and of speeds (m/s), all as likely: a uniform distribution of
    /// half width h has the standard deviation h / √3, a disc of radius r that of r / 2 each way.
    pub(crate) fn within(
        region: Option<&Outline>,
        yaw: f64,
        yaw_half: f64,
        speed_half_m_s: f64,
    ) -> Self {
        let share = 1.0 / 3.0_f64.sqrt();
        let of_place = region.map_or([0.0; 2], |region| {
            let half = region.turned(-yaw).size().map(|size| 0.5 * size);
            half.map(|half| half * if region.is_round() { 0.5 } else { share })
        });
        let [longitudinal_m, lateral_m] = of_place;
        let [yaw, speed_m_s] = [yaw_half * share, speed_half_m_s * share];
        Self { longitudinal_m, lateral_m, yaw, speed_m_s }
    }

    /// What is taken of it, in words.
    pub(crate) fn taken(&self) -> String {
        let all = [
            (self.longitudinal_m, "m along"),
            (self.lateral_m, "m across"),
            (self.yaw.to_degrees(), "° of heading"),
            (self.speed_m_s, "m/s"),
        ];
        let some = all.iter().filter(|(value, _)| *value > 0.0);
        let said: Vec<String> = some.map(|(value, of)| format!("{value:.3} {of}")).collect();
        format!("as likely anywhere in them, standard deviations {}", said.join(", "))
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

/// Keeps the heading where front and rear are exchanged; if they are, says so of this body.
pub(crate) fn without_turns_about(track: &mut [TimedState], whose: &str) -> Option<String> {
    let (mut count, mut is_turned) = (0, false);
    for index in 1..track.len() {
        let (last, next) = (track[index - 1], &mut track[index]);
        if is_turned {
            next.place.yaw = wrapped(next.place.yaw + PI);
        }
        let by = wrapped(next.place.yaw - last.place.yaw).abs();
        if by > TURNED_RAD && next.time_s - last.time_s <= STEP_S {
            next.place.yaw = wrapped(next.place.yaw + PI);
            is_turned = !is_turned;
            count += 1;
        }
    }
    (count > 0).then(|| {
        format!(
            "{whose}: front and rear are exchanged {count} times from one state to the next; it is \
             taken to keep its heading"
        )
    })
}
