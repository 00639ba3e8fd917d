//! Eight boxes of A against eight of B at once, in f32.
//!
//! The boxes of one body are moved into the frame of the other, where they become larger boxes, and
//! compared there axis by axis; then the same the other way round, where the first test left
//! anything. Together these are the six tests of [`crate::Placement`].
//!
//! # What rounding may do
//!
//! Stored boxes are exact; only moving one rounds. With u = 2⁻²⁴ and S the sum of magnitudes of
//! all terms of a coordinate, centre and half extent are off by u, a matrix entry and its product
//! by 2u, three sums by 3u: at most 6u·S for the centre, as much for the reach, and 2u·S more where
//! they are subtracted. [`ROUNDING`] is 32u, and S is taken for the whole body once. On the way
//! into B's frame, that R is not quite a rotation counts too: what [`RelativePose::point`] moved by
//! R comes back by Rᵀ, which misses by (RᵀR − I) times the point.

use fearless_simd::{Simd, SimdBase, SimdMask, f32x8};
use geometry::{Aabb, DVec3, RelativePose};
use model::{BodyView, WideNode};

/// 32 u.
const ROUNDING: f64 = 1.0 / (1 << 19) as f64;

/// Sizes (m) for which nothing overflows in f32, and nothing that matters underflows.
const SIZES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// How boxes of one frame lie in the other.
#[derive(Clone, Copy, Debug)]
struct Motion {
    rows: [[f32; 3]; 3],
    rows_abs: [[f32; 3]; 3],
    shift: [f32; 3],
    /// Added to every reach (m).
    slack: [f32; 3],
}

/// Both ways between the frames of A and B, for boxes within two bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    to_a: Motion,
    to_b: Motion,
}

/// Eight boxes in one frame.
#[derive(Clone, Copy)]
struct Boxes<S: Simd> {
    min: [f32x8<S>; 3],
    max: [f32x8<S>; 3],
}

impl Frames {
    /// `None` where f32 cannot hold what would have to be computed: bodies of less than 10⁻³⁰ m or
    /// more than 10³⁰ m, or a pose that is not finite.
    pub(super) fn of(a: &BodyView<'_>, b: &BodyView<'_>, pose: &RelativePose) -> Option<Self> {
        let rows = pose.rotation.map(DVec3::from_array);
        let columns = [0, 1, 2].map(|j| DVec3::new(rows[0][j], rows[1][j], rows[2][j]));
        let t = DVec3::from_array(pose.translation);
        let reach = |box_: Aabb| {
            let box_ = box_.bounds();
            box_.min.abs().max(box_.max.abs())
        };
        let (reach_a, reach_b) = (reach(a.bounds()), reach(b.bounds()));
        let mut skew = 0.0_f64;
        for i in 0..3 {
            for j in 0..3 {
                let identity = if i == j { 1.0 } else { 0.0 };
                skew = skew.max((columns[i].dot(columns[j]) - identity).abs());
            }
        }
        let back = [0, 1, 2].map(|j| -columns[j].dot(t));
        let size_in_a = DVec3::from_array(rows.map(|row| row.abs().dot(reach_b))) + t.abs();
        let in_a = reach_a + t.abs();
        let size_in_b = DVec3::from_array(columns.map(|column| column.abs().dot(in_a))) + reach_b;
        let size = size_in_a.element_sum() + size_in_b.element_sum();
        if !SIZES.contains(&size) || !skew.is_finite() {
            return None;
        }
        let lost = skew * reach_b.element_sum();
        Some(Self {
            to_a: Motion::new(rows, t, size_in_a * ROUNDING),
            to_b: Motion::new(columns, DVec3::from_array(back), size_in_b * ROUNDING + lost),
        })
    }

    /// Which boxes of `a` can meet which of `b`: bit 8i + j for lane i of A and lane j of B.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, a: &WideNode, b: &WideNode) -> u64 {
        let (of_a, of_b) = (Boxes::of(simd, a), Boxes::of(simd, b));
        let moved = self.to_a.moved(simd, &of_b);
        let meeting = moved.meet_each(simd, &a.min, &a.max);
        if meeting == 0 {
            return 0;
        }
        let Boxes { min: [x, y, z], max: [u, v, w] } = self.to_b.moved(simd, &of_a);
        meeting
            & of_b.meet_each(simd, &[x.into(), y.into(), z.into()], &[u.into(), v.into(), w.into()])
    }

    /// Which boxes of `a` can meet the one box of B: bit i for lane i.
    #[inline(always)]
    pub(super) fn meet_one_of_b<S: Simd>(&self, simd: S, a: &WideNode, b: &Aabb) -> u64 {
        let (of_a, of_b) = (Boxes::of(simd, a), Boxes::splat(simd, b));
        let in_a = self.to_a.moved(simd, &of_b).overlap(&of_a);
        in_a & self.to_b.moved(simd, &of_a).overlap(&of_b)
    }

    /// Which boxes of `b` can meet the one box of A: bit j for lane j.
    #[inline(always)]
    pub(super) fn meet_one_of_a<S: Simd>(&self, simd: S, a: &Aabb, b: &WideNode) -> u64 {
        let (of_a, of_b) = (Boxes::splat(simd, a), Boxes::of(simd, b));
        let in_a = self.to_a.moved(simd, &of_b).overlap(&of_a);
        in_a & self.to_b.moved(simd, &of_a).overlap(&of_b)
    }
}

/// The lanes of a node that are in use, a bit each.
#[inline(always)]
pub(super) fn used<S: Simd>(simd: S, node: &WideNode) -> u64 {
    let min = f32x8::from_slice(simd, &node.min[0]);
    min.simd_le(f32x8::from_slice(simd, &node.max[0])).to_bitmask()
}

impl Motion {
    fn new(rows: [DVec3; 3], shift: DVec3, slack: DVec3) -> Self {
        let narrow = |v: DVec3| v.to_array().map(|x| x as f32);
        Self {
            rows: rows.map(narrow),
            rows_abs: rows.map(|row| narrow(row.abs())),
            shift: narrow(shift),
            slack: narrow(slack),
        }
    }

    /// The boxes in the other frame: larger, and never too small. Empty ones meet nothing there.
    #[inline(always)]
    fn moved<S: Simd>(&self, simd: S, boxes: &Boxes<S>) -> Boxes<S> {
        let half = f32x8::splat(simd, 0.5);
        let Boxes { min: [x, y, z], max: [u, v, w] } = *boxes;
        let centre = [(u + x) * half, (v + y) * half, (w + z) * half];
        let extent = [(u - x) * half, (v - y) * half, (w - z) * half];
        let (x, y, z) = (
            self.along(simd, 0, &centre, &extent),
            self.along(simd, 1, &centre, &extent),
            self.along(simd, 2, &centre, &extent),
        );
        Boxes { min: [x.0, y.0, z.0], max: [x.1, y.1, z.1] }
    }

    /// Where boxes begin and end along one axis of the other frame.
    #[inline(always)]
    fn along<S: Simd>(
        &self,
        simd: S,
        axis: usize,
        centre: &[f32x8<S>; 3],
        extent: &[f32x8<S>; 3],
    ) -> (f32x8<S>, f32x8<S>) {
        let middle = sum(simd, &self.rows[axis], centre, self.shift[axis]);
        let reach = sum(simd, &self.rows_abs[axis], extent, self.slack[axis]);
        (middle - reach, middle + reach)
    }
}

/// `((row₀ v₀ + row₁ v₁) + row₂ v₂) + last`.
#[inline(always)]
fn sum<S: Simd>(simd: S, row: &[f32; 3], v: &[f32x8<S>; 3], last: f32) -> f32x8<S> {
    let (x, y, z) = (
        f32x8::splat(simd, row[0]) * v[0],
        f32x8::splat(simd, row[1]) * v[1],
        f32x8::splat(simd, row[2]) * v[2],
    );
    x + y + z + f32x8::splat(simd, last)
}

impl<S: Simd> Boxes<S> {
    #[inline(always)]
    fn of(simd: S, node: &WideNode) -> Self {
        Self { min: lanes(simd, &node.min), max: lanes(simd, &node.max) }
    }

    #[inline(always)]
    fn splat(simd: S, box_: &Aabb) -> Self {
        Self { min: same(simd, &box_.min), max: same(simd, &box_.max) }
    }

    /// Which of the eight meet which of eight others: bit 8i + j for the other i.
    #[inline(always)]
    fn meet_each(&self, simd: S, min: &[[f32; 8]; 3], max: &[[f32; 8]; 3]) -> u64 {
        let mut meeting = 0;
        for lane in 0..8 {
            let other = Self {
                min: same(simd, &[min[0][lane], min[1][lane], min[2][lane]]),
                max: same(simd, &[max[0][lane], max[1][lane], max[2][lane]]),
            };
            meeting |= self.overlap(&other) << (8 * lane);
        }
        meeting
    }

    /// Which meet the other's in the same lane. Comparisons with NaN are false: an empty box, once
    /// moved, is NaN.
    #[inline(always)]
    fn overlap(&self, other: &Self) -> u64 {
        let x = self.min[0].simd_le(other.max[0]) & other.min[0].simd_le(self.max[0]);
        let y = self.min[1].simd_le(other.max[1]) & other.min[1].simd_le(self.max[1]);
        let z = self.min[2].simd_le(other.max[2]) & other.min[2].simd_le(self.max[2]);
        (x & y & z).to_bitmask()
    }
}

/// Three coordinates of eight points.
#[inline(always)]
fn lanes<S: Simd>(simd: S, of: &[[f32; 8]; 3]) -> [f32x8<S>; 3] {
    let [x, y, z] = of;
    [f32x8::from_slice(simd, x), f32x8::from_slice(simd, y), f32x8::from_slice(simd, z)]
}

/// The same point eight times.
#[inline(always)]
fn same<S: Simd>(simd: S, point: &[f32; 3]) -> [f32x8<S>; 3] {
    let [x, y, z] = *point;
    [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)]
}
