//! The travels at which two triangles touch, exactly, for all that f64 leaves in doubt: edges and
//! planes along the motion, coplanar and degenerate triangles.
//!
//! The travels are those of a linear programme: least and greatest s with a point of A equal to a
//! point of B moved by s·d. Its optima are basic solutions, in which at most four corners take
//! part: a corner on a face, two edges that cross, a corner on an edge, or two corners (G. B.
//! Dantzig, *Linear Programming and Extensions*, 1963). All are tried; each is feasible or not by
//! the signs of a few determinants, and its travel is a quotient of two.

use super::numbers::{Arm, Number, Numbers};
use super::{Feature, Interval};
use crate::DVec3;
use crate::triangle::{A, B, Corner, Sign, Triangle};

/// The travels, if there are any.
pub(super) fn interval(a: &Triangle, b: &Triangle, direction: DVec3) -> Option<Interval> {
    let (box_a, box_b) = (a.bounds(), b.bounds());
    let extent = (box_a.max.max(box_b.max) - box_a.min.min(box_b.min)).max_element();
    let ([a0, a1, a2], [b0, b1, b2]) = (&a.0, &b.0);
    let numbers = Numbers::of([a0, a1, a2, b0, b1, b2], extent, direction);
    let mut search = Search { numbers, found: None };
    search.run();
    search.found
}

struct Search<'t> {
    numbers: Numbers<'t>,
    found: Option<Interval>,
}

/// An edge of a triangle, by its ends.
fn edge(of: [Corner; 3], i: usize) -> [Corner; 2] {
    [of[i], of[(i + 1) % 3]]
}

impl Search<'_> {
    fn run(&mut self) {
        let side = |[p, q]: [Corner; 2], r: Corner| {
            let arms = [Arm::Between(p, q), Arm::Between(p, r), Arm::Direction];
            self.numbers.determinant(arms)
        };
        let to_b = [0, 1, 2].map(|k| A.map(|r| side(edge(B, k), r)));
        let b_sides = [0, 1, 2].map(|i| B.map(|r| side(edge(A, i), r).sign));
        let a_sides = to_b.map(|sides| sides.map(|side| side.sign));
        let (area_a, area_b) = (side(edge(A, 0), A[2]).sign, side(edge(B, 0), B[2]).sign);
        for k in 0..3 {
            if area_a != 0 && is_inside(b_sides.map(|sides| sides[k])) {
                self.corner_on_face(A, B[k], Feature::CornerOfB(k));
            }
            if area_b != 0 && is_inside(a_sides.map(|sides| sides[k])) {
                self.corner_on_face(B, A[k], Feature::CornerOfA(k));
            }
        }
        for (i, b_to_edge) in b_sides.iter().enumerate() {
            for (k, a_to_edge) in a_sides.iter().enumerate() {
                let do_cross = b_to_edge[k] * b_to_edge[(k + 1) % 3] <= 0
                    && a_to_edge[i] * a_to_edge[(i + 1) % 3] <= 0;
                if do_cross {
                    self.edges(i, k, to_b[k][i].share(to_b[k][(i + 1) % 3]));
                }
            }
        }
        // Two triangles with an area across the motion need no more: their overlap has corners of
        // one in the other and proper crossings alone.
        if area_a != 0 && area_b != 0 {
            return;
        }
        for i in 0..3 {
            for k in 0..3 {
                if b_sides[i][k] == 0 {
                    self.corner_on_edge(edge(A, i), B[k], Feature::CornerOfB(k));
                }
                if a_sides[i][k] == 0 {
                    self.corner_on_edge(edge(B, i), A[k], Feature::CornerOfA(k));
                }
                self.corners(i, k);
            }
        }
    }

    /// Takes a travel: that of B, as a quotient.
    fn add(&mut self, feature: Feature, travel: Number, over: Number) {
        let travel = travel.over(over);
        let found = self.found.get_or_insert(Interval {
            start: travel,
            end: travel,
            first: feature,
            last: feature,
        });
        if travel < found.start {
            (found.start, found.first) = (travel, feature);
        }
        if travel > found.end {
            (found.end, found.last) = (travel, feature);
        }
    }

    /// A corner that lies in a triangle's projection, which has an area.
    fn corner_on_face(&mut self, face: [Corner; 3], corner: Corner, feature: Feature) {
        let [p, q, r] = face;
        let [u, v] = [Arm::Between(p, q), Arm::Between(p, r)];
        let towards = b_to_a(corner, p);
        let travel = self.numbers.determinant([u, v, towards]);
        let over = self.numbers.determinant([u, v, Arm::Direction]);
        self.add(feature, travel, over);
    }

    /// Two edges whose projections share a point, at this share of A's, unless these are parallel.
    fn edges(&mut self, i: usize, k: usize, share: f64) {
        let ([p, q], [r, s]) = (edge(A, i), edge(B, k));
        let [u, v] = [Arm::Between(p, q), Arm::Between(r, s)];
        let over = self.numbers.determinant([u, v, Arm::Direction]);
        if over.sign != 0 {
            let travel = self.numbers.determinant([u, v, Arm::Between(r, p)]);
            self.add(Feature::EdgeOfA(i, share), travel, over);
        }
    }

    /// A corner whose projection lies on the line of that of an edge.
    fn corner_on_edge(&mut self, [p, q]: [Corner; 2], corner: Corner, feature: Feature) {
        let along = Arm::Between(p, q);
        // A coordinate in which the edge has an extent across the motion.
        let spans = (0..3).map(|k| (k, self.numbers.area(k, [along, Arm::Direction])));
        let Some((k, span)) = spans.into_iter().find(|(_, span)| span.sign != 0) else { return };
        let from = |end: Corner| {
            self.numbers.area(k, [Arm::Between(end, corner), Arm::Direction]).sign * span.sign
        };
        if from(p) < 0 || from(q) > 0 {
            return;
        }
        // Between p and b + s·d lies a piece of the edge: s·(d × e) = (p − b) × e.
        let travel = self.numbers.area(k, [b_to_a(corner, p), along]);
        let over = self.numbers.area(k, [Arm::Direction, along]);
        self.add(feature, travel, over);
    }

    /// Two corners, if one moves into the other.
    fn corners(&mut self, i: usize, k: usize) {
        let between = Arm::Between(B[k], A[i]);
        let is_ahead = (0..3).all(|j| self.numbers.area(j, [between, Arm::Direction]).sign == 0);
        let lengths = (0..3).map(|j| (j, self.numbers.length(j, Arm::Direction)));
        let way = lengths.into_iter().find(|(_, length)| length.sign != 0);
        if let (true, Some((j, over))) = (is_ahead, way) {
            let travel = self.numbers.length(j, between);
            self.add(Feature::CornerOfA(i), travel, over);
        }
    }
}

/// From that of two corners which is B's to that which is A's: travel is measured that way.
fn b_to_a(corner: Corner, other: Corner) -> Arm {
    if corner >= B[0] { Arm::Between(corner, other) } else { Arm::Between(other, corner) }
}

/// Whether no two of the signs are opposite.
fn is_inside(signs: [Sign; 3]) -> bool {
    signs.iter().all(|sign| *sign >= 0) || signs.iter().all(|sign| *sign <= 0)
}
