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

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f32x8, mask32x8};
use fearless_simd_macros::simd;
use geometry::{Aabb, DVec3, RelativePose};
use model::wide::{LANES, Slab};
use model::{BodyView, WideNode};

mod packed;

pub(super) use packed::{LEAF_MAX, Packed, WAITING};

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
    /// R and t themselves.
    rows: [DVec3; 3],
    shift: DVec3,
    /// Added to both sides of a slab (m).
    slack: f64,
}

/// Eight times a slab in A's frame.
#[derive(Clone, Copy)]
struct Slabs<S: Simd> {
    normal: [f32x8<S>; 3],
    normal_abs: [f32x8<S>; 3],
    low: f32x8<S>,
    high: f32x8<S>,
}

/// Eight boxes in one frame, each as its middle and how far it reaches from there.
#[derive(Clone, Copy)]
struct Centred<S: Simd> {
    middle: [f32x8<S>; 3],
    reach: [f32x8<S>; 3],
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
            rows,
            shift: t,
            slack: (size_in_a + reach_a).element_sum() * ROUNDING + 3.0 * lost,
        })
    }

    /// Which boxes of `a` can meet which of `b`: bit 8i + j for lane i of A and lane j of B.
    #[simd]
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

    /// Packs those triangles of two leaves, each of several nodes, that may meet one of the other
    /// leaf, all in A's frame. Each leaf is tested against what is left of the other.
    #[simd]
    pub(super) fn pack<S: Simd>(
        &self,
        simd: S,
        (a, b): (&[WideNode], &[WideNode]),
        (of_a, of_b): (&mut Packed, &mut Packed),
    ) {
        of_a.clear();
        of_b.clear();
        let all_a = Boxes::splat(simd, &a[0].bounds);
        let all_b = Boxes::splat(simd, &b[0].bounds);
        let slab_a = Slabs::splat(simd, &a[0].slab(), self.slack);
        let slab_b = Slabs::splat(simd, &self.slab_in_a(&b[0].slab()), self.slack);
        let apart = !(slab_a.crossing(&self.to_a.centred(simd, &all_b))
            & slab_b.crossing(&all_a.centred(simd)));
        if apart.any_true() {
            return;
        }
        let all_a_in_b = self.to_b.moved(simd, &all_a);
        let mut near = Boxes::nothing(simd);
        for node in b {
            let boxes = Boxes::of(simd, node);
            let meeting = boxes.overlapping(&all_a_in_b);
            if meeting.all_false() {
                continue;
            }
            let centred = self.to_a.centred(simd, &boxes);
            let moved = centred.boxes();
            let meeting = meeting & moved.overlapping(&all_a) & slab_a.crossing(&centred);
            of_b.add(simd, &moved, meeting, node.triangle(0));
            near.grow(meeting, &moved);
        }
        if of_b.triangles().is_empty() {
            return;
        }
        of_b.close(simd);
        let all_b = near.all(simd);
        near = Boxes::nothing(simd);
        for node in a {
            let boxes = Boxes::of(simd, node);
            let meeting = boxes.overlapping(&all_b);
            if meeting.all_false() {
                continue;
            }
            let meeting = meeting & slab_b.crossing(&boxes.centred(simd));
            of_a.add(simd, &boxes, meeting, node.triangle(0));
            near.grow(meeting, &boxes);
        }
        if !of_a.triangles().is_empty() {
            of_b.keep(simd, &near.all(simd));
        }
    }

    /// A slab of B in A's frame; what rounding moves there is less than the slack.
    fn slab_in_a(&self, slab: &Slab) -> Slab {
        let normal = DVec3::from_array(slab.normal.map(f64::from));
        let normal = DVec3::from_array(self.rows.map(|row| row.dot(normal)));
        let shift = normal.dot(self.shift);
        Slab {
            normal: normal.to_array().map(|x| x as f32),
            low: (f64::from(slab.low) + shift) as f32,
            high: (f64::from(slab.high) + shift) as f32,
        }
    }

    /// Which boxes of `a` can meet the one box of B: bit i for lane i.
    #[simd]
    pub(super) fn meet_one_of_b<S: Simd>(&self, simd: S, a: &WideNode, b: &Aabb) -> u64 {
        let (of_a, of_b) = (Boxes::of(simd, a), Boxes::splat(simd, b));
        let in_a = self.to_a.moved(simd, &of_b).overlap(&of_a);
        in_a & self.to_b.moved(simd, &of_a).overlap(&of_b)
    }

    /// Which boxes of `b` can meet the one box of A: bit j for lane j.
    #[simd]
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
        self.centred(simd, boxes).boxes()
    }

    #[inline(always)]
    fn centred<S: Simd>(&self, simd: S, boxes: &Boxes<S>) -> Centred<S> {
        let Centred { middle: centre, reach: extent } = boxes.centred(simd);
        let (x, y, z) = (
            self.along(simd, 0, &centre, &extent),
            self.along(simd, 1, &centre, &extent),
            self.along(simd, 2, &centre, &extent),
        );
        Centred { middle: [x.0, y.0, z.0], reach: [x.1, y.1, z.1] }
    }

    /// Where boxes lie along one axis of the other frame.
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
        (middle, reach)
    }
}

impl<S: Simd> Centred<S> {
    #[inline(always)]
    fn boxes(&self) -> Boxes<S> {
        let Self { middle: [x, y, z], reach: [u, v, w] } = *self;
        Boxes { min: [x - u, y - v, z - w], max: [x + u, y + v, z + w] }
    }
}

impl<S: Simd> Slabs<S> {
    #[inline(always)]
    fn splat(simd: S, slab: &Slab, slack: f64) -> Self {
        let [x, y, z] = slab.normal;
        Self {
            normal: same(simd, &[x, y, z]),
            normal_abs: same(simd, &[x.abs(), y.abs(), z.abs()]),
            low: f32x8::splat(simd, (f64::from(slab.low) - slack) as f32),
            high: f32x8::splat(simd, (f64::from(slab.high) + slack) as f32),
        }
    }

    /// Which boxes may hold a point of the slab; an empty one, whose middle is NaN, does not.
    #[inline(always)]
    fn crossing(&self, boxes: &Centred<S>) -> mask32x8<S> {
        let ([x, y, z], [u, v, w]) = (boxes.middle, boxes.reach);
        let at = self.normal[0] * x + self.normal[1] * y + self.normal[2] * z;
        let reach = self.normal_abs[0] * u + self.normal_abs[1] * v + self.normal_abs[2] * w;
        (at - reach).simd_le(self.high) & self.low.simd_le(at + reach)
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
    /// Eight times nothing.
    #[inline(always)]
    fn nothing(simd: S) -> Self {
        Self::splat(simd, &Aabb::EMPTY)
    }

    /// Lane by lane the box of both, of the other only where `which` says so.
    #[inline(always)]
    fn grow(&mut self, which: mask32x8<S>, other: &Self) {
        for axis in 0..3 {
            let (min, max) = (other.min[axis], other.max[axis]);
            self.min[axis] = self.min[axis].min(which.select(min, self.min[axis]));
            self.max[axis] = self.max[axis].max(which.select(max, self.max[axis]));
        }
    }

    /// Eight times the box of all lanes.
    #[inline(always)]
    fn all(&self, simd: S) -> Self {
        let ([u, v, w], [x, y, z]) = (self.min, self.max);
        Self {
            min: same(simd, &[u.reduce_min(), v.reduce_min(), w.reduce_min()]),
            max: same(simd, &[x.reduce_max(), y.reduce_max(), z.reduce_max()]),
        }
    }

    #[inline(always)]
    fn of(simd: S, node: &WideNode) -> Self {
        Self { min: lanes(simd, &node.min, 0..LANES), max: lanes(simd, &node.max, 0..LANES) }
    }

    #[inline(always)]
    fn splat(simd: S, box_: &Aabb) -> Self {
        Self { min: same(simd, &box_.min), max: same(simd, &box_.max) }
    }

    #[inline(always)]
    fn centred(&self, simd: S) -> Centred<S> {
        let half = f32x8::splat(simd, 0.5);
        let Self { min: [x, y, z], max: [u, v, w] } = *self;
        Centred {
            middle: [(u + x) * half, (v + y) * half, (w + z) * half],
            reach: [(u - x) * half, (v - y) * half, (w - z) * half],
        }
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
        self.overlapping(other).to_bitmask()
    }

    #[inline(always)]
    fn overlapping(&self, other: &Self) -> mask32x8<S> {
        let x = self.min[0].simd_le(other.max[0]) & other.min[0].simd_le(self.max[0]);
        let y = self.min[1].simd_le(other.max[1]) & other.min[1].simd_le(self.max[1]);
        let z = self.min[2].simd_le(other.max[2]) & other.min[2].simd_le(self.max[2]);
        x & y & z
    }
}

/// Three coordinates of eight points.
#[inline(always)]
fn lanes<S: Simd, const N: usize>(
    simd: S,
    of: &[[f32; N]; 3],
    at: std::ops::Range<usize>,
) -> [f32x8<S>; 3] {
    let [x, y, z] = of;
    [
        f32x8::from_slice(simd, &x[at.clone()]),
        f32x8::from_slice(simd, &y[at.clone()]),
        f32x8::from_slice(simd, &z[at]),
    ]
}

/// The same point eight times.
#[inline(always)]
fn same<S: Simd>(simd: S, point: &[f32; 3]) -> [f32x8<S>; 3] {
    let [x, y, z] = *point;
    [f32x8::splat(simd, x), f32x8::splat(simd, y), f32x8::splat(simd, z)]
}
