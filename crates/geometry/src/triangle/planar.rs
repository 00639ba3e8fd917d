//! Triangles that are coplanar or degenerate, exactly, by dimension.
//!
//! A degenerate triangle is a segment or a point. What lies in one plane is compared in a projection
//! that drops one coordinate: on raw coordinates, so nothing is rounded, and one-to-one on the plane,
//! because three of the points keep an area.

use super::exact::{self, Point2, Sign};
use super::{Orient, Position, Triangle, orient};
use crate::DVec3;

/// The corners of a triangle without repetition: three of a true one, two ends of a segment, or a
/// point.
struct Hull {
    corners: [DVec3; 3],
    count: usize,
}

/// A segment (or point) pq, and a true triangle whose plane separates p and q, or holds one of them.
pub(super) struct Piercing {
    p: DVec3,
    q: DVec3,
    triangle: [DVec3; 3],
}

/// Two hulls in one plane, or on one line.
pub(super) struct Flat {
    a: Hull,
    b: Hull,
    /// The coordinate to drop; none if all is on one line.
    drop: Option<usize>,
}

/// The position of two triangles of which at least one has no corner off the other's plane.
pub(super) fn position(a: &Triangle, b: &Triangle) -> Position {
    let (a, b) = (Hull::of(a), Hull::of(b));
    match (a.count, b.count) {
        (3, 3) => Flat::of(a, b),
        (3, _) => against_triangle(b, a),
        (_, 3) => against_triangle(a, b),
        _ => {
            let ([p, q], [r, s]) = (a.ends(), b.ends());
            if exact::orient3d(p, q, r, s) == 0 { Flat::of(a, b) } else { Position::Apart }
        }
    }
}

/// A segment or point against a true triangle.
fn against_triangle(segment: Hull, triangle: Hull) -> Position {
    let [a, b, c] = triangle.corners;
    let [p, q] = segment.ends();
    match [p, q].map(|end| exact::orient3d(a, b, c, end)) {
        [0, 0] => Flat::of(segment, triangle),
        [1, 1] | [-1, -1] => Position::Apart,
        _ => Position::Piercing(Piercing { p, q, triangle: triangle.corners }),
    }
}

impl Piercing {
    /// Whether the segment meets the triangle: it passes no edge on the wrong side.
    pub(super) fn meet(&self) -> bool {
        let [a, b, c] = self.triangle;
        inside([(a, b), (b, c), (c, a)].map(|(from, to)| exact::orient3d(self.p, self.q, from, to)))
    }

    /// Calls `push` with the common point, if there is one.
    pub(super) fn point(&self, orient: &Orient, mut push: impl FnMut(DVec3)) {
        if self.meet() {
            push(orient.cut(&self.triangle, self.p, self.q));
        }
    }
}

impl Flat {
    fn of(a: Hull, b: Hull) -> Position {
        let drop = projection(&a, &b);
        Position::Flat(Self { a, b, drop })
    }

    /// Whether the hulls share a point, given that their boxes do.
    pub(super) fn meet(&self) -> bool {
        // On a line, boxes overlap only where the sets do.
        let Some(drop) = self.drop else { return true };
        let touch = self.a.edges().any(|(p, q)| {
            let (p, q) = (flat(p, drop), flat(q, drop));
            self.b.edges().any(|(r, s)| segments_meet(p, q, flat(r, drop), flat(s, drop)))
        });
        touch
            || self.a.holds(self.b.corners[0], Some(drop))
            || self.b.holds(self.a.corners[0], Some(drop))
    }

    /// Calls `push` with the corners of the overlap: corners of one hull that the other holds (some
    /// twice), and proper crossings of edges. Without repetition at most six.
    pub(super) fn corners(&self, mut push: impl FnMut(DVec3)) {
        for corner in self.a.corners().iter().filter(|p| self.b.holds(**p, self.drop)) {
            push(*corner);
        }
        for corner in self.b.corners().iter().filter(|p| self.a.holds(**p, self.drop)) {
            push(*corner);
        }
        let Some(drop) = self.drop else { return };
        for (p, q) in self.a.edges() {
            for (r, s) in self.b.edges() {
                let [p2, q2, r2, s2] = [p, q, r, s].map(|point| flat(point, drop));
                if straddle(p2, q2, r2, s2) == -1 && straddle(r2, s2, p2, q2) == -1 {
                    push(orient::along(p, q, exact::cut_fraction2d(r2, s2, p2, q2)));
                }
            }
        }
    }
}

impl Hull {
    fn of(triangle: &Triangle) -> Self {
        let corners = triangle.0;
        let [a, b, c] = corners;
        if (0..3).any(|drop| exact::orient2d(flat(a, drop), flat(b, drop), flat(c, drop)) != 0) {
            return Self { corners, count: 3 };
        }
        // Along a line the lexicographic order is the order on the line.
        let before = |p: &DVec3, q: &DVec3| (p.x, p.y, p.z) < (q.x, q.y, q.z);
        let low = [b, c].into_iter().fold(a, |low, p| if before(&p, &low) { p } else { low });
        let high = [b, c].into_iter().fold(a, |high, p| if before(&high, &p) { p } else { high });
        Self { corners: [low, high, high], count: if low == high { 1 } else { 2 } }
    }

    fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// The ends of a segment; twice a point.
    fn ends(&self) -> [DVec3; 2] {
        [self.corners[0], self.corners[1]]
    }

    /// Three edges of a triangle, else the one segment, perhaps of length 0.
    fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let edges = if self.count == 3 { 3 } else { 1 };
        (0..edges).map(|i| (self.corners[i], self.corners[(i + 1) % 3]))
    }

    /// Whether it holds a point of its plane (or its line, if no coordinate is to be dropped).
    fn holds(&self, point: DVec3, drop: Option<usize>) -> bool {
        if self.count == 3
            && let Some(drop) = drop
        {
            let [a, b, c, x] =
                [self.corners[0], self.corners[1], self.corners[2], point].map(|p| flat(p, drop));
            return inside([(a, b), (b, c), (c, a)].map(|(p, q)| exact::orient2d(p, q, x)));
        }
        let [p, q] = self.ends();
        let boxed = p.min(q).cmple(point).all() && point.cmple(p.max(q)).all();
        boxed
            && drop.is_none_or(|drop| {
                exact::orient2d(flat(p, drop), flat(q, drop), flat(point, drop)) == 0
            })
    }
}

/// A coordinate that can be dropped without flattening the common plane of the hulls; none if all
/// is on one line.
fn projection(a: &Hull, b: &Hull) -> Option<usize> {
    let ([p, q, t], [r, s, u]) = (a.corners, b.corners);
    let triples = [[p, q, t], [r, s, u], [p, q, r], [p, q, s], [r, s, p]];
    (0..3).find(|drop| {
        triples.iter().any(|triple| {
            let [x, y, z] = triple.map(|point| flat(point, *drop));
            exact::orient2d(x, y, z) != 0
        })
    })
}

/// Drops a coordinate; the handedness does not matter, as long as it is one and the same.
fn flat(point: DVec3, drop: usize) -> Point2 {
    match drop {
        0 => [point.y, point.z],
        1 => [point.z, point.x],
        _ => [point.x, point.y],
    }
}

/// Whether two closed segments, perhaps of length 0, share a point: their boxes overlap and each
/// touches or straddles the other's line.
fn segments_meet(p: Point2, q: Point2, r: Point2, s: Point2) -> bool {
    let overlap = |i: usize| p[i].min(q[i]) <= r[i].max(s[i]) && r[i].min(s[i]) <= p[i].max(q[i]);
    overlap(0) && overlap(1) && straddle(p, q, r, s) <= 0 && straddle(r, s, p, q) <= 0
}

/// −1 if r and s lie strictly on both sides of the line pq, 0 if one of them lies on it.
fn straddle(p: Point2, q: Point2, r: Point2, s: Point2) -> Sign {
    exact::orient2d(p, q, r) * exact::orient2d(p, q, s)
}

/// Whether no two of the signs are opposite.
fn inside(signs: [Sign; 3]) -> bool {
    signs.iter().all(|sign| *sign >= 0) || signs.iter().all(|sign| *sign <= 0)
}
