//! Sums of products of three f64, without any rounding, for all finite f64.
//!
//! A fixed-point number as wide as the exponents reach (U. Kulisch's long accumulator): slow
//! compared with an adaptive predicate (about a microsecond per determinant) but correct for every
//! range. It is the last resort, for coordinates so small or large that floating point would under-
//! or overflow, and the source of well-rounded cuts where planes are nearly parallel.

use super::Sign;
use super::exact::Point2;
use crate::DVec3;

/// 2⁻³²²² (a product of three least denormals) up to 2³⁰⁷⁷ (24 products of three numbers below
/// 2¹⁰²⁴), and a sign: 6,300 bits.
const LIMBS: usize = 100;

/// Exponent of the lowest bit of the least denormal.
const EXPONENT_MIN: i32 = -1074;

/// A two's complement fixed-point number; bit 0 counts 2⁻³²²².
#[derive(Clone)]
pub(super) struct Wide([u64; LIMBS]);

impl Wide {
    /// 0.
    pub(super) const ZERO: Self = Self([0; LIMBS]);

    /// det(b − a, c − a, d − a), expanded into products of coordinates, so without differences.
    pub(super) fn orient3d([a, b, c, d]: [DVec3; 4]) -> Self {
        let mut sum = Self([0; LIMBS]);
        sum.add_volume(b, c, d, false);
        sum.add_volume(a, c, d, true);
        sum.add_volume(a, b, d, false);
        sum.add_volume(a, b, c, true);
        sum
    }

    /// det(b − a, c − a), expanded in the same way.
    pub(super) fn orient2d([a, b, c]: [Point2; 3]) -> Self {
        let mut sum = Self([0; LIMBS]);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            sum.add([p[0], q[1], 1.0], false);
            sum.add([p[1], q[0], 1.0], true);
        }
        sum
    }

    /// Adds (or subtracts) det(u, v, w).
    pub(super) fn add_volume(&mut self, u: DVec3, v: DVec3, w: DVec3, negative: bool) {
        self.add([u.x, v.y, w.z], negative);
        self.add([u.y, v.z, w.x], negative);
        self.add([u.z, v.x, w.y], negative);
        self.add([u.x, v.z, w.y], !negative);
        self.add([u.y, v.x, w.z], !negative);
        self.add([u.z, v.y, w.x], !negative);
    }

    /// Adds (or subtracts) a product.
    pub(super) fn add(&mut self, factors: [f64; 3], negative: bool) {
        let [(nx, mx, ex), (ny, my, ey), (nz, mz, ez)] = factors.map(parts);
        if mx == 0 || my == 0 || mz == 0 {
            return;
        }
        // The product of three 53-bit numbers: 159 bits in three limbs.
        let xy = u128::from(mx) * u128::from(my);
        let low = (xy & u128::from(u64::MAX)) * u128::from(mz);
        let high = (xy >> 64) * u128::from(mz) + (low >> 64);
        let product = [low as u64, high as u64, (high >> 64) as u64];

        // Shifted to its place: four limbs.
        let shift = (ex + ey + ez - 3 * EXPONENT_MIN) as usize;
        let (limb, bits) = (shift / 64, shift % 64);
        let mut placed = [0; 4];
        for (i, part) in product.into_iter().enumerate() {
            let wide = u128::from(part) << bits;
            placed[i] |= wide as u64;
            placed[i + 1] |= (wide >> 64) as u64;
        }

        let subtract = negative ^ nx ^ ny ^ nz;
        let mut carry = false;
        for (i, digit) in self.0[limb..].iter_mut().enumerate() {
            if i >= placed.len() && !carry {
                break;
            }
            let part = placed.get(i).copied().unwrap_or(0);
            (*digit, carry) = if subtract {
                digit.borrowing_sub(part, carry)
            } else {
                digit.carrying_add(part, carry)
            };
        }
    }

    fn is_negative(&self) -> bool {
        self.0[LIMBS - 1] >> 63 == 1
    }

    /// The sign.
    pub(super) fn sign(&self) -> Sign {
        if self.is_negative() { -1 } else { Sign::from(self.0.iter().any(|digit| *digit != 0)) }
    }

    /// The magnitude.
    pub(super) fn magnitude(&self) -> Magnitude {
        let mut digits = self.0;
        if self.is_negative() {
            let mut carry = true;
            for digit in &mut digits {
                (*digit, carry) = (!*digit).overflowing_add(u64::from(carry));
            }
        }
        let Some(top) = digits.iter().rposition(|digit| *digit != 0) else {
            return Magnitude::of(0, 0);
        };
        let below = if top == 0 { 0 } else { digits[top - 1] };
        Magnitude::of(u128::from(digits[top]) << 64 | u128::from(below), 64 * top as i32)
    }
}

/// A magnitude m·2^e, rounded: m in [2⁶³, 2⁶⁴], or 0.
#[derive(Clone, Copy)]
pub(super) struct Magnitude {
    m: f64,
    exponent: i32,
}

impl Magnitude {
    /// The magnitude of `digits`·2^`exponent`, up to a factor common to all.
    pub(super) fn of(digits: u128, exponent: i32) -> Self {
        let zeros = digits.leading_zeros();
        let m = (digits.checked_shl(zeros).unwrap_or(0) >> 64) as u64 as f64;
        Self { m, exponent: exponent - zeros as i32 }
    }

    /// p / q, within a few units in the last place; q is not 0.
    pub(super) fn quotient(p: Self, q: Self) -> f64 {
        libm::scalbn(p.m / q.m, p.exponent - q.exponent)
    }

    /// p times two to the power of `exponent`.
    pub(super) fn scaled(self, exponent: i32) -> Self {
        Self { exponent: self.exponent + exponent, ..self }
    }

    /// p / (p + q), within a few units in the last place; 0 if both are 0.
    pub(super) fn share(p: Self, q: Self) -> f64 {
        if p.m == 0.0 {
            return 0.0;
        }
        // 1 / (1 + q/p): a quotient outside f64's range is 0 or infinite, and the share 1 or 0.
        1.0 / (1.0 + libm::scalbn(q.m / p.m, q.exponent - p.exponent))
    }
}

/// A finite f64 as sign, integer and exponent of two: (negative, m, e), ±m·2^e.
pub(super) fn parts(value: f64) -> (bool, u64, i32) {
    let bits = value.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    (bits >> 63 == 1, mantissa, exponent.max(1) - 1 + EXPONENT_MIN)
}
