//! Exact determinants of the corners of a pair as whole numbers: nearly all pairs have them.
//!
//! Triangles that may meet are small beside their distance from the origin, so their coordinates
//! are multiples of one power of two, 2ᴸ, and their differences are below 2⁶⁰ of these. With that,
//! an area is below 2¹²¹ and a volume below 2¹⁸⁴: a few multiplications, without any rounding.
//! The coordinates themselves may be larger; they are kept modulo 2⁶⁴, which no difference notices.

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
    /// The corners, if there is an L; `extent` (m) bounds all differences of coordinates.
    pub(super) fn of(corners: &[DVec3; 6], extent: f64) -> Option<Self> {
        // Rounded or not, no difference reaches 2^(e + 1), with e the exponent of the extent.
        let (_, _, exponent) = wide::parts(extent);
        let unit = exponent - 7;
        let mut whole = [[0; 3]; 6];
        for (whole, corner) in whole.iter_mut().zip(corners) {
            for (whole, x) in whole.iter_mut().zip(corner.to_array()) {
                *whole = multiple(x, unit)?;
            }
        }
        Some(Self(whole))
    }

    /// det(b − a, c − a, d − a).
    #[inline]
    pub(super) fn volume(&self, [a, b, c, d]: [Corner; 4]) -> Whole {
        let from_a = |p: Corner| {
            let (p, a) = (self.0[p], self.0[a]);
            [0, 1, 2].map(|i| i128::from(p[i].wrapping_sub(a[i])))
        };
        let ([bx, by, bz], [cx, cy, cz], d) = (from_a(b), from_a(c), from_a(d));
        let normal = [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx];
        // Each product in two parts: below 2^118 and 2^124.
        let (mut high, mut low) = (0, 0);
        for (n, d) in normal.into_iter().zip(d) {
            high += (n >> 64) * d;
            low += i128::from(n as u64) * d;
        }
        Whole { high: high + (low >> 64), low: low as u64 }
    }

    /// det(b − a, c − a) without the coordinate `drop`.
    #[inline]
    pub(super) fn area(&self, drop: usize, [a, b, c]: [Corner; 3]) -> i128 {
        let [x, y] = [(drop + 1) % 3, (drop + 2) % 3];
        let [a, b, c] = [self.0[a], self.0[b], self.0[c]];
        let from_a = |p: [i64; 3], i: usize| i128::from(p[i].wrapping_sub(a[i]));
        from_a(b, x) * from_a(c, y) - from_a(b, y) * from_a(c, x)
    }
}

/// `x` in units of 2^(unit), modulo 2⁶⁴, if it is a multiple of it.
fn multiple(x: f64, unit: i32) -> Option<i64> {
    let (negative, mantissa, exponent) = wide::parts(x);
    let shift = exponent - unit;
    let magnitude = if shift >= 0 {
        mantissa.checked_shl(shift as u32).unwrap_or(0)
    } else if mantissa == 0 || mantissa.trailing_zeros() as i32 >= -shift {
        mantissa.checked_shr(shift.unsigned_abs()).unwrap_or(0)
    } else {
        return None;
    };
    Some(if negative { (magnitude as i64).wrapping_neg() } else { magnitude as i64 })
}

impl Whole {
    /// Its sign.
    pub(super) fn sign(self) -> Sign {
        if self.high != 0 { self.high.signum() as Sign } else { Sign::from(self.low != 0) }
    }

    /// Its magnitude.
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
