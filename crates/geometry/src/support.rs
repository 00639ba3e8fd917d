//! Support values along the fixed set of directions in which contact is measured.
//!
//! D = 72 horizontal directions, every 5° from u (the direction of the relative velocity), and ±z
//! ([`Directions`]). A support is the greatest `x·d` over a set of points; merging takes the
//! maximum, so neither the order nor the number of times that points are added matters, not even
//! for the sign of a zero, which is always `+0.0`.

use crate::DVec3;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x4};

/// The number of directions: 72 horizontal ones and ±z.
pub const DIRECTIONS: usize = 74;

/// Half a turn, in steps of 5°.
const HALF: usize = 36;

/// +z; −z follows.
const UP: usize = 2 * HALF;

/// The directions in which contact is measured, as unit vectors in A's frame.
///
/// Index `i < 72` is the direction `5°·i` from u, turning from u towards t = z × u; 72 is +z and
/// 73 is −z. Each has its exact opposite: `d[i + 36] == -d[i]` for `i < 36`, and `d[73] == -d[72]`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Directions {
    /// Unit vectors in A's frame. Read-only: only [`Directions::around`] creates them.
    pub d: [DVec3; DIRECTIONS],
    /// The coordinates of the first half of the horizontal directions, for vector code.
    half: [[f64; HALF]; 3],
}

/// The greatest `x·d` (m) seen so far in each direction; negative infinity if there was none.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Supports(pub [f64; DIRECTIONS]);

impl Directions {
    /// The directions around the horizontal unit vector `u` and the upward unit vector `z`, both in
    /// A's frame. Sines and cosines come from `libm`.
    #[must_use]
    pub fn around(u: DVec3, z: DVec3) -> Self {
        let t = z.cross(u);
        let mut d = [z; DIRECTIONS];
        d[UP + 1] = -z;
        for i in 0..HALF {
            let (sin, cos) = libm::sincos((5.0 * i as f64).to_radians());
            d[i] = u * cos + t * sin;
            d[i + HALF] = -d[i];
        }
        let half = [0, 1, 2].map(|axis| core::array::from_fn(|i| d[i][axis]));
        Self { d, half }
    }
}

impl Supports {
    /// The supports of no points.
    pub const EMPTY: Self = Self([f64::NEG_INFINITY; DIRECTIONS]);

    /// Includes one point (m) in A's frame. A point with a NaN coordinate changes nothing.
    pub fn add(&mut self, directions: &Directions, point: DVec3) {
        let (ahead, rest) = self.0.split_at_mut(HALF);
        let (behind, vertical) = rest.split_at_mut(HALF);
        // `x·(−d)` is `−(x·d)` to the last bit, so half of the products serve both directions.
        for ((ahead, behind), d) in ahead.iter_mut().zip(behind).zip(&directions.d) {
            let x = point.dot(*d);
            raise(ahead, x);
            raise(behind, -x);
        }
        let x = point.dot(directions.d[UP]);
        raise(&mut vertical[0], x);
        raise(&mut vertical[1], -x);
    }

    /// Includes several points, with the same bits as [`Supports::add`] at every vector width. Call
    /// it from a function that is already specialised for `S`.
    #[inline(always)]
    pub fn add_all<S: Simd>(&mut self, simd: S, directions: &Directions, points: &[DVec3]) {
        let (ahead, rest) = self.0.split_at_mut(HALF);
        let (behind, vertical) = rest.split_at_mut(HALF);
        let [dx, dy, dz] = &directions.half;
        for start in (0..HALF).step_by(4) {
            let four = start..start + 4;
            let dx = f64x4::from_slice(simd, &dx[four.clone()]);
            let dy = f64x4::from_slice(simd, &dy[four.clone()]);
            let dz = f64x4::from_slice(simd, &dz[four.clone()]);
            let mut greatest = f64x4::from_slice(simd, &ahead[four.clone()]);
            let mut greatest_behind = f64x4::from_slice(simd, &behind[four.clone()]);
            for point in points {
                let x = (dx * point.x + dy * point.y) + dz * point.z;
                greatest = raised(greatest, x);
                greatest_behind = raised(greatest_behind, -x);
            }
            greatest.store_slice(&mut ahead[four.clone()]);
            greatest_behind.store_slice(&mut behind[four]);
        }
        for point in points {
            let x = point.dot(directions.d[UP]);
            raise(&mut vertical[0], x);
            raise(&mut vertical[1], -x);
        }
    }

    /// Includes everything that `other` includes.
    pub fn merge(&mut self, other: &Self) {
        for (support, more) in self.0.iter_mut().zip(&other.0) {
            raise(support, *more);
        }
    }
}

/// Raises a support to `x`, with −0 as +0: which of two zeros `f64::max` returns depends on the
/// machine.
fn raise(support: &mut f64, x: f64) {
    let x = x + 0.0;
    *support = if x > *support { x } else { *support };
}

/// Applies [`raise`] in each lane.
#[inline(always)]
fn raised<S: Simd>(support: f64x4<S>, x: f64x4<S>) -> f64x4<S> {
    let x = x + 0.0;
    x.simd_gt(support).select(x, support)
}

#[cfg(test)]
mod tests;
