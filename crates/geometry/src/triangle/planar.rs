//! Triangles that are coplanar or degenerate, exactly, by dimension.
//!
//! A degenerate triangle is a segment or a point. What lies in one plane is compared in a
//! projection that drops one coordinate: on raw coordinates, so nothing is rounded, and one-to-one
//! on the plane, because three of the points span an area.

use super::exact::Projection;
use super::{A, B, Corner, Orient, Position, Sign, orient};
use crate::DVec3;

/// The corners of a triangle without repetition: three of a proper one, two ends of a segment, or a
/// point.
#[derive(Clone, Copy)]
struct Hull {
    corners: [Corner; 3],
    count: usize,
    /// For a proper triangle: the first coordinate without which it keeps an area, and its turn
    /// then.
    drop: Option<usize>,
    turn: Sign,
}

/// A segment pq, and a proper triangle whose plane separates p and q, or contains one of them.
pub(super) struct Piercing {
    p: Corner,
    q: Corner,
    triangle: [Corner; 3],
}

/// Two hulls in one plane, or on one line.
pub(super) struct Flat {
    a: Hull,
    b: Hull,
    /// A projection that preserves the plane's areas; none if all points are on one line.
    projection: Option<Projection>,
}

/// How the corners of each hull lie relative to the edges of the other, in a projection.
struct Table {
    /// `[i][k]`: on which side of A's edge i B's corner k lies.
    b_to_a: [[Sign; 3]; 3],
    /// `[k][i]`: on which side of B's edge k A's corner i lies.
    a_to_b: [[Sign; 3]; 3],
}

/// The position of two triangles of which at least one lies entirely in the other's plane.
pub(super) fn position(orient: &Orient<'_>) -> Position {
    let (a, b) = (Hull::of(orient, A), Hull::of(orient, B));
    match (a.count, b.count) {
        (3, 3) => Position::Flat(Flat::of(orient, a, b)),
        (3, _) => against_triangle(orient, b, a),
        (_, 3) => against_triangle(orient, a, b),
        _ => {
            let ([p, q], [r, s]) = (a.ends(), b.ends());
            if orient.exact().side([p, q, r], s) == 0 {
                Position::Flat(Flat::of(orient, a, b))
            } else {
                Position::Apart
            }
        }
    }
}

/// A segment or point against a proper triangle.
fn against_triangle(orient: &Orient<'_>, segment: Hull, triangle: Hull) -> Position {
    let [p, q] = segment.ends();
    match orient.exact().sides(triangle.corners, [p, q]) {
        [0, 0] => Position::Flat(Flat::of(orient, segment, triangle)),
        [1, 1] | [-1, -1] => Position::Apart,
        _ => Position::Piercing(Piercing { p, q, triangle: triangle.corners }),
    }
}

impl Piercing {
    /// Whether the segment meets the triangle: it passes no edge on the wrong side.
    pub(super) fn meet(&self, orient: &Orient<'_>) -> bool {
        let [a, b, c] = self.triangle;
        let side = |(from, to)| orient.exact().side([self.p, self.q, from], to);
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
        let ([p, q, _], [r, s, _]) = (a.corners, b.corners);
        let of_segments = || {
            (0..3).find(|drop| {
                let projection = orient.exact().without(*drop);
                [[p, q, r], [p, q, s], [r, s, p]].iter().any(|triple| projection.turn(*triple) != 0)
            })
        };
        let drop = a.drop.or(b.drop).or_else(of_segments);
        Self { a, b, projection: drop.map(|drop| orient.exact().without(drop)) }
    }

    /// Whether the hulls share a point, given that their boxes do.
    ///
    /// Convex sets in a plane are apart only if the line through an edge of one separates them. On
    /// a line, boxes overlap only where the sets do.
    pub(super) fn meet(&self) -> bool {
        let Some(projection) = &self.projection else { return true };
        !self.a.has_edge_before(&self.b, projection) && !self.b.has_edge_before(&self.a, projection)
    }

    /// Calls `push` with the corners of the overlap: corners of one hull that the other holds (some
    /// twice), and proper crossings of edges. At most six without repetition.
    pub(super) fn corners(&self, orient: &Orient<'_>, mut push: impl FnMut(DVec3)) {
        let signs = self.projection.as_ref().map(|projection| Table {
            b_to_a: sides(&self.b, &self.a, projection),
            a_to_b: sides(&self.a, &self.b, projection),
        });
        let side = |table: fn(&Table) -> &[[Sign; 3]; 3], corner: usize| {
            signs.as_ref().map_or([0; 3], |signs| table(signs).map(|edge| edge[corner]))
        };
        for (i, corner) in self.a.corners().iter().enumerate() {
            if self.b.holds(orient, *corner, side(|signs| &signs.a_to_b, i)) {
                push(orient.at(*corner));
            }
        }
        for (k, corner) in self.b.corners().iter().enumerate() {
            if self.a.holds(orient, *corner, side(|signs| &signs.b_to_a, k)) {
                push(orient.at(*corner));
            }
        }
        let (Some(signs), Some(projection)) = (&signs, &self.projection) else { return };
        for i in 0..self.a.edges() {
            for k in 0..self.b.edges() {
                if signs.cross(i, k) {
                    let ([p, q], edge) = (self.a.edge(i), self.b.edge(k));
                    let fraction = projection.cut_fraction(edge, p, q);
                    push(orient::along(orient.at(p), orient.at(q), fraction));
                }
            }
        }
    }
}

impl Table {
    /// Whether the ends of A's edge i lie strictly on both sides of the line of B's edge k, and
    /// vice versa.
    fn cross(&self, i: usize, k: usize) -> bool {
        let (a, b) = (&self.a_to_b[k], &self.b_to_a[i]);
        b[k] * b[(k + 1) % 3] < 0 && a[i] * a[(i + 1) % 3] < 0
    }
}

impl Hull {
    fn of(orient: &Orient<'_>, corners: [Corner; 3]) -> Self {
        let normal = orient.exact().normal_signs(corners);
        if let Some(drop) = normal.iter().position(|sign| *sign != 0) {
            return Self { corners, count: 3, drop: Some(drop), turn: normal[drop] };
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
        Self { corners: [low, high, high], count, drop: None, turn: 0 }
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// The ends of a segment; a point twice.
    fn ends(&self) -> [Corner; 2] {
        [self.corners[0], self.corners[1]]
    }

    /// The number of edges: three for a triangle, else the one segment, possibly of length 0.
    fn edges(&self) -> usize {
        if self.count == 3 { 3 } else { 1 }
    }

    fn edge(&self, i: usize) -> [Corner; 2] {
        [self.corners[i], self.corners[(i + 1) % 3]]
    }

    /// Whether `other` lies strictly beyond the line of an edge: of a segment, on either side.
    fn has_edge_before(&self, other: &Self, projection: &Projection) -> bool {
        (0..self.edges()).any(|i| {
            let [p, q] = self.edge(i);
            let side = |corner: Corner| projection.turn([p, q, corner]);
            let first = side(other.corners[0]);
            first != 0
                && first != self.turn
                && other.corners()[1..].iter().all(|corner| side(*corner) == first)
        })
    }

    /// Whether the hull contains a point of its plane (or its line) that lies on these sides of its
    /// edges.
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
fn sides(other: &Hull, hull: &Hull, projection: &Projection) -> [[Sign; 3]; 3] {
    let mut sides = [[0; 3]; 3];
    for (i, sides) in sides.iter_mut().enumerate().take(hull.edges()) {
        let [p, q] = hull.edge(i);
        *sides = other.corners.map(|corner| projection.turn([p, q, corner]));
    }
    sides
}

/// Whether no two of the signs are opposite.
fn inside(signs: [Sign; 3]) -> bool {
    signs.iter().all(|sign| *sign >= 0) || signs.iter().all(|sign| *sign <= 0)
}
