//! Points and directions of many triangles, one per lane: three vectors of coordinates.
//!
//! Products are fused with sums where the processor supports it, so the last bits of a lane differ
//! from machine to machine. Nothing here decides a result: it only filters, with bounds on all
//! errors, and a fused product has one rounding less.

use crate::Corners;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8};

/// Coordinates (m) in single precision, one per lane.
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

/// `matrix · v`.
#[inline(always)]
pub fn rotated<S: Simd, V: Lanes<S>>(simd: S, rows: &[[f32; 3]; 3], v: [V; 3]) -> [V; 3] {
    let [p, q, r] = rows;
    [dot(splat(simd, p), v), dot(splat(simd, q), v), dot(splat(simd, r), v)]
}

/// The same vector in all lanes.
#[inline(always)]
fn splat<S: Simd, V: Lanes<S>>(simd: S, [x, y, z]: &[f32; 3]) -> [V; 3] {
    [V::splat(simd, *x), V::splat(simd, *y), V::splat(simd, *z)]
}

/// `row · v + last`.
#[inline(always)]
fn along<S: Simd, V: Lanes<S>>(simd: S, [p, q, r]: &[f32; 3], [x, y, z]: [V; 3], last: V) -> V {
    let (p, q, r) = (V::splat(simd, *p), V::splat(simd, *q), V::splat(simd, *r));
    z.mul_add(r, y.mul_add(q, x.mul_add(p, last)))
}

/// The corners of the eight triangles with these numbers.
///
/// # Panics
///
/// A number is out of range, or there are not eight numbers.
#[inline(always)]
pub fn gather<S: Simd>(simd: S, triangles: &[Corners], numbers: &[u32]) -> [[f32x8<S>; 3]; 3] {
    let row = |i: usize| triangles[numbers[i] as usize].as_flattened();
    let rows = [row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7)];
    let [ax, ay, az, bx] = columns(simd, &rows, 0);
    let [by, bz, cx, cy] = columns(simd, &rows, 4);
    let [.., cz] = columns(simd, &rows, 5);
    [[ax, ay, az], [bx, by, bz], [cx, cy, cz]]
}

/// Loads four columns, from `at` on, of eight rows.
#[inline(always)]
fn columns<S: Simd>(simd: S, rows: &[&[f32]; 8], at: usize) -> [f32x8<S>; 4] {
    let four = |i: usize| f32x4::from_slice(simd, &rows[i][at..at + 4]);
    let two = |i: usize| four(i).combine(four(i + 4));
    let [p, q, r, s] = [two(0), two(1), two(2), two(3)];
    let ([even, even_high], [odd, odd_high]) = (zip(simd, p, r), zip(simd, q, s));
    let ([a, b], [c, d]) = (zip(simd, even, odd), zip(simd, even_high, odd_high));
    [a, b, c, d]
}

/// Interleaves the elements of both: of the first halves of each half, and of the second halves.
///
/// This is a single instruction where a vector of eight is one register, but only there.
#[inline(always)]
#[cfg_attr(
    not(target_arch = "x86_64"),
    expect(unused_variables, reason = "of one instruction there")
)]
fn zip<S: Simd>(simd: S, p: f32x8<S>, q: f32x8<S>) -> [f32x8<S>; 2] {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{__m256, _mm256_unpackhi_ps, _mm256_unpacklo_ps};
        fearless_simd::kernel!(
            #[inline(always)]
            fn unpack(_simd: Avx2, p: __m256, q: __m256) -> [__m256; 2] {
                [_mm256_unpacklo_ps(p, q), _mm256_unpackhi_ps(p, q)]
            }
        );
        if let Some(avx2) = simd.level().as_avx2() {
            let here = |v: f32x8<S>| f32x8::simd_from(avx2, <[f32; 8]>::from(v)).into();
            let back = |v| f32x8::simd_from(simd, <[f32; 8]>::from(f32x8::simd_from(avx2, v)));
            return unpack(avx2, here(p), here(q)).map(back);
        }
    }
    let ((p, r), (q, s)) = (p.split(), q.split());
    [p.zip_low(q).combine(r.zip_low(s)), p.zip_high(q).combine(r.zip_high(s))]
}
