//! Triangles that are coplanar or degenerate, exactly, by dimension.
//!
//! A degenerate triangle is a segment or a point. What lies in one plane is compared in a
//! projection that drops one coordinate: on raw coordinates, so nothing is rounded, and one-to-one
//! on the plane, because three of the points keep an area.

use super::exact::Exact;
use super::{A, B, Corner, Orient, Position, Sign, orient};
use crate::DVec3;

/// The corners of a triangle without repetition: three of a true one, two ends of a segment, or a
/// point.
#[derive(Clone, Copy)]
struct Hull {
    corners: [Corner; 3],
    count: usize,
    /// Of a true triangle: a coordinate without which it still has an area.
    projection: Option<usize>,
}

/// A segment pq, and a true triangle whose plane separates p and q, or holds one of them.
pub(super) struct Piercing {
    p: Corner,
    q: Corner,
    triangle: [Corner; 3],
}

/// Two hulls in one plane, or on one line.
pub(super) struct Flat {
    a: Hull,
    b: Hull,
    /// The coordinate that a projection of the plane drops; none if all is on one line.
    drop: Option<usize>,
}

/// How the corners of each hull lie to the edges of the other, in a projection.
struct Plane {
    drop: usize,
    /// `[i][k]`: on which side of A's edge i B's corner k lies.
    b_to_a: [[Sign; 3]; 3],
    /// `[k][i]`: on which side of B's edge k A's corner i lies.
    a_to_b: [[Sign; 3]; 3],
}

/// The position of two triangles of which at least one has no corner off the other's plane.
pub(super) fn position(orient: &Orient<'_>) -> Position {
    let (a, b) = (Hull::of(orient, A), Hull::of(orient, B));
    match (a.count, b.count) {
        (3, 3) => Position::Flat(Flat::of(orient, a, b)),
        (3, _) => against_triangle(orient, b, a),
        (_, 3) => against_triangle(orient, a, b),
        _ => {
            let ([p, q], [r, s]) = (a.ends(), b.ends());
            if orient.exact().orient3d([p, q, r, s]) == 0 {
                Position::Flat(Flat::of(orient, a, b))
            } else {
                Position::Apart
            }
        }
    }
}

/// A segment or point against a true triangle.
fn against_triangle(orient: &Orient<'_>, segment: Hull, triangle: Hull) -> Position {
    let [a, b, c] = triangle.corners;
    let [p, q] = segment.ends();
    match [p, q].map(|end| orient.exact().orient3d([a, b, c, end])) {
        [0, 0] => Position::Flat(Flat::of(orient, segment, triangle)),
        [1, 1] | [-1, -1] => Position::Apart,
        _ => Position::Piercing(Piercing { p, q, triangle: triangle.corners }),
    }
}

impl Piercing {
    /// Whether the segment meets the triangle: it passes no edge on the wrong side.
    pub(super) fn meet(&self, orient: &Orient<'_>) -> bool {
        let [a, b, c] = self.triangle;
        let side = |(from, to)| orient.exact().orient3d([self.p, self.q, from, to]);
        inside([(a, b), (b, c), (c, a)].map(side))
    }

    /// Calls `push` with the common point, if there is one.
    pub(super) fn point(&self, orient: &Orient<'_>, mut push: impl FnMut(DVec3)) {
        if self.meet(orient) {
            push(orient.cut(self.triangle, self.p, self.q));
        }
    }
}

impl Flat {
    fn of(orient: &Orient<'_>, a: Hull, b: Hull) -> Self {
        let of_triangle = a.projection.or(b.projection);
        let ([p, q, _], [r, s, _]) = (a.corners, b.corners);
        let of_segments = || {
            (0..3).find(|drop| {
                let area = |triple| orient.exact().orient2d(*drop, triple) != 0;
                area([p, q, r]) || area([p, q, s]) || area([r, s, p])
            })
        };
        Self { a, b, drop: of_triangle.or_else(of_segments) }
    }

    /// Whether the hulls share a point, given that their boxes do.
    ///
    /// Convex sets in a plane are apart only if the line through an edge of one separates them. On
    /// a line, boxes overlap only where the sets do.
    pub(super) fn meet(&self, orient: &Orient<'_>) -> bool {
        let Some(drop) = self.drop else { return true };
        let exact = orient.exact();
        !self.a.has_edge_before(&self.b, exact, drop)
            && !self.b.has_edge_before(&self.a, exact, drop)
    }

    /// Calls `push` with the corners of the overlap: corners of one hull that the other holds (some
    /// twice), and proper crossings of edges. Without repetition at most six.
    pub(super) fn corners(&self, orient: &Orient<'_>, mut push: impl FnMut(DVec3)) {
        let exact = orient.exact();
        let plane = self.drop.map(|drop| Plane {
            drop,
            b_to_a: sides(&self.b, &self.a, exact, drop),
            a_to_b: sides(&self.a, &self.b, exact, drop),
        });
        let side = |table: fn(&Plane) -> &[[Sign; 3]; 3], corner: usize| {
            plane.as_ref().map_or([0; 3], |plane| table(plane).map(|edge| edge[corner]))
        };
        for (i, corner) in self.a.corners().iter().enumerate() {
            if self.b.holds(orient, *corner, side(|plane| &plane.a_to_b, i)) {
                push(orient.at(*corner));
            }
        }
        for (k, corner) in self.b.corners().iter().enumerate() {
            if self.a.holds(orient, *corner, side(|plane| &plane.b_to_a, k)) {
                push(orient.at(*corner));
            }
        }
        let Some(plane) = &plane else { return };
        for i in 0..self.a.edges() {
            for k in 0..self.b.edges() {
                if plane.cross(i, k) {
                    let ([p, q], edge) = (self.a.edge(i), self.b.edge(k));
                    let fraction = exact.cut_fraction2d(plane.drop, edge, p, q);
                    push(orient::along(orient.at(p), orient.at(q), fraction));
                }
            }
        }
    }
}

impl Plane {
    /// Whether the ends of A's edge i lie strictly on both sides of the line of B's edge k, and the
    /// other way round.
    fn cross(&self, i: usize, k: usize) -> bool {
        let (a, b) = (&self.a_to_b[k], &self.b_to_a[i]);
        b[k] * b[(k + 1) % 3] < 0 && a[i] * a[(i + 1) % 3] < 0
    }
}

impl Hull {
    fn of(orient: &Orient<'_>, corners: [Corner; 3]) -> Self {
        for drop in 0..3 {
            if orient.exact().orient2d(drop, corners) != 0 {
                return Self { corners, count: 3, projection: Some(drop) };
            }
        }
        // Along a line the lexicographic order is the order on the line.
        let before = |p: Corner, q: Corner| {
            let (p, q) = (orient.at(p), orient.at(q));
            (p.x, p.y, p.z) < (q.x, q.y, q.z)
        };
        let [a, b, c] = corners;
        let low = [b, c].into_iter().fold(a, |low, p| if before(p, low) { p } else { low });
        let high = [b, c].into_iter().fold(a, |high, p| if before(high, p) { p } else { high });
        let count = if orient.at(low) == orient.at(high) { 1 } else { 2 };
        Self { corners: [low, high, high], count, projection: None }
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// The ends of a segment; twice a point.
    fn ends(&self) -> [Corner; 2] {
        [self.corners[0], self.corners[1]]
    }

    /// How many edges: three of a triangle, else the one segment, perhaps of length 0.
    fn edges(&self) -> usize {
        if self.count == 3 { 3 } else { 1 }
    }

    fn edge(&self, i: usize) -> [Corner; 2] {
        [self.corners[i], self.corners[(i + 1) % 3]]
    }

    /// Whether `other` lies strictly beyond the line of an edge: of a segment, on either side.
    fn has_edge_before(&self, other: &Self, exact: &Exact, drop: usize) -> bool {
        let inner = if self.count == 3 { exact.orient2d(drop, self.corners) } else { 0 };
        (0..self.edges()).any(|i| {
            let [p, q] = self.edge(i);
            let side = |corner: Corner| exact.orient2d(drop, [p, q, corner]);
            let first = side(other.corners[0]);
            first != 0
                && first != inner
                && other.corners()[1..].iter().all(|corner| side(*corner) == first)
        })
    }

    /// Whether it holds a point of its plane (or its line) that lies on these sides of its edges.
    fn holds(&self, orient: &Orient<'_>, point: Corner, sides: [Sign; 3]) -> bool {
        if self.count == 3 {
            return inside(sides);
        }
        let [p, q] = self.ends().map(|end| orient.at(end));
        let point = orient.at(point);
        sides[0] == 0 && p.min(q).cmple(point).all() && point.cmple(p.max(q)).all()
    }
}

/// `[i][k]`: on which side of edge i of `hull` corner k of `other` lies.
fn sides(other: &Hull, hull: &Hull, exact: &Exact, drop: usize) -> [[Sign; 3]; 3] {
    let mut sides = [[0; 3]; 3];
    for (i, sides) in sides.iter_mut().enumerate().take(hull.edges()) {
        let [p, q] = hull.edge(i);
        *sides = other.corners.map(|corner| exact.orient2d(drop, [p, q, corner]));
    }
    sides
}

/// Whether no two of the signs are opposite.
fn inside(signs: [Sign; 3]) -> bool {
    signs.iter().all(|sign| *sign >= 0) || signs.iter().all(|sign| *sign <= 0)
}
