//! When in an interval boxes and triangles may come near each other: spans of time.
//!
//! Along a fixed axis the coordinates of what moves along chords lie between those at the begin
//! and at the end, interpolated: its least coordinate is concave in time, its greatest convex. So
//! two shapes that come within a distance of each other at some time do so along every axis at that
//! time: the spans of all axes have it in common. For triangles that move without turning, the
//! normals and the products of edges leave little else (D. Eberly, *Intersection of Convex Objects:
//! The Method of Separating Axes*, 2001).
//!
//! Times are shares of the interval: 0 is its begin, 1 its end.

use super::interval::Mover;
use super::separation::{Pair, edges, normal};
use super::{Moved, TimeInterval};
use crate::{Aabb, Corners, DVec3, Triangle};
use glam::{BVec3A, Vec3A};

/// By how much a span of boxes is widened at either end: eight roundings of a share in single
/// precision.
const WIDER: f32 = 8.0 / (1 << 23) as f32;
/// Boxes that move by less (m) stand: quotients of what is smaller might overflow.
const STANDS_M: f32 = 1e-12;
/// By how much a span of triangles is widened at either end, far above the rounding of a share.
const WIDER_TRIANGLES: f64 = 1e-12;

/// A span of shares of an interval, from the first to the last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearSpan {
    /// The first share, from 0.
    pub from: f64,
    /// The last share, up to 1.
    pub to: f64,
}

impl NearSpan {
    /// All of an interval.
    pub const ALL: Self = Self { from: 0.0, to: 1.0 };

    /// What two spans have in common, if they have anything.
    fn and(self, other: Self) -> Option<Self> {
        let (from, to) = (self.from.max(other.from), self.to.min(other.to));
        (from <= to).then_some(Self { from, to })
    }
}

/// When what moves in an interval may come within a distance of each other.
#[derive(Clone, Copy, Debug)]
pub struct NearSpans {
    /// Boxes of B in A's frame, and of A in B's.
    boxes: [MovingBoxes; 2],
    /// How near counts, with what points are off their chords by (m), in either frame.
    near_m: [f64; 2],
}

impl TimeInterval {
    /// When what moves in it may come within `near_m` (m) of each other.
    #[must_use]
    pub fn near_spans(&self, near_m: f64) -> NearSpans {
        let boxes = self.movers.each_ref().map(|movers| MovingBoxes {
            begin: movers.ends[0],
            end: movers.ends[1],
            near_m: movers.margin_m + Vec3A::splat(near_m as f32),
        });
        let near_m = self.lasting_margins_m().map(|margin_m| margin_m + near_m);
        NearSpans { boxes, near_m }
    }

    /// The time of a share of it (s), within it.
    #[must_use]
    pub fn time_s(&self, share: f64) -> f64 {
        (self.from_s + (self.to_s - self.from_s) * share).clamp(self.from_s, self.to_s)
    }
}

impl NearSpans {
    /// When a box of A and a box of B may be near; `None`: never.
    #[must_use]
    #[inline]
    pub fn of_boxes(&self, a: &Aabb, b: &Aabb) -> Option<NearSpan> {
        let [of_b, of_a] = &self.boxes;
        of_b.span(b, a)?.and(of_a.span(a, b)?)
    }

    /// When a triangle of A and one of B may be near before a share `before`; `None`: never.
    /// `moved_b` is B's triangle in `interval`, from which these spans are.
    #[must_use]
    pub fn of_triangles(
        &self,
        interval: &TimeInterval,
        (a, b): (&Corners, &Corners),
        moved_b: &Moved,
        before: f64,
    ) -> Option<NearSpan> {
        let stored_a = Triangle::stored(a);
        let in_a = Pair { still: stored_a.0, moved: &moved_b.ends, margin_m: self.near_m[0] };
        let span = in_a.of_boxes(NearSpan { from: 0.0, to: before.min(1.0) })?;
        let span = span.and(in_a.span(normal(&stored_a.0))?)?;
        let stored_b = Triangle::stored(b);
        let moved_a = interval.moved_a(a);
        let in_b = Pair { still: stored_b.0, moved: &moved_a.ends, margin_m: self.near_m[1] };
        let span = span.and(in_b.span(normal(&stored_b.0))?)?;
        let span = in_b.of_boxes(span)?;
        let [begin, end] = &moved_b.ends;
        let middle = [0, 1, 2].map(|k| (begin[k] + end[k]) * 0.5);
        let (edges_a, edges_b) = (edges(&stored_a.0), edges(&middle));
        let mut crosses = edges_b.iter().flat_map(|q| edges_a.iter().map(|p| p.cross(*q)));
        crosses.try_fold(span, |span, axis| span.and(in_a.span(axis)?))
    }
}

impl Pair<'_> {
    /// What a span has in common with those of the axes of the frame: without products.
    #[inline]
    fn of_boxes(&self, within: NearSpan) -> Option<NearSpan> {
        let ends = |[p, q, r]: &[DVec3; 3]| [p.min(*q).min(*r), p.max(*q).max(*r)];
        let ([least, most], [begin, end]) =
            (ends(&self.still), [ends(&self.moved[0]), ends(&self.moved[1])]);
        let mut span = within;
        for axis in 0..3 {
            let moved = [[begin[0][axis], begin[1][axis]], [end[0][axis], end[1][axis]]];
            let near = along([least[axis], most[axis]], moved, self.margin_m)?;
            span = span.and(near)?;
        }
        Some(span)
    }

    /// When both are near along an axis of any length.
    fn span(&self, axis: DVec3) -> Option<NearSpan> {
        let (still, moved) = self.ranges(axis);
        along(still, moved, self.margin_m * axis.length())
    }
}

/// When ranges are within a distance: one that stands, and one at the begin and at the end.
#[inline]
fn along([least, most]: [f64; 2], [begin, end]: [[f64; 2]; 2], near: f64) -> Option<NearSpan> {
    let comes = below(begin[0], end[0], most + near)?;
    comes.and(below(-begin[1], -end[1], near - least)?)
}

/// When a figure that goes steadily from `begin` to `end` is at most `limit`. What is no number is
/// always so.
#[inline]
fn below(begin: f64, end: f64, limit: f64) -> Option<NearSpan> {
    let share = (limit - begin) / (end - begin);
    let is_above = |figure: f64| figure > limit;
    match (is_above(begin), is_above(end)) {
        (false, false) => Some(NearSpan::ALL),
        (true, true) => None,
        (true, false) => Some(NearSpan { from: (share - WIDER_TRIANGLES).max(0.0), to: 1.0 }),
        (false, true) => Some(NearSpan { from: 0.0, to: (share + WIDER_TRIANGLES).min(1.0) }),
    }
}

/// Boxes of one body in the frame of the other, in single precision.
#[derive(Clone, Copy, Debug)]
struct MovingBoxes {
    begin: Mover,
    end: Mover,
    /// How near counts, with margins and rounding (m).
    near_m: Vec3A,
}

impl MovingBoxes {
    /// When `moving` may be near `still`.
    #[inline]
    fn span(&self, moving: &Aabb, still: &Aabb) -> Option<NearSpan> {
        let [least, most] = [still.min, still.max].map(Vec3A::from_array);
        let [min, max] = [moving.min, moving.max].map(Vec3A::from_array);
        let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let (begin, reach) = self.begin.placed(middle, half);
        let (end, reach_at_end) = self.end.placed(middle, half);
        // The middle is linear in time, and extents are no more than the greater of both ends.
        let reach = reach.max(reach_at_end) + self.near_m + (most - least) * 0.5;
        let (from, way) = (begin - (least + most) * 0.5, end - begin);
        // What is no number is near all the time.
        let stands: BVec3A = !way.abs().cmpgt(Vec3A::splat(STANDS_M));
        let is_apart = from.abs().cmpgt(reach + Vec3A::splat(STANDS_M));
        if (stands & is_apart).any() {
            return None;
        }
        let per_metre = Vec3A::ONE / Vec3A::select(stands, Vec3A::ONE, way);
        let (p, q) = ((-reach - from) * per_metre, (reach - from) * per_metre);
        let first = Vec3A::select(stands, Vec3A::ZERO, p.min(q)).max_element() - WIDER;
        let last = Vec3A::select(stands, Vec3A::ONE, p.max(q)).min_element() + WIDER;
        let (from, to) = (first.max(0.0), last.min(1.0));
        (!(from > to)).then(|| NearSpan { from: f64::from(from), to: f64::from(to) })
    }
}
