//! Two true triangles in planes that cross: two intervals on one line.
//!
//! The triangles are turned so that each has its *apex* p alone on one side of the other's plane,
//! and mirrored so that this is the side of the other's normal. Then A cuts the common line
//! between j (on its edge pr) and i (on pq), and B between k (on its edge pq) and l (on pr), all
//! in one direction, and each comparison of ends is the sign of a determinant of their two edges:
//!
//! ```text
//!       j ======A====== i
//!            k ======B====== l        meet if k ≤ i and j ≤ l
//! ```

use super::exact::Sign;
use super::{Orient, Triangle};
use crate::DVec3;

/// Two triangles, neither degenerate, in different planes, each with corners on both closed sides
/// of the other's plane: turned as the module says.
pub(super) struct Crossing {
    a: [DVec3; 3],
    b: [DVec3; 3],
}

impl Crossing {
    /// `sides_a` are those of A's corners to B's plane, `sides_b` the other way round; neither are
    /// all zero, nor all strictly on one side.
    pub(super) fn new(a: &Triangle, sides_a: [Sign; 3], b: &Triangle, sides_b: [Sign; 3]) -> Self {
        let (apex_a, mirror_b) = apex(sides_a);
        let (apex_b, mirror_a) = apex(sides_b);
        Self { a: turned(&a.0, apex_a, mirror_a), b: turned(&b.0, apex_b, mirror_b) }
    }

    /// Whether the intervals share a point.
    pub(super) fn meet(&self, orient: &Orient) -> bool {
        let ([pa, qa, ra], [pb, qb, rb]) = (self.a, self.b);
        orient.sign(pa, qa, pb, qb) <= 0 && orient.sign(pa, ra, pb, rb) >= 0
    }

    /// Calls `push` with the ends of the common interval, if there is one: one or two points.
    pub(super) fn ends(&self, orient: &Orient, mut push: impl FnMut(DVec3)) {
        let ([pa, qa, ra], [pb, qb, rb]) = (self.a, self.b);
        let (i_to_k, j_to_l) = (orient.sign(pa, qa, pb, qb), orient.sign(pa, ra, pb, rb));
        if i_to_k > 0 || j_to_l < 0 {
            return;
        }
        let upper_is_i = orient.sign(pa, qa, pb, rb) >= 0;
        push(if upper_is_i { orient.cut(&self.b, pa, qa) } else { orient.cut(&self.a, pb, rb) });
        if i_to_k == 0 || j_to_l == 0 {
            return;
        }
        let lower_is_k = orient.sign(pa, ra, pb, qb) > 0;
        push(if lower_is_k { orient.cut(&self.a, pb, qb) } else { orient.cut(&self.b, pa, ra) });
    }
}

/// Which corner is alone on its side of the other's plane, and whether that is the negative side.
///
/// A corner on the plane counts to either side, but both edges at the apex must leave the plane.
fn apex(sides: [Sign; 3]) -> (usize, bool) {
    for i in 0..3 {
        let [p, q, r] = [0, 1, 2].map(|k| sides[(i + k) % 3]);
        if p * q <= 0 && p * r <= 0 && p != 0 {
            return (i, p < 0);
        }
    }
    // What is left: one corner on the plane, the others together on one side.
    let i = sides.iter().position(|side| *side == 0).unwrap_or(0);
    (i, sides[(i + 1) % 3] > 0)
}

/// The corners from `apex` on, the other two exchanged if `mirror`.
fn turned(corners: &[DVec3; 3], apex: usize, mirror: bool) -> [DVec3; 3] {
    let [p, q, r] = [0, 1, 2].map(|k| corners[(apex + k) % 3]);
    if mirror { [p, r, q] } else { [p, q, r] }
}
