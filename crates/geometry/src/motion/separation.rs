//! Separating axes of two triangles of which one moves along chords.
//!
//! Along a fixed axis the least coordinate of B's corners is concave in time, as a minimum of
//! linear functions, and so is the gap to a triangle that stands. So a gap at the begin and at the
//! end is a gap all the time. Which axes are tried decides how much is excluded, never whether it
//! is right.
//!
//! Tried are the axes of both frames, both normals, the products of two edges, those of an edge and
//! the motion (these together suffice for triangles that move without turning: S. Gottschalk,
//! M. Lin, D. Manocha, *OBBTree*, SIGGRAPH 1996, for the swept prism), and at last the line between
//! the closest points half-way, along which the gap is the distance.

use super::{Moved, TimeInterval};
use crate::{Corners, DVec3, Triangle};

impl TimeInterval {
    /// Whether a triangle of A and one of B certainly share no point all the time, by few axes:
    /// those of both frames and both normals. `moved_b` is B's triangle.
    ///
    /// These axes stay the same in parts of the interval. So what is apart here is apart in them
    /// too, for [`TimeInterval::are_apart`].
    #[must_use]
    #[inline]
    pub fn are_clearly_apart(&self, a: &Corners, b: &Corners, moved_b: &Moved) -> bool {
        let stored_a = Triangle::stored(a);
        if self.is_far() || !stored_a.bounds().overlaps(&moved_b.bounds) {
            return true;
        }
        let margins_m = self.lasting_margins_m();
        let in_a = Pair { still: stored_a.0, moved: &moved_b.ends, margin_m: margins_m[0] };
        if in_a.is_split(normal(&stored_a.0)) {
            return true;
        }
        let moved_a = self.moved_a(a);
        let stored_b = Triangle::stored(b);
        if !stored_b.bounds().overlaps(&moved_a.bounds) {
            return true;
        }
        let in_b = Pair { still: stored_b.0, moved: &moved_a.ends, margin_m: margins_m[1] };
        in_b.is_split(normal(&stored_b.0))
    }

    /// Whether a triangle of A and one of B certainly share no point all the time, by all axes.
    /// `moved_b` is B's triangle.
    ///
    /// If it is false in an interval that is [short](TimeInterval::is_short) for a resolution, then
    /// the triangles come within about that distance (m) of each other.
    #[must_use]
    pub fn are_apart(&self, a: &Corners, b: &Corners, moved_b: &Moved) -> bool {
        if self.is_just_far() {
            return true;
        }
        let (stored_a, stored_b) = (Triangle::stored(a), Triangle::stored(b));
        let moved_a = self.moved_a(a);
        let [margin_a, margin_b] = self.margins_m();
        let in_a = Pair { still: stored_a.0, moved: &moved_b.ends, margin_m: margin_a };
        let in_b = Pair { still: stored_b.0, moved: &moved_a.ends, margin_m: margin_b };
        let is_split_along = |axis: DVec3| in_a.is_split(axis) || in_b.is_split(axis);
        if DVec3::AXES.into_iter().any(is_split_along)
            || in_a.is_split(normal(&stored_a.0))
            || in_b.is_split(normal(&stored_b.0))
        {
            return true;
        }
        let [begin, end] = &moved_b.ends;
        let middle = [0, 1, 2].map(|k| (begin[k] + end[k]) * 0.5);
        let (edges_a, edges_b) = (edges(&stored_a.0), edges(&middle));
        let along = [0, 1, 2].map(|k| end[k] - begin[k]);
        let along = (along[0] + along[1]) + along[2];
        let crosses = |q: DVec3| edges_a.iter().any(|p| in_a.is_split(p.cross(q)));
        edges_b.into_iter().any(crosses)
            || crosses(along)
            || edges_b.iter().any(|q| in_a.is_split(q.cross(along)))
            || in_a.is_split(shortest_way(&stored_a.0, &middle))
    }
}

/// A triangle that stands and one that moves, in one frame.
pub(super) struct Pair<'p> {
    pub(super) still: [DVec3; 3],
    pub(super) moved: &'p [[DVec3; 3]; 2],
    /// What the moved one may be off its chords by (m).
    pub(super) margin_m: f64,
}

impl Pair<'_> {
    /// Whether a plane across `axis`, of any length, separates them all the time.
    #[inline]
    fn is_split(&self, axis: DVec3) -> bool {
        let ([least, most], [begin, end]) = self.ranges(axis);
        let gap = (begin[0].min(end[0]) - most).max(least - begin[1].max(end[1]));
        gap > 0.0 && gap * gap > self.margin_m * self.margin_m * axis.dot(axis)
    }

    /// The least and greatest coordinates along an axis: of the one that stands, and of the other
    /// at the begin and at the end.
    #[inline]
    pub(super) fn ranges(&self, axis: DVec3) -> ([f64; 2], [[f64; 2]; 2]) {
        let along = |points: &[DVec3; 3]| points.map(|p| axis.dot(p));
        let range = |[p, q, r]: [f64; 3]| [p.min(q).min(r), p.max(q).max(r)];
        let moved = [0, 1].map(|k| range(along(&self.moved[k])));
        (range(along(&self.still)), moved)
    }
}

pub(super) fn edges([p, q, r]: &[DVec3; 3]) -> [DVec3; 3] {
    [*q - *p, *r - *q, *p - *r]
}

pub(super) fn normal([p, q, r]: &[DVec3; 3]) -> DVec3 {
    (*q - *p).cross(*r - *p)
}

/// The vector between the closest points of two triangles that share none, up to rounding.
///
/// These are points of two edges, or a corner and a point of the other triangle.
fn shortest_way(a: &[DVec3; 3], b: &[DVec3; 3]) -> DVec3 {
    let mut best = a[0] - b[0];
    let mut take = |way: DVec3| {
        if way.dot(way) < best.dot(best) {
            best = way;
        }
    };
    for i in 0..3 {
        for k in 0..3 {
            take(between_segments([a[i], a[(i + 1) % 3]], [b[k], b[(k + 1) % 3]]));
        }
    }
    for k in 0..3 {
        if let Some(way) = onto_plane(a, b[k]) {
            take(way);
        }
        if let Some(way) = onto_plane(b, a[k]) {
            take(way);
        }
    }
    best
}

/// The vector between the closest points of two segments (C. Ericson, *Real-Time Collision
/// Detection*, 2005, section 5.1.9).
fn between_segments([p, p_end]: [DVec3; 2], [q, q_end]: [DVec3; 2]) -> DVec3 {
    let (u, v, w) = (p_end - p, q_end - q, p - q);
    let (uu, vv, uv, uw, vw) = (u.dot(u), v.dot(v), u.dot(v), u.dot(w), v.dot(w));
    // 0 where the quotient is none: segments that are points, or parallel.
    let share = |of: f64, whole: f64| if whole > 0.0 { (of / whole).clamp(0.0, 1.0) } else { 0.0 };
    let s = share(uv * vw - uw * vv, uu * vv - uv * uv);
    let t = share(uv * s + vw, vv);
    let s = share(uv * t - uw, uu);
    w + u * s - v * t
}

/// The vector to a point from the plane of a triangle, if the foot lies within the triangle.
fn onto_plane([p, q, r]: &[DVec3; 3], point: DVec3) -> Option<DVec3> {
    let n = (*q - *p).cross(*r - *p);
    let length = n.dot(n);
    let is_left = |from: &DVec3, to: &DVec3| (*to - *from).cross(point - *from).dot(n) >= 0.0;
    let is_inside = length > 0.0 && is_left(p, q) && is_left(q, r) && is_left(r, p);
    is_inside.then(|| n * ((point - *p).dot(n) / length))
}
