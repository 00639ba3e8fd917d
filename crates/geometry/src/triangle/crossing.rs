//! Two proper triangles in planes that cross: two intervals on one line.
//!
//! The corners are rotated so that each triangle has its *apex* p alone on one side of the other's
//! plane, and mirrored so that this is the side of the other's normal. Then A cuts the common line
//! between j (on its edge pr) and i (on pq), and B between k (on its edge pq) and l (on pr), all in
//! one direction, and each comparison of ends is the sign of a determinant of their two edges:
//!
//! ```text
//!       j ======A====== i
//!            k ======B====== l        meet if k ≤ i and j ≤ l
//! ```

use super::{A, B, Corner, Orient, Sign};
use crate::DVec3;

/// Two triangles, neither degenerate, in different planes, each with corners on both closed sides
/// of the other's plane, with corners ordered as the module describes.
pub(super) struct Crossing {
    a: [Corner; 3],
    b: [Corner; 3],
}

impl Crossing {
    /// `sides_a` are the sides of B's plane on which A's corners lie, `sides_b` the reverse;
    /// neither are all zero, nor all strictly on one side.
    #[inline]
    pub(super) fn new(sides_a: [Sign; 3], sides_b: [Sign; 3]) -> Self {
        let (apex_a, mirror_b) = apex(sides_a);
        let (apex_b, mirror_a) = apex(sides_b);
        Self { a: turned(A, apex_a, mirror_a), b: turned(B, apex_b, mirror_b) }
    }

    /// Whether the intervals share a point.
    #[inline]
    pub(super) fn meet(&self, orient: &Orient<'_>) -> bool {
        let ([pa, qa, ra], [pb, qb, rb]) = (self.a, self.b);
        orient.sign([pa, qa, pb, qb]) <= 0 && orient.sign([pa, ra, pb, rb]) >= 0
    }

    /// Calls `push` with the ends of the common interval, if there is one: one or two points.
    pub(super) fn ends(&self, orient: &Orient<'_>, mut push: impl FnMut(DVec3)) {
        let (a, b) = (self.a, self.b);
        let ([pa, qa, ra], [pb, qb, rb]) = (a, b);
        let (i_to_k, j_to_l) = (orient.sign([pa, qa, pb, qb]), orient.sign([pa, ra, pb, rb]));
        if i_to_k > 0 || j_to_l < 0 {
            return;
        }
        let upper_is_i = orient.sign([pa, qa, pb, rb]) >= 0;
        push(if upper_is_i { orient.cut(b, pa, qa) } else { orient.cut(a, pb, rb) });
        if i_to_k == 0 || j_to_l == 0 {
            return;
        }
        let lower_is_k = orient.sign([pa, ra, pb, qb]) > 0;
        push(if lower_is_k { orient.cut(a, pb, qb) } else { orient.cut(b, pa, ra) });
    }
}

/// Returns which corner is alone on its side of the other's plane, and whether that is the negative
/// side.
fn apex(sides: [Sign; 3]) -> (usize, bool) {
    let [p, q, r] = sides;
    APEX[(9 * p + 3 * q + r + 13) as usize]
}

/// [`apex`] indexed by the three sides, −1 first: a table, because a search would mispredict its
/// branches.
const APEX: [(usize, bool); 27] = {
    let mut table = [(0, false); 27];
    let mut code = 0;
    while code < 27 {
        table[code as usize] = find_apex([code / 9 - 1, code / 3 % 3 - 1, code % 3 - 1]);
        code += 1;
    }
    table
};

/// A corner on the plane counts to either side, but both edges at the apex must leave the plane.
const fn find_apex(sides: [Sign; 3]) -> (usize, bool) {
    let mut on_plane = 0;
    let mut i = 0;
    while i < 3 {
        let (p, q, r) = (sides[i], sides[(i + 1) % 3], sides[(i + 2) % 3]);
        if p * q <= 0 && p * r <= 0 && p != 0 {
            return (i, p < 0);
        }
        if p == 0 {
            on_plane = i;
        }
        i += 1;
    }
    // The remaining case: one corner on the plane, the others together on one side.
    (on_plane, sides[(on_plane + 1) % 3] > 0)
}

/// The corners from `apex` on, the other two exchanged if `mirror`.
fn turned(corners: [Corner; 3], apex: usize, mirror: bool) -> [Corner; 3] {
    const NEXT: [usize; 3] = [1, 2, 0];
    let (q, r) = (NEXT[apex], NEXT[NEXT[apex]]);
    let (q, r) = if mirror { (r, q) } else { (q, r) };
    [corners[apex], corners[q], corners[r]]
}
