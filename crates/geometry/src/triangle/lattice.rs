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
pub(super) struct Lattice([[i64; 3]; 6]);

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
        let mut lattice = Self([[0; 3]; 6]);
        for (whole, corner) in lattice.0.iter_mut().zip(corners) {
            let [x, y, z] = corner.to_array();
            *whole = [multiple(x, unit)?, multiple(y, unit)?, multiple(z, unit)?];
        }
        Some(lattice)
    }

    /// The vector from corner a to corner p.
    #[inline]
    fn difference(&self, a: Corner, p: Corner) -> [i128; 3] {
        let ([ax, ay, az], [px, py, pz]) = (self.0[a], self.0[p]);
        [px.wrapping_sub(ax).into(), py.wrapping_sub(ay).into(), pz.wrapping_sub(az).into()]
    }

    /// The normal (b − a) × (c − a).
    #[inline]
    pub(super) fn normal(&self, [a, b, c]: [Corner; 3]) -> [i128; 3] {
        let ([bx, by, bz], [cx, cy, cz]) = (self.difference(a, b), self.difference(a, c));
        [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx]
    }

    /// The distance of d along a normal at a: det(b − a, c − a, d − a) for that of abc.
    #[inline]
    pub(super) fn height(&self, normal: &[i128; 3], a: Corner, d: Corner) -> Whole {
        let ([nx, ny, nz], [dx, dy, dz]) = (*normal, self.difference(a, d));
        // Each product in two parts: below 2^117 and 2^124.
        let low = |n: i128| i128::from(n as u64);
        let high = (nx >> 64) * dx + (ny >> 64) * dy + (nz >> 64) * dz;
        let low = low(nx) * dx + low(ny) * dy + low(nz) * dz;
        Whole { high: high + (low >> 64), low: low as u64 }
    }

    /// The corners without the coordinate `drop`.
    pub(super) fn without(&self, drop: usize) -> [[i64; 2]; 6] {
        let (x, y) = kept(drop);
        self.0.map(|corner| [corner[x], corner[y]])
    }
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
