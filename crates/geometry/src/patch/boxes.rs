//! Eight boxes side by side, one per lane, in the same frame.

use super::{OneBox, Vector, same, side_by_side};
use crate::Aabb;
use crate::lanes::only;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, mask32x8};

/// Eight boxes.
#[derive(Clone, Copy)]
pub struct Boxes<S: Simd> {
    /// Least x, y, z (m).
    pub min: Vector<S>,
    /// Greatest x, y, z (m).
    pub max: Vector<S>,
}

impl<S: Simd> Boxes<S> {
    /// The box of three corners, lane by lane.
    #[inline(always)]
    pub(super) fn around([p, q, r]: &[Vector<S>; 3]) -> Self {
        Self {
            min: [p[0].min(q[0]).min(r[0]), p[1].min(q[1]).min(r[1]), p[2].min(q[2]).min(r[2])],
            max: [p[0].max(q[0]).max(r[0]), p[1].max(q[1]).max(r[1]), p[2].max(q[2]).max(r[2])],
        }
    }

    /// The same box in all eight lanes.
    #[inline(always)]
    pub fn splat(simd: S, box_: &Aabb) -> Self {
        Self { min: same(simd, &box_.min), max: same(simd, &box_.max) }
    }

    /// Eight empty boxes.
    #[inline(always)]
    pub fn nothing(simd: S) -> Self {
        Self::splat(simd, &Aabb::EMPTY)
    }

    /// Enlarges each box by `margin` on all sides.
    #[inline(always)]
    pub(super) fn enlarged(&self, margin: f32x8<S>) -> Self {
        let Self { min: [u, v, w], max: [x, y, z] } = *self;
        Self {
            min: [u - margin, v - margin, w - margin],
            max: [x + margin, y + margin, z + margin],
        }
    }

    /// Empties the lanes outside the mask.
    #[inline(always)]
    pub(super) fn only(&self, simd: S, lanes: mask32x8<S>) -> Self {
        let Self { min: none_min, max: none_max } = Self::nothing(simd);
        Self { min: only(lanes, self.min, none_min), max: only(lanes, self.max, none_max) }
    }

    /// The union, lane by lane.
    #[inline(always)]
    pub(super) fn include(&mut self, other: &Self) {
        for axis in 0..3 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
    }

    /// The union of all lanes.
    #[inline(always)]
    pub fn all(&self, simd: S) -> OneBox<S> {
        let ([u, v, w], [x, y, z]) = (self.min, self.max);
        let min = [u.reduce_min(), v.reduce_min(), w.reduce_min()];
        let max = [x.reduce_max(), y.reduce_max(), z.reduce_max()];
        OneBox { min: side_by_side(simd, min), max: side_by_side(simd, max) }
    }

    /// Which boxes overlap the other's in the same lane. Comparisons with NaN are false.
    #[inline(always)]
    pub fn meet(&self, other: &Self) -> mask32x8<S> {
        let x = self.min[0].simd_le(other.max[0]) & other.min[0].simd_le(self.max[0]);
        let y = self.min[1].simd_le(other.max[1]) & other.min[1].simd_le(self.max[1]);
        let z = self.min[2].simd_le(other.max[2]) & other.min[2].simd_le(self.max[2]);
        x & y & z
    }
}
