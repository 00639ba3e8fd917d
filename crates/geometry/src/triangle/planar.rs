//! Triangles that are coplanar or degenerate, exactly, by dimension.
//!
//! A degenerate triangle is a segment or a point. What lies in one plane is compared in a
//! projection that drops one coordinate: on raw coordinates, so nothing is rounded, and one-to-one
//! on the plane, because three of the points keep an area.

use super::exact::{self, Point2, Sign};
use super::{Orient, Position, Triangle, orient};
use crate::DVec3;

/// The corners of a triangle without repetition: three of a true one, two ends of a segment, or a
/// point.
struct Hull {
    corners: [DVec3; 3],
    count: usize,
}

/// A segment pq, and a true triangle whose plane separates p and q, or holds one of them.
pub(super) struct Piercing {
    p: DVec3,
    q: DVec3,
    triangle: [DVec3; 3],
}

/// Two hulls in one plane, or on one line.
pub(super) struct Flat {
    a: Hull,
    b: Hull,
    /// None if all is on one line.
    plane: Option<Plane>,
}

/// How the corners of each hull lie to the edges of the other, in a projection.
struct Plane {
    /// The coordinate that the projection drops.
    drop: usize,
    /// `[i][k]`: on which side of A's edge i B's corner k lies.
    b_to_a: [[Sign; 3]; 3],
    /// `[k][i]`: on which side of B's edge k A's corner i lies.
    a_to_b: [[Sign; 3]; 3],
}

/// The position of two triangles of which at least one has no corner off the other's plane.
#[cold]
pub(super) fn position(a: &Triangle, b: &Triangle) -> Position<'static> {
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
fn against_triangle(segment: Hull, triangle: Hull) -> Position<'static> {
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
    fn of(a: Hull, b: Hull) -> Position<'static> {
        let plane = projection(&a, &b).map(|drop| Plane {
            drop,
            b_to_a: sides(&b, &a, drop),
            a_to_b: sides(&a, &b, drop),
        });
        Position::Flat(Self { a, b, plane })
    }

    /// Whether the hulls share a point, given that their boxes do.
    pub(super) fn meet(&self) -> bool {
        // On a line, boxes overlap only where the sets do.
        let Some(plane) = &self.plane else { return true };
        self.edge_pairs().any(|(i, k)| {
            // Each touches or straddles the other's line. On one line, only if the boxes overlap.
            let (p, q) = self.a.edge(i);
            let (r, s) = self.b.edge(k);
            plane.straddle(i, k).iter().all(|product| *product <= 0)
                && p.min(q).cmple(r.max(s)).all()
                && r.min(s).cmple(p.max(q)).all()
        }) || self.a.holds(self.b.corners[0], plane.b_to_a.map(|edge| edge[0]))
            || self.b.holds(self.a.corners[0], plane.a_to_b.map(|edge| edge[0]))
    }

    /// Calls `push` with the corners of the overlap: corners of one hull that the other holds (some
    /// twice), and proper crossings of edges. Without repetition at most six.
    pub(super) fn corners(&self, mut push: impl FnMut(DVec3)) {
        let side = |table: fn(&Plane) -> &[[Sign; 3]; 3], corner: usize| {
            self.plane.as_ref().map_or([0; 3], |plane| table(plane).map(|edge| edge[corner]))
        };
        for (i, corner) in self.a.corners().iter().enumerate() {
            if self.b.holds(*corner, side(|plane| &plane.a_to_b, i)) {
                push(*corner);
            }
        }
        for (k, corner) in self.b.corners().iter().enumerate() {
            if self.a.holds(*corner, side(|plane| &plane.b_to_a, k)) {
                push(*corner);
            }
        }
        let Some(plane) = &self.plane else { return };
        for (i, k) in self.edge_pairs().filter(|(i, k)| plane.straddle(*i, *k) == [-1, -1]) {
            let (p, q) = self.a.edge(i);
            let (r, s) = self.b.edge(k);
            let [p2, q2, r2, s2] = [p, q, r, s].map(|point| flat(point, plane.drop));
            push(orient::along(p, q, exact::cut_fraction2d(r2, s2, p2, q2)));
        }
    }

    fn edge_pairs(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.a.edges()).flat_map(|i| (0..self.b.edges()).map(move |k| (i, k)))
    }
}

impl Plane {
    /// For A's edge i and B's edge k: −1 if the ends of the other lie strictly on both sides of its
    /// line, 0 if one of them lies on it; first for the line of A's edge, then for that of B's.
    fn straddle(&self, i: usize, k: usize) -> [Sign; 2] {
        let (a, b) = (&self.a_to_b[k], &self.b_to_a[i]);
        [b[k] * b[(k + 1) % 3], a[i] * a[(i + 1) % 3]]
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

    /// How many edges: three of a triangle, else the one segment, perhaps of length 0.
    fn edges(&self) -> usize {
        if self.count == 3 { 3 } else { 1 }
    }

    fn edge(&self, i: usize) -> (DVec3, DVec3) {
        (self.corners[i], self.corners[(i + 1) % 3])
    }

    /// Whether it holds a point of its plane (or its line) that lies on these sides of its edges.
    fn holds(&self, point: DVec3, sides: [Sign; 3]) -> bool {
        if self.count == 3 {
            return inside(sides);
        }
        let [p, q] = self.ends();
        sides[0] == 0 && p.min(q).cmple(point).all() && point.cmple(p.max(q)).all()
    }
}

/// `[i][k]`: on which side of edge i of `hull` corner k of `other` lies.
fn sides(other: &Hull, hull: &Hull, drop: usize) -> [[Sign; 3]; 3] {
    let corners = other.corners.map(|corner| flat(corner, drop));
    let mut sides = [[0; 3]; 3];
    for (i, sides) in sides.iter_mut().enumerate().take(hull.edges()) {
        let (p, q) = hull.edge(i);
        *sides = corners.map(|corner| exact::orient2d(flat(p, drop), flat(q, drop), corner));
    }
    sides
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

/// Whether no two of the signs are opposite.
fn inside(signs: [Sign; 3]) -> bool {
    signs.iter().all(|sign| *sign >= 0) || signs.iter().all(|sign| *sign <= 0)
}
