//! Support values along the fixed set of directions in which contact is measured.
//!
//! D = 72 horizontal directions, every 5° from u (the direction of the relative velocity), and ±z
//! (`Directions`). A support is the greatest `x·d` over a set of points; the merge is the maximum,
//! so it does not matter in which order, or how often, points are added.

use crate::DVec3;

/// How many directions there are: 72 horizontal ones and ±z.
pub const DIRECTIONS: usize = 74;

/// The directions in which contact is measured, as unit vectors in A's frame.
///
/// Index `i < 72` is the direction `5°·i` from u, turning from u towards t = z × u; 72 is +z, 73 −z.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions {
    /// Unit vectors, A's frame.
    pub d: [DVec3; DIRECTIONS],
}

/// The greatest `x·d` [m] seen so far in each direction; negative infinity where nothing was.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Supports(pub [f64; DIRECTIONS]);

impl Directions {
    /// The directions around the horizontal unit vector `u` and the upward unit vector `z`, both in
    /// A's frame. Sines and cosines are those of `libm`.
    #[must_use]
    pub fn around(u: DVec3, z: DVec3) -> Self {
        let t = z.cross(u);
        let d = core::array::from_fn(|i| match i {
            72 => z,
            73 => -z,
            _ => {
                let (sin, cos) = libm::sincos((5.0 * i as f64).to_radians());
                u * cos + t * sin
            }
        });
        Self { d }
    }
}

impl Supports {
    /// Of no points.
    pub const EMPTY: Self = Self([f64::NEG_INFINITY; DIRECTIONS]);

    /// Includes one point [m], A's frame.
    pub fn add(&mut self, directions: &Directions, point: DVec3) {
        for (support, d) in self.0.iter_mut().zip(&directions.d) {
            *support = support.max(point.dot(*d));
        }
    }

    /// Includes all that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        for (support, more) in self.0.iter_mut().zip(&other.0) {
            *support = support.max(*more);
        }
    }
}
