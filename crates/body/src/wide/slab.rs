//! The space between two parallel planes that contains some triangles.

use bytemuck::{Pod, Zeroable};
use geometry::{Corners, DVec3};

/// All points x with `low ≤ normal·x ≤ high`, body frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Slab {
    /// A unit vector, up to rounding; any direction is valid.
    pub normal: [f32; 3],
    /// Least distance along the normal (m), rounded down.
    pub low: f32,
    /// Greatest distance along the normal (m), rounded up.
    pub high: f32,
}

impl Slab {
    /// A thin slab around triangles: along the mean of their normals, weighted by area, each
    /// flipped to the side of those before it, so that the two sides of a sheet do not cancel.
    #[must_use]
    pub fn around(triangles: &[Corners]) -> Self {
        let point = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
        let mut sum = DVec3::ZERO;
        for [a, b, c] in triangles {
            let (a, b, c) = (point(*a), point(*b), point(*c));
            let normal = (b - a).cross(c - a);
            sum += if normal.dot(sum) < 0.0 { -normal } else { normal };
        }
        let normal = sum.try_normalize().unwrap_or(DVec3::Z).to_array().map(|x| x as f32);
        let along = point(normal);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in triangles.as_flattened() {
            // Exact up to a few parts in 2⁵³; the rounding to f32 covers this a thousand times
            // over.
            let distance = along.dot(point(*corner));
            (low, high) = (low.min(distance), high.max(distance));
        }
        let (low, high) = ((low as f32).next_down().next_down(), (high as f32).next_up().next_up());
        Self { normal, low: low + 0.0, high: high + 0.0 }
    }
}
