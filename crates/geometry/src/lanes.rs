//! Points and directions of many triangles, a lane each: three vectors of coordinates.
//!
//! Products are fused with sums where the processor does that, so the last bits of a lane differ
//! from machine to machine. Nothing here is an answer: it filters, with bounds of all errors, and a
//! fused product has one rounding less.

use crate::Corners;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

/// Coordinates (m) in single precision, a lane each.
pub trait Lanes<S: Simd>: SimdFloat<S, Element = f32> {}

impl<S: Simd, V: SimdFloat<S, Element = f32>> Lanes<S> for V {}

/// `a − b`.
#[inline(always)]
pub fn minus<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> [V; 3] {
    [x - u, y - v, z - w]
}

/// `a + b`.
#[inline(always)]
pub fn plus<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> [V; 3] {
    [x + u, y + v, z + w]
}

/// `a · b`.
#[inline(always)]
pub fn dot<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> V {
    z.mul_add(w, y.mul_add(v, x * u))
}

/// `a · b + last`.
#[inline(always)]
pub fn dot_and<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3], [u, v, w]: [V; 3], last: V) -> V {
    z.mul_add(w, y.mul_add(v, x.mul_add(u, last)))
}

/// `a × b`.
#[inline(always)]
pub fn cross<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> [V; 3] {
    [y.mul_sub(w, z * v), z.mul_sub(u, x * w), x.mul_sub(v, y * u)]
}

/// The greatest magnitude of the coordinates.
#[inline(always)]
pub fn reach<S: Simd, V: Lanes<S>>([x, y, z]: [V; 3]) -> V {
    x.abs().max(y.abs()).max(z.abs())
}

/// `a` in the lanes of `mask`, else `b`.
#[inline(always)]
pub fn only<S: Simd, V: Lanes<S>>(mask: V::Mask, [x, y, z]: [V; 3], [u, v, w]: [V; 3]) -> [V; 3] {
    [mask.select(x, u), mask.select(y, v), mask.select(z, w)]
}

/// `matrix · v + last`.
#[inline(always)]
pub fn turned<S: Simd, V: Lanes<S>>(
    simd: S,
    [p, q, r]: &[[f32; 3]; 3],
    v: [V; 3],
    [x, y, z]: [V; 3],
) -> [V; 3] {
    [along(simd, p, v, x), along(simd, q, v, y), along(simd, r, v, z)]
}

/// `row · v + last`.
#[inline(always)]
fn along<S: Simd, V: Lanes<S>>(simd: S, [p, q, r]: &[f32; 3], [x, y, z]: [V; 3], last: V) -> V {
    let (p, q, r) = (V::splat(simd, *p), V::splat(simd, *q), V::splat(simd, *r));
    z.mul_add(r, y.mul_add(q, x.mul_add(p, last)))
}

/// The corners of one triangle per lane, those that `number` of the lane says.
///
/// # Panics
///
/// There is no triangle of such a number.
#[inline(always)]
pub fn gather<S: Simd, V: Lanes<S>>(
    simd: S,
    triangles: &[Corners],
    number: impl Fn(usize) -> u32,
) -> [[V; 3]; 3] {
    let mut lanes = [V::splat(simd, 0.0); 9];
    let mut start = 0;
    while start < V::LEN {
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
    [[ax, ay, az], [bx, by, bz], [cx, cy, cz]]
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
