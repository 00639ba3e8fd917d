//! The split of Wiseman and Grinberg (2018), with and without a balance rule.
//!
//! For each axis: sort the triangles by highest vertex, and choose the index k that minimises
//! `[len(left) + len(rest)] / len(parent)`, where len is the extent of the parts along that axis.
//! Of the three axes, the one with the least ratio wins; ties go to the most balanced cut, then to
//! the lowest axis, then to the lowest k.
//!
//! Taken literally, the rule has no balance term, and on real bodies it peels slivers off: the tree
//! is thousands of levels deep. So the default keeps k within [n/8, 7n/8].
//!
//! Triangles are sorted once per axis. A cut then partitions the other two orders stably, so that
//! they stay sorted: O(n) per level of the tree. Where several threads work on one range, each
//! takes an axis.

use super::grow::{self, Cut, Forest, Job, Parts};
use super::thread_pool::BuildPool;
use crate::float_order;
use bytemuck::{Pod, Zeroable};
use geometry::{Aabb, Corners};
use std::ops::{Range, RangeInclusive};
use std::sync::atomic::{AtomicBool, Ordering};

/// Allowed cuts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cuts {
    /// k in [n/8, 7n/8].
    Balanced,
    /// Any cut that leaves neither half empty.
    Any,
}

impl Cuts {
    /// The allowed indices among n ≥ 2 triangles: neither half is ever empty.
    fn among(self, n: usize) -> RangeInclusive<usize> {
        match self {
            Self::Balanced => n.div_ceil(8)..=(n - n.div_ceil(8)),
            Self::Any => 1..=n - 1,
        }
    }
}

/// A triangle in one of the three orders: its extent along that axis (m), and its number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
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
    /// The distance of k from the middle: |2k − n|.
    skew: usize,
    k: usize,
    /// Where the parent begins and ends (m).
    extent: [f32; 2],
}

/// Triangles sorted along one axis.
struct Axis<'a> {
    order: &'a mut [Entry],
    /// Scratch of half the length, for what a cut records and moves.
    room: &'a mut [Entry],
}

/// Triangles in three orders: the same ones along x, y, z.
struct Orders<'a> {
    cuts: Cuts,
    axes: [Axis<'a>; 3],
    /// For each triangle of the whole body, whether the last cut put it into the right half.
    /// Threads share the array but never a triangle, so plain loads and stores would suffice if the
    /// language could express it.
    right: &'a [AtomicBool],
}

/// Grows the tree over `corners`.
pub(super) fn grow(corners: &[Corners], cuts: Cuts, job: &Job<'_>) -> Forest {
    let n = corners.len();
    let (order, room) = (grow::order(n), n / 2);
    // Two buffers whose memory is reused once freed: that of the orders is as large as the
    // triangles in leaf order; that of the spare, with two threads, as large as the nodes of a tree
    // with four triangles per leaf. The tree does not depend on this.
    let mut orders = job.pool.copies(Entry::zeroed(), 3 * n);
    let to_sort = n * job.pool.threads().min(3);
    let mut spare = job.pool.copies(Entry::zeroed(), to_sort.max(3 * room));
    sort(corners, thirds(&mut orders), &mut spare, job.pool);
    let right: Vec<AtomicBool> = std::iter::repeat_with(AtomicBool::default).take(n).collect();
    let ([x, y, z], [of_x, of_y, of_z]) = (thirds(&mut orders), thirds(&mut spare[..3 * room]));
    let axes = [(x, of_x), (y, of_y), (z, of_z)].map(|(order, room)| Axis { order, room });
    grow::grow(Orders { cuts, axes, right: &right }, (), order, job)
}

/// Splits into three parts of the same length, one per axis. Those of x and y lie at the ends: the
/// threads that sort along these axes are the first to write there.
fn thirds<T>(all: &mut [T]) -> [&mut [T]; 3] {
    let third = all.len() / 3;
    let (x, rest) = all.split_at_mut(third);
    let (z, y) = rest.split_at_mut(third);
    [x, y, z]
}

fn numbered<T>(axes: &mut [T; 3]) -> [(usize, &mut T); 3] {
    let [x, y, z] = axes;
    [(0, x), (1, y), (2, z)]
}

/// Sorts triangles by highest vertex along each axis, equal ones by number.
///
/// `spare` has at least an order's length for each of up to three threads. Three axes do not divide
/// evenly among two threads, so the third one is sorted in halves, which are merged from both ends.
/// Each of the two threads also reads only one half of the triangles, for all axes: the entries
/// that the other made of its half are a third as long.
fn sort(corners: &[Corners], orders: [&mut [Entry]; 3], spare: &mut [Entry], pool: &BuildPool) {
    let n = corners.len();
    let [x, y, z] = orders;
    match pool.threads() {
        1 => {
            for (axis, order) in [x, y, z].into_iter().enumerate() {
                sort_along(axis, corners, [order, &mut spare[..n]]);
            }
        }
        2 => {
            let middle = n.div_ceil(2);
            let (left, right) = corners.split_at(middle);
            let (near, far) = z.split_at_mut(middle);
            let (one, other) = spare.split_at_mut(n);
            let (one_near, one_far) = one.split_at_mut(middle);
            let (other_near, other_far) = other.split_at_mut(middle);
            pool.both(
                || read_all(left, 0, [one_near, other_near, near]),
                || read_all(right, middle as u32, [one_far, other_far, far]),
            );
            pool.both(
                || {
                    sort_entries([x, one]);
                    sort_entries([&mut one[..middle], near]);
                },
                || {
                    sort_entries([y, other]);
                    sort_entries([&mut other[middle..], far]);
                },
            );
            let halves = (&one[..middle], &other[middle..]);
            pool.both(|| merge_near(halves, near), || merge_far(halves, far));
        }
        _ => {
            let [of_x, of_y, of_z] = thirds(spare);
            pool.three([(0, x, of_x), (1, y, of_y), (2, z, of_z)], |(axis, order, spare)| {
                sort_along(axis, corners, [order, spare]);
            });
        }
    }
}

/// Bits of a digit: the table of counts stays in the first-level cache.
const DIGIT: usize = 11;
/// Digits of a rank: an odd number of passes from one buffer to the other.
const DIGITS: usize = 3;

/// Sorts triangles along `axis` into the first buffer.
fn sort_along(axis: usize, corners: &[Corners], [to, from]: [&mut [Entry]; 2]) {
    read(axis, corners, 0, from);
    sort_entries([to, from]);
}

/// The entries of triangles, numbered from `first`, along each axis.
fn read_all(corners: &[Corners], first: u32, entries: [&mut [Entry]; 3]) {
    for (axis, entries) in entries.into_iter().enumerate() {
        read(axis, corners, first, entries);
    }
}

/// The entries of triangles, numbered from `first`, along `axis`.
fn read(axis: usize, corners: &[Corners], first: u32, entries: &mut [Entry]) {
    for ((entry, corners), id) in entries.iter_mut().zip(corners).zip(first..) {
        let [x, y, z] = corners.map(|corner| corner[axis]);
        let (low, high) = (lesser(lesser(x, y), z), -lesser(lesser(-x, -y), -z));
        *entry = Entry { low, high, id };
    }
}

/// Sorts entries by highest vertex, stably, digit by digit from the lowest one. They start in the
/// second buffer and end up in the first.
///
/// Knuth, *The Art of Computer Programming* 3, section 5.2.5.
fn sort_entries([mut to, mut from]: [&mut [Entry]; 2]) {
    let digit =
        |entry: &Entry, at: usize| rank(entry.high) as usize >> (at * DIGIT) & ((1 << DIGIT) - 1);
    let mut counts = [[0_u32; 1 << DIGIT]; DIGITS];
    for entry in from.iter() {
        counts.iter_mut().enumerate().for_each(|(at, counts)| counts[digit(entry, at)] += 1);
    }
    for (at, counts) in counts.iter_mut().enumerate() {
        let mut start = 0;
        for count in counts.iter_mut() {
            start += std::mem::replace(count, start);
        }
        for entry in from.iter() {
            let place = &mut counts[digit(entry, at)];
            to[*place as usize] = *entry;
            *place += 1;
        }
        (from, to) = (to, from);
    }
}

/// Merges the first entries of two sorted halves; ties go to the left half, which is as long as
/// `to` and no shorter than the right one.
fn merge_near((left, right): (&[Entry], &[Entry]), to: &mut [Entry]) {
    let (mut l, mut r) = (0, 0);
    for place in to {
        let is_right = right.get(r).is_some_and(|entry| entry.high < left[l].high);
        *place = if is_right { right[r] } else { left[l] };
        r += usize::from(is_right);
        l += usize::from(!is_right);
    }
}

/// Merges the last entries of the same halves, as many as the right one has.
fn merge_far((left, right): (&[Entry], &[Entry]), to: &mut [Entry]) {
    let (mut l, mut r) = (left.len() - 1, right.len() - 1);
    for place in to.iter_mut().rev() {
        let is_right = right[r].high >= left[l].high;
        *place = if is_right { right[r] } else { left[l] };
        r = r.wrapping_sub(usize::from(is_right));
        l = l.wrapping_sub(usize::from(!is_right));
    }
}

/// An integer that orders as the finite float does.
fn rank(x: f32) -> u32 {
    // Both zeros are the same position.
    float_order::ordinal(x + 0.0)
}

/// The lesser of two numbers: a single instruction, since neither is NaN.
fn lesser(x: f32, y: f32) -> f32 {
    if y < x { y } else { x }
}

/// The best cut of one order.
fn best(order: &[Entry], lows: &mut [f32], allowed: RangeInclusive<usize>) -> Best {
    let n = order.len();
    let (first, last) = allowed.into_inner();
    let mut low = f32::INFINITY;
    for (entry, slot) in order.iter().zip(lows.iter_mut()).skip(first).rev() {
        low = lesser(low, entry.low);
        *slot = low;
    }
    let high = order[n - 1].high;
    let mut low = order[..first - 1].iter().fold(f32::INFINITY, |low, e| lesser(low, e.low));
    let (mut least, mut skew, mut k) = (f64::INFINITY, n, first);
    for ((end, rest), at) in order[first - 1..last].iter().zip(&lows[first..=last]).zip(first..) {
        low = lesser(low, end.low);
        let left = f64::from(end.high) - f64::from(low);
        let sum = left + (f64::from(high) - f64::from(*rest));
        if sum <= least {
            let skew_at = (2 * at).abs_diff(n);
            if sum < least || skew_at < skew {
                (least, skew, k) = (sum, skew_at, at);
            }
        }
    }
    let low = lesser(low, lows[last]);
    let whole = f64::from(high) - f64::from(low);
    let ratio = if whole > 0.0 { least / whole } else { f64::INFINITY };
    Best { ratio, skew, k, extent: [low, high] }
}

/// The axis whose best cut wins.
fn winner(found: &[Best; 3]) -> usize {
    let mut axis = 0;
    for other in 1..3 {
        let (new, old) = (&found[other], &found[axis]);
        if new.ratio < old.ratio || (new.ratio == old.ratio && new.skew < old.skew) {
            axis = other;
        }
    }
    axis
}

/// Moves the `k` triangles of the left half before those of the right one, preserving their order.
///
/// The smaller half waits in `room`, which is at least as long, while the other closes up. A second
/// buffer for both would be more memory to fetch: 5 to 13 % more time for a tree of 100,000
/// triangles.
fn divide(order: &mut [Entry], k: usize, room: &mut [Entry], right: &[AtomicBool]) {
    let n = order.len();
    let goes_right = |entry: Entry| right[entry.id as usize].load(Ordering::Relaxed);
    // Every entry is written to both halves and kept in one of them: no branch to predict.
    if 2 * k >= n {
        let (mut l, mut r) = (0, 0);
        for i in 0..n {
            let entry = order[i];
            let is_right = goes_right(entry);
            order[l] = entry;
            if let Some(place) = room.get_mut(r) {
                *place = entry;
            }
            l += usize::from(!is_right);
            r += usize::from(is_right);
        }
        order[k..].copy_from_slice(&room[..n - k]);
    } else {
        let (mut l, mut r) = (k, n);
        for i in (0..n).rev() {
            let entry = order[i];
            let is_right = goes_right(entry);
            order[r - 1] = entry;
            if let Some(place) = room.get_mut(l.wrapping_sub(1)) {
                *place = entry;
            }
            l -= usize::from(!is_right);
            r -= usize::from(is_right);
        }
        order[..k].copy_from_slice(&room[..k]);
    }
}

impl Parts for Orders<'_> {
    type Known = ();

    fn len(&self) -> usize {
        self.axes[0].order.len()
    }

    fn cut(&mut self, range: Range<usize>, (): (), pool: &BuildPool) -> Cut<()> {
        let allowed = self.cuts.among(range.len());
        // At least half as long as the range, and so for every parallel range. In bytes, this is
        // enough for one number per triangle.
        let spare = range.start / 2..range.end / 2;
        let found = pool.three(self.axes.each_mut(), |axis| {
            let lows = bytemuck::cast_slice_mut(&mut axis.room[spare.clone()]);
            best(&axis.order[range.clone()], lows, allowed.clone())
        });
        let (axis, right) = (winner(&found), self.right);
        let k = found[axis].k;
        for (i, entry) in self.axes[axis].order[range.clone()].iter().enumerate() {
            right[entry.id as usize].store(i >= k, Ordering::Relaxed);
        }
        pool.three(numbered(&mut self.axes), |(number, Axis { order, room })| {
            if number != axis {
                divide(&mut order[range.clone()], k, &mut room[spare.clone()], right);
            }
        });
        let [min, max] = [0, 1].map(|end| found.each_ref().map(|best| best.extent[end]));
        Cut { bounds: Aabb { min, max }, left: k, known: [(), ()] }
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (cuts, right) = (self.cuts, self.right);
        let [x, y, z] = self.axes.map(|Axis { order, room }| {
            let (order, room) = (order.split_at_mut(at), room.split_at_mut(at / 2));
            (Axis { order: order.0, room: room.0 }, Axis { order: order.1, room: room.1 })
        });
        (Self { cuts, axes: [x.0, y.0, z.0], right }, Self { cuts, axes: [x.1, y.1, z.1], right })
    }

    fn settle(&mut self, range: Range<usize>, (): (), ids: &mut [u32]) -> Aabb {
        let along = self.axes.each_ref().map(|axis| &axis.order[range.clone()]);
        ids.iter_mut().zip(along[0]).for_each(|(id, entry)| *id = entry.id);
        ids.sort_unstable();
        let min = along.map(|order| order.iter().fold(f32::INFINITY, |low, e| lesser(low, e.low)));
        Aabb { min, max: along.map(|order| order[order.len() - 1].high) }
    }
}
