//! The exact triangle test of many pairs at once.
//!
//! A pair per lane in f32, relative to corners of its own, with a bound of all errors: of a car
//! crash that decides all but two in a thousand. Those, and every pair that touches, shares a
//! corner or lies in one plane, go to [`triangle::intersect`]. So the answer is the exact one, at
//! every width of the vectors.
//!
//! # Errors
//!
//! With u = 2⁻²⁴ and a₀, b₀ the first corners, the lanes know edges of A e = aᵢ − a₀, edges of B
//! f = R(bᵢ − b₀) and d = b₀ − a₀ in A's frame. Let La, Lb, Ld bound the magnitudes of their
//! coordinates.
//!
//! - e is off by u·La: one rounded difference of stored numbers.
//! - d is computed in f64, as [`RelativePose::point`] defines it, and rounded: off by u·Ld.
//! - f is off by 5¼ u·Lb: difference, R rounded, product, two sums; and ¼ u·Lb because the corners
//!   are defined by sums in f64, each off by 2⁻⁵¹ M with M = ρ·|b| + |t|, ρ the greatest sum of
//!   magnitudes of a row of R. Lb is ρ times the greatest coordinate of B's edges and 2⁻²⁴ M; M has
//!   a bit added, so that all sizes are beyond denormals and relative errors are what they say.
//! - A side of A's plane, (e₁ × e₂)·(d + f), is off by at most 80 u·La²(Lb + Ld); one of B's plane
//!   by 103 u·Lb²(La + Ld); 128 u allows for the bound's own rounding.
//! - The edge determinant (p × w)·q, with p between corners of A, q between corners of B, each as
//!   seen from its own first corner, and w from A to B, is off by 484 u·La·Lb(La + Lb + Ld); 512 u
//!   are allowed.
//! - Underflow adds less than 2⁻¹⁰⁰ while La + Lb + Ld ≤ 2⁴⁰, and nothing overflows there; beyond,
//!   all is in doubt.

mod lanes;
#[cfg(test)]
mod tests;

use crate::{Corners, RelativePose, Triangle, triangle};
use fearless_simd::Simd;
use fearless_simd::prelude::*;
use lanes::{Mask, Single, Vector, gather};

/// The most pairs that [`intersecting`] takes: the bits of its answer.
pub const BATCH: usize = 64;

/// The greatest sum of sizes (m) that is decided in f32: 2⁴⁰.
const SIZE_MAX: f32 = f32::from_bits((127 + 40) << 23);

/// More than all errors of underflow: 2⁻¹⁰⁰.
const UNDERFLOW: f32 = f32::from_bits((127 - 100) << 23);

/// Of a side of a plane: 128 u = 2⁻¹⁷.
const SIDE_ERROR: f32 = f32::from_bits((127 - 17) << 23);

/// Of an edge determinant: 512 u = 2⁻¹⁵.
const EDGE_ERROR: f32 = f32::from_bits((127 - 15) << 23);

/// The share of magnitudes in f64 that sizes in f32 are enlarged by: 2⁻²⁴.
const DOUBLE: f32 = f32::from_bits((127 - 24) << 23);

/// The stored triangles of two bodies, and where B stands.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pose: &'a RelativePose,
    a: &'a [Corners],
    b: &'a [Corners],
    /// The rotation, rounded.
    rotation: [[f32; 3]; 3],
    /// ρ and |t| (m): see the module.
    rotation_max: f32,
    translation_max: f32,
}

impl<'a> Batch<'a> {
    /// The triangles of A and of B, each in its own frame; B stands at `pose`.
    #[must_use]
    pub fn new(pose: &'a RelativePose, a: &'a [Corners], b: &'a [Corners]) -> Self {
        let up = |x: f64| (x * (1.0 + 1e-6)) as f32;
        let rows = pose.rotation.map(|[x, y, z]| x.abs() + y.abs() + z.abs());
        let offsets = pose.translation.map(f64::abs);
        Self {
            pose,
            a,
            b,
            rotation: pose.rotation.map(|row| row.map(|x| x as f32)),
            rotation_max: up(rows.into_iter().fold(1.0, f64::max)),
            translation_max: up(offsets.into_iter().fold(1e-20, f64::max)),
        }
    }

    /// The triangles of a pair as the exact test takes them, both in A's frame.
    #[must_use]
    pub fn triangles(&self, [a, b]: [u32; 2]) -> [Triangle; 2] {
        [Triangle::stored(&self.a[a as usize]), self.pose.triangle(&self.b[b as usize])]
    }

    /// The exact test of those `pairs` whose bit is set in `doubt`.
    #[cold]
    #[inline(never)]
    fn exactly(&self, pairs: &[[u32; 2]], mut doubt: u64) -> u64 {
        let mut hits = 0;
        while doubt != 0 {
            let i = doubt.trailing_zeros();
            let [a, b] = self.triangles(pairs[i as usize]);
            hits |= u64::from(triangle::intersect(&a, &b)) << i;
            doubt &= doubt - 1;
        }
        hits
    }
}

/// Which of the `pairs`, numbers of a triangle of A and one of B, intersect: bit i for pair i.
///
/// Exactly what [`triangle::intersect`] says of [`Batch::triangles`], whatever the order and
/// number of pairs. To be called from a function that is specialised for `S` already.
///
/// # Panics
///
/// There are more than [`BATCH`] pairs, or no triangle of such a number.
#[must_use]
#[inline(always)]
pub fn intersecting<S: Simd>(simd: S, batch: &Batch<'_>, pairs: &[[u32; 2]]) -> u64 {
    assert!(pairs.len() <= BATCH, "a batch of {} pairs", pairs.len());
    let Some(first) = pairs.first() else { return 0 };
    let mut padded = [*first; BATCH];
    padded[..pairs.len()].copy_from_slice(pairs);
    let lanes = Single::<S>::LEN;
    let (mut hits, mut doubt) = (0, 0);
    for start in (0..pairs.len()).step_by(lanes) {
        let [hit, open] = sifted(simd, batch, &padded[start..start + lanes]);
        hits |= hit << start;
        doubt |= open << start;
    }
    let given = u64::MAX >> (BATCH - pairs.len());
    (hits, doubt) = (hits & given, doubt & given);
    if doubt == 0 { hits } else { hits | batch.exactly(pairs, doubt) }
}

/// Of as many pairs as there are lanes: those that certainly intersect, and those in doubt.
#[inline(always)]
fn sifted<S: Simd>(simd: S, batch: &Batch<'_>, pairs: &[[u32; 2]]) -> [u64; 2] {
    let pairs = &pairs[..Single::<S>::LEN];
    let [a0, a1, a2] = gather(simd, batch.a, |lane| pairs[lane][0]);
    let (e1, e2) = (a1.minus(a0), a2.minus(a0));
    let size_a = e1.reach().max(e2.reach());

    let [b0, b1, b2] = gather(simd, batch.b, |lane| pairs[lane][1]);
    let (g1, g2) = (b1.minus(b0), b2.minus(b0));
    let edge_b = g1.reach().max(g2.reach());
    let magnitude = (b0.reach() + edge_b) * batch.rotation_max + batch.translation_max;
    let size_b = edge_b * batch.rotation_max + magnitude * DOUBLE;
    let d = between(batch.pose, a0, b0);
    let (f1, f2) = (turned(batch, g1), turned(batch, g2));
    let size_d = d.reach() + magnitude * DOUBLE;
    let size = size_a + size_b + size_d;
    let sound = size.simd_le(SIZE_MAX);

    let normal_a = e1.cross(e2);
    let to_b = normal_a.dot(d);
    let sides_b = [to_b, normal_a.dot(f1) + to_b, normal_a.dot(f2) + to_b];
    let bound_b = size_a * size_a * (size_b + size_d) * SIDE_ERROR + UNDERFLOW;
    let normal_b = f1.cross(f2);
    let to_a = normal_b.dot(d);
    let sides_a = [-to_a, normal_b.dot(e1) - to_a, normal_b.dot(e2) - to_a];
    let bound_a = size_b * size_b * (size_a + size_d) * SIDE_ERROR + UNDERFLOW;
    let apart = sound & (one_side(sides_a, bound_a) | one_side(sides_b, bound_b));
    if apart.all_true() {
        return [0, 0];
    }

    // As in `triangle::crossing`, but there each triangle is mirrored where it has to be; here B's
    // edges are exchanged if one alone is, and the signs turned if A is.
    let origin = e1.minus(e1);
    let a = Apex::of([origin, e1, e2], sides_a);
    let b = Apex::of([origin, f1, f2], sides_b);
    let (mirror_a, mirror_b) = (a.mirrored ^ b.below, b.mirrored ^ a.below);
    let crossed = mirror_a ^ mirror_b;
    let (qb, rb) = (b.r.only(crossed, b.q), b.q.only(crossed, b.r));
    let w = d.plus(b.p).minus(a.p);
    let i_to_k = a.q.minus(a.p).cross(w).dot(qb.minus(b.p));
    let l_to_j = a.r.minus(a.p).cross(w).dot(b.p.minus(rb));
    let most = mirror_a.select(-i_to_k.min(l_to_j), i_to_k.max(l_to_j));
    let bound = size_a * size_b * size * EDGE_ERROR + UNDERFLOW;
    let certain = !apart & sound & beyond(sides_a, bound_a) & beyond(sides_b, bound_b);
    let hit = certain & most.simd_lt(-bound);
    let decided = apart | hit | (certain & most.simd_gt(bound));
    [hit.to_bitmask(), (!decided).to_bitmask()]
}

/// Rotates a direction of B into A's frame, in f32.
#[inline(always)]
fn turned<S: Simd>(batch: &Batch<'_>, v: Vector<S>) -> Vector<S> {
    let ([x, y, z], [rx, ry, rz]) = (v.0, &batch.rotation);
    Vector([along(rx, x, y, z), along(ry, x, y, z), along(rz, x, y, z)])
}

#[inline(always)]
fn along<S: Simd, V: SimdFloat<S, Element = f32>>(r: &[f32; 3], x: V, y: V, z: V) -> V {
    x * r[0] + y * r[1] + z * r[2]
}

/// From corners of A to corners of B, in A's frame: [`RelativePose::point`] in f64, then rounded.
#[inline(always)]
fn between<S: Simd>(pose: &RelativePose, from: Vector<S>, to: Vector<S>) -> Vector<S> {
    let ([x, y, z], [u, v, w]) = (from.0, to.0);
    let ((u0, u1), (v0, v1), (w0, w1)) = (u.widen(), v.widen(), w.widen());
    let ((x0, x1), (y0, y1), (z0, z1)) = (x.widen(), y.widen(), z.widen());
    let low = |i: usize| moved(pose, i, u0, v0, w0);
    let high = |i: usize| moved(pose, i, u1, v1, w1);
    Vector([
        (low(0) - x0).narrow(high(0) - x1),
        (low(1) - y0).narrow(high(1) - y1),
        (low(2) - z0).narrow(high(2) - z1),
    ])
}

/// Coordinate `i` of [`RelativePose::point`].
#[inline(always)]
fn moved<S: Simd, V: SimdFloat<S, Element = f64>>(
    pose: &RelativePose,
    i: usize,
    x: V,
    y: V,
    z: V,
) -> V {
    let r = &pose.rotation[i];
    ((x * r[0] + y * r[1]) + z * r[2]) + pose.translation[i]
}

/// Where all three are certainly on one side of a plane.
#[inline(always)]
fn one_side<S: Simd, V: SimdFloat<S, Element = f32>>(sides: [V; 3], bound: V) -> V::Mask {
    let [p, q, r] = sides;
    p.min(q).min(r).simd_gt(bound) | p.max(q).max(r).simd_lt(-bound)
}

/// Where all three are certainly not on a plane.
#[inline(always)]
fn beyond<S: Simd, V: SimdFloat<S, Element = f32>>(sides: [V; 3], bound: V) -> V::Mask {
    let [p, q, r] = sides;
    p.abs().min(q.abs()).min(r.abs()).simd_gt(bound)
}

/// A triangle seen from the corner that is alone on its side of a plane.
struct Apex<S: Simd> {
    p: Vector<S>,
    /// The other two, in the triangle's own order unless `mirrored`.
    q: Vector<S>,
    r: Vector<S>,
    mirrored: Mask<S>,
    /// Whether it is alone on the negative side.
    below: Mask<S>,
}

impl<S: Simd> Apex<S> {
    #[inline(always)]
    fn of([p, q, r]: [Vector<S>; 3], [side_p, side_q, side_r]: [Single<S>; 3]) -> Self {
        let (above_p, above_q, above_r) =
            (side_p.simd_gt(0.0), side_q.simd_gt(0.0), side_r.simd_gt(0.0));
        let (p_is, r_is) =
            ((above_p ^ above_q) & (above_p ^ above_r), (above_p ^ above_r) & (above_q ^ above_r));
        Self {
            p: p.only(p_is, r.only(r_is, q)),
            q: q.only(p_is, p),
            r: q.only(r_is, r),
            mirrored: !(p_is | r_is),
            below: (above_p & above_q) | (above_r & (above_p | above_q)),
        }
    }
}
