//! The split of Wiseman and Grinberg (2018), with and without a balance rule.
//!
//! For each axis: sort the triangles by highest vertex, and choose the index k that minimises
//! `[len(left) + len(rest)] / len(parent)`, where len is the extent of the parts along that axis.
//! Of the three axes, the one with the least ratio wins; ties go to the most balanced cut, then to
//! the lowest axis, then to the lowest k.
//!
//! By the letter there is no balance term, and on real bodies the rule peels slivers off: the tree
//! is thousands deep. So the default keeps k within [n/8, 7n/8].
//!
//! Triangles are sorted once per axis. A cut then divides the other two orders stably, so that they
//! stay sorted: O(n) per level of the tree.

use super::grow::{self, Cut, Job, Parts};
use geometry::{Aabb, Corners};
use model::Node;
use std::ops::{Range, RangeInclusive};
use std::sync::atomic::{AtomicBool, Ordering};

/// Which cuts are allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cuts {
    /// k in [n/8, 7n/8].
    Balanced,
    /// Any that leaves neither half empty.
    Any,
}

impl Cuts {
    /// The indices that may be chosen among n ≥ 2 triangles: neither half is ever empty.
    fn among(self, n: usize) -> RangeInclusive<usize> {
        match self {
            Self::Balanced => n.div_ceil(8)..=(n - n.div_ceil(8)),
            Self::Any => 1..=n - 1,
        }
    }
}

/// A triangle in one of the three orders: its extent along that axis (m), and its number.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    low: f32,
    high: f32,
    id: u32,
}

/// The best cut of one axis.
struct Best {
    /// `[len(left) + len(rest)] / len(parent)`; infinite where the parent has no length, since no
    /// cut along that axis can help.
    ratio: f64,
    /// How far k is from the middle: |2k − n|.
    skew: usize,
    k: usize,
    /// Where the parent begins and ends (m).
    extent: [f32; 2],
}

/// Some triangles in three orders: the same triangles in each, sorted along x, y, z.
struct Orders<'a> {
    cuts: Cuts,
    along: [&'a mut [Entry]; 3],
    /// As long as each of `along`.
    spare: &'a mut [Entry],
    /// Least `low` from here on, while an axis is looked at; as long as each of `along`.
    lows: &'a mut [f32],
    /// Per triangle of the whole body: whether the last cut put it right. Threads share the array
    /// but no triangle, so plain loads and stores would do if the language could know.
    right: &'a [AtomicBool],
}

/// Grows the tree over `corners`; also says which triangle goes where.
pub(super) fn grow(corners: &[Corners], cuts: Cuts, job: &Job<'_>) -> (Vec<Node>, Vec<u32>, u32) {
    let n = corners.len();
    let [mut x, mut y, mut z] = sorted(corners, job.threads);
    let (mut spare, mut lows) = (vec![Entry::default(); n], vec![0.0; n]);
    let right: Vec<AtomicBool> = std::iter::repeat_with(AtomicBool::default).take(n).collect();
    let along = [x.as_mut_slice(), &mut y, &mut z];
    let orders = Orders { cuts, along, spare: &mut spare, lows: &mut lows, right: &right };
    grow::grow(orders, (), job)
}

/// The three orders of all triangles.
fn sorted(corners: &[Corners], threads: usize) -> [Vec<Entry>; 3] {
    if threads < 2 {
        return [0, 1, 2].map(|axis| sorted_along(corners, axis));
    }
    std::thread::scope(|scope| {
        let [x, y] = [0, 1].map(|axis| scope.spawn(move || sorted_along(corners, axis)));
        let z = sorted_along(corners, 2);
        let [x, y] = [x, y].map(|t| t.join().unwrap_or_else(|e| std::panic::resume_unwind(e)));
        [x, y, z]
    })
}

/// Triangles by highest vertex along `axis`, equal ones by number.
fn sorted_along(corners: &[Corners], axis: usize) -> Vec<Entry> {
    let box_of = |id: u32| Aabb::of(&corners[id as usize]);
    // One integer per triangle sorts several times faster than a comparison of floats.
    let mut keys: Vec<u64> = (0..corners.len() as u32)
        .map(|id| u64::from(rank(box_of(id).max[axis] + 0.0)) << 32 | u64::from(id))
        .collect();
    keys.sort_unstable();
    keys.into_iter()
        .map(|key| {
            let id = (key & u64::from(u32::MAX)) as u32;
            let box_ = box_of(id);
            Entry { low: box_.min[axis], high: box_.max[axis], id }
        })
        .collect()
}

/// An integer that orders as the finite float does: IEEE 754 sorts as sign and magnitude.
fn rank(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// The best cut of one order.
fn best(order: &[Entry], lows: &mut [f32], allowed: RangeInclusive<usize>) -> Best {
    let n = order.len();
    let (first, last) = allowed.into_inner();
    let mut low = f32::INFINITY;
    for (entry, slot) in order.iter().zip(lows.iter_mut()).skip(first).rev() {
        low = low.min(entry.low);
        *slot = low;
    }
    let high = order[n - 1].high;
    let mut low = order[..first - 1].iter().fold(f32::INFINITY, |low, entry| low.min(entry.low));
    let (mut least, mut skew, mut k) = (f64::INFINITY, n, first);
    for at in first..=last {
        let end = order[at - 1];
        low = low.min(end.low);
        let left = f64::from(end.high) - f64::from(low);
        let sum = left + (f64::from(high) - f64::from(lows[at]));
        let skew_at = (2 * at).abs_diff(n);
        if sum < least || (sum == least && skew_at < skew) {
            (least, skew, k) = (sum, skew_at, at);
        }
    }
    let low = low.min(lows[last]);
    let whole = f64::from(high) - f64::from(low);
    let ratio = if whole > 0.0 { least / whole } else { f64::INFINITY };
    Best { ratio, skew, k, extent: [low, high] }
}

impl Orders<'_> {
    /// The best cut of `range`: its axis and k; and the box of all triangles.
    fn choose(&mut self, range: &Range<usize>) -> (usize, usize, Aabb) {
        let allowed = self.cuts.among(range.len());
        let found = [0, 1, 2].map(|axis| {
            let order = &self.along[axis][range.clone()];
            best(order, &mut self.lows[range.clone()], allowed.clone())
        });
        let mut axis = 0;
        for other in 1..3 {
            let (new, old) = (&found[other], &found[axis]);
            if new.ratio < old.ratio || (new.ratio == old.ratio && new.skew < old.skew) {
                axis = other;
            }
        }
        let [min, max] = [0, 1].map(|end| [0, 1, 2].map(|axis: usize| found[axis].extent[end]));
        (axis, found[axis].k, Aabb { min, max })
    }
}

impl Parts for Orders<'_> {
    type Known = ();

    fn len(&self) -> usize {
        self.spare.len()
    }

    fn cut(&mut self, range: Range<usize>, (): (), _threads: usize) -> Cut<()> {
        let (axis, k, bounds) = self.choose(&range);
        for (i, entry) in self.along[axis][range.clone()].iter().enumerate() {
            self.right[entry.id as usize].store(i >= k, Ordering::Relaxed);
        }
        for other in (0..3).filter(|&other| other != axis) {
            let order = &mut self.along[other][range.clone()];
            // Both halves are written for every entry and one of them kept: no branch to guess.
            let (mut left, mut right) = (0, 0);
            for i in 0..order.len() {
                let entry = order[i];
                let goes_right = self.right[entry.id as usize].load(Ordering::Relaxed);
                order[left] = entry;
                self.spare[range.start + right] = entry;
                left += usize::from(!goes_right);
                right += usize::from(goes_right);
            }
            order[left..].copy_from_slice(&self.spare[range.start..range.start + right]);
        }
        Cut { bounds, left: k, known: [(), ()] }
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let [x, y, z] = self.along.map(|order| order.split_at_mut(at));
        let (spare, lows) = (self.spare.split_at_mut(at), self.lows.split_at_mut(at));
        let (cuts, right) = (self.cuts, self.right);
        (
            Self { cuts, along: [x.0, y.0, z.0], spare: spare.0, lows: lows.0, right },
            Self { cuts, along: [x.1, y.1, z.1], spare: spare.1, lows: lows.1, right },
        )
    }

    fn settle(&mut self, range: Range<usize>, (): (), ids: &mut [u32]) -> Aabb {
        let along = [0, 1, 2].map(|axis: usize| &self.along[axis][range.clone()]);
        ids.iter_mut().zip(along[0]).for_each(|(id, entry)| *id = entry.id);
        ids.sort_unstable();
        let min = along.map(|order| order.iter().fold(f32::INFINITY, |low, e| low.min(e.low)));
        Aabb { min, max: along.map(|order| order[order.len() - 1].high) }
    }
}
