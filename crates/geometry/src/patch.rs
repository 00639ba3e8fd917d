//! The exact triangle test for eight pairs at once: small patches of two bodies, in a frame close
//! to both, and those pairs of their triangles whose boxes overlap there ([`Pairs`]).
//!
//! Each lane tests one pair in f32 with a bound on all errors: in a car crash this decides all but
//! one pair in a hundred. The rest, and every pair that touches, shares a corner or lies in one
//! plane, go to [`crate::triangle::intersect`]. So the result is exact at every vector width.
//!
//! # Errors
//!
//! Positions are measured in A's frame from the middle of a box around A's patch; B's patch is
//! rotated about the middle of its own box. Let u = 2⁻²⁴, M bound the intermediate values in f64
//! (ρ|b| + |t| with ρ the greatest sum of magnitudes of a row of R), and L bound all positions, ρ
//! times half the extents of B's box, and 2⁻²³ M.
//!
//! - A position of A is off by uL: one rounded difference of stored numbers.
//! - A first corner of B is off by 8uL: the difference to the middle, R rounded, the product, two
//!   sums, the middle's own position, the last sum, and 2⁻⁵⁰ M, since [`RelativePose::point`]
//!   rounds too. The other corners add an edge to that: 20 uL.
//!
//! The lanes hold edges of A e = aᵢ − a₀, edges of B f = R(bᵢ − b₀) and d = b₀ − a₀. Let La, Lb, Ld
//! bound the magnitudes of their coordinates.
//!
//! - e is off by u·La: one rounded difference of stored numbers.
//! - f is off by 5¼ u·Lb: difference, R rounded, product, two sums; and ¼ u·Lb because the corners
//!   are defined by sums in f64, each off by 2⁻⁵¹ M. Lb is ρ times the greatest coordinate of B's
//!   edges and 2⁻²⁴ M; M is slightly enlarged, so that all sizes are above the denormal range and
//!   the relative error bounds hold.
//! - d is off by 9½ uL: both positions, of which ρ times half an extent and the middle's position
//!   are no more than L together, and their difference.
//! - A side of A's plane, (e₁ × e₂)·(d + f), is off by at most 80 u·La²(Lb + Ld) and 57 u·La²L; one
//!   of B's plane by 103 u·Lb²(La + Ld) and 57 u·Lb²L; 128 u are allowed, with L/2 added to Ld.
//! - The edge determinant (p × w)·q, with p between corners of A, q between corners of B, each as
//!   seen from its own first corner, and w from A to B, is off by 484 u·La·Lb(La + Lb + Ld) and
//!   228 u·La·Lb·L; 512 u are allowed, with L/2 added to Ld.
//! - Underflow adds less than 2⁻¹⁰⁰ while La + Lb + Ld ≤ 2⁴⁰, and nothing overflows there; beyond
//!   that, every pair is undecided.

mod boxes;
mod one;
mod pairs;
mod places;
mod swept;
#[cfg(test)]
mod tests;

use crate::lanes::{gather, minus, plus, rotated, turned};
use crate::simd::prefetch;
use crate::{Aabb, Corners, DVec3, RelativePose, Triangle};
use core::ops::Range;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};

pub use boxes::Boxes;
pub use one::{OneBox, side_by_side};
pub use pairs::Pairs;
pub use places::{Places, WORDS};
pub use swept::{Inverse, SweptPairs, Window, down, travels, up};

/// Triangles per vector.
pub const LANES: usize = 8;

/// The maximum number of triangles of a patch.
pub const ROOM: usize = 128;

/// The amount by which boxes of B, and slabs, are enlarged: 32 u = 2⁻¹⁹ times L.
const PLACE_ERROR: f32 = f32::from_bits((127 - 19) << 23);

/// The share of f64 magnitudes by which f32 sizes are enlarged: 2⁻²⁴.
const DOUBLE: f32 = f32::from_bits((127 - 24) << 23);

/// A point, edge or normal per lane.
pub type Vector<S> = [f32x8<S>; 3];

/// The stored triangles of two bodies, and the pose of B.
#[derive(Clone, Copy, Debug)]
pub struct Posed<'a> {
    pose: &'a RelativePose,
    a: &'a [Corners],
    b: &'a [Corners],
    /// The rotation, rounded.
    rotation: [[f32; 3]; 3],
    /// ρ and |t| (m): see the module documentation.
    rotation_max: f32,
    translation_max: f32,
}

impl<'a> Posed<'a> {
    /// The triangles of A and of B, each in its own frame; `pose` is that of B.
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

    /// The triangles of a pair as input to the exact test, both in A's frame.
    #[must_use]
    pub fn triangles(&self, [a, b]: [u32; 2]) -> [Triangle; 2] {
        [Triangle::stored(&self.a[a as usize]), self.pose.triangle(&self.b[b as usize])]
    }

    /// The frame close to two patches: one in a box of A's frame and one in a box of B's.
    #[must_use]
    #[inline(always)]
    pub fn close(&self, a: &Aabb, b: &Aabb) -> Close {
        let ((origin, half_a), (middle, half_b)) = (middle(a), middle(b));
        let from = self.pose.point(middle) - DVec3::from_array(origin.map(f64::from));
        let moved = from.to_array().map(|x| x as f32);
        let most = |[x, y, z]: [f32; 3]| greater(greater(x.abs(), y.abs()), z.abs());
        let magnitude = (most(middle) + most(half_b)) * self.rotation_max + self.translation_max;
        let size_b = most(moved) + most(half_b) * self.rotation_max;
        // The last factor covers the rounding of this computation.
        let size = greater(greater(most(half_a), size_b), 2.0 * DOUBLE * magnitude) * 1.01;
        Close { origin, middle, moved, size, floor: magnitude * DOUBLE * 1.01 }
    }
}

/// The greater of two numbers. The standard library's `max` also checks for NaN.
#[inline(always)]
fn greater(x: f32, y: f32) -> f32 {
    if x > y { x } else { y }
}

/// The middle of a box and half its extents, both rounded.
#[inline(always)]
fn middle(box_: &Aabb) -> ([f32; 3], [f32; 3]) {
    let Aabb { min: [u, v, w], max: [x, y, z] } = *box_;
    let half = |low: f32, high: f32| (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
    let ((x, p), (y, q), (z, r)) = (half(u, x), half(v, y), half(w, z));
    ([x, y, z], [p, q, r])
}

/// A frame close to two patches: A's axes, with the origin in the middle of A's patch.
#[derive(Clone, Copy, Debug)]
pub struct Close {
    /// The origin in A's frame (m).
    origin: [f32; 3],
    /// The middle of B's patch in B's frame, and in this frame (m).
    middle: [f32; 3],
    moved: [f32; 3],
    /// L (m).
    size: f32,
    /// 2⁻²⁴ M (m).
    floor: f32,
}

impl Close {
    /// The origin in A's frame (m).
    #[must_use]
    #[inline]
    pub fn origin(&self) -> [f32; 3] {
        self.origin
    }

    /// The distance (m) by which rounding moves a position in this frame, including that of boxes.
    #[must_use]
    pub fn error(&self) -> f32 {
        self.size * PLACE_ERROR
    }

    /// Triangles of B in this frame, from their first corners and the edges from there in B's
    /// frame.
    #[inline(always)]
    fn placed<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        corner: Vector<S>,
        [g, h]: [Vector<S>; 2],
    ) -> Placed<S> {
        let rotation = &posed.rotation;
        let from_middle = minus(corner, same(simd, &self.middle));
        Placed {
            corner: turned(simd, rotation, from_middle, same(simd, &self.moved)),
            edges: [rotated(simd, rotation, g), rotated(simd, rotation, h)],
        }
    }

    /// Lb of triangles of B whose edges, in B's frame, have no coordinate greater than `extent`.
    #[inline(always)]
    fn size_b<S: Simd>(&self, posed: &Posed<'_>, extent: f32x8<S>) -> f32x8<S> {
        extent * posed.rotation_max + self.floor
    }
}

/// Selects the triangles that are added to a patch.
pub trait Choice<S: Simd> {
    /// Returns which of eight triangles, with these corners and boxes, to add.
    fn of(&self, corners: &[Vector<S>; 3], boxes: &Boxes<S>) -> mask32x8<S>;
}

/// Triangles of one body, with their boxes in the close frame in column layout.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Entries after the last triangle are empty.
    min: [Column; 3],
    max: [Column; 3],
    triangles: [u32; PLACES],
    count: usize,
    /// Triangles to be examined; the up to eight entries after the last one hold some valid number.
    wanted: [u32; PLACES],
    wanted_count: usize,
}

/// A coordinate of every triangle.
type Column = [f32; PLACES];

/// Eight are stored at a time.
const PLACES: usize = ROOM + LANES;

/// Eight triangles of B in the close frame.
struct Placed<S: Simd> {
    corner: Vector<S>,
    /// Edges from there to the other two corners.
    edges: [Vector<S>; 2],
}

impl Default for Patch {
    fn default() -> Self {
        const ZERO: Column = [0.0; PLACES];
        Self {
            min: [ZERO; 3],
            max: [ZERO; 3],
            triangles: [0; PLACES],
            count: 0,
            wanted: [0; PLACES],
            wanted_count: 0,
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

    /// Requests triangles of A, numbered from `first`, and prefetches them: the time between this
    /// call and [`Patch::take_a`] hides the memory latency.
    #[inline(always)]
    pub fn want_a<S: Simd>(&mut self, simd: S, posed: &Posed<'_>, first: u32, places: &Places) {
        self.want(simd, posed.a, first, places);
    }

    /// Requests triangles of B; see [`Patch::want_a`].
    #[inline(always)]
    pub fn want_b<S: Simd>(&mut self, simd: S, posed: &Posed<'_>, first: u32, places: &Places) {
        self.want(simd, posed.b, first, places);
    }

    /// Eight at a time, since their number is unpredictable: the triangle where a word begins is
    /// prefetched if any of the word is.
    #[inline(always)]
    fn want<S: Simd>(&mut self, simd: S, triangles: &[Corners], first: u32, places: &Places) {
        let mut count = 0;
        for (word, mut bits) in places.words().into_iter().enumerate() {
            let start = first + u64::BITS * word as u32;
            let more = bits.count_ones() as usize;
            let free = self.wanted[count..].as_chunks_mut::<LANES>().0;
            for eight in free.iter_mut().take(more.div_ceil(LANES)) {
                for number in eight {
                    *number = start + bits.trailing_zeros() % u64::BITS;
                    prefetch(simd, triangles, *number as usize);
                    bits &= bits.wrapping_sub(1);
                }
            }
            count += more;
        }
        self.wanted[count..count + LANES].fill(first);
        self.wanted_count = count;
    }

    /// Adds those requested triangles of A that `choice` selects. Returns the union of their boxes,
    /// spread over eight lanes.
    ///
    /// # Panics
    ///
    /// A triangle number is out of range.
    #[inline(always)]
    pub fn take_a<S: Simd>(
        &mut self,
        simd: S,
        (posed, close): (&Posed<'_>, &Close),
        choice: &impl Choice<S>,
    ) -> Boxes<S> {
        let mut all = Boxes::nothing(simd);
        self.count = 0;
        let origin = same(simd, &close.origin);
        for eight in 0..self.wanted_count.div_ceil(LANES) {
            let numbers = &self.wanted.as_chunks::<LANES>().0[eight];
            let [a0, a1, a2]: [Vector<S>; 3] = gather(simd, posed.a, numbers);
            let corners = [minus(a0, origin), minus(a1, origin), minus(a2, origin)];
            let boxes = Boxes::around(&corners);
            let chosen =
                choice.of(&corners, &boxes) & given(simd, self.wanted_count - eight * LANES);
            all.include(&boxes.only(simd, chosen));
            self.put(simd, eight, chosen, &boxes);
        }
        self.close(simd);
        all
    }

    /// Adds those requested triangles of B that `choice` selects; see [`Patch::take_a`].
    ///
    /// # Panics
    ///
    /// A triangle number is out of range.
    #[inline(always)]
    pub fn take_b<S: Simd>(
        &mut self,
        simd: S,
        (posed, close): (&Posed<'_>, &Close),
        choice: &impl Choice<S>,
    ) -> Boxes<S> {
        let mut all = Boxes::nothing(simd);
        self.count = 0;
        let error = f32x8::splat(simd, close.error());
        for eight in 0..self.wanted_count.div_ceil(LANES) {
            let numbers = &self.wanted.as_chunks::<LANES>().0[eight];
            let [b0, b1, b2]: [Vector<S>; 3] = gather(simd, posed.b, numbers);
            let edges = [minus(b1, b0), minus(b2, b0)];
            let Placed { corner, edges: [f1, f2] } = close.placed(simd, posed, b0, edges);
            let corners = [corner, plus(corner, f1), plus(corner, f2)];
            let boxes = Boxes::around(&corners).enlarged(error);
            let chosen =
                choice.of(&corners, &boxes) & given(simd, self.wanted_count - eight * LANES);
            all.include(&boxes.only(simd, chosen));
            self.put(simd, eight, chosen, &boxes);
        }
        self.close(simd);
        all
    }

    /// Appends those of the eight requested triangles that are selected.
    #[inline(always)]
    fn put<S: Simd>(&mut self, simd: S, eight: usize, chosen: mask32x8<S>, boxes: &Boxes<S>) {
        let at = self.count..self.count + LANES;
        for axis in 0..3 {
            let at = at.clone();
            boxes.min[axis].compress(chosen).store_slice(&mut self.min[axis][at.clone()]);
            boxes.max[axis].compress(chosen).store_slice(&mut self.max[axis][at]);
        }
        let numbers = u32x8::from_slice(simd, &self.wanted.as_chunks::<LANES>().0[eight]);
        numbers.compress(chosen).store_slice(&mut self.triangles[at]);
        self.count += chosen.to_bitmask().count_ones() as usize;
    }

    /// Makes the entries after the last triangle overlap nothing.
    #[inline(always)]
    fn close<S: Simd>(&mut self, simd: S) {
        let (nothing, at) = (Boxes::nothing(simd), self.count..self.count + LANES);
        for axis in 0..3 {
            nothing.min[axis].store_slice(&mut self.min[axis][at.clone()]);
            nothing.max[axis].store_slice(&mut self.max[axis][at.clone()]);
        }
    }

    /// The box of the triangle at a place, repeated eight times.
    #[inline(always)]
    pub fn one_box<S: Simd>(&self, simd: S, place: usize) -> Boxes<S> {
        Boxes { min: one(simd, &self.min, place), max: one(simd, &self.max, place) }
    }
}

/// Buffers for two patches and their pairs.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Triangles of A.
    pub a: Patch,
    /// Triangles of B.
    pub b: Patch,
    /// Some of their pairs.
    pub pairs: Pairs,
}

/// Reports all intersecting pairs between some triangles of A and some of B, at most [`ROOM`] of
/// each, testing every combination.
///
/// Call it from a function that is already specialised for `S`.
///
/// # Panics
///
/// A triangle number is out of range, or there are too many triangles.
#[inline(always)]
pub fn meet_all<S: Simd>(
    simd: S,
    posed: &Posed<'_>,
    patches: &mut Patches,
    (a, b): (Range<u32>, Range<u32>),
    hit: &mut dyn FnMut([u32; 2]),
) {
    let around = |of: &[Corners], range: &Range<u32>| {
        let boxes = of[range.start as usize..range.end as usize].iter().map(Aabb::of);
        boxes.fold(Aabb::EMPTY, |all, one| all.union(&one))
    };
    let (box_a, box_b) = (around(posed.a, &a), around(posed.b, &b));
    if box_a.is_empty() || box_b.is_empty() {
        return;
    }
    let close = posed.close(&box_a, &box_b);
    let Patches { a: patch_a, b: patch_b, pairs } = patches;
    patch_a.want_a(simd, posed, a.start, &Places::first(a.len()));
    patch_b.want_b(simd, posed, b.start, &Places::first(b.len()));
    patch_a.take_a(simd, (posed, &close), &All(simd));
    patch_b.take_b(simd, (posed, &close), &All(simd));
    for at in (0..patch_b.count).step_by(LANES) {
        pairs.take(simd, patch_a, (patch_b, at));
        if pairs.is_full() || at + LANES >= patch_b.count {
            pairs.sift(simd, posed, &close);
            let [a, b] = pairs.drain();
            a.iter().zip(b).for_each(|(a, b)| hit([*a, *b]));
        }
    }
}

/// Selects every triangle.
struct All<S: Simd>(S);

impl<S: Simd> Choice<S> for All<S> {
    #[inline(always)]
    fn of(&self, _: &[Vector<S>; 3], _: &Boxes<S>) -> mask32x8<S> {
        mask32x8::splat(self.0, true)
    }
}

/// A mask of the first `count` of eight lanes.
#[inline(always)]
fn given<S: Simd>(simd: S, count: usize) -> mask32x8<S> {
    mask32x8::from_bitmask(simd, 0xff >> (LANES - count.min(LANES)))
}

/// Three coordinates of one point, repeated eight times.
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
