//! One box in one or two vectors, for work done once per pair of leaves: its three axes side by
//! side.

use super::{Boxes, same};
use crate::Aabb;
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4};

/// A box (m): x, y, z, and z once more.
#[derive(Clone, Copy)]
pub struct OneBox<S: Simd> {
    /// Least coordinates.
    pub min: f32x4<S>,
    /// Greatest coordinates.
    pub max: f32x4<S>,
}

/// Three coordinates side by side, the last one twice.
#[inline(always)]
pub fn side_by_side<S: Simd>(simd: S, [x, y, z]: [f32; 3]) -> f32x4<S> {
    f32x4::simd_from(simd, [x, y, z, z])
}

impl<S: Simd> OneBox<S> {
    /// Loads a box.
    #[inline(always)]
    pub fn of(simd: S, Aabb { min, max }: &Aabb) -> Self {
        Self { min: side_by_side(simd, *min), max: side_by_side(simd, *max) }
    }

    /// Returns the intersection: [empty](OneBox::is_empty) where they do not overlap.
    #[must_use]
    #[inline(always)]
    pub fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Enlarges the box by `margin` (m) on all sides, up to rounding.
    #[must_use]
    #[inline(always)]
    pub fn enlarged(&self, margin: f32) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Moves the box, up to rounding.
    #[must_use]
    #[inline(always)]
    pub fn moved(&self, by: f32x4<S>) -> Self {
        Self { min: self.min + by, max: self.max + by }
    }

    /// Whether the box contains no point.
    #[must_use]
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.min.simd_gt(self.max).any_true()
    }

    /// Repeats the box eight times.
    #[must_use]
    #[inline(always)]
    pub fn spread(&self, simd: S) -> Boxes<S> {
        let spread_axes = |v: &f32x4<S>| {
            let [x, y, z, _] = <[f32; 4]>::from(*v);
            same(simd, &[x, y, z])
        };
        Boxes { min: spread_axes(&self.min), max: spread_axes(&self.max) }
    }
}
