//! Whether a box of A and a box of B can overlap, for one relative pose.
//!
//! A box of B is not axis-aligned in A's frame, nor is one of A in B's. Both frames' axes are tried
//! as separating axes: the first six of the fifteen of Gottschalk, Lin and Manocha, *OBBTree*
//! (1996). The remaining nine cost more than they save.

use body::BodyView;
use geometry::{Aabb, DVec3, RelativePose, Sweep};

/// Box tests between A and B.
///
/// [`Placement::apart`] is true only for boxes whose triangles share no point: whatever rounding
/// may have moved, here and in [`RelativePose::point`], is added to the reach of the boxes.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Rows of R: A's axes in B's frame.
    rows: [DVec3; 3],
    /// Columns of R: B's axes in A's frame.
    columns: [DVec3; 3],
    rows_abs: [DVec3; 3],
    columns_abs: [DVec3; 3],
    translation: DVec3,
    /// Slack (m) added to every distance along an axis of A.
    slack: f64,
    /// Slack (m) added to every distance along an axis of B; there it also scales with `skew`.
    slack_b: f64,
    /// The deviation of RᵀR from the identity, dimensionless: rows of a stored rotation are
    /// rounded.
    skew: f64,
}

/// A box of A, prepared for tests against several of B.
#[derive(Clone, Copy, Debug)]
pub struct BoxA {
    centre: DVec3,
    half: DVec3,
    /// Half extents along B's axes.
    reach: DVec3,
}

/// A box of B, prepared for tests against several of A.
#[derive(Clone, Copy, Debug)]
pub struct BoxB {
    /// Centre in A's frame.
    centre: DVec3,
    /// Half extents along A's axes, slack included.
    reach: DVec3,
    /// Half extents along B's own axes, slack included.
    half: DVec3,
}

impl Placement {
    /// Creates the test for bodies that lie within the boxes `a` and `b`, each in its own frame.
    #[must_use]
    pub fn new(pose: &RelativePose, a: &Aabb, b: &Aabb) -> Self {
        let rows = pose.rotation.map(DVec3::from_array);
        let columns = [0, 1, 2].map(|j| DVec3::new(rows[0][j], rows[1][j], rows[2][j]));
        let (rows_abs, columns_abs) = (rows.map(DVec3::abs), columns.map(DVec3::abs));
        let translation = DVec3::from_array(pose.translation);
        let reach = |box_: &Aabb| {
            let box_ = box_.bounds();
            box_.min.abs().max(box_.max.abs())
        };
        // No intermediate of `point` or `apart` exceeds four times this sum, of at most twenty
        // roundings each: 256 ulps cover them, and are below 1 nm for bodies within 10 km.
        let size = (combine(&columns_abs, reach(b)) + translation.abs() + reach(a)).element_sum();
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
        let widest = columns_abs.iter().map(|c| c.element_sum()).fold(1.0, f64::max);
        let slack_b = slack * widest;
        Self { rows, columns, rows_abs, columns_abs, translation, slack, slack_b, skew }
    }

    /// Creates the test for two bodies under `pose`.
    #[must_use]
    pub fn of(a: &BodyView<'_>, b: &BodyView<'_>, pose: &RelativePose) -> Self {
        Self::new(pose, &a.bounds(), &b.bounds())
    }

    /// Prepares a box of A, given in A's frame.
    #[must_use]
    #[inline]
    pub fn box_a(&self, box_: &Aabb) -> BoxA {
        let (centre, half) = centre_and_half(box_);
        BoxA { centre, half, reach: combine(&self.rows_abs, half) }
    }

    /// Prepares a box of B, given in B's frame.
    #[must_use]
    #[inline]
    pub fn box_b(&self, box_: &Aabb) -> BoxB {
        let (centre, half) = centre_and_half(box_);
        BoxB {
            centre: combine(&self.columns, centre) + self.translation,
            reach: combine(&self.columns_abs, half) + self.slack,
            half: half + (self.slack_b + self.skew * half.element_sum()),
        }
    }

    /// Whether nothing in `a` can intersect anything in `b`.
    ///
    /// Always false if a box or the pose is not finite.
    #[must_use]
    #[inline]
    pub fn apart(&self, a: &BoxA, b: &BoxB) -> bool {
        let between = b.centre - a.centre;
        if between.abs().cmpgt(a.half + b.reach).any() {
            return true;
        }
        combine(&self.rows, between).abs().cmpgt(a.reach + b.half).any()
    }
}

/// When boxes meet as B moves along a line: the slab test along the six axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    /// Inverses of the components of the direction along A's axes and along B's.
    inverse: [DVec3; 2],
    /// What box sides are moved out by (m).
    slack: f64,
    /// What travels are widened by (m).
    tolerance_m: f64,
    from_m: f64,
}

/// Components of directions are taken as at least this great.
const COMPONENT_MIN: f64 = 1e-9;

impl Passage {
    pub(crate) fn new(placement: &Placement, sweep: &Sweep) -> Self {
        let longest = sweep.from_m().abs().max(sweep.to_m().abs());
        let ahead = sweep.direction();
        let inverse = |d: DVec3| {
            let component = |x: f64| x.abs().max(COMPONENT_MIN).copysign(x);
            1.0 / DVec3::new(component(d.x), component(d.y), component(d.z))
        };
        Self {
            inverse: [inverse(ahead), inverse(combine(&placement.rows, ahead))],
            // Where a component is taken as greater, a box moves too far by that.
            slack: 2.0 * COMPONENT_MIN * longest + 2.0 * placement.slack_b,
            tolerance_m: 8.0 * f64::EPSILON * longest + 2.0 * geometry::sweep::TOLERANCE_M,
            from_m: sweep.from_m(),
        }
    }

    /// From when to when the boxes may share a point (m); `None` if they do not within the motion,
    /// whatever its end.
    pub(crate) fn travels(&self, placement: &Placement, a: &BoxA, b: &BoxB) -> Option<[f64; 2]> {
        let between = a.centre - b.centre;
        let slabs = [
            (between, a.half + b.reach, self.inverse[0]),
            (combine(&placement.rows, between), a.reach + b.half, self.inverse[1]),
        ];
        let (mut first, mut last) = (f64::NEG_INFINITY, f64::INFINITY);
        for (between, reach, inverse) in slabs {
            let (middle, half) = (between * inverse, (reach + self.slack) * inverse.abs());
            first = first.max((middle - half).max_element());
            last = last.min((middle + half).min_element());
        }
        let (first, last) = (first - self.tolerance_m, last + self.tolerance_m);
        let never = first > last || last < self.from_m;
        (!never).then_some([first, last])
    }
}

/// Whether a box of B, given in its own frame, and one of A are apart along an axis of A all along
/// a motion: whoever passes at a distance mostly is, and nothing else has to be prepared.
///
/// Always false if a box or the pose is not finite.
pub(crate) fn pass_apart(pose: &RelativePose, [a, b]: [&Aabb; 2], sweep: &Sweep) -> bool {
    let rows = pose.rotation.map(DVec3::from_array);
    let (of_a, half_a) = centre_and_half(a);
    let (of_b, half_b) = centre_and_half(b);
    let (from_m, to_m) = (sweep.from_m(), sweep.to_m());
    let ahead = sweep.direction().to_array();
    let (of_a, half_a) = (of_a.to_array(), half_a.to_array());
    (0..3).any(|k| {
        let (row, widest) = (rows[k], rows[k].abs());
        let shift = pose.translation[k];
        let centre = row.dot(of_b) + shift;
        let reach = widest.dot(half_b) + half_a[k];
        // As in `Placement::new`, and for the travels; and what the contact of two triangles is off
        // by, with some to spare.
        let size = widest.dot(of_b.abs() + half_b) + shift.abs() + of_a[k].abs() + half_a[k];
        let size = size + from_m.abs().max(to_m.abs());
        let margin = 256.0 * f64::EPSILON * size + 4.0 * geometry::sweep::TOLERANCE_M;
        let [begin, end] = [from_m, to_m].map(|s| centre + ahead[k] * s - of_a[k]);
        begin.min(end) > reach + margin || begin.max(end) < -(reach + margin)
    })
}

/// The sum of three vectors, each times one coordinate: R v with the columns of R, Rᵀ v with its
/// rows. Three parallel lanes suit a processor better than three dot products.
#[inline]
fn combine(vectors: &[DVec3; 3], v: DVec3) -> DVec3 {
    vectors[0] * v.x + vectors[1] * v.y + vectors[2] * v.z
}

#[inline]
fn centre_and_half(box_: &Aabb) -> (DVec3, DVec3) {
    let wide = |p: [f32; 3]| DVec3::new(p[0].into(), p[1].into(), p[2].into());
    let (min, max) = (wide(box_.min), wide(box_.max));
    ((min + max) * 0.5, (max - min) * 0.5)
}

#[cfg(test)]
mod tests;
