//! Whether a box of A and a box of B can meet, for one relative pose.
//!
//! A box of B is not axis-aligned in A's frame, nor is one of A in B's. Both frames' axes are tried
//! as separating axes: the first six of the fifteen of Gottschalk, Lin and Manocha, *OBBTree*
//! (1996). The nine that remain cost more than they save.

use crate::Counters;
use geometry::{Aabb, DVec3, RelativePose};
use model::{BodyView, Node};

/// B's boxes among A's.
///
/// [`Placement::apart`] is only ever said of boxes whose triangles share no point: what rounding may
/// have moved, here and in [`RelativePose::point`], is added to the reach of the boxes.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Rows of R.
    rows: [DVec3; 3],
    /// Columns of R: B's axes in A's frame.
    columns: [DVec3; 3],
    translation: DVec3,
    /// Added to every distance that must be exceeded along an axis of A [m].
    slack: f64,
    /// The same along an axis of B, where it also scales with `skew`.
    slack_b: f64,
    /// How far RᵀR is from the identity: rows of a stored rotation are rounded. No unit.
    skew: f64,
}

impl Placement {
    /// For bodies that lie within the boxes `a` and `b`, each in its own frame.
    #[must_use]
    pub fn new(pose: &RelativePose, a: &Aabb, b: &Aabb) -> Self {
        let rows = pose.rotation.map(DVec3::from_array);
        let columns = [0, 1, 2].map(|j| DVec3::new(rows[0][j], rows[1][j], rows[2][j]));
        let translation = DVec3::from_array(pose.translation);
        let reach = |box_: &Aabb| {
            let box_ = box_.bounds();
            box_.min.abs().max(box_.max.abs())
        };
        let (a, b) = (reach(a), reach(b));
        let placed = DVec3::from_array(rows.map(|row| row.abs().dot(b)));
        // No intermediate of `point` or `apart` exceeds four times this sum, of at most twenty
        // roundings each: 256 ulps cover them, and are below 1 nm for bodies within 10 km.
        let size = (placed + translation.abs() + a).element_sum();
        let slack = 256.0 * f64::EPSILON * size;
        let mut skew = 0.0_f64;
        for i in 0..3 {
            for j in 0..3 {
                let identity = if i == j { 1.0 } else { 0.0 };
                skew = skew.max((columns[i].dot(columns[j]) - identity).abs());
            }
        }
        // The dot product itself is rounded too.
        let skew = skew + 8.0 * f64::EPSILON;
        let widest = columns.iter().map(|c| c.abs().element_sum()).fold(1.0, f64::max);
        Self { rows, columns, translation, slack, slack_b: slack * widest, skew }
    }

    /// The placement of two bodies under `pose`.
    #[must_use]
    pub fn of(a: &BodyView<'_>, b: &BodyView<'_>, pose: &RelativePose) -> Self {
        Self::new(pose, &a.bounds(), &b.bounds())
    }

    /// Whether nothing in box `a` of A can meet anything in box `b` of B; each in its own frame.
    ///
    /// Boxes that are not finite, or a pose that is not, are never apart.
    #[must_use]
    #[inline]
    pub fn apart(&self, a: &Aabb, b: &Aabb) -> bool {
        let (centre_a, half_a) = centre_and_half(a);
        let (centre_b, half_b) = centre_and_half(b);
        let along = |row: DVec3, v: DVec3| row.x * v.x + row.y * v.y + row.z * v.z;
        let [x, y, z] = self.rows;
        let placed = DVec3::new(along(x, centre_b), along(y, centre_b), along(z, centre_b));
        let between = placed + self.translation - centre_a;
        let reach = |row: DVec3, half: DVec3| along(row.abs(), half);
        let reach_b = DVec3::new(reach(x, half_b), reach(y, half_b), reach(z, half_b));
        if between.abs().cmpgt(half_a + reach_b + self.slack).any() {
            return true;
        }
        let [u, v, w] = self.columns;
        let between = DVec3::new(along(u, between), along(v, between), along(w, between));
        let reach_a = DVec3::new(reach(u, half_a), reach(v, half_a), reach(w, half_a));
        let slack = self.slack_b + self.skew * half_b.element_sum();
        between.abs().cmpgt(reach_a + half_b + slack).any()
    }

    /// The same of two nodes, counted as one box-pair test.
    #[must_use]
    #[inline]
    pub fn nodes_apart(&self, a: &Node, b: &Node, counters: &mut Counters) -> bool {
        counters.nb += 1;
        self.apart(&a.bounds, &b.bounds)
    }
}

fn centre_and_half(box_: &Aabb) -> (DVec3, DVec3) {
    let box_ = box_.bounds();
    ((box_.min + box_.max) * 0.5, (box_.max - box_.min) * 0.5)
}

#[cfg(test)]
mod tests;
