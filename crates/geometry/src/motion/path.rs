//! Paths of bodies in the world: states in time, and poses between them.

use crate::{DVec3, Pose};
use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// The longest span of time of a motion (s).
pub const SPAN_MAX: f64 = 30.0;

/// The greatest magnitude of a time (s). Double precision resolves 0.12 ns there.
pub const TIME_MAX: f64 = 1e6;

/// The greatest magnitude of a coordinate of a position (m).
pub const POSITION_MAX: f64 = 1e6;

/// The greatest speed of a body's origin (m/s).
pub const SPEED_MAX: f64 = 1e3;

/// The greatest rate at which a body turns (rad/s).
pub const RATE_MAX: f64 = 100.0;

/// An orientation in space: from the body frame to the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orientation {
    /// A quaternion of length 1 up to rounding: w, x, y, z.
    quaternion: [f64; 4],
}

/// Where a body is at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// The time (s).
    pub time_s: f64,
    /// Position of the body frame's origin in the world (m).
    pub position_m: [f64; 3],
    /// Orientation of the body frame in the world.
    pub orientation: Orientation,
}

/// Numbers of a state: see [`State::to_bits`].
pub const STATE_WORDS: usize = 8;

/// The path of a body: between two states position is linear in time, and orientation turns at a
/// constant rate about one axis, the shorter way.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionPath {
    states: Vec<State>,
    /// What lies between a state and the next one.
    turns: Vec<Turn>,
}

/// The turn from one orientation to another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// In the world, of length 1; 0 if there is no turn.
    axis: DVec3,
    /// From 0 to π (rad).
    angle: f64,
}

/// The part of a path between two states.
pub(super) struct Leg {
    pub(super) to_s: f64,
    /// Velocity of the origin in the world (m/s).
    pub(super) velocity: DVec3,
    /// Rate of turning in the world (rad/s).
    pub(super) rate: DVec3,
}

/// Why states are no path, or two paths no motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathError {
    /// There are fewer than two states.
    Short,
    /// A number of this state is not finite or too large, or its time is not after the one before.
    State(usize),
    /// From this state to the next one the body would move or turn too fast.
    Fast(usize),
    /// The paths do not both cover this span of time, or it is empty or too long.
    Span {
        /// Its begin (s).
        from_s: f64,
        /// Its end (s).
        to_s: f64,
    },
}

impl Orientation {
    /// The body frame is the world frame.
    pub const IDENTITY: Self = Self { quaternion: [1.0, 0.0, 0.0, 0.0] };

    /// An orientation from yaw, pitch, roll in degrees, applied in the order Z·Y·X, as in
    /// [`Pose::from_degrees`].
    #[must_use]
    pub fn from_degrees(yaw: f64, pitch: f64, roll: f64) -> Self {
        let [(sy, cy), (sp, cp), (sr, cr)] =
            [yaw, pitch, roll].map(|degrees| libm::sincos(degrees.to_radians() * 0.5));
        Self::from_quaternion([
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ])
    }

    /// An orientation from a quaternion w, x, y, z, scaled to length 1. If it has no length, or a
    /// number is not finite, a path does not accept it.
    #[must_use]
    pub fn from_quaternion(quaternion: [f64; 4]) -> Self {
        let [w, x, y, z] = quaternion;
        let length = libm::sqrt((w * w + x * x) + (y * y + z * z));
        Self { quaternion: quaternion.map(|q| q / length) }
    }

    /// The quaternion: w, x, y, z.
    #[must_use]
    pub fn quaternion(&self) -> [f64; 4] {
        self.quaternion
    }

    /// The rotation matrix, row-major.
    #[must_use]
    pub fn rotation(&self) -> [[f64; 3]; 3] {
        let [w, x, y, z] = self.quaternion;
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }

    /// The angle of the turn from here to another orientation, the shorter way: 0 to π (rad).
    #[must_use]
    pub fn angle_to(&self, other: &Self) -> f64 {
        self.turn_to(other).angle
    }

    /// This orientation, turned about an axis of the world (of length 1) by an angle (rad).
    fn turned(&self, axis: DVec3, angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle * 0.5);
        let [x, y, z] = (axis * sin).to_array();
        Self { quaternion: product([cos, x, y, z], self.quaternion) }
    }

    /// The turn from here to `other`, the shorter way; of two halves of a full turn one of them.
    fn turn_to(&self, other: &Self) -> Turn {
        let [w, x, y, z] = self.quaternion;
        let [w, x, y, z] = product(other.quaternion, [w, -x, -y, -z]);
        let sign = if w < 0.0 { -1.0 } else { 1.0 };
        let along = DVec3::new(x, y, z) * sign;
        let length = libm::sqrt(along.dot(along));
        if length > 0.0 {
            Turn { axis: along * (1.0 / length), angle: 2.0 * libm::atan2(length, w * sign) }
        } else {
            Turn { axis: DVec3::ZERO, angle: 0.0 }
        }
    }
}

/// The product of two quaternions: the rotation `q`, then `p`.
fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    let ([a, b, c, d], [w, x, y, z]) = (p, q);
    [
        ((a * w - b * x) - c * y) - d * z,
        ((a * x + b * w) + c * z) - d * y,
        ((a * y - b * z) + c * w) + d * x,
        ((a * z + b * y) - c * x) + d * w,
    ]
}

impl State {
    /// The bits of time, position and quaternion, from which [`State::from_bits`] makes this state.
    #[must_use]
    pub fn to_bits(&self) -> [u64; STATE_WORDS] {
        let ([x, y, z], [q, i, j, k]) = (self.position_m, self.orientation.quaternion);
        [self.time_s, x, y, z, q, i, j, k].map(f64::to_bits)
    }

    /// The state of these bits. A path accepts it if it accepted that which they are of.
    #[must_use]
    pub fn from_bits(bits: [u64; STATE_WORDS]) -> Self {
        let [time_s, x, y, z, q, i, j, k] = bits.map(f64::from_bits);
        // Scaled to length 1 again, it would be another one.
        let orientation = Orientation { quaternion: [q, i, j, k] };
        Self { time_s, position_m: [x, y, z], orientation }
    }
}

impl MotionPath {
    /// A path through states that ascend in time.
    ///
    /// ```
    /// use trolley_geometry::motion::{Orientation, MotionPath, State};
    ///
    /// let state = |time_s, x, yaw| State {
    ///     time_s,
    ///     position_m: [x, 0.0, 0.0],
    ///     orientation: Orientation::from_degrees(yaw, 0.0, 0.0),
    /// };
    /// let path = MotionPath::new(&[state(0.0, 0.0, 0.0), state(2.0, 20.0, 90.0)])?;
    /// assert_eq!(path.pose_at(0.5).translation, [5.0, 0.0, 0.0]);
    /// # Ok::<(), trolley_geometry::motion::PathError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// There are fewer than two states; a number is not finite, or beyond [`TIME_MAX`] or
    /// [`POSITION_MAX`]; times do not ascend; between two states the body would be faster than
    /// [`SPEED_MAX`] or turn faster than [`RATE_MAX`].
    pub fn new(states: &[State]) -> Result<Self, PathError> {
        if states.len() < 2 {
            return Err(PathError::Short);
        }
        for (i, state) in states.iter().enumerate() {
            let is_after = i == 0 || states[i - 1].time_s < state.time_s;
            let is_place = state.position_m.iter().all(|x| x.abs() <= POSITION_MAX);
            let is_turn = state.orientation.quaternion.iter().all(|x| x.is_finite());
            if !(is_after && is_place && is_turn && state.time_s.abs() <= TIME_MAX) {
                return Err(PathError::State(i));
            }
        }
        let turns = states.windows(2).map(|s| s[0].orientation.turn_to(&s[1].orientation));
        let path = Self { states: states.to_vec(), turns: turns.collect() };
        for i in 0..path.turns.len() {
            let leg = path.leg(i);
            if !(leg.velocity.length() <= SPEED_MAX && leg.rate.length() <= RATE_MAX) {
                return Err(PathError::Fast(i));
            }
        }
        Ok(path)
    }

    /// A body that stays where it is between two times (s).
    ///
    /// # Errors
    ///
    /// See [`MotionPath::new`].
    pub fn still(
        position_m: [f64; 3],
        orientation: Orientation,
        [from_s, to_s]: [f64; 2],
    ) -> Result<Self, PathError> {
        let state = State { time_s: from_s, position_m, orientation };
        Self::new(&[state, State { time_s: to_s, ..state }])
    }

    /// The same path of a body that is always moved by this much in its own frame, forward and to
    /// the left (m), level with the ground, and turned to the left by an angle (degrees).
    ///
    /// # Errors
    ///
    /// See [`MotionPath::new`].
    pub fn offset(&self, [forward_m, left_m]: [f64; 2], yaw_deg: f64) -> Result<Self, PathError> {
        let moved = |state: &State| {
            let rotation = state.orientation.rotation();
            // A body that stands on its nose has no heading: then it is not moved.
            let (x, y) = (rotation[0][0], rotation[1][0]);
            let length = libm::sqrt(x * x + y * y);
            let (x, y) = if length > 1e-6 { (x / length, y / length) } else { (0.0, 0.0) };
            let [p, q, z] = state.position_m;
            State {
                position_m: [p + (x * forward_m - y * left_m), q + (y * forward_m + x * left_m), z],
                orientation: state.orientation.turned(DVec3::Z, yaw_deg.to_radians()),
                ..*state
            }
        };
        Self::new(&self.states.iter().map(moved).collect::<Vec<_>>())
    }

    /// Its begin (s).
    #[must_use]
    pub fn from_s(&self) -> f64 {
        self.states[0].time_s
    }

    /// Its end (s).
    #[must_use]
    pub fn to_s(&self) -> f64 {
        self.states[self.states.len() - 1].time_s
    }

    /// The states.
    #[must_use]
    pub fn states(&self) -> &[State] {
        &self.states
    }

    /// The pose in the world at a time (s); before the first state and after the last one that of
    /// the state.
    ///
    /// With the share s of the time between two states that has passed: position p + (q − p)·s,
    /// orientation that of the first state, turned by the angle times s, then made a matrix. At a
    /// state its own orientation is taken. All in f64, in this order; the same bits on every
    /// machine.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> Pose {
        let State { position_m, orientation, .. } = self.state_at(time_s);
        Pose { rotation: orientation.rotation(), translation: position_m }
    }

    /// The state at a time (s), of which [`MotionPath::pose_at`] is the pose; its time is the one
    /// that was asked for. A path through it, cut there, is the same motion up to rounding.
    #[must_use]
    pub fn state_at(&self, time_s: f64) -> State {
        let i = self.number_at(time_s);
        let (state, next, turn) = (&self.states[i], &self.states[i + 1], &self.turns[i]);
        let share = (time_s - state.time_s) / (next.time_s - state.time_s);
        let share = share.clamp(0.0, 1.0);
        let (p, q) = (state.position_m, next.position_m);
        let orientation = match share {
            0.0 => state.orientation,
            1.0 => next.orientation,
            _ if turn.angle == 0.0 => state.orientation,
            _ => state.orientation.turned(turn.axis, turn.angle * share),
        };
        let position_m = core::array::from_fn(|k| p[k] + (q[k] - p[k]) * share);
        State { time_s, position_m, orientation }
    }

    /// The velocity of a point that is fixed to the body (m, body frame) and the rate at which the
    /// body turns, both in the world (m/s, rad/s), just before a time (s): those of the piece that
    /// ends there, or holds it. Before the first state those of the first piece.
    #[must_use]
    pub fn velocity_before(&self, time_s: f64, point_m: [f64; 3]) -> (DVec3, DVec3) {
        let before = self.states.partition_point(|state| state.time_s < time_s);
        let leg = self.leg(before.saturating_sub(1).min(self.turns.len() - 1));
        let rotation = self.state_at(time_s).orientation.rotation();
        let arm =
            rotation.map(|row| (row[0] * point_m[0] + row[1] * point_m[1]) + row[2] * point_m[2]);
        (leg.velocity + leg.rate.cross(DVec3::from_array(arm)), leg.rate)
    }

    /// The number of the state from which the body moves at a time, which is never the last one.
    fn number_at(&self, time_s: f64) -> usize {
        let after = self.states.partition_point(|state| state.time_s <= time_s);
        after.saturating_sub(1).min(self.turns.len() - 1)
    }

    pub(super) fn leg_at(&self, time_s: f64) -> Leg {
        self.leg(self.number_at(time_s))
    }

    fn leg(&self, i: usize) -> Leg {
        let (state, next, turn) = (&self.states[i], &self.states[i + 1], &self.turns[i]);
        let lasts_s = next.time_s - state.time_s;
        let moved = DVec3::from_array(next.position_m) - DVec3::from_array(state.position_m);
        Leg {
            to_s: next.time_s,
            velocity: moved * (1.0 / lasts_s),
            rate: turn.axis * (turn.angle / lasts_s),
        }
    }

    /// The greatest sum of magnitudes of coordinates (m), speed (m/s) and rate of turning (rad/s).
    pub(super) fn greatest(&self) -> (f64, f64, f64) {
        let position = |s: &State| s.position_m.iter().map(|x| x.abs()).sum::<f64>();
        let position = self.states.iter().map(position).fold(0.0, f64::max);
        let legs = (0..self.turns.len()).map(|i| self.leg(i));
        legs.fold((position, 0.0, 0.0), |(position, speed, rate), leg| {
            (position, leg.velocity.length().max(speed), leg.rate.length().max(rate))
        })
    }
}

impl Diagnostic for PathError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn what(&self) -> String {
        match self {
            Self::Short => "a path needs at least two states".into(),
            Self::State(i) => format!(
                "state {i} of a path has a number that is not finite or too large, or a time that \
                 is not after that of the state before"
            ),
            Self::Fast(i) => {
                format!("from state {i} of a path to the next one the body would be too fast")
            }
            Self::Span { from_s, to_s } => {
                format!("two paths do not share the span of time from {from_s} to {to_s} s")
            }
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy: Cow<'_, str> = match self {
            Self::Short => "repeat the state at a later time for a body that stands".into(),
            Self::State(_) => format!(
                "times ascend within ±{TIME_MAX} s, and coordinates lie within ±{POSITION_MAX} m"
            )
            .into(),
            Self::Fast(_) => {
                format!("a body moves by at most {SPEED_MAX} m/s and turns by {RATE_MAX} rad/s")
                    .into()
            }
            Self::Span { .. } => {
                format!("it begins before it ends, and lasts at most {SPAN_MAX} s").into()
            }
        };
        Some(remedy)
    }
}

impl fmt::Display for PathError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what())
    }
}

impl core::error::Error for PathError {}
