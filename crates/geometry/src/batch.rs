//! The exact triangle test of many pairs at once.
//!
//! The same answer as [`triangle::intersect`] for every pair, at every width of the vectors.

use crate::{Corners, DVec3, RelativePose, Triangle, triangle};
use fearless_simd::Simd;

/// The most pairs that [`intersecting`] takes: the bits of its answer.
pub const BATCH: usize = 64;

/// The stored triangles of two bodies, and where B stands.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pose: &'a RelativePose,
    a: &'a [Corners],
    b: &'a [Corners],
}

impl<'a> Batch<'a> {
    /// The triangles of A and of B, each in its own frame; B stands at `pose`.
    #[must_use]
    pub fn new(pose: &'a RelativePose, a: &'a [Corners], b: &'a [Corners]) -> Self {
        Self { pose, a, b }
    }

    /// The triangles of a pair as the exact test takes them, both in A's frame.
    #[must_use]
    pub fn triangles(&self, [a, b]: [u32; 2]) -> [Triangle; 2] {
        let widened = self.a[a as usize].map(|corner| DVec3::from_array(corner.map(f64::from)));
        [Triangle(widened), self.pose.triangle(&self.b[b as usize])]
    }
}

/// Which of the `pairs`, numbers of a triangle of A and one of B, intersect: bit i for pair i.
///
/// # Panics
///
/// There are more than [`BATCH`] pairs, or no triangle of such a number.
#[must_use]
#[inline(always)]
pub fn intersecting<S: Simd>(_simd: S, batch: &Batch<'_>, pairs: &[[u32; 2]]) -> u64 {
    assert!(pairs.len() <= BATCH, "a batch of {} pairs", pairs.len());
    let mut hits = 0;
    for (i, pair) in pairs.iter().enumerate() {
        let [a, b] = batch.triangles(*pair);
        hits |= u64::from(triangle::intersect(&a, &b)) << i;
    }
    hits
}
