//! The exact triangle test of one triangle against eight: small patches of two bodies, made ready
//! in a frame close to both.
//!
//! A pair per lane in f32 with a bound of all errors: of a car crash that decides all but one in a
//! hundred. Those, and every pair that touches, shares a corner or lies in one plane, are for
//! [`triangle::intersect`]. So the answer is the exact one, at every width of the vectors.
//!
//! # Errors
//!
//! Places are counted in A's frame from the middle of a box around A's patch; B's patch is turned
//! about the middle of its own. Let u = 2⁻²⁴, M bound what is computed on the way in f64 (ρ|b| +
//! |t| with ρ the greatest sum of magnitudes of a row of R), and L bound all places, ρ times half
//! the extents of B's box, and 2⁻²³ M.
//!
//! - A place of A is off by uL: one rounded difference of stored numbers.
//! - A first corner of B is off by 8uL: the difference to the middle, R rounded, the product, two
//!   sums, the middle's own place, the last sum, and 2⁻⁵⁰ M, since [`RelativePose::point`] rounds
//!   too. The others are that and an edge: 20 uL.
//!
//! The lanes know edges of A e = aᵢ − a₀, edges of B f = R(bᵢ − b₀) and d = b₀ − a₀. Let La, Lb, Ld
//! bound the magnitudes of their coordinates.
//!
//! - e is off by u·La: one rounded difference of stored numbers.
//! - f is off by 5¼ u·Lb: difference, R rounded, product, two sums; and ¼ u·Lb because the corners
//!   are defined by sums in f64, each off by 2⁻⁵¹ M. Lb is ρ times the greatest coordinate of B's
//!   edges and 2⁻²⁴ M; M has a bit added, so that all sizes are beyond denormals and relative
//!   errors are what they say.
//! - d is off by 9½ uL: both places, of which ρ times half an extent and the middle's place are no
//!   more than L together, and their difference.
//! - A side of A's plane, (e₁ × e₂)·(d + f), is off by at most 80 u·La²(Lb + Ld) and 57 u·La²L; one
//!   of B's plane by 103 u·Lb²(La + Ld) and 57 u·Lb²L; 128 u are allowed, with L/2 added to Ld.
//! - The edge determinant (p × w)·q, with p between corners of A, q between corners of B, each as
//!   seen from its own first corner, and w from A to B, is off by 484 u·La·Lb(La + Lb + Ld) and
//!   228 u·La·Lb·L; 512 u are allowed, with L/2 added to Ld.
//! - Underflow adds less than 2⁻¹⁰⁰ while La + Lb + Ld ≤ 2⁴⁰, and nothing overflows there; beyond,
//!   all is in doubt.

#[cfg(test)]
mod tests;

use crate::lanes::{cross, dot, dot_and, gather, minus, only, plus, reach, turned};
use crate::{Aabb, Corners, DVec3, RelativePose, Triangle, triangle};
use core::ops::Range;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};

/// Triangles side by side.
pub const LANES: usize = 8;

/// The most triangles of a patch: the bits of a word.
pub const ROOM: usize = 64;

/// The greatest sum of sizes (m) that is decided in f32: 2⁴⁰.
const SIZE_MAX: f32 = f32::from_bits((127 + 40) << 23);

/// More than all errors of underflow: 2⁻¹⁰⁰.
const UNDERFLOW: f32 = f32::from_bits((127 - 100) << 23);

/// Of a side of a plane: 128 u = 2⁻¹⁷.
const SIDE_ERROR: f32 = f32::from_bits((127 - 17) << 23);

/// Of an edge determinant: 512 u = 2⁻¹⁵.
const EDGE_ERROR: f32 = f32::from_bits((127 - 15) << 23);

/// By how much boxes of B are enlarged, and slabs: 32 u = 2⁻¹⁹ times L.
const PLACE_ERROR: f32 = f32::from_bits((127 - 19) << 23);

/// The share of magnitudes in f64 that sizes in f32 are enlarged by: 2⁻²⁴.
const DOUBLE: f32 = f32::from_bits((127 - 24) << 23);

/// A point, edge or normal per lane.
pub type Vector<S> = [f32x8<S>; 3];

/// The stored triangles of two bodies, and where B stands.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    pose: &'a RelativePose,
    a: &'a [Corners],
    b: &'a [Corners],
    /// The rotation, rounded.
    rotation: [[f32; 3]; 3],
    /// ρ and |t| (m): see the module.
    rotation_max: f32,
    translation_max: f32,
}

impl<'a> Posed<'a> {
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

    /// The frame close to a patch in a box of A's frame and one in a box of B's.
    #[must_use]
    #[inline]
    pub fn close(&self, a: &Aabb, b: &Aabb) -> Close {
        let ((origin, half_a), (middle, half_b)) = (middle(a), middle(b));
        let from = self.pose.point(middle) - DVec3::from_array(origin.map(f64::from));
        let moved = from.to_array().map(|x| x as f32);
        let most = |[x, y, z]: [f32; 3]| x.abs().max(y.abs()).max(z.abs());
        let magnitude = (most(middle) + most(half_b)) * self.rotation_max + self.translation_max;
        let size_b = most(moved) + most(half_b) * self.rotation_max;
        // The last factor is for the rounding of all this.
        let size = most(half_a).max(size_b).max(2.0 * DOUBLE * magnitude) * 1.01;
        Close { origin, middle, moved, size, floor: magnitude * DOUBLE * 1.01 }
    }
}

/// The middle of a box and half its extents, both rounded.
#[inline]
fn middle(box_: &Aabb) -> ([f32; 3], [f32; 3]) {
    let Aabb { min: [u, v, w], max: [x, y, z] } = *box_;
    let half = |low: f32, high: f32| (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
    let ((x, p), (y, q), (z, r)) = (half(u, x), half(v, y), half(w, z));
    ([x, y, z], [p, q, r])
}

/// A frame close to two patches: A's, but with its origin in the middle of A's patch.
#[derive(Clone, Copy, Debug)]
pub struct Close {
    /// Its origin in A's frame (m).
    origin: [f32; 3],
    /// The middle of B's patch in B's frame, and here (m).
    middle: [f32; 3],
    moved: [f32; 3],
    /// L (m).
    size: f32,
    /// 2⁻²⁴ M (m).
    floor: f32,
}

impl Close {
    /// Its origin in A's frame (m).
    #[must_use]
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// How far (m) rounding moves a place here, that of boxes included.
    #[must_use]
    pub fn error(&self) -> f32 {
        self.size * PLACE_ERROR
    }

    /// A box of A's frame here, rounded.
    #[must_use]
    #[inline]
    pub fn of_a(&self, Aabb { min, max }: &Aabb) -> Aabb {
        let [x, y, z] = self.origin;
        Aabb {
            min: [min[0] - x, min[1] - y, min[2] - z],
            max: [max[0] - x, max[1] - y, max[2] - z],
        }
    }

    /// A box of this frame in A's, rounded.
    #[must_use]
    #[inline]
    pub fn to_a(&self, Aabb { min, max }: &Aabb) -> Aabb {
        let [x, y, z] = self.origin;
        Aabb {
            min: [min[0] + x, min[1] + y, min[2] + z],
            max: [max[0] + x, max[1] + y, max[2] + z],
        }
    }
}

/// Eight boxes.
#[derive(Clone, Copy)]
pub struct Boxes<S: Simd> {
    /// Least x, y, z (m).
    pub min: Vector<S>,
    /// Greatest x, y, z (m).
    pub max: Vector<S>,
}

/// Which triangles to take into a patch.
pub trait Choice<S: Simd> {
    /// Of eight triangles with these corners in boxes, those to take.
    fn of(&self, corners: &[Vector<S>; 3], boxes: &Boxes<S>) -> mask32x8<S>;
}

/// Triangles of one body side by side, in the close frame.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Their boxes; those behind the last triangle are empty.
    min: [Column; 3],
    max: [Column; 3],
    /// The first corner, the edges from it to the others, their product.
    corner: [Column; 3],
    edges: [[Column; 3]; 2],
    normal: [Column; 3],
    /// La or Lb.
    size: Column,
    triangles: [u32; PLACES],
    count: usize,
}

/// A coordinate of every triangle.
type Column = [f32; PLACES];

/// Eight are stored at once.
const PLACES: usize = ROOM + LANES;

/// A triangle, or eight, of a patch.
struct Ready<S: Simd> {
    corner: Vector<S>,
    edges: [Vector<S>; 2],
    normal: Vector<S>,
    size: f32x8<S>,
}

impl Default for Patch {
    fn default() -> Self {
        const ZERO: Column = [0.0; PLACES];
        Self {
            min: [ZERO; 3],
            max: [ZERO; 3],
            corner: [ZERO; 3],
            edges: [[ZERO; 3]; 2],
            normal: [ZERO; 3],
            size: ZERO,
            triangles: [0; PLACES],
            count: 0,
        }
    }
}

impl Patch {
    /// The triangles, in the order of their places.
    #[must_use]
    #[inline]
    pub fn triangles(&self) -> &[u32] {
        &self.triangles[..self.count]
    }

    /// Takes triangles of A: of those whose bit is set in `bits`, counted from number `first` on,
    /// the ones of that choice. Returns their boxes, spread over eight.
    ///
    /// # Panics
    ///
    /// There is no triangle of such a number.
    #[inline(always)]
    pub fn take_a<S: Simd>(
        &mut self,
        simd: S,
        (posed, close): (&Posed<'_>, &Close),
        (first, bits): (u32, u64),
        choice: &impl Choice<S>,
    ) -> Boxes<S> {
        let mut all = Boxes::nothing(simd);
        self.count = 0;
        let (numbers, count) = numbers(first, bits);
        let origin = same(simd, &close.origin);
        for from in (0..count).step_by(LANES) {
            let numbers = &numbers[from..from + LANES];
            let [a0, a1, a2]: [Vector<S>; 3] = gather(simd, posed.a, |lane| numbers[lane]);
            let corners = [minus(a0, origin), minus(a1, origin), minus(a2, origin)];
            let boxes = around(&corners);
            let chosen = choice.of(&corners, &boxes) & given(simd, count - from);
            if chosen.any_true() {
                let edges = [minus(a1, a0), minus(a2, a0)];
                let size = reach(edges[0]).max(reach(edges[1]));
                let ready =
                    Ready { corner: corners[0], edges, normal: cross(edges[0], edges[1]), size };
                all.include(&boxes.only(simd, chosen));
                self.put(simd, numbers, chosen, &boxes, &ready);
            }
        }
        self.close(simd);
        all
    }

    /// Takes triangles of B, likewise.
    ///
    /// # Panics
    ///
    /// There is no triangle of such a number.
    #[inline(always)]
    pub fn take_b<S: Simd>(
        &mut self,
        simd: S,
        (posed, close): (&Posed<'_>, &Close),
        (first, bits): (u32, u64),
        choice: &impl Choice<S>,
    ) -> Boxes<S> {
        let mut all = Boxes::nothing(simd);
        self.count = 0;
        let (numbers, count) = numbers(first, bits);
        let (middle, moved) = (same(simd, &close.middle), same(simd, &close.moved));
        let error = f32x8::splat(simd, close.error());
        let (rotation, none) = (&posed.rotation, same(simd, &[0.0; 3]));
        for from in (0..count).step_by(LANES) {
            let numbers = &numbers[from..from + LANES];
            let [b0, b1, b2]: [Vector<S>; 3] = gather(simd, posed.b, |lane| numbers[lane]);
            let (g1, g2) = (minus(b1, b0), minus(b2, b0));
            let edges = [turned(simd, rotation, g1, none), turned(simd, rotation, g2, none)];
            let corner = turned(simd, rotation, minus(b0, middle), moved);
            let corners = [corner, plus(corner, edges[0]), plus(corner, edges[1])];
            let boxes = around(&corners).enlarged(error);
            let chosen = choice.of(&corners, &boxes) & given(simd, count - from);
            if chosen.any_true() {
                let size = reach(g1).max(reach(g2)) * posed.rotation_max + close.floor;
                let ready = Ready { corner, edges, normal: cross(edges[0], edges[1]), size };
                all.include(&boxes.only(simd, chosen));
                self.put(simd, numbers, chosen, &boxes, &ready);
            }
        }
        self.close(simd);
        all
    }

    /// Puts those of eight triangles that are chosen behind the others.
    #[inline(always)]
    fn put<S: Simd>(
        &mut self,
        simd: S,
        numbers: &[u32],
        chosen: mask32x8<S>,
        boxes: &Boxes<S>,
        ready: &Ready<S>,
    ) {
        let at = self.count..self.count + LANES;
        for axis in 0..3 {
            let at = at.clone();
            boxes.min[axis].compress(chosen).store_slice(&mut self.min[axis][at.clone()]);
            boxes.max[axis].compress(chosen).store_slice(&mut self.max[axis][at.clone()]);
            let (e, f) = (ready.edges[0][axis], ready.edges[1][axis]);
            e.compress(chosen).store_slice(&mut self.edges[0][axis][at.clone()]);
            f.compress(chosen).store_slice(&mut self.edges[1][axis][at.clone()]);
            ready.corner[axis].compress(chosen).store_slice(&mut self.corner[axis][at.clone()]);
            ready.normal[axis].compress(chosen).store_slice(&mut self.normal[axis][at]);
        }
        ready.size.compress(chosen).store_slice(&mut self.size[at.clone()]);
        let numbers = u32x8::from_slice(simd, numbers);
        numbers.compress(chosen).store_slice(&mut self.triangles[at]);
        self.count += chosen.to_bitmask().count_ones() as usize;
    }

    /// Makes what follows the last triangle meet nothing.
    #[inline(always)]
    fn close<S: Simd>(&mut self, simd: S) {
        let (nothing, at) = (Boxes::nothing(simd), self.count..self.count + LANES);
        for axis in 0..3 {
            nothing.min[axis].store_slice(&mut self.min[axis][at.clone()]);
            nothing.max[axis].store_slice(&mut self.max[axis][at.clone()]);
        }
    }

    /// The places whose boxes meet one box: bit i for place i.
    #[inline(always)]
    pub fn meeting<S: Simd>(&self, simd: S, one: &Boxes<S>) -> u64 {
        let mut meeting = 0;
        for at in (0..self.count).step_by(LANES) {
            let boxes = Boxes { min: eight(simd, &self.min, at), max: eight(simd, &self.max, at) };
            meeting |= one.meet(&boxes).to_bitmask() << at;
        }
        meeting
    }

    /// The box of the triangle in a place, eight times.
    #[inline(always)]
    pub fn one_box<S: Simd>(&self, simd: S, place: usize) -> Boxes<S> {
        Boxes { min: one(simd, &self.min, place), max: one(simd, &self.max, place) }
    }

    /// The triangle in a place, eight times.
    #[inline(always)]
    fn one<S: Simd>(&self, simd: S, place: usize) -> Ready<S> {
        Ready {
            corner: one(simd, &self.corner, place),
            edges: [one(simd, &self.edges[0], place), one(simd, &self.edges[1], place)],
            normal: one(simd, &self.normal, place),
            size: f32x8::splat(simd, self.size[place]),
        }
    }

    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, at: usize) -> Ready<S> {
        Ready {
            corner: eight(simd, &self.corner, at),
            edges: [eight(simd, &self.edges[0], at), eight(simd, &self.edges[1], at)],
            normal: eight(simd, &self.normal, at),
            size: f32x8::from_slice(simd, &self.size[at..at + LANES]),
        }
    }
}

/// Which of the eight triangles of B from place `at` on, of those whose bit is set in `asked`,
/// intersect A's triangle in place `row`: exactly what [`triangle::intersect`] says of
/// [`Posed::triangles`].
///
/// To be called from a function that is specialised for `S` already.
#[must_use]
#[inline(always)]
pub fn meet<S: Simd>(
    simd: S,
    (posed, close): (&Posed<'_>, &Close),
    (a, row): (&Patch, usize),
    (b, at): (&Patch, usize),
    asked: u64,
) -> u64 {
    let [hits, doubt] = sift(simd, close, (a, row), (b, at), asked);
    if doubt == 0 {
        return hits;
    }
    hits | exactly(posed, a.triangles[row], &b.triangles[at..at + LANES], doubt)
}

/// Which of those in doubt intersect, of one triangle of A and eight of B.
#[cold]
#[inline(never)]
fn exactly(posed: &Posed<'_>, a: u32, eight: &[u32], mut doubt: u64) -> u64 {
    let mut hits = 0;
    while doubt != 0 {
        let lane = doubt.trailing_zeros();
        let [a, b] = posed.triangles([a, eight[lane as usize]]);
        hits |= u64::from(triangle::intersect(&a, &b)) << lane;
        doubt &= doubt - 1;
    }
    hits
}

/// Tells all intersecting pairs of some triangles of A and some of B, at most [`ROOM`] each, all
/// of them with all.
///
/// To be called from a function that is specialised for `S` already.
///
/// # Panics
///
/// There is no triangle of such a number, or there are too many.
#[inline(always)]
pub fn meet_all<S: Simd>(
    simd: S,
    posed: &Posed<'_>,
    [patch_a, patch_b]: &mut [Patch; 2],
    (a, b): (Range<u32>, Range<u32>),
    hit: &mut dyn FnMut([u32; 2]),
) {
    let bits = |range: &Range<u32>| {
        assert!(range.len() <= ROOM, "a patch of {} triangles", range.len());
        u64::MAX.checked_shr((ROOM - range.len()) as u32).unwrap_or(0)
    };
    let around = |of: &[Corners], range: &Range<u32>| {
        let boxes = of[range.start as usize..range.end as usize].iter().map(Aabb::of);
        boxes.fold(Aabb::EMPTY, |all, one| all.union(&one))
    };
    let (box_a, box_b) = (around(posed.a, &a), around(posed.b, &b));
    if box_a.is_empty() || box_b.is_empty() {
        return;
    }
    let close = posed.close(&box_a, &box_b);
    patch_a.take_a(simd, (posed, &close), (a.start, bits(&a)), &All(simd));
    patch_b.take_b(simd, (posed, &close), (b.start, bits(&b)), &All(simd));
    for row in 0..patch_a.count {
        let meeting = patch_b.meeting(simd, &patch_a.one_box(simd, row));
        for at in (0..patch_b.count).step_by(LANES) {
            let asked = meeting >> at & 0xff;
            let (a, b) = ((&*patch_a, row), (&*patch_b, at));
            let mut hits = meet(simd, (posed, &close), a, b, asked);
            while hits != 0 {
                let lane = at + hits.trailing_zeros() as usize;
                hit([patch_a.triangles[row], patch_b.triangles[lane]]);
                hits &= hits - 1;
            }
        }
    }
}

/// Takes every triangle.
struct All<S: Simd>(S);

impl<S: Simd> Choice<S> for All<S> {
    #[inline(always)]
    fn of(&self, _: &[Vector<S>; 3], _: &Boxes<S>) -> mask32x8<S> {
        mask32x8::splat(self.0, true)
    }
}

/// Of A's triangle in place `row` and those of the eight of B from place `at` on whose bit is set
/// in `asked`: which pairs certainly intersect, and which are in doubt.
#[inline(always)]
fn sift<S: Simd>(
    simd: S,
    close: &Close,
    (a, row): (&Patch, usize),
    (b, at): (&Patch, usize),
    asked: u64,
) -> [u64; 2] {
    let (a, b) = (a.one(simd, row), b.eight(simd, at));
    let ([e1, e2], [f1, f2]) = (a.edges, b.edges);
    let d = minus(b.corner, a.corner);
    let size_d = reach(d) + 0.5 * close.size;
    let size = a.size + b.size + size_d;
    let sound = size.simd_le(SIZE_MAX);

    let to_b = dot(a.normal, d);
    let sides_b = [to_b, dot_and(a.normal, f1, to_b), dot_and(a.normal, f2, to_b)];
    let bound_b = a.size * a.size * (b.size + size_d) * SIDE_ERROR + UNDERFLOW;
    let to_a = -dot(b.normal, d);
    let sides_a = [to_a, dot_and(b.normal, e1, to_a), dot_and(b.normal, e2, to_a)];
    let bound_a = b.size * b.size * (a.size + size_d) * SIDE_ERROR + UNDERFLOW;
    let apart = sound & (one_side(sides_a, bound_a) | one_side(sides_b, bound_b));
    let asked = asked & !apart.to_bitmask();
    if asked == 0 {
        return [0, 0];
    }

    // As in `triangle::crossing`, but there each triangle is mirrored where it has to be; here B's
    // edges are exchanged if one alone is, and the signs turned if A is.
    let origin = f32x8::splat(simd, 0.0);
    let corner_a = Apex::of([[origin; 3], e1, e2], sides_a);
    let corner_b = Apex::of([[origin; 3], f1, f2], sides_b);
    let (mirror_a, mirror_b) =
        (corner_a.mirrored ^ corner_b.below, corner_b.mirrored ^ corner_a.below);
    let crossed = mirror_a ^ mirror_b;
    let (p, q, r) = (corner_b.p, corner_b.q, corner_b.r);
    let (q, r) = (only(crossed, r, q), only(crossed, q, r));
    let w = minus(plus(d, p), corner_a.p);
    let i_to_k = dot(cross(minus(corner_a.q, corner_a.p), w), minus(q, p));
    let l_to_j = dot(cross(minus(corner_a.r, corner_a.p), w), minus(p, r));
    let most = mirror_a.select(-i_to_k.min(l_to_j), i_to_k.max(l_to_j));
    let bound = a.size * b.size * size * EDGE_ERROR + UNDERFLOW;
    let certain = sound & beyond(sides_a, bound_a) & beyond(sides_b, bound_b);
    let hit = certain & most.simd_lt(-bound);
    let decided = hit | (certain & most.simd_gt(bound));
    [asked & hit.to_bitmask(), asked & !decided.to_bitmask()]
}

/// The numbers of the bits that are set, from `first` on, and how many there are; the rest of the
/// last eight has some number that is there.
#[inline(always)]
fn numbers(first: u32, mut bits: u64) -> ([u32; ROOM], usize) {
    let mut numbers = [first + bits.trailing_zeros() % ROOM as u32; ROOM];
    let count = bits.count_ones() as usize;
    for number in &mut numbers[..count] {
        *number = first + bits.trailing_zeros();
        bits &= bits - 1;
    }
    (numbers, count)
}

/// The first so many of eight lanes.
#[inline(always)]
fn given<S: Simd>(simd: S, count: usize) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, 0xff >> (LANES - count.min(LANES)))
}

/// Three coordinates of the same point eight times.
#[inline(always)]
pub fn same<S: Simd>(simd: S, [x, y, z]: &[f32; 3]) -> Vector<S> {
    [f32x8::splat(simd, *x), f32x8::splat(simd, *y), f32x8::splat(simd, *z)]
}

#[inline(always)]
fn one<S: Simd>(simd: S, [x, y, z]: &[Column; 3], place: usize) -> Vector<S> {
    same(simd, &[x[place], y[place], z[place]])
}

#[inline(always)]
fn eight<S: Simd>(simd: S, [x, y, z]: &[Column; 3], at: usize) -> Vector<S> {
    let at = at..at + LANES;
    [
        f32x8::from_slice(simd, &x[at.clone()]),
        f32x8::from_slice(simd, &y[at.clone()]),
        f32x8::from_slice(simd, &z[at]),
    ]
}

/// The box of three corners.
#[inline(always)]
fn around<S: Simd>([p, q, r]: &[Vector<S>; 3]) -> Boxes<S> {
    Boxes {
        min: [p[0].min(q[0]).min(r[0]), p[1].min(q[1]).min(r[1]), p[2].min(q[2]).min(r[2])],
        max: [p[0].max(q[0]).max(r[0]), p[1].max(q[1]).max(r[1]), p[2].max(q[2]).max(r[2])],
    }
}

impl<S: Simd> Boxes<S> {
    /// Eight times the same.
    #[inline(always)]
    pub fn splat(simd: S, box_: &Aabb) -> Self {
        Self { min: same(simd, &box_.min), max: same(simd, &box_.max) }
    }

    /// Eight times nothing.
    #[inline(always)]
    pub fn nothing(simd: S) -> Self {
        Self::splat(simd, &Aabb::EMPTY)
    }

    /// Larger by `margin` on all sides.
    #[inline(always)]
    fn enlarged(&self, margin: f32x8<S>) -> Self {
        let Self { min: [u, v, w], max: [x, y, z] } = *self;
        Self {
            min: [u - margin, v - margin, w - margin],
            max: [x + margin, y + margin, z + margin],
        }
    }

    /// Nothing in the other lanes.
    #[inline(always)]
    fn only(&self, simd: S, lanes: mask32x8<S>) -> Self {
        let Self { min: none_min, max: none_max } = Self::nothing(simd);
        Self { min: only(lanes, self.min, none_min), max: only(lanes, self.max, none_max) }
    }

    /// Lane by lane the box of both.
    #[inline(always)]
    fn include(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// The box of all lanes.
    #[inline(always)]
    pub fn all(&self) -> Aabb {
        let ([u, v, w], [x, y, z]) = (self.min, self.max);
        Aabb {
            min: [u.reduce_min(), v.reduce_min(), w.reduce_min()],
            max: [x.reduce_max(), y.reduce_max(), z.reduce_max()],
        }
    }

    /// Which meet the other's in the same lane. Comparisons with NaN are false.
    #[inline(always)]
    pub fn meet(&self, other: &Self) -> mask32x8<S> {
        let x = self.min[0].simd_le(other.max[0]) & other.min[0].simd_le(self.max[0]);
        let y = self.min[1].simd_le(other.max[1]) & other.min[1].simd_le(self.max[1]);
        let z = self.min[2].simd_le(other.max[2]) & other.min[2].simd_le(self.max[2]);
        x & y & z
    }
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
    /// Whether it is alone on the negative side.
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
