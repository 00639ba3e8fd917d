//! Exact integer determinants of the corners of a pair; possible for nearly all pairs.
//!
//! Triangles that may meet are small compared with their distance from the origin, so their
//! coordinates are multiples of one power of two, 2ᴸ, and their differences are below 2⁶⁰ of these.
//! So an area is below 2¹²¹ and a volume below 2¹⁸⁴: a few multiplications, without any rounding.
//! The coordinates themselves may be larger; they are kept modulo 2⁶⁴, which does not affect
//! differences.

use super::exact::kept;
use super::wide::{self, Magnitude};
use super::{Corner, Sign};
use crate::DVec3;

/// The six corners of a pair, in units of 2ᴸ, modulo 2⁶⁴.
pub(super) struct Lattice {
    corners: [[i64; 3]; 6],
    /// L.
    unit: i32,
}

/// A determinant: `high·2⁶⁴ + low`.
#[derive(Clone, Copy)]
pub(super) struct Whole {
    high: i128,
    low: u64,
}

impl Lattice {
    /// The corners, if an L exists; `extent` (m) bounds all differences of coordinates.
    pub(super) fn of(corners: &[&DVec3; 6], extent: f64) -> Option<Self> {
        // Rounded or not, no difference exceeds 2^53 times the extent's last place.
        let (_, _, exponent) = wide::parts(extent);
        let unit = exponent - 7;
        let mut lattice = Self { corners: [[0; 3]; 6], unit };
        for (whole, corner) in lattice.corners.iter_mut().zip(corners) {
            let [x, y, z] = corner.to_array();
            *whole = [multiple(x, unit)?, multiple(y, unit)?, multiple(z, unit)?];
        }
        Some(lattice)
    }

    /// L: coordinates are multiples of 2ᴸ m.
    pub(super) fn unit(&self) -> i32 {
        self.unit
    }

    /// The vector from corner a to corner p.
    #[inline]
    pub(super) fn difference(&self, a: Corner, p: Corner) -> [i128; 3] {
        let ([ax, ay, az], [px, py, pz]) = (self.corners[a], self.corners[p]);
        [px.wrapping_sub(ax).into(), py.wrapping_sub(ay).into(), pz.wrapping_sub(az).into()]
    }

    /// The normal (b − a) × (c − a).
    #[inline]
    pub(super) fn normal(&self, [a, b, c]: [Corner; 3]) -> [i128; 3] {
        cross(self.difference(a, b), self.difference(a, c))
    }

    /// The distance of d along a normal at a: det(b − a, c − a, d − a) for that of abc.
    #[inline]
    pub(super) fn height(&self, normal: &[i128; 3], a: Corner, d: Corner) -> Whole {
        dot(*normal, self.difference(a, d))
    }

    /// The corners without the coordinate `drop`.
    pub(super) fn without(&self, drop: usize) -> [[i64; 2]; 6] {
        let (x, y) = kept(drop);
        self.corners.map(|corner| [corner[x], corner[y]])
    }
}

/// The product of two vectors of coordinates below 2⁶¹.
#[inline]
pub(super) fn cross([bx, by, bz]: [i128; 3], [cx, cy, cz]: [i128; 3]) -> [i128; 3] {
    [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx]
}

/// The dot product of a normal, as [`cross`] returns it, and a vector of coordinates below 2⁶¹.
#[inline]
pub(super) fn dot([nx, ny, nz]: [i128; 3], [dx, dy, dz]: [i128; 3]) -> Whole {
    // Each product in two parts: below 2^119 and 2^125.
    let low = |n: i128| i128::from(n as u64);
    let high = (nx >> 64) * dx + (ny >> 64) * dy + (nz >> 64) * dz;
    let low = low(nx) * dx + low(ny) * dy + low(nz) * dz;
    Whole { high: high + (low >> 64), low: low as u64 }
}

/// det(b − a, c − a) of points of a projection.
#[inline]
pub(super) fn area([a, b, c]: [[i64; 2]; 3]) -> i128 {
    let from_a = |p: [i64; 2], i: usize| i128::from(p[i].wrapping_sub(a[i]));
    from_a(b, 0) * from_a(c, 1) - from_a(b, 1) * from_a(c, 0)
}

/// `x` in units of 2^`unit`, modulo 2⁶⁴, if it is a multiple of that.
#[inline]
fn multiple(x: f64, unit: i32) -> Option<i64> {
    let (negative, mantissa, exponent) = wide::parts(x);
    let magnitude = match exponent - unit {
        shift @ 0..64 => mantissa << shift,
        64.. => 0,
        _ if mantissa == 0 => 0,
        shift if mantissa.trailing_zeros() >= shift.unsigned_abs() => mantissa >> -shift,
        _ => return None,
    };
    Some(if negative { (magnitude as i64).wrapping_neg() } else { magnitude as i64 })
}

impl Whole {
    /// The sign.
    pub(super) fn sign(self) -> Sign {
        if self.high != 0 { self.high.signum() as Sign } else { Sign::from(self.low != 0) }
    }

    /// The magnitude.
    pub(super) fn magnitude(self) -> Magnitude {
        let Self { high, low } = if self.high < 0 { self.negative() } else { self };
        let high = high as u128;
        if high >> 64 == 0 {
            Magnitude::of(high << 64 | u128::from(low), 0)
        } else {
            let zeros = high.leading_zeros();
            let top = high << zeros | u128::from(low) << zeros >> 64;
            Magnitude::of(top, 64 - zeros as i32)
        }
    }

    fn negative(self) -> Self {
        let (low, borrow) = 0_u64.overflowing_sub(self.low);
        Self { high: -self.high - i128::from(borrow), low }
    }
}
