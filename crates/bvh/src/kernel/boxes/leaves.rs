//! Two leaves: which of their triangles may meet, from coarse to fine.
//!
//! First quantised boxes, 32 at a time, without reading any triangle: against the intersection of
//! both leaves' boxes, and against the slab of the other leaf. The remaining ones are moved into a
//! frame close to both leaves, where their boxes are nearly exact.

use super::{Frames, Motion, combined};
use crate::build::LEAF_SIZE_MAX;
use body::WideLeaf;
use body::wide::{Grid, LEAF_LANES, LEAF_TRIANGLES, Slab};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x8, i32x4, mask8x32, mask32x8, u8x32, u16x16};
use fearless_simd_macros::simd;
use geometry::lanes::dot;
use geometry::patch::{Boxes, Choice, Close, OneBox, Places, ROOM, Vector, same, side_by_side};
use geometry::{Patch, Posed};

/// Maximum number of triangles of a leaf, wide or binary.
pub(in crate::kernel) const LEAF_MAX: usize =
    if LEAF_TRIANGLES > LEAF_SIZE_MAX as usize { LEAF_TRIANGLES } else { LEAF_SIZE_MAX as usize };
const _: () = assert!(LEAF_MAX <= ROOM);

/// Nodes of a leaf whose triangles share a word.
const IN_A_WORD: usize = u64::BITS as usize / LEAF_LANES;

impl Frames {
    /// Adds those triangles of two leaves that may meet one of the other leaf to patches; `None` if
    /// there are none. Each leaf is tested against what remains of the other.
    ///
    /// Triangles of A and of B that are `known` to be hit are left out where all remaining
    /// triangles of the other leaf are known as well.
    #[simd]
    pub(in crate::kernel) fn pack<S: Simd>(
        &self,
        simd: S,
        posed: &Posed<'_>,
        (a, b): (&[WideLeaf], &[WideLeaf]),
        known: Option<&[Places; 2]>,
        (patch_a, patch_b): (&mut Patch, &mut Patch),
    ) -> Option<Close> {
        let (box_a, box_b) = (OneBox::of(simd, &a[0].bounds), OneBox::of(simd, &b[0].bounds));
        // The intersection of the leaves lies in this box.
        let common = self.to_a.moved_one(simd, &box_b).intersection(&box_a);
        if common.is_empty() {
            return None;
        }
        let of_b = cells(simd, b, &self.to_b.moved_one(simd, &common));
        if of_b.is_empty() {
            return None;
        }
        let layer = self.to_b.layer(simd, &a[0].slab);
        let mut of_b = of_b.and(&beside(simd, b, &layer, self.slack));
        if let Some([known_a, known_b]) = known
            && Places::first(a[0].count as usize).is_within(known_a)
        {
            of_b = of_b.without(known_b);
        }
        if of_b.is_empty() {
            return None;
        }
        patch_b.want_b(simd, posed, b[0].first, &of_b);
        let close = posed.close(&a[0].bounds, &b[0].bounds);
        let origin = side_by_side(simd, close.origin());
        let slab = Layer::of_a(simd, &a[0].slab);
        let near = Near::new(simd, &close, &common.moved(-origin), &slab, self.slack);
        let boxes = patch_b.take_b(simd, (posed, &close), &near).all(simd);
        if patch_b.triangles().is_empty() {
            return None;
        }
        let in_a = boxes.moved(origin).enlarged(self.slack as f32).intersection(&common);
        let mut of_a = cells(simd, a, &in_a);
        if let Some([known_a, known_b]) = known
            && of_b.is_within(known_b)
        {
            of_a = of_a.without(known_a);
        }
        if of_a.is_empty() {
            return None;
        }
        patch_a.want_a(simd, posed, a[0].first, &of_a);
        let slab = self.to_a.layer(simd, &b[0].slab);
        let near = Near::new(simd, &close, &boxes, &slab, self.slack);
        patch_a.take_a(simd, (posed, &close), &near);
        (!patch_a.triangles().is_empty()).then_some(close)
    }
}

impl Motion {
    /// A slab in the other frame, up to rounding.
    #[inline(always)]
    fn layer<S: Simd>(&self, simd: S, slab: &Slab) -> Layer<S> {
        let normal = side_by_side(simd, slab.normal);
        let normal = combined(&self.columns, normal, f32x4::splat(simd, 0.0));
        let shift = dot_one(normal, side_by_side(simd, self.shift));
        Layer { normal, low: slab.low + shift, high: slab.high + shift }
    }
}

/// A slab, with its normal in vector layout.
struct Layer<S: Simd> {
    normal: f32x4<S>,
    low: f32,
    high: f32,
}

impl<S: Simd> Layer<S> {
    #[inline(always)]
    fn of_a(simd: S, slab: &Slab) -> Self {
        Self { normal: side_by_side(simd, slab.normal), low: slab.low, high: slab.high }
    }
}

/// `a · b`.
#[inline(always)]
fn dot_one<S: Simd>(a: f32x4<S>, b: f32x4<S>) -> f32 {
    sum(a * b)
}

/// The sum of three coordinates.
#[inline(always)]
fn sum<S: Simd>(of: f32x4<S>) -> f32 {
    let [x, y, z, _] = <[f32; 4]>::from(of);
    x + y + z
}

/// Which triangles of a leaf may overlap a box of its body's frame.
#[inline(always)]
pub(super) fn cells<S: Simd>(simd: S, leaf: &[WideLeaf], box_: &OneBox<S>) -> Places {
    let [min, max] = cells_of(box_, &OneBox::of(simd, &leaf[0].bounds));
    let mut meeting = Places::default();
    for (i, leaf) in leaf.iter().enumerate() {
        let mut here = mask8x32::splat(simd, true);
        for axis in 0..3 {
            here &= u8x32::from_slice(simd, &leaf.min[axis]).simd_le(max[axis]);
            here &= u8x32::from_slice(simd, &leaf.max[axis]).simd_ge(min[axis]);
        }
        meeting.insert_from(i / IN_A_WORD, i % IN_A_WORD * LEAF_LANES, here.to_bitmask());
    }
    meeting
}

/// Which triangles of a leaf may overlap a slab of its body's frame.
///
/// `slack` (m) bounds the rounding of the slab in the transform to this frame; the slab is widened
/// by twice as much on both sides: once for it, once for the corner of the grid and the length of
/// its cells.
///
/// Along the normal, a triangle reaches from the corner of its cells farthest against it to the
/// corner farthest along it. Relative to the least corner of the grid, each is a sum of three
/// products of cells and the length of a cell along the normal, computed here in integers: the
/// lengths are scaled so that they add up to 256, and rounded down. So a sum is too small by up to
/// 255 times the truncated part, and never too large.
#[inline(always)]
fn beside<S: Simd>(simd: S, leaf: &[WideLeaf], layer: &Layer<S>, slack: f64) -> Places {
    let over = OneBox::of(simd, &leaf[0].bounds);
    let steps = layer.normal * ((over.max - over.min) * (1.0 / Grid::LAST));
    let lengths = steps.abs();
    let total = sum(lengths);
    let scale = (256.0 / total).min(f32::MAX);
    let whole = (lengths * scale).to_int::<i32x4<S>>();
    let [x, y, z, _] = <[i32; 4]>::from(whole);
    let cut_off = total * scale - (x + y + z) as f32;
    let start = dot_one(layer.normal, over.min) + 256.0 * sum(steps.min(0.0));
    let slack = 2.0 * slack as f32;
    // One more on either side, for the rounding of numbers of this size.
    let most = (layer.high + slack - start) * scale + 1.0;
    let least = (layer.low - slack - start - total) * scale - 255.0 * cut_off - 1.0;
    if most < 0.0 || least > f32::from(u16::MAX) {
        return Places::default();
    }
    let (most, least) = (u16x16::splat(simd, most as u16), u16x16::splat(simd, least as u16));
    let whole = [x, y, z].map(|x| u16x16::splat(simd, x as u16));
    let [x, y, z, _] = <[f32; 4]>::from(steps);
    let backward = [x < 0.0, y < 0.0, z < 0.0];
    let mut meeting = Places::default();
    for (i, leaf) in leaf.iter().enumerate() {
        let mut near = [u16x16::splat(simd, 0); 2];
        let mut far = near;
        for axis in 0..3 {
            let (min, max) = (
                u8x32::from_slice(simd, &leaf.min[axis]),
                u8x32::from_slice(simd, &leaf.max[axis]),
            );
            let [from, to] = if backward[axis] { [!max, !min] } else { [min, max] };
            let ([p, q], [r, s]) = (simd.widen_u8x32(from).into(), simd.widen_u8x32(to).into());
            near = [near[0] + p * whole[axis], near[1] + q * whole[axis]];
            far = [far[0] + r * whole[axis], far[1] + s * whole[axis]];
        }
        let here = [0, 1].map(|half| near[half].simd_le(most) & far[half].simd_ge(least));
        let bits = here[0].to_bitmask() | here[1].to_bitmask() << (LEAF_LANES / 2);
        meeting.insert_from(i / IN_A_WORD, i % IN_A_WORD * LEAF_LANES, bits);
    }
    meeting
}

/// [`Grid::cells`] of a box, in the grid over another one.
#[inline(always)]
fn cells_of<S: Simd>(box_: &OneBox<S>, over: &OneBox<S>) -> [[u8; 3]; 2] {
    let last = f32x4::splat(over.min.token(), Grid::LAST);
    let scale = (last / (over.max - over.min)).min(f32::MAX);
    let cell = |point: f32x4<S>| {
        let along = ((point - over.min) * scale).min(last).max(0.0);
        let [x, y, z, _] = <[i32; 4]>::from(along.to_int::<i32x4<S>>());
        [x as u8, y as u8, z as u8]
    };
    [cell(box_.min), cell(box_.max)]
}

/// The triangles that overlap a box and a slab of the close frame.
struct Near<S: Simd> {
    box_: Boxes<S>,
    normal: Vector<S>,
    low: f32x8<S>,
    high: f32x8<S>,
}

impl<S: Simd> Near<S> {
    /// A box of the close frame, and a slab of A's, both enlarged by this much (m) on both sides.
    #[inline(always)]
    fn new(simd: S, close: &Close, box_: &OneBox<S>, slab: &Layer<S>, slack: f64) -> Self {
        let at = dot_one(slab.normal, side_by_side(simd, close.origin()));
        let slack = slack as f32 + close.error();
        let [x, y, z, _] = <[f32; 4]>::from(slab.normal);
        Self {
            box_: box_.spread(simd),
            normal: same(simd, &[x, y, z]),
            low: f32x8::splat(simd, slab.low - at - slack),
            high: f32x8::splat(simd, slab.high - at + slack),
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

#[cfg(test)]
mod tests;
