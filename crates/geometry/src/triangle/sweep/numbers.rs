//! Determinants of differences of corners and of the direction, without any rounding: on a lattice
//! where there is one, else by sums of products as wide as the exponents reach.

use super::DIRECTION_UNIT;
use crate::DVec3;
use crate::triangle::lattice::{self, Lattice};
use crate::triangle::wide::{Magnitude, Wide};
use crate::triangle::{Corner, Sign};

/// A vector that a determinant is made of.
#[derive(Clone, Copy, Debug)]
pub(super) enum Arm {
    /// From one corner to another.
    Between(Corner, Corner),
    /// The direction of motion.
    Direction,
}

/// The exact sign of a number, and its magnitude, rounded.
#[derive(Clone, Copy)]
pub(super) struct Number {
    pub(super) sign: Sign,
    magnitude: Magnitude,
}

impl Number {
    /// The quotient, within a few units in the last place; `divisor` is not 0.
    pub(super) fn over(self, divisor: Self) -> f64 {
        if self.sign == 0 {
            return 0.0;
        }
        let quotient = Magnitude::quotient(self.magnitude, divisor.magnitude);
        if self.sign == divisor.sign { quotient } else { -quotient }
    }

    /// The share that this is of itself less another number, which is not of the same sign; 0 if
    /// both are 0.
    pub(super) fn share(self, other: Self) -> f64 {
        Magnitude::share(self.magnitude, other.magnitude)
    }
}

/// The corners of a pair and a direction, as exact numbers.
pub(super) enum Numbers<'t> {
    /// Corners in units of 2ᴸ, and the direction in its own unit.
    Whole(Lattice, [i128; 3]),
    /// As given.
    Float([&'t DVec3; 6], DVec3),
}

impl<'t> Numbers<'t> {
    /// `extent` (m) bounds all differences of coordinates.
    pub(super) fn of(corners: [&'t DVec3; 6], extent: f64, direction: DVec3) -> Self {
        match Lattice::of(&corners, extent) {
            Some(lattice) => {
                let whole = |x: f64| libm::scalbn(x, -DIRECTION_UNIT) as i64;
                let [x, y, z] = direction.to_array().map(whole);
                Self::Whole(lattice, [x.into(), y.into(), z.into()])
            }
            None => Self::Float(corners, direction),
        }
    }

    /// det(p, q, r).
    pub(super) fn determinant(&self, [p, q, r]: [Arm; 3]) -> Number {
        match self {
            Self::Whole(lattice, direction) => {
                let [(p, unit_p), (q, unit_q), (r, unit_r)] =
                    [p, q, r].map(|arm| whole(lattice, direction, arm));
                let value = lattice::dot(lattice::cross(p, q), r);
                let magnitude = value.magnitude().scaled(unit_p + unit_q + unit_r);
                Number { sign: value.sign(), magnitude }
            }
            Self::Float(corners, direction) => {
                let mut sum = Wide::ZERO;
                for (p, minus_p) in summands(corners, *direction, p) {
                    for (q, minus_q) in summands(corners, *direction, q) {
                        for (r, minus_r) in summands(corners, *direction, r) {
                            sum.add_volume(p, q, r, minus_p ^ minus_q ^ minus_r);
                        }
                    }
                }
                Number { sign: sum.sign(), magnitude: sum.magnitude() }
            }
        }
    }

    /// Coordinate `k` of p × q.
    pub(super) fn area(&self, k: usize, [p, q]: [Arm; 2]) -> Number {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        match self {
            Self::Whole(lattice, direction) => {
                let [(p, unit_p), (q, unit_q)] = [p, q].map(|arm| whole(lattice, direction, arm));
                let value = p[i] * q[j] - p[j] * q[i];
                let magnitude = Magnitude::of(value.unsigned_abs(), unit_p + unit_q);
                Number { sign: value.signum() as Sign, magnitude }
            }
            Self::Float(corners, direction) => {
                let mut sum = Wide::ZERO;
                for (p, minus_p) in summands(corners, *direction, p) {
                    for (q, minus_q) in summands(corners, *direction, q) {
                        sum.add([p[i], q[j], 1.0], minus_p ^ minus_q);
                        sum.add([p[j], q[i], 1.0], !(minus_p ^ minus_q));
                    }
                }
                Number { sign: sum.sign(), magnitude: sum.magnitude() }
            }
        }
    }

    /// Coordinate `k` of p.
    pub(super) fn length(&self, k: usize, p: Arm) -> Number {
        match self {
            Self::Whole(lattice, direction) => {
                let (p, unit) = whole(lattice, direction, p);
                let magnitude = Magnitude::of(p[k].unsigned_abs(), unit);
                Number { sign: p[k].signum() as Sign, magnitude }
            }
            Self::Float(corners, direction) => {
                let mut sum = Wide::ZERO;
                for (p, minus) in summands(corners, *direction, p) {
                    sum.add([p[k], 1.0, 1.0], minus);
                }
                Number { sign: sum.sign(), magnitude: sum.magnitude() }
            }
        }
    }
}

/// A vector as whole numbers below 2⁶¹, and the exponent of their unit.
fn whole(lattice: &Lattice, direction: &[i128; 3], arm: Arm) -> ([i128; 3], i32) {
    match arm {
        Arm::Between(from, to) => (lattice.difference(from, to), lattice.unit()),
        Arm::Direction => (*direction, DIRECTION_UNIT),
    }
}

/// The points that add up to a vector, and whether each is subtracted.
fn summands(
    corners: &[&DVec3; 6],
    direction: DVec3,
    arm: Arm,
) -> impl Iterator<Item = (DVec3, bool)> + Clone {
    let (plus, minus) = match arm {
        Arm::Between(from, to) => (*corners[to], Some(*corners[from])),
        Arm::Direction => (direction, None),
    };
    core::iter::once((plus, false)).chain(minus.map(|point| (point, true)))
}
