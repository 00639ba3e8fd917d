//! Two leaves: which of their triangles may meet, from coarse to fine.
//!
//! Boxes in cells first, 32 at a time, without looking at any triangle; then those that are left
//! are moved into a frame close to both leaves, where their boxes are as good as exact.

use super::Frames;
use crate::build::LEAF_SIZE_MAX;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask8x32, mask32x8, u8x32};
use fearless_simd_macros::simd;
use geometry::lanes::dot;
use geometry::patch::{Boxes, Choice, Close, ROOM, Vector, same};
use geometry::{Aabb, DVec3, Patch, Posed};
use model::WideLeaf;
use model::wide::{Grid, LEAF_LANES, LEAF_TRIANGLES, Slab};

/// Most triangles of a leaf, wide or binary.
pub(in crate::kernel) const LEAF_MAX: usize = LEAF_SIZE_MAX as usize;
const _: () = assert!(LEAF_TRIANGLES <= LEAF_MAX && LEAF_MAX <= ROOM);

impl Frames {
    /// Takes those triangles of two leaves that may meet one of the other leaf into patches; `None`
    /// where there are none. Each leaf is tested against what is left of the other.
    #[simd]
    pub(in crate::kernel) fn pack<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        (a, b): (&[WideLeaf], &[WideLeaf]),
        (patch_a, patch_b): (&mut Patch, &mut Patch),
    ) -> Option<Close> {
        // What the leaves have in common lies in here.
        let common = self.to_a.moved_one(&b[0].bounds).intersection(&a[0].bounds);
        let (slab_a, slab_b) = (a[0].slab, self.slab_in_a(&b[0].slab));
        if common.is_empty()
            || misses(&slab_a, &common, self.slack)
            || misses(&slab_b, &common, self.slack)
        {
            return None;
        }
        let bits = cells(simd, b, &self.to_b.moved_one(&common));
        if bits == 0 {
            return None;
        }
        let close = posed.close(&a[0].bounds, &b[0].bounds);
        let near = Near::new(simd, &close, &close.of_a(&common), (&slab_a, self.slack));
        let boxes = patch_b.take_b(simd, (posed, &close), (b[0].first, bits), &near).all();
        if patch_b.triangles().is_empty() {
            return None;
        }
        let in_a = close.to_a(&boxes).enlarged(self.slack as f32).intersection(&common);
        let bits = cells(simd, a, &in_a);
        if bits == 0 {
            return None;
        }
        let near = Near::new(simd, &close, &boxes, (&slab_b, self.slack));
        patch_a.take_a(simd, (posed, &close), (a[0].first, bits), &near);
        (!patch_a.triangles().is_empty()).then_some(close)
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
}

/// Whether no point of the box is in the slab, `slack` (m) wider on both sides.
#[inline(always)]
fn misses(slab: &Slab, Aabb { min, max }: &Aabb, slack: f64) -> bool {
    let ([x, y, z], slack) = (slab.normal, slack as f32);
    let along = x * (min[0] + max[0]) + y * (min[1] + max[1]) + z * (min[2] + max[2]);
    let reach =
        x.abs() * (max[0] - min[0]) + y.abs() * (max[1] - min[1]) + z.abs() * (max[2] - min[2]);
    0.5 * (along - reach) - slack > slab.high || 0.5 * (along + reach) + slack < slab.low
}

/// Which triangles of a leaf may meet a box of its body's frame: bit i for the ith.
#[inline(always)]
fn cells<S: Simd>(simd: S, leaf: &[WideLeaf], box_: &Aabb) -> u64 {
    let [min, max] = Grid::over(&leaf[0].bounds).cells(box_);
    let mut meeting = 0;
    for (i, leaf) in leaf.iter().enumerate() {
        let mut here = mask8x32::splat(simd, true);
        for axis in 0..3 {
            here &= u8x32::from_slice(simd, &leaf.min[axis]).simd_le(max[axis]);
            here &= u8x32::from_slice(simd, &leaf.max[axis]).simd_ge(min[axis]);
        }
        meeting |= here.to_bitmask() << (i * LEAF_LANES);
    }
    meeting
}

/// Triangles that meet a box and a slab of the close frame.
struct Near<S: Simd> {
    box_: Boxes<S>,
    normal: Vector<S>,
    low: f32x8<S>,
    high: f32x8<S>,
}

impl<S: Simd> Near<S> {
    /// A box of the close frame, and a slab of A's, so much (m) wider on both sides.
    #[inline(always)]
    fn new(simd: S, close: &Close, box_: &Aabb, (slab, slack): (&Slab, f64)) -> Self {
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let at = double(slab.normal).dot(double(close.origin()));
        let slack = slack + f64::from(close.error());
        Self {
            box_: Boxes::splat(simd, box_),
            normal: same(simd, &slab.normal),
            low: f32x8::splat(simd, (f64::from(slab.low) - at - slack) as f32),
            high: f32x8::splat(simd, (f64::from(slab.high) - at + slack) as f32),
        }
    }
}

impl<S: Simd> Choice<S> for Near<S> {
    #[inline(always)]
    fn of(&self, [p, q, r]: &[Vector<S>; 3], boxes: &Boxes<S>) -> mask32x8<S> {
        let (p, q, r) = (dot(self.normal, *p), dot(self.normal, *q), dot(self.normal, *r));
        let above = p.min(q).min(r).simd_gt(self.high);
        let below = p.max(q).max(r).simd_lt(self.low);
        self.box_.meet(boxes) & !(above | below)
    }
}
