//! Pairs of triangles that may touch while B moves along a line: eight at a time, what certainly
//! does not is left out. What is left is decided by [`crate::sweep::first_contact`].
//!
//! Positions are those of a close frame under B's pose at a *reference* travel; travels are
//! measured from there. Two filters follow each other:
//!
//! - Boxes: the travels at which two boxes overlap along each axis of A form an interval; the three
//!   intersected begin no later than any contact.
//! - Projections along the motion: their bounds are apart, an edge of one separates both, or the
//!   heights are too far apart.
//!
//! # Errors
//!
//! With u and L as in [`super`], positions are off by 20uL. A motion is at most as long as two
//! boxes of L on either side overlap, which is below 7L, since a component of its direction is
//! above ½.
//!
//! - A travel by boxes is a difference of two coordinates, known to uL where both boxes were
//!   enlarged, times the inverse of a component of the direction: 3u of a travel below 7L. 64uL are
//!   allowed. A component below 10⁻⁹ is taken as that; a box moves by less than 10⁻⁸L meanwhile, of
//!   the 12uL by which it was enlarged beyond need.
//! - A coordinate across or along the motion is a product of a position with a rounded row: 35uL
//!   for the position, 12uL for products and sums, 4u of the way of below 7L. 128uL are allowed.
//! - An orientation across the motion is off as in `triangle/sweep/projection.rs`, with that
//!   coordinate error.
//! - A plane is computed from corners that are off by e = 128uL, and misses them by what is
//!   measured, r. Within the triangle it is a mean of its values at the true corners, so it is off
//!   by at most e + r + e·(sum of slopes); 3e times that sum are allowed, as it is also evaluated
//!   with rounding.

use super::{Boxes, Close, LANES, Patch, Posed, Vector, eight, same};
use crate::Sweep;
use crate::lanes::{cross, gather, minus, plus, rotated};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8, u32x8};

/// With more pairs than this, it is time to sift them.
const FULL: usize = 512;

/// One triangle against a whole patch always fits in addition, and eight are stored at a time.
const PLACES: usize = FULL + LANES * super::ROOM + LANES;

/// Components of directions are at least this great.
const COMPONENT_MIN: f64 = 1e-9;

/// A direction of motion in f32: the inverse of each component.
#[derive(Clone, Copy, Debug)]
pub struct Inverse(pub [f32; 3]);

impl Inverse {
    /// Of a direction of length 1. A component below 10⁻⁹ is taken as that.
    #[must_use]
    pub fn of(direction: [f64; 3]) -> Self {
        Self(direction.map(|x| {
            let x = if x.abs() < COMPONENT_MIN { COMPONENT_MIN.copysign(x) } else { x };
            (1.0 / x) as f32
        }))
    }
}

/// The travels at which boxes of B, moving along a direction, overlap those of A in the same lane:
/// from the first to the second, which is less where they never do. In the frame of both, each
/// inverse spread over all lanes.
#[inline(always)]
pub fn travels<S: Simd>(of_a: &Boxes<S>, of_b: &Boxes<S>, inverse: &Vector<S>) -> [f32x8<S>; 2] {
    let [x, u] = along(of_a, of_b, inverse, 0);
    let [y, v] = along(of_a, of_b, inverse, 1);
    let [z, w] = along(of_a, of_b, inverse, 2);
    [x.max(y).max(z), u.min(v).min(w)]
}

/// [`travels`] along one axis.
#[inline(always)]
fn along<S: Simd>(
    of_a: &Boxes<S>,
    of_b: &Boxes<S>,
    inverse: &Vector<S>,
    axis: usize,
) -> [f32x8<S>; 2] {
    let p = (of_a.min[axis] - of_b.max[axis]) * inverse[axis];
    let q = (of_a.max[axis] - of_b.min[axis]) * inverse[axis];
    [p.min(q), p.max(q)]
}

/// A motion seen from a close frame at the reference travel.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    inverse: Inverse,
    /// Rows of the projection: across the motion, and along it.
    rows: [[f32; 3]; 3],
    /// Travels from the reference on within which contact matters (m), rounded outward.
    from: f32,
    to: f32,
    /// What travels by boxes may be off by (m).
    travel_error: f32,
    /// What a coordinate of the projection may be off by (m).
    coordinate_error: f32,
}

impl Window {
    /// The travels of `sweep` from `reference_m` on.
    #[must_use]
    #[inline]
    pub fn new(sweep: &Sweep, reference_m: f64, close: &Close) -> Self {
        let error = close.error();
        Self {
            inverse: Inverse::of(sweep.direction().to_array()),
            rows: sweep.axes().map(|row| row.to_array().map(|x| x as f32)),
            from: down(sweep.from_m() - reference_m),
            to: up(sweep.to_m() - reference_m),
            travel_error: 2.0 * error + NANOMETRES,
            coordinate_error: 4.0 * error + NANOMETRES,
        }
    }

    /// Ends the window earlier.
    #[inline]
    pub fn end(&mut self, to_m: f64, reference_m: f64) {
        self.to = self.to.min(up(to_m - reference_m));
    }

    /// Which boxes may meet within the window, and the travels from when on at the earliest.
    #[inline(always)]
    pub fn meet<S: Simd>(
        &self,
        simd: S,
        of_a: &Boxes<S>,
        of_b: &Boxes<S>,
    ) -> (mask32x8<S>, f32x8<S>) {
        let [first, last] = travels(of_a, of_b, &same(simd, &self.inverse.0));
        let first = first - self.travel_error;
        let last = last + self.travel_error;
        let meeting = first.simd_le(last) & first.simd_le(self.to) & last.simd_ge(self.from);
        (meeting, first)
    }
}

/// More than the travel of two triangles may be off by (m).
const NANOMETRES: f32 = 2e-9;

/// `x`, rounded up.
#[must_use]
#[inline]
pub fn up(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

/// `x`, rounded down.
#[must_use]
#[inline]
pub fn down(x: f64) -> f32 {
    -up(-x)
}

/// Pairs of triangles that may touch, with the travel from when on at the earliest.
#[derive(Clone, Debug)]
pub struct SweptPairs {
    a: [u32; PLACES],
    b: [u32; PLACES],
    first: [f32; PLACES],
    count: usize,
}

impl Default for SweptPairs {
    fn default() -> Self {
        Self { a: [0; PLACES], b: [0; PLACES], first: [0.0; PLACES], count: 0 }
    }
}

impl SweptPairs {
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

    /// Removes and returns all pairs: triangles of A, of B, and the travels from when on they may
    /// touch (m from the reference).
    #[must_use]
    #[inline]
    pub fn drain(&mut self) -> (&[u32], &[u32], &[f32]) {
        let count = core::mem::take(&mut self.count);
        (&self.a[..count], &self.b[..count], &self.first[..count])
    }

    /// Adds the pairs of every triangle of A with those of the eight of B, from place `at` on,
    /// whose boxes may meet within the window.
    #[inline(always)]
    pub fn take<S: Simd>(&mut self, simd: S, a: &Patch, (b, at): (&Patch, usize), window: &Window) {
        let boxes = Boxes { min: eight(simd, &b.min, at), max: eight(simd, &b.max, at) };
        let there = boxes.min[0].simd_le(boxes.max[0]);
        let numbers = u32x8::from_slice(simd, &b.triangles[at..at + LANES]);
        for (row, &triangle) in a.triangles().iter().enumerate() {
            let (meeting, first) = window.meet(simd, &a.one_box(simd, row), &boxes);
            let meeting = meeting & there;
            self.put(simd, u32x8::splat(simd, triangle), numbers, first, meeting);
        }
    }

    #[inline(always)]
    fn put<S: Simd>(
        &mut self,
        _simd: S,
        a: u32x8<S>,
        b: u32x8<S>,
        first: f32x8<S>,
        chosen: mask32x8<S>,
    ) {
        let places = self.count..self.count + LANES;
        a.compress(chosen).store_slice(&mut self.a[places.clone()]);
        b.compress(chosen).store_slice(&mut self.b[places.clone()]);
        first.compress(chosen).store_slice(&mut self.first[places]);
        self.count += chosen.to_bitmask().count_ones() as usize;
    }

    /// Leaves out the pairs that certainly do not touch within the window.
    ///
    /// Call it from a function that is already specialised for `S`.
    ///
    /// # Panics
    ///
    /// A triangle number is out of range.
    #[inline(always)]
    pub fn sift<S: Simd>(
        &mut self,
        simd: S,
        (posed, close): (&Posed<'_>, &Close),
        window: &Window,
    ) {
        let count = core::mem::take(&mut self.count);
        if count == 0 {
            return;
        }
        // The last pair is repeated, so that there are always eight.
        let (a, b) = (self.a[count - 1], self.b[count - 1]);
        u32x8::splat(simd, a).store_slice(&mut self.a[count..count + LANES]);
        u32x8::splat(simd, b).store_slice(&mut self.b[count..count + LANES]);
        for at in (0..count).step_by(LANES) {
            let (possible, first) = self.eight(simd, posed, close, window, at);
            let here = mask32x8::from_bitmask(simd, 0xff >> (LANES - LANES.min(count - at)));
            let places = at..at + LANES;
            let a = u32x8::from_slice(simd, &self.a[places.clone()]);
            let b = u32x8::from_slice(simd, &self.b[places.clone()]);
            let first = first.max(f32x8::from_slice(simd, &self.first[places]));
            // The write position never passes the read position.
            self.put(simd, a, b, first, possible & here);
        }
    }

    /// For the eight pairs from place `at` on: which may touch within the window, and from when on.
    #[inline(always)]
    fn eight<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        close: &Close,
        window: &Window,
        at: usize,
    ) -> (mask32x8<S>, f32x8<S>) {
        let (of_a, of_b) = (&self.a[at..at + LANES], &self.b[at..at + LANES]);
        let origin = same(simd, &close.origin());
        let [a0, a1, a2]: [Vector<S>; 3] = gather(simd, posed.a, of_a);
        let [b0, b1, b2]: [Vector<S>; 3] = gather(simd, posed.b, of_b);
        let placed = close.placed(simd, posed, b0, [minus(b1, b0), minus(b2, b0)]);
        let [f, g] = placed.edges;
        let corner = placed.corner;
        // What follows is written out: closures over vectors are not always inlined, and then slow.
        let rows = &window.rows;
        let a = [
            rotated(simd, rows, minus(a0, origin)),
            rotated(simd, rows, minus(a1, origin)),
            rotated(simd, rows, minus(a2, origin)),
        ];
        let b = [
            rotated(simd, rows, corner),
            rotated(simd, rows, plus(corner, f)),
            rotated(simd, rows, plus(corner, g)),
        ];
        let (box_a, box_b) = (Boxes::around(&a), Boxes::around(&b));
        let error = window.coordinate_error;
        let low = [box_a.min[0].max(box_b.min[0]), box_a.min[1].max(box_b.min[1])];
        let high = [box_a.max[0].min(box_b.max[0]), box_a.max[1].min(box_b.max[1])];
        let first = box_a.min[2] - box_b.max[2] - 2.0 * error;
        let last = box_a.max[2] - box_b.min[2] + 2.0 * error;
        let apart = (low[0] - high[0]).simd_gt(2.0 * error)
            | (low[1] - high[1]).simd_gt(2.0 * error)
            | first.simd_gt(window.to)
            | last.simd_lt(window.from);
        if apart.to_bitmask() & ALL == ALL {
            return (!apart, first);
        }

        let width_x = box_a.max[0].max(box_b.max[0]) - box_a.min[0].min(box_b.min[0]);
        let width_y = box_a.max[1].max(box_b.max[1]) - box_a.min[1].min(box_b.min[1]);
        let side_error = (width_x.max(width_y) + error) * (16.0 * error) + UNDERFLOW;
        let apart =
            apart | separated(simd, &a, &b, side_error) | separated(simd, &b, &a, side_error);

        // The distance of both planes along the motion is linear: least at a corner of the box that
        // holds all points of both projections.
        let (plane_a, plane_b) = (Plane::of(&a), Plane::of(&b));
        let (low_x, high_x) = (low[0] - error, high[0] + error);
        let (low_y, high_y) = (low[1] - error, high[1] + error);
        let (x, half_x) = ((low_x + high_x) * 0.5, (high_x - low_x) * 0.5);
        let (y, half_y) = ((low_y + high_y) * 0.5, (high_y - low_y) * 0.5);
        let steep = plane_a.steepness() + plane_b.steepness();
        let off = plane_a.off + plane_b.off + (steep * 3.0 + 2.0) * error;
        let middle = plane_a.height(x, y) - plane_b.height(x, y);
        let least = middle
            - (plane_a.slope_x - plane_b.slope_x).abs() * half_x
            - (plane_a.slope_y - plane_b.slope_y).abs() * half_y
            - off;
        // Planes along the motion have no slope: then the bound is infinite or NaN, and unused.
        let first = least.simd_gt(first).select(least, first);
        (!(apart | first.simd_gt(window.to)), first)
    }
}

/// Eight lanes.
const ALL: u64 = 0xff;

/// The height of a triangle's plane over the plane across the motion.
struct Plane<S: Simd> {
    corner: Vector<S>,
    slope_x: f32x8<S>,
    slope_y: f32x8<S>,
    /// By how much the plane misses the corners, as computed (m).
    off: f32x8<S>,
}

impl<S: Simd> Plane<S> {
    #[inline(always)]
    fn of([p, q, r]: &[Vector<S>; 3]) -> Self {
        let normal = cross(minus(*q, *p), minus(*r, *p));
        let (slope_x, slope_y) = (-normal[0] / normal[2], -normal[1] / normal[2]);
        let plane = Self { corner: *p, slope_x, slope_y, off: normal[2] };
        let miss_q = (plane.height(q[0], q[1]) - q[2]).abs();
        let miss_r = (plane.height(r[0], r[1]) - r[2]).abs();
        Self { off: miss_q.max(miss_r), ..plane }
    }

    #[inline(always)]
    fn height(&self, x: f32x8<S>, y: f32x8<S>) -> f32x8<S> {
        self.corner[2] + self.slope_x * (x - self.corner[0]) + self.slope_y * (y - self.corner[1])
    }

    #[inline(always)]
    fn steepness(&self) -> f32x8<S> {
        self.slope_x.abs() + self.slope_y.abs()
    }
}

/// More than all underflow errors: 2⁻¹⁰⁰.
const UNDERFLOW: f32 = f32::from_bits((127 - 100) << 23);

/// Where an edge of one projection has the whole other one on its far side, certainly.
#[inline(always)]
fn separated<S: Simd>(
    simd: S,
    [p, q, r]: &[Vector<S>; 3],
    other: &[Vector<S>; 3],
    error: f32x8<S>,
) -> mask32x8<S> {
    let zero = f32x8::splat(simd, 0.0);
    let margin = error + error;
    let area = side(p, q, r);
    let (most, least) = (area.max(zero) + margin, area.min(zero) - margin);
    beyond(p, q, other, most, least)
        | beyond(q, r, other, most, least)
        | beyond(r, p, other, most, least)
}

/// Twice the area of a projected triangle, positive if its corners turn counter-clockwise.
#[inline(always)]
fn side<S: Simd>(p: &Vector<S>, q: &Vector<S>, r: &Vector<S>) -> f32x8<S> {
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// Where a whole triangle lies on one side of the line pq, beyond these areas.
#[inline(always)]
fn beyond<S: Simd>(
    p: &Vector<S>,
    q: &Vector<S>,
    [u, v, w]: &[Vector<S>; 3],
    most: f32x8<S>,
    least: f32x8<S>,
) -> mask32x8<S> {
    let (u, v, w) = (side(p, q, u), side(p, q, v), side(p, q, w));
    u.min(v).min(w).simd_gt(most) | u.max(v).max(w).simd_lt(least)
}
