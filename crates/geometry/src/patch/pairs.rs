//! Candidate pairs of triangles, and the test of which intersect: eight at a time, in any
//! combination.
//!
//! A triangle of one patch overlaps the boxes of only two or three triangles of the other, so
//! testing one against eight would leave most lanes empty. Here pairs are stored side by side, and
//! each lane loads both of its triangles: loading and placing them again costs less than empty
//! lanes.

use super::{Boxes, Close, LANES, Patch, Posed, Vector, eight, same};
use crate::lanes::{cross, dot, dot_and, gather, minus, only, plus, reach};
use crate::triangle;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};

/// With more pairs than this, it is time to sift them.
const FULL: usize = 512;

/// One triangle against a whole patch always fits in addition, and eight are stored at a time.
const PLACES: usize = FULL + LANES * super::ROOM + LANES;

/// Eight lanes.
const ALL: u64 = 0xff;

/// The greatest sum of sizes (m) that is decided in f32: 2⁴⁰.
const SIZE_MAX: f32 = f32::from_bits((127 + 40) << 23);

/// More than all underflow errors: 2⁻¹⁰⁰.
const UNDERFLOW: f32 = f32::from_bits((127 - 100) << 23);

/// The error bound of a side of a plane: 128 u = 2⁻¹⁷.
const SIDE_ERROR: f32 = f32::from_bits((127 - 17) << 23);

/// The error bound of an edge determinant: 512 u = 2⁻¹⁵.
const EDGE_ERROR: f32 = f32::from_bits((127 - 15) << 23);

/// Pairs whose boxes overlap, by the numbers of their triangles.
#[derive(Clone, Debug)]
pub struct Pairs {
    a: [u32; PLACES],
    b: [u32; PLACES],
    count: usize,
}

impl Default for Pairs {
    fn default() -> Self {
        Self { a: [0; PLACES], b: [0; PLACES], count: 0 }
    }
}

impl Pairs {
    /// The number of pairs.
    #[must_use]
    #[inline]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether the buffer cannot take more.
    #[must_use]
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count > FULL
    }

    /// Removes and returns all pairs: the triangles of A, and those of B in the same order.
    #[must_use]
    #[inline]
    pub fn drain(&mut self) -> [&[u32]; 2] {
        let count = core::mem::take(&mut self.count);
        [&self.a[..count], &self.b[..count]]
    }

    /// Adds the pairs of every triangle of A with those of the eight of B, from place `at` on,
    /// whose boxes overlap its own.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, a: &Patch, (b, at): (&Patch, usize)) {
        let boxes = Boxes { min: eight(simd, &b.min, at), max: eight(simd, &b.max, at) };
        let numbers = u32x8::from_slice(simd, &b.triangles[at..at + LANES]);
        let mut count = self.count;
        for (row, &triangle) in a.triangles().iter().enumerate() {
            let meeting = a.one_box(simd, row).meet(&boxes);
            let places = count..count + LANES;
            u32x8::splat(simd, triangle).store_slice(&mut self.a[places.clone()]);
            numbers.compress(meeting).store_slice(&mut self.b[places]);
            count += meeting.to_bitmask().count_ones() as usize;
        }
        self.count = count;
    }

    /// Keeps the pairs that intersect: exactly those for which [`triangle::intersect`] is true,
    /// given [`Posed::triangles`].
    ///
    /// Call it from a function that is already specialised for `S`.
    ///
    /// # Panics
    ///
    /// A triangle number is out of range.
    #[inline(always)]
    pub fn sift<S: Simd>(&mut self, simd: S, posed: &Posed<'_>, close: &Close) {
        let count = self.count;
        if count == 0 {
            return;
        }
        // The last pair is repeated, so that there are always eight.
        let (a, b) = (self.a[count - 1], self.b[count - 1]);
        u32x8::splat(simd, a).store_slice(&mut self.a[count..count + LANES]);
        u32x8::splat(simd, b).store_slice(&mut self.b[count..count + LANES]);
        let mut kept = 0;
        for at in (0..count).step_by(LANES) {
            let [mut hits, doubt] = self.eight(simd, posed, close, at);
            let there = ALL >> (LANES - LANES.min(count - at));
            let doubt = doubt.to_bitmask() & there;
            if doubt != 0 {
                hits |= mask32x8::from_bitmask(simd, self.exactly(posed, at, doubt));
            }
            // The write position never passes the read position.
            let (from, to) = (at..at + LANES, kept..kept + LANES);
            let (a, b) = (&mut self.a, &mut self.b);
            let of_a = u32x8::from_slice(simd, &a[from.clone()]);
            of_a.compress(hits).store_slice(&mut a[to.clone()]);
            let of_b = u32x8::from_slice(simd, &b[from]);
            of_b.compress(hits).store_slice(&mut b[to]);
            kept += (hits.to_bitmask() & there).count_ones() as usize;
        }
        self.count = kept;
    }

    /// Which of the undecided pairs intersect.
    #[cold]
    #[inline(never)]
    fn exactly(&self, posed: &Posed<'_>, at: usize, mut doubt: u64) -> u64 {
        let mut hits = 0;
        while doubt != 0 {
            let lane = doubt.trailing_zeros();
            let place = at + lane as usize;
            let [a, b] = posed.triangles([self.a[place], self.b[place]]);
            hits |= u64::from(triangle::intersect(&a, &b)) << lane;
            doubt &= doubt - 1;
        }
        hits
    }

    /// For the eight pairs from place `at` on: which certainly intersect, and which are undecided.
    #[inline(always)]
    pub(super) fn eight<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        close: &Close,
        at: usize,
    ) -> [mask32x8<S>; 2] {
        let (of_a, of_b) = (&self.a[at..at + LANES], &self.b[at..at + LANES]);
        let [a0, a1, a2]: [Vector<S>; 3] = gather(simd, posed.a, of_a);
        let (e1, e2) = (minus(a1, a0), minus(a2, a0));
        let corner_a = minus(a0, same(simd, &close.origin));
        let [b0, b1, b2]: [Vector<S>; 3] = gather(simd, posed.b, of_b);
        let (g1, g2) = (minus(b1, b0), minus(b2, b0));
        let placed = close.placed(simd, posed, b0, [g1, g2]);
        let [f1, f2] = placed.edges;
        let (size_a, size_b) = (extent([e1, e2]), close.size_b(posed, extent([g1, g2])));

        let d = minus(placed.corner, corner_a);
        let size_d = reach(d) + 0.5 * close.size;
        let size = size_a + size_b + size_d;
        let sound = size.simd_le(SIZE_MAX);

        let normal_a = cross(e1, e2);
        let to_b = dot(normal_a, d);
        let sides_b = [to_b, dot_and(normal_a, f1, to_b), dot_and(normal_a, f2, to_b)];
        let bound_b = size_a * size_a * (size_b + size_d) * SIDE_ERROR + UNDERFLOW;
        let normal_b = cross(f1, f2);
        let to_a = -dot(normal_b, d);
        let sides_a = [to_a, dot_and(normal_b, e1, to_a), dot_and(normal_b, e2, to_a)];
        let bound_a = size_b * size_b * (size_a + size_d) * SIDE_ERROR + UNDERFLOW;
        let apart = sound & (one_side(sides_a, bound_a) | one_side(sides_b, bound_b));

        // As in `triangle::crossing`, but there each triangle is mirrored where necessary; here B's
        // edges are exchanged if exactly one needs it, and the signs are flipped if A does.
        let origin = f32x8::splat(simd, 0.0);
        let apex_a = Apex::of([[origin; 3], e1, e2], sides_a);
        let apex_b = Apex::of([[origin; 3], f1, f2], sides_b);
        let (mirror_a, mirror_b) = (apex_a.mirrored ^ apex_b.below, apex_b.mirrored ^ apex_a.below);
        let crossed = mirror_a ^ mirror_b;
        let (p, q, r) = (apex_b.p, apex_b.q, apex_b.r);
        let (q, r) = (only(crossed, r, q), only(crossed, q, r));
        let w = minus(plus(d, p), apex_a.p);
        let i_to_k = dot(cross(minus(apex_a.q, apex_a.p), w), minus(q, p));
        let l_to_j = dot(cross(minus(apex_a.r, apex_a.p), w), minus(p, r));
        let most = mirror_a.select(-i_to_k.min(l_to_j), i_to_k.max(l_to_j));
        let bound = size_a * size_b * size * EDGE_ERROR + UNDERFLOW;
        let certain = sound & beyond(sides_a, bound_a) & beyond(sides_b, bound_b);
        let hit = !apart & certain & most.simd_lt(-bound);
        let decided = apart | hit | (certain & most.simd_gt(bound));
        [hit, !decided]
    }
}

/// The greatest coordinate magnitude of two edges.
#[inline(always)]
fn extent<S: Simd>([e, f]: [Vector<S>; 2]) -> f32x8<S> {
    reach(e).max(reach(f))
}

/// Where all three are certainly on one side of a plane.
#[inline(always)]
fn one_side<S: Simd>([p, q, r]: [f32x8<S>; 3], bound: f32x8<S>) -> mask32x8<S> {
    p.min(q).min(r).simd_gt(bound) | p.max(q).max(r).simd_lt(-bound)
}

/// Where all three are certainly not on a plane.
#[inline(always)]
fn beyond<S: Simd>([p, q, r]: [f32x8<S>; 3], bound: f32x8<S>) -> mask32x8<S> {
    p.abs().min(q.abs()).min(r.abs()).simd_gt(bound)
}

/// A triangle seen from the corner that is alone on its side of a plane.
struct Apex<S: Simd> {
    p: Vector<S>,
    /// The other two, in the triangle's own order unless `mirrored`.
    q: Vector<S>,
    r: Vector<S>,
    mirrored: mask32x8<S>,
    /// Whether the apex is alone on the negative side.
    below: mask32x8<S>,
}

impl<S: Simd> Apex<S> {
    #[inline(always)]
    fn of([p, q, r]: [Vector<S>; 3], [side_p, side_q, side_r]: [f32x8<S>; 3]) -> Self {
        let (above_p, above_q, above_r) =
            (side_p.simd_gt(0.0), side_q.simd_gt(0.0), side_r.simd_gt(0.0));
        let (p_is, r_is) =
            ((above_p ^ above_q) & (above_p ^ above_r), (above_p ^ above_r) & (above_q ^ above_r));
        Self {
            p: only(p_is, p, only(r_is, r, q)),
            q: only(p_is, q, p),
            r: only(r_is, q, r),
            mirrored: !(p_is | r_is),
            below: (above_p & above_q) | (above_r & (above_p | above_q)),
        }
    }
}
