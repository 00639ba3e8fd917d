//! Eight boxes of A against eight of B at once, in f32.
//!
//! The boxes of one body are moved into the frame of the other, where they become larger boxes, and
//! compared there axis by axis; then, if any pair remains, the same in the opposite direction.
//! Together these are the six tests of [`crate::Placement`].
//!
//! # Rounding
//!
//! Stored boxes are exact; only moving one rounds. With u = 2⁻²⁴ and S the sum of magnitudes of all
//! terms of a coordinate, centre and half extent are off by u, a matrix entry and its product by
//! 2u, three sums by 3u: at most 6u·S for the centre, as much for the reach, and 2u·S more where
//! they are subtracted. [`ROUNDING`] is 32u, and S is computed once for the whole body. On the way
//! into B's frame, the deviation of R from a rotation counts too: what [`RelativePose::point`]
//! moved by R comes back by Rᵀ, which misses by (RᵀR − I) times the point.
//!
//! A [`body::wide::Slab`] of B in A's frame has a normal that is off by 5u in each coordinate, and
//! is shifted by its product with t (3u·S, S now of both bodies) and a sum (2u·S); it is compared
//! in a frame close by, whose origin it is moved to (3u·S, and two sums of 3u·S each). That is
//! 19u·S of the 32u·S on either side.

use body::wide::LANES;
use body::{BodyView, WideNode};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8};
use fearless_simd_macros::simd;
use geometry::lanes::{minus, plus, turned};
use geometry::patch::{Boxes, OneBox, Vector, same, side_by_side};
use geometry::{Aabb, DVec3, RelativePose};

mod leaves;
mod passing;

pub(super) use leaves::LEAF_MAX;
pub(super) use passing::Passing;

/// 32 u.
const ROUNDING: f64 = 1.0 / (1 << 19) as f64;

/// Sizes (m) for which nothing overflows in f32, and no underflow matters.
const SIZES: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

/// The pose of the boxes of one frame in the other.
#[derive(Clone, Copy, Debug)]
struct Motion {
    rows: [[f32; 3]; 3],
    rows_abs: [[f32; 3]; 3],
    /// Columns, side by side.
    columns: [[f32; 4]; 3],
    columns_abs: [[f32; 4]; 3],
    shift: [f32; 3],
    /// Slack (m) added to every reach.
    slack: [f32; 3],
}

/// The transforms between the frames of A and B, in both directions, for boxes within two bodies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    to_a: Motion,
    to_b: Motion,
    /// Slack (m) added to both sides of a slab.
    slack: f64,
}

impl Frames {
    /// `None` if f32 cannot hold the intermediate values: bodies of less than 10⁻³⁰ m or more than
    /// 10³⁰ m, or a pose that is not finite.
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
            slack: (size_in_a + reach_a).element_sum() * ROUNDING + 3.0 * lost,
        })
    }

    /// The same, with more slack (m) on all sides.
    fn slackened(self, by: f64) -> Self {
        let more = |motion: Motion| {
            let slack =
                motion.slack.map(|slack| (f64::from(slack) + by) as f32 * (1.0 + f32::EPSILON));
            Motion { slack, ..motion }
        };
        Self { to_a: more(self.to_a), to_b: more(self.to_b), slack: self.slack + by }
    }

    /// Which boxes of `a` can overlap which of `b`: bit 8i + j for lane i of A and lane j of B.
    #[simd]
    pub(super) fn meet<S: Simd>(&self, simd: S, a: &WideNode, b: &WideNode) -> u64 {
        let (of_a, of_b) = (lanes(simd, a), lanes(simd, b));
        let meeting = meet_each(simd, &self.to_a.moved(simd, &of_b), &a.min, &a.max);
        if meeting == 0 {
            return 0;
        }
        let Boxes { min: [x, y, z], max: [u, v, w] } = self.to_b.moved(simd, &of_a);
        let (min, max) = ([x.into(), y.into(), z.into()], [u.into(), v.into(), w.into()]);
        meeting & meet_each(simd, &of_b, &min, &max)
    }

    /// Which boxes of `a` can overlap the one box of B: bit i for lane i.
    #[simd]
    pub(super) fn meet_one_of_b<S: Simd>(&self, simd: S, a: &WideNode, b: &Aabb) -> u64 {
        let (of_a, of_b) = (lanes(simd, a), Boxes::splat(simd, b));
        let in_a = self.to_a.moved(simd, &of_b).meet(&of_a);
        (in_a & self.to_b.moved(simd, &of_a).meet(&of_b)).to_bitmask()
    }

    /// Which boxes of `b` can overlap the one box of A: bit j for lane j.
    #[simd]
    pub(super) fn meet_one_of_a<S: Simd>(&self, simd: S, a: &Aabb, b: &WideNode) -> u64 {
        let (of_a, of_b) = (Boxes::splat(simd, a), lanes(simd, b));
        let in_a = self.to_a.moved(simd, &of_b).meet(&of_a);
        (in_a & self.to_b.moved(simd, &of_a).meet(&of_b)).to_bitmask()
    }
}

/// The lanes of a node that are in use, one bit each.
#[inline(always)]
pub(super) fn used<S: Simd>(simd: S, node: &WideNode) -> u64 {
    let min = f32x8::from_slice(simd, &node.min[0]);
    min.simd_le(f32x8::from_slice(simd, &node.max[0])).to_bitmask()
}

impl Motion {
    fn new(rows: [DVec3; 3], shift: DVec3, slack: DVec3) -> Self {
        let narrow = |v: DVec3| v.to_array().map(|x| x as f32);
        let column = |j: usize| [rows[0][j], rows[1][j], rows[2][j], rows[2][j]].map(|x| x as f32);
        let columns = [column(0), column(1), column(2)];
        Self {
            rows: rows.map(narrow),
            rows_abs: rows.map(|row| narrow(row.abs())),
            columns,
            columns_abs: columns.map(|column| column.map(f32::abs)),
            shift: narrow(shift),
            slack: narrow(slack),
        }
    }

    /// A box in the other frame, enlarged: never too small.
    #[inline(always)]
    fn moved_one<S: Simd>(&self, simd: S, OneBox { min, max }: &OneBox<S>) -> OneBox<S> {
        let (middle, reach) = ((*max + *min) * 0.5, (*max - *min) * 0.5);
        let middle = combined(&self.columns, middle, side_by_side(simd, self.shift));
        let reach = combined(&self.columns_abs, reach, side_by_side(simd, self.slack));
        OneBox { min: middle - reach, max: middle + reach }
    }

    /// [`Motion::moved_one`] without vectors.
    fn moved_plainly(&self, Aabb { min, max }: &Aabb) -> Aabb {
        let row = |k: usize| {
            let ([p, q, r], [s, t, u]) = (self.rows[k], self.rows_abs[k]);
            let middle = [0, 1, 2].map(|i| (max[i] + min[i]) * 0.5);
            let reach = [0, 1, 2].map(|i| (max[i] - min[i]) * 0.5);
            let middle = p * middle[0] + q * middle[1] + r * middle[2] + self.shift[k];
            let reach = s * reach[0] + t * reach[1] + u * reach[2] + self.slack[k];
            [middle - reach, middle + reach]
        };
        let [[x, u], [y, v], [z, w]] = [row(0), row(1), row(2)];
        Aabb { min: [x, y, z], max: [u, v, w] }
    }

    /// The boxes in the other frame, enlarged: never too small. Empty boxes become NaN and overlap
    /// nothing.
    #[inline(always)]
    fn moved<S: Simd>(&self, simd: S, Boxes { min, max }: &Boxes<S>) -> Boxes<S> {
        let half = f32x8::splat(simd, 0.5);
        let ([x, y, z], [u, v, w]) = (plus(*max, *min), minus(*max, *min));
        let (middle, reach) = ([x * half, y * half, z * half], [u * half, v * half, w * half]);
        let middle = turned(simd, &self.rows, middle, same(simd, &self.shift));
        let reach = turned(simd, &self.rows_abs, reach, same(simd, &self.slack));
        Boxes { min: minus(middle, reach), max: plus(middle, reach) }
    }
}

/// The sum of three columns, each times one coordinate, and of `last`.
#[inline(always)]
fn combined<S: Simd>(columns: &[[f32; 4]; 3], v: f32x4<S>, last: f32x4<S>) -> f32x4<S> {
    let simd = last.token();
    let [x, y, z, _] = <[f32; 4]>::from(v);
    let column = |j: usize| f32x4::from_slice(simd, &columns[j]);
    let sum = column(0).mul_add(f32x4::splat(simd, x), last);
    column(2).mul_add(f32x4::splat(simd, z), column(1).mul_add(f32x4::splat(simd, y), sum))
}

/// The boxes of a node.
#[inline(always)]
fn lanes<S: Simd>(simd: S, node: &WideNode) -> Boxes<S> {
    Boxes { min: loaded(simd, &node.min), max: loaded(simd, &node.max) }
}

#[inline(always)]
fn loaded<S: Simd>(simd: S, [x, y, z]: &[[f32; LANES]; 3]) -> Vector<S> {
    [f32x8::from_slice(simd, x), f32x8::from_slice(simd, y), f32x8::from_slice(simd, z)]
}

/// Which of eight boxes overlap which of eight others: bit 8i + j for the other i.
#[inline(always)]
fn meet_each<S: Simd>(
    simd: S,
    boxes: &Boxes<S>,
    min: &[[f32; LANES]; 3],
    max: &[[f32; LANES]; 3],
) -> u64 {
    let mut meeting = 0;
    for lane in 0..LANES {
        let other = Boxes {
            min: same(simd, &[min[0][lane], min[1][lane], min[2][lane]]),
            max: same(simd, &[max[0][lane], max[1][lane], max[2][lane]]),
        };
        meeting |= boxes.meet(&other).to_bitmask() << (LANES * lane);
    }
    meeting
}
