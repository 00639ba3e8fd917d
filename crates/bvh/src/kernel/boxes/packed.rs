//! The triangles of one leaf that may meet another, side by side, and two such leaves compared.

use super::{Boxes, lanes, same};
use crate::build::LEAF_SIZE_MAX;
use fearless_simd::{Simd, SimdBase, SimdMask, mask32x8, u32x8};
use fearless_simd_macros::simd;
use geometry::batch::BATCH;
use model::wide::{LANES, LEAF_TRIANGLES};

/// Candidates that wait at most: each triangle of A adds as many as a leaf of B has, and a vector
/// is stored whole.
pub(in crate::kernel) const WAITING: usize = BATCH + LEAF_MAX + LANES;

/// Most triangles of a leaf, wide or binary.
pub(in crate::kernel) const LEAF_MAX: usize = LEAF_SIZE_MAX as usize;
const _: () = assert!(LEAF_TRIANGLES <= LEAF_MAX && LEAF_MAX <= u64::BITS as usize);

/// Boxes of triangles side by side, without gaps: those of one leaf that may meet another leaf.
#[derive(Clone, Debug)]
pub(in crate::kernel) struct Packed {
    min: [[f32; Self::ROOM]; 3],
    max: [[f32; Self::ROOM]; 3],
    triangles: [u32; Self::ROOM],
    len: usize,
}

impl Packed {
    /// One more vector than triangles, since vectors are stored whole.
    const ROOM: usize = LEAF_MAX + LANES;

    pub(in crate::kernel) const EMPTY: Self = Self {
        min: [[0.0; Self::ROOM]; 3],
        max: [[0.0; Self::ROOM]; 3],
        triangles: [0; Self::ROOM],
        len: 0,
    };

    /// Forgets all triangles.
    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// The triangles.
    pub(in crate::kernel) fn triangles(&self) -> &[u32] {
        &self.triangles[..self.len]
    }

    /// Adds some of eight triangles, the first of which is `first`.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        boxes: &Boxes<S>,
        which: mask32x8<S>,
        first: u32,
    ) {
        let triangles = u32x8::from_slice(simd, &[0, 1, 2, 3, 4, 5, 6, 7]) + first;
        self.put(simd, boxes, which, triangles);
    }

    #[inline(always)]
    fn put<S: Simd>(
        &mut self,
        _simd: S,
        boxes: &Boxes<S>,
        which: mask32x8<S>,
        triangles: u32x8<S>,
    ) {
        let at = self.len;
        for axis in 0..3 {
            boxes.min[axis].compress(which).store_slice(&mut self.min[axis][at..at + LANES]);
            boxes.max[axis].compress(which).store_slice(&mut self.max[axis][at..at + LANES]);
        }
        triangles.compress(which).store_slice(&mut self.triangles[at..at + LANES]);
        self.len += which.to_bitmask().count_ones() as usize;
    }

    /// Makes what follows the last triangle meet nothing.
    #[inline(always)]
    pub(super) fn close<S: Simd>(&mut self, simd: S) {
        let nothing = Boxes::nothing(simd);
        let at = self.len;
        for axis in 0..3 {
            nothing.min[axis].store_slice(&mut self.min[axis][at..at + LANES]);
            nothing.max[axis].store_slice(&mut self.max[axis][at..at + LANES]);
        }
    }

    /// Drops those that do not meet `other`; what follows the last one meets nothing, as before.
    #[inline(always)]
    pub(super) fn keep<S: Simd>(&mut self, simd: S, other: &Boxes<S>) {
        let len = std::mem::take(&mut self.len);
        for at in (0..len).step_by(LANES) {
            // What is written lies before what is read next.
            let boxes = self.eight(simd, at);
            let triangles = u32x8::from_slice(simd, &self.triangles[at..at + LANES]);
            self.put(simd, &boxes, boxes.overlapping(other), triangles);
        }
        self.close(simd);
    }

    #[inline(always)]
    fn eight<S: Simd>(&self, simd: S, at: usize) -> Boxes<S> {
        Boxes {
            min: lanes(simd, &self.min, at..at + LANES),
            max: lanes(simd, &self.max, at..at + LANES),
        }
    }

    /// Pairs of triangles whose boxes meet: of those of A from the one at `row` on, one by one, and
    /// those of B. Writes them to `out` behind the `count` that are there, until there are
    /// [`BATCH`] or no triangle of A is left; returns the next row and how many there are then.
    ///
    /// `only` says which of B a triangle of A is to be tested with, bit j for the jth.
    #[simd]
    pub(in crate::kernel) fn meet<S: Simd>(
        &self,
        simd: S,
        b: &Self,
        mut row: usize,
        only: impl Fn(u32) -> u64,
        out: &mut [[u32; 2]; WAITING],
        mut count: usize,
    ) -> (usize, usize) {
        while row < self.len && count < BATCH {
            let (min, max) = (&self.min, &self.max);
            let one = Boxes {
                min: same(simd, &[min[0][row], min[1][row], min[2][row]]),
                max: same(simd, &[max[0][row], max[1][row], max[2][row]]),
            };
            let only = only(self.triangles[row]);
            let triangle = u32x8::splat(simd, self.triangles[row]);
            for at in (0..b.len).step_by(LANES) {
                let mut meeting = one.overlapping(&b.eight(simd, at));
                if only != u64::MAX {
                    meeting &= mask32x8::from_bitmask(simd, only >> at & 0xff);
                }
                let others = u32x8::from_slice(simd, &b.triangles[at..at + LANES]);
                let (low, high) = triangle.interleave(others.compress(meeting));
                let pairs = out[count..count + LANES].as_flattened_mut();
                low.store_slice(&mut pairs[..LANES]);
                high.store_slice(&mut pairs[LANES..]);
                count += meeting.to_bitmask().count_ones() as usize;
            }
            row += 1;
        }
        (row, count)
    }
}
