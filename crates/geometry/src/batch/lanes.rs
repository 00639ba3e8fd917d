//! Points and directions of many pairs of triangles, a lane each.

use crate::Corners;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

/// Single precision: a lane per pair.
pub(super) type Single<S> = <S as Simd>::f32s;

/// Yes or no, a lane per pair.
pub(super) type Mask<S> = <Single<S> as SimdBase<S>>::Mask;

/// Three coordinates, a lane per pair.
#[derive(Clone, Copy)]
pub(super) struct Vector<S: Simd>(pub(super) [Single<S>; 3]);

impl<S: Simd> Vector<S> {
    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([x - u, y - v, z - w])
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([x + u, y + v, z + w])
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Single<S> {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        x * u + y * v + z * w
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([y * w - z * v, z * u - x * w, x * v - y * u])
    }

    /// The greatest magnitude of its coordinates.
    #[inline(always)]
    pub(super) fn reach(self) -> Single<S> {
        let [x, y, z] = self.0;
        x.abs().max(y.abs()).max(z.abs())
    }

    /// In the lanes of `mask`, else `other`.
    #[inline(always)]
    pub(super) fn only(self, mask: Mask<S>, other: Self) -> Self {
        let ([x, y, z], [u, v, w]) = (self.0, other.0);
        Self([mask.select(x, u), mask.select(y, v), mask.select(z, w)])
    }
}

/// The corners of one triangle per lane, those that `number` of the lane says.
#[inline(always)]
pub(super) fn gather<S: Simd>(
    simd: S,
    triangles: &[Corners],
    number: impl Fn(usize) -> u32,
) -> [Vector<S>; 3] {
    let mut lanes = [Single::<S>::splat(simd, 0.0); 9];
    let mut start = 0;
    while start < Single::<S>::LEN {
        let row = |i: usize| triangles[number(start + i) as usize].as_flattened();
        let rows = [row(0), row(1), row(2), row(3)];
        let [c0, c1, c2, c3] = four(simd, rows, 0);
        let [c4, c5, c6, c7] = four(simd, rows, 4);
        let [.., c8] = four(simd, rows, 5);
        let columns = [c0, c1, c2, c3, c4, c5, c6, c7, c8];
        let mut k = 0;
        while k < 9 {
            lanes[k].as_mut_slice()[start..start + 4].copy_from_slice(columns[k].as_slice());
            k += 1;
        }
        start += 4;
    }
    let [ax, ay, az, bx, by, bz, cx, cy, cz] = lanes;
    [Vector([ax, ay, az]), Vector([bx, by, bz]), Vector([cx, cy, cz])]
}

/// Four columns from `at` on, of four rows.
#[inline(always)]
fn four<S: Simd>(simd: S, [p, q, r, s]: [&[f32]; 4], at: usize) -> [f32x4<S>; 4] {
    transposed([
        f32x4::from_slice(simd, &p[at..at + 4]),
        f32x4::from_slice(simd, &q[at..at + 4]),
        f32x4::from_slice(simd, &r[at..at + 4]),
        f32x4::from_slice(simd, &s[at..at + 4]),
    ])
}

/// Rows become columns.
#[inline(always)]
fn transposed<S: Simd>([p, q, r, s]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (even, odd) = (p.zip_low(r), q.zip_low(s));
    let (even_high, odd_high) = (p.zip_high(r), q.zip_high(s));
    [
        even.zip_low(odd),
        even.zip_high(odd),
        even_high.zip_low(odd_high),
        even_high.zip_high(odd_high),
    ]
}
