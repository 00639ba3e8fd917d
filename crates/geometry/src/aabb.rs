//! Axis-aligned boxes: [`Aabb`] as stored with a tree (f32), [`Bounds`] as used in traversal (f64).

use crate::{Corners, DVec3};
use bytemuck::{Pod, Zeroable};

/// A closed axis-aligned box in a body's own frame, in metres.
///
/// Holds the exact minima and maxima of stored f32 coordinates; nothing is rounded. The empty box
/// is inverted and infinite: it overlaps nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Aabb {
    /// Least x, y, z.
    pub min: [f32; 3],
    /// Greatest x, y, z.
    pub max: [f32; 3],
}

impl Aabb {
    /// The empty box: the neutral element of [`Aabb::union`].
    pub const EMPTY: Self = Self { min: [f32::INFINITY; 3], max: [f32::NEG_INFINITY; 3] };

    /// The box of one triangle.
    #[must_use]
    pub fn of(corners: &Corners) -> Self {
        corners.iter().fold(Self::EMPTY, |mut box_, corner| {
            box_.grow(*corner);
            box_
        })
    }

    /// Includes one point; a NaN coordinate changes nothing.
    pub fn grow(&mut self, point: [f32; 3]) {
        *self = self.union(&Self { min: point, max: point });
    }

    /// Returns the smallest box that contains both.
    ///
    /// Of two zeros, that of `self` is kept, on every machine, so equal input gives equal bits;
    /// `f32::min` leaves the choice to the processor.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let least = |x: f32, y: f32| if y < x { y } else { x };
        let most = |x: f32, y: f32| if y > x { y } else { x };
        Self {
            min: core::array::from_fn(|i| least(self.min[i], other.min[i])),
            max: core::array::from_fn(|i| most(self.max[i], other.max[i])),
        }
    }

    /// Returns the intersection: [empty](Aabb::is_empty) where they do not overlap.
    #[must_use]
    #[inline]
    pub fn intersection(&self, other: &Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.min, self.max);
        let ([g, h, i], [j, k, l]) = (other.min, other.max);
        Self { min: [a.max(g), b.max(h), c.max(i)], max: [d.min(j), e.min(k), f.min(l)] }
    }

    /// Enlarges the box by `margin` (m) on all sides, up to rounding.
    #[must_use]
    #[inline]
    pub fn enlarged(&self, margin: f32) -> Self {
        let ([u, v, w], [x, y, z]) = (self.min, self.max);
        Self {
            min: [u - margin, v - margin, w - margin],
            max: [x + margin, y + margin, z + margin],
        }
    }

    /// Whether the box contains no point.
    #[must_use]
    #[inline]
    pub fn is_empty(&self) -> bool {
        let Self { min, max } = self;
        min[0] > max[0] || min[1] > max[1] || min[2] > max[2]
    }

    /// Length along an axis (0, 1, 2), in metres; negative infinity for the empty box.
    #[must_use]
    pub fn extent(&self, axis: usize) -> f32 {
        self.max[axis] - self.min[axis]
    }

    /// Half the surface area (m²), 0 for the empty box.
    #[must_use]
    pub fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.extent(axis));
        if x < 0.0 { 0.0 } else { x * y + y * z + z * x }
    }

    /// Converts the box to f64.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        Bounds {
            min: DVec3::from_array(self.min.map(f64::from)),
            max: DVec3::from_array(self.max.map(f64::from)),
        }
    }
}

/// A closed axis-aligned box in f64, in the frame of the traversal, in metres; rounded outward
/// where it was computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least x, y, z.
    pub min: DVec3,
    /// Greatest x, y, z.
    pub max: DVec3,
}

impl Bounds {
    /// Whether the two closed boxes share a point: touching counts.
    #[must_use]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Half the surface area (m²), 0 for the empty box.
    #[must_use]
    pub fn half_area(&self) -> f64 {
        let e = self.max - self.min;
        if e.x < 0.0 { 0.0 } else { e.x * e.y + e.y * e.z + e.z * e.x }
    }
}

#[cfg(test)]
mod tests;
