//! Bodies that move and turn: paths in the world, and the motion of one body in another's frame.
//!
//! ```text
//! states of A --MotionPath::new--> path ─┐
//!                                        ├─ RelativeMotion ──▶ pieces ──▶ TimeInterval: axes that
//! states of B --MotionPath::new--> path ─┘       │                        separate
//!                                                └─▶ pose_at: the input of exact tests
//! ```
//!
//! Between two states position is linear in time, and orientation turns at a constant rate about
//! one axis, the shorter way: spherical linear interpolation (K. Shoemake, *Animating Rotation with
//! Quaternion Curves*, SIGGRAPH 1985). This is the motion; what [`MotionPath::pose_at`] returns
//! differs from it by rounding, and defines the input of exact tests.
//!
//! # How far motion is from straight
//!
//! Let p be a point fixed to B, u = Rb p, y = tb − ta and v = y′ (constant between two states), and
//! ωa, ωb the rates at which A and B turn, vectors in the world (constant too). In A's frame the
//! point is at x = Raᵀ(u + y). As (Raᵀ w)′ = Raᵀ(w′ − ωa × w) and u′ = ωb × u, with Ω = ωb − ωa and
//! Jacobi's identity,
//!
//! ```text
//! Ra x″ = Ω × (Ω × u) + (ωb × ωa) × u + ωa × (ωa × y) − 2 ωa × v
//! |x″|  ≤ K = (|Ω|² + |ωa × ωb|) |p| + max |ωa × (ωa × y) − 2 ωa × v|
//! ```
//!
//! The last vector is linear in time, so its length is greatest at an end. Over δ seconds a curve
//! with |x″| ≤ K is within K δ²/8 of its chord. Corners of a triangle thus move along chords up to
//! that margin, and so do all its points, which are means of them with fixed weights. No other
//! bound is needed: turning is part of the chords, at second order. (With a fixed orientation the
//! deviation is of first order, |Ω| δ r/2: 1 mm at 1 rad/s would take intervals of 0.7 ms instead
//! of about 10.) The motion of A in B's frame is bounded in the same way, with y and v negated.
//!
//! # Parts of an interval
//!
//! Within an interval the curve is off its chord by up to f = K t (δ − t)/2, and the chord of a
//! part is off that of the whole by no more than the chord of f there, at most K δ²/8. With M = 4/3
//! K δ²/8 as the margin, the chord of a half has the margin M/4, and is off by 3/4 M: together M.
//! So a gap of more than M along a fixed axis in an interval is a gap of more than its margin in
//! each half, and in theirs. (K is at most that of the whole: it has the same form with ends
//! further in.) What axes that do not change exclude stays excluded, whether or not the halves are
//! looked at.
//!
//! # Invariants
//!
//! - Poses have the same bits on every machine: sines, cosines and arc tangents come from `libm`,
//!   and nothing is fused.
//! - An [`TimeInterval`] never calls two triangles apart that touch within it, neither in the
//!   motion nor at a pose that [`RelativeMotion::pose_at`] returns: `motion/tests.rs`.
//! - What is clearly apart in an interval is apart in all parts of it: `motion/tests.rs`.

mod interval;
mod near_span;
mod path;
mod separation;
#[cfg(test)]
mod tests;
mod touch;

pub use interval::{Moved, MovingBodies, TimeInterval};
pub use near_span::{NearSpan, NearSpans};
pub use path::{
    MotionPath, Orientation, POSITION_MAX, PathError, RATE_MAX, SPAN_MAX, SPEED_MAX, STATE_WORDS,
    State, TIME_MAX,
};

use crate::{DVec3, Pose, RelativePose};

/// The motion of B in A's frame while both have a path.
#[derive(Clone, Copy, Debug)]
pub struct RelativeMotion<'p> {
    paths: [&'p MotionPath; 2],
    from_s: f64,
    to_s: f64,
}

/// A span of time between two states of which neither path has one within: both bodies move and
/// turn steadily.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPiece {
    /// Its begin (s).
    pub from_s: f64,
    /// Its end (s), after its begin.
    pub to_s: f64,
    /// Velocity of B's origin less that of A's, in the world (m/s).
    velocity: DVec3,
    /// Rates of turning of A and of B, in the world (rad/s).
    rates: [DVec3; 2],
}

impl<'p> RelativeMotion<'p> {
    /// The motion of B along its path, seen from A on its own, while both have one.
    ///
    /// # Errors
    ///
    /// There is no such time, or it lasts longer than [`SPAN_MAX`].
    pub fn new(a: &'p MotionPath, b: &'p MotionPath) -> Result<Self, PathError> {
        let from_s = a.from_s().max(b.from_s());
        Self { paths: [a, b], from_s, to_s: from_s }.between(from_s, a.to_s().min(b.to_s()))
    }

    /// The same motion between other times (s), within the paths.
    ///
    /// # Errors
    ///
    /// The times are not ascending, not within both paths, or more than [`SPAN_MAX`] apart.
    pub fn between(&self, from_s: f64, to_s: f64) -> Result<Self, PathError> {
        let is_known = self.paths.iter().all(|path| path.from_s() <= from_s && to_s <= path.to_s());
        if !(from_s < to_s && to_s - from_s <= SPAN_MAX && is_known) {
            return Err(PathError::Span { from_s, to_s });
        }
        Ok(Self { from_s, to_s, ..*self })
    }

    /// Its begin (s).
    #[must_use]
    pub fn from_s(&self) -> f64 {
        self.from_s
    }

    /// Its end (s).
    #[must_use]
    pub fn to_s(&self) -> f64 {
        self.to_s
    }

    /// The poses of A and of B in the world at a time (s): see [`MotionPath::pose_at`].
    #[must_use]
    pub fn poses_at(&self, time_s: f64) -> [Pose; 2] {
        self.paths.map(|path| path.pose_at(time_s))
    }

    /// The pose of B in A's frame at a time (s): [`RelativePose::between`] the poses of both. With
    /// [`RelativePose::point`] it defines what exact tests are given.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> RelativePose {
        let [a, b] = self.poses_at(time_s);
        RelativePose::between(&a, &b)
    }

    /// The pieces of the motion, ascending in time, without gaps.
    pub fn pieces(&self) -> impl Iterator<Item = PathPiece> + '_ {
        let mut from_s = self.from_s;
        core::iter::from_fn(move || {
            if from_s >= self.to_s {
                return None;
            }
            let [a, b] = self.paths.map(|path| path.leg_at(from_s));
            let to_s = self.to_s.min(a.to_s).min(b.to_s);
            let piece = PathPiece {
                from_s,
                to_s,
                velocity: b.velocity - a.velocity,
                rates: [a.rate, b.rate],
            };
            from_s = to_s;
            Some(piece)
        })
    }

    /// A bound on the sum of the magnitudes of all positions and what time adds to them by its
    /// rounding (m), for bodies that reach this far from their origins (m).
    fn magnitude_m(&self, reaches: [f64; 2]) -> f64 {
        let time = self.from_s.abs().max(self.to_s.abs());
        let most = |path: &MotionPath, reach: f64| {
            let (position, speed, rate) = path.greatest();
            position + reach + (speed + rate * reach) * time
        };
        most(self.paths[0], reaches[0]) + most(self.paths[1], reaches[1])
    }
}
