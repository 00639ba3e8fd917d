//! One box in a vector or two: what is done once per pair of leaves, its three axes side by side.

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
    /// That box.
    #[inline(always)]
    pub fn of(simd: S, Aabb { min, max }: &Aabb) -> Self {
        Self { min: side_by_side(simd, *min), max: side_by_side(simd, *max) }
    }

    /// What lies in both: [empty](OneBox::is_empty) where they do not overlap.
    #[must_use]
    #[inline(always)]
    pub fn intersection(&self, other: &Self) -> Self {
        Self { min: self.min.max(other.min), max: self.max.min(other.max) }
    }

    /// Larger by `margin` (m) on all sides, but for rounding.
    #[must_use]
    #[inline(always)]
    pub fn enlarged(&self, margin: f32) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Elsewhere, but for rounding.
    #[must_use]
    #[inline(always)]
    pub fn moved(&self, by: f32x4<S>) -> Self {
        Self { min: self.min + by, max: self.max + by }
    }

    /// Whether no point is in it.
    #[must_use]
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.min.simd_gt(self.max).any_true()
    }

    /// The same box eight times.
    #[must_use]
    #[inline(always)]
    pub fn spread(&self, simd: S) -> Boxes<S> {
        let of = |v: &f32x4<S>| {
            let [x, y, z, _] = <[f32; 4]>::from(*v);
            same(simd, &[x, y, z])
        };
        Boxes { min: of(&self.min), max: of(&self.max) }
    }
}
