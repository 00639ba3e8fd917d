//! First contact of two closed triangles, one of which moves along a straight line.
//!
//! B's corners are b + s·d: d is a direction and s the *travel* (m). These are real numbers, not
//! rounded ones: the motion is its own input. The travels at which A and B share a point form one
//! closed interval, because {s : s·d ∈ A ⊖ B} is the intersection of a line with a convex set. Its
//! least travel is that of a corner of one triangle on the other, or of two crossing edges.
//!
//! ```text
//! projection along d, f64 --> apart, certainly
//!                         \-> all signs certain: corners inside, edges crossing --> start and end
//!                         \-> a doubtful sign, or a bracket above 1 nm: exact, by whole numbers
//! ```
//!
//! # Invariants
//!
//! - The result is a function of both triangles and the motion alone. Whether and where there is
//!   contact is exact but for 1 nm of travel; the search compares with rational arithmetic in
//!   `tests/oracle`.
//! - No answer comes from vector instructions: [`crate::patch`] only leaves out what cannot be it.

mod exact;
mod numbers;
mod projection;
#[cfg(test)]
mod tests;

use super::Triangle;
use crate::DVec3;
use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use projection::{Doubt, Projected, Sides};

/// The greatest travel of a motion, in either sense (m).
pub const TRAVEL_MAX: f64 = 1e6;

/// How far the travel at first contact may be from the true one (m).
pub const TOLERANCE_M: f64 = 1e-9;

/// Components of a direction are multiples of this: 2⁻⁶⁰. So directions are whole numbers.
const DIRECTION_UNIT: i32 = -60;

/// A motion along a straight line: a direction in A's frame, and the travels from where to where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    direction: DVec3,
    /// Two unit vectors across the direction.
    across: [DVec3; 2],
    from_m: f64,
    to_m: f64,
}

/// A motion that is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweepError {
    /// The direction has no length, or a component is not finite.
    Direction,
    /// The travels are not ascending numbers within ±[`TRAVEL_MAX`].
    Travel(f64, f64),
}

/// The contact of two triangles on their way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstTouch {
    /// The first travel within the motion at which they share a point (m).
    pub travel_m: f64,
    /// A point where they touch then (m), in A's frame, rounded: within a few nanometres of A, and
    /// of B as moved.
    pub point: DVec3,
}

/// What touches at an end of the interval: corners of a triangle by number.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feature {
    /// A corner of A on B.
    CornerOfA(usize),
    /// A corner of B on A.
    CornerOfB(usize),
    /// The edge of A from this corner to the next, on one of B; the share of the way to the next.
    EdgeOfA(usize, f64),
}

/// The travels at which two triangles touch, unlimited.
#[derive(Clone, Copy, Debug)]
struct Interval {
    start: f64,
    end: f64,
    /// What touches at the start, and at the end.
    first: Feature,
    last: Feature,
}

impl Sweep {
    /// A motion along `direction`, of any length but 0, from travel `from_m` to `to_m`.
    ///
    /// The direction is scaled to length 1, and its components are rounded to multiples of 2⁻⁶⁰
    /// ([`Sweep::direction`]): over [`TRAVEL_MAX`] that moves nothing by more than a picometre.
    ///
    /// # Errors
    ///
    /// The direction has no length or is not finite; the travels are not ascending, or beyond
    /// [`TRAVEL_MAX`].
    pub fn new(direction: DVec3, from_m: f64, to_m: f64) -> Result<Self, SweepError> {
        // Scaled by a power of two first, so that no square over- or underflows.
        let largest = direction.abs().max_element();
        if !(direction.is_finite() && largest > 0.0) {
            return Err(SweepError::Direction);
        }
        let scaled = direction * libm::scalbn(1.0, -libm::ilogb(largest));
        let scaled = if scaled.is_finite() { scaled } else { direction * (1.0 / largest) };
        let unit = scaled * (1.0 / libm::sqrt(scaled.dot(scaled)));
        let whole =
            |x: f64| libm::scalbn(libm::rint(libm::scalbn(x, -DIRECTION_UNIT)), DIRECTION_UNIT);
        let d = DVec3::new(whole(unit.x), whole(unit.y), whole(unit.z));
        let least = d.abs().min_element();
        let axis = DVec3::AXES.into_iter().find(|axis| (d * *axis).abs().element_sum() <= least);
        let side = d.cross(axis.unwrap_or(DVec3::Z));
        let u = side * (1.0 / libm::sqrt(side.dot(side)));
        let sweep = Self { direction: d, across: [u, d.cross(u)], from_m: 0.0, to_m: 0.0 };
        sweep.between(from_m, to_m)
    }

    /// The same motion between other travels (m).
    ///
    /// # Errors
    ///
    /// They are not ascending, or beyond [`TRAVEL_MAX`].
    pub fn between(&self, from_m: f64, to_m: f64) -> Result<Self, SweepError> {
        if !(-TRAVEL_MAX <= from_m && from_m <= to_m && to_m <= TRAVEL_MAX) {
            return Err(SweepError::Travel(from_m, to_m));
        }
        Ok(Self { from_m, to_m, ..*self })
    }

    /// The same motion, ended at `to_m` (m) if that is earlier.
    #[must_use]
    #[inline]
    pub fn until(&self, to_m: f64) -> Self {
        Self { to_m: if to_m < self.to_m { to_m } else { self.to_m }, ..*self }
    }

    /// The direction d, as used: a vector of length 1 up to rounding, in A's frame.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The rows of the projection: two directions across the motion, and d.
    #[must_use]
    pub fn axes(&self) -> [DVec3; 3] {
        let [u, v] = self.across;
        [u, v, self.direction]
    }

    /// The travel where the motion begins (m).
    #[must_use]
    pub fn from_m(&self) -> f64 {
        self.from_m
    }

    /// The travel where the motion ends (m).
    #[must_use]
    pub fn to_m(&self) -> f64 {
        self.to_m
    }
}

/// The first contact of `a` with `b` as it moves, if it lies within the motion: the ends of the
/// motion included, and triangles that touch at its begin.
///
/// A pure function of its arguments, the same bits on every machine. Contact is missed or reported
/// by mistake only if it begins within 1 nm of the end of the motion, or ends within 1 nm of its
/// begin; the travel is within 1 nm of the true one. For coordinates that are not finite the result
/// is unspecified.
#[must_use]
pub fn first_contact(a: &Triangle, b: &Triangle, sweep: &Sweep) -> Option<FirstTouch> {
    let projected = Projected::of(a, b, sweep);
    if projected.is_early(sweep.from_m) || projected.is_late(sweep.to_m) || projected.are_beyond() {
        return None;
    }
    let sides = Sides::of(&projected);
    if sides.are_apart() {
        return None;
    }
    let interval = match sides.interval(sweep) {
        Ok(interval) => interval?,
        Err(Doubt) => exact::interval(a, b, sweep.direction)?,
    };
    if interval.start > sweep.to_m || interval.end < sweep.from_m {
        return None;
    }
    let travel_m = if interval.start > sweep.from_m { interval.start } else { sweep.from_m };
    Some(FirstTouch { travel_m, point: interval.point(a, b, sweep.direction, travel_m) })
}

impl Interval {
    /// A point that touches at a travel of the interval, rounded (m).
    ///
    /// The places of contact and their travels form a convex set: between those at both ends lie
    /// others.
    fn point(&self, a: &Triangle, b: &Triangle, direction: DVec3, at_m: f64) -> DVec3 {
        let place = |feature: Feature, travel_m: f64| match feature {
            Feature::CornerOfA(i) => a.0[i],
            Feature::CornerOfB(k) => b.0[k] + direction * travel_m,
            Feature::EdgeOfA(i, share) => {
                let (from, to) = (a.0[i], a.0[(i + 1) % 3]);
                from + (to - from) * share
            }
        };
        let mut point = place(self.first, self.start);
        if at_m > self.start && self.end > self.start {
            let share = (at_m - self.start) / (self.end - self.start);
            point += (place(self.last, self.end) - point) * share;
        }
        let bounds = a.bounds();
        point.max(bounds.min).min(bounds.max)
    }
}

impl fmt::Display for SweepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Direction => {
                f.write_str("the direction of motion has no length, or is not finite")
            }
            Self::Travel(from, to) => write!(
                f,
                "the motion goes from {from} to {to} m: \
                 travels ascend, and lie within ±{TRAVEL_MAX} m"
            ),
        }
    }
}

impl core::error::Error for SweepError {}

impl Diagnostic for SweepError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }
}
