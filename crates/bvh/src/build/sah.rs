//! The binned surface-area heuristic.
//!
//! Triangles are sorted into bins by the centre of their box; of all cuts between two bins, along
//! all three axes, the one with the least `half_area(left)·n(left) + half_area(right)·n(right)` is
//! taken. Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies* (2007). Where all
//! centres are the same no bin tells anything, and the triangles are halved as they stand.

use super::grow::{self, Job, Parts};
use geometry::{Aabb, Corners};
use model::Node;
use std::ops::Range;

/// Most bins per axis. A range of fewer triangles has as many bins as triangles.
const BINS: usize = 32;

#[derive(Clone, Copy)]
struct Item {
    bounds: Aabb,
    id: u32,
}

impl Item {
    /// Twice the centre of the box (m): f64 holds it without overflow.
    fn centre(&self, axis: usize) -> f64 {
        f64::from(self.bounds.min[axis]) + f64::from(self.bounds.max[axis])
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    count: usize,
}

const NO_ITEMS: Bin = Bin { bounds: Aabb::EMPTY, count: 0 };

impl Bin {
    fn add(&mut self, other: &Self) {
        self.bounds = self.bounds.union(&other.bounds);
        self.count += other.count;
    }

    /// What it costs to meet these triangles, in f64: the area of huge boxes overflows f32.
    fn cost(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.bounds.bounds().half_area() * self.count as f64 }
    }
}

/// How centres along one axis fall into bins.
#[derive(Clone, Copy)]
struct Scale {
    axis: usize,
    low: f64,
    per_metre: f64,
    bins: usize,
}

impl Scale {
    /// `None` if all centres are the same along this axis.
    fn of(items: &[Item], axis: usize) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for item in items {
            low = low.min(item.centre(axis));
            high = high.max(item.centre(axis));
        }
        let bins = items.len().min(BINS);
        (low < high).then(|| Self { axis, low, per_metre: bins as f64 / (high - low), bins })
    }

    /// The lowest centre falls into the first bin, the highest into the last one.
    fn bin(&self, item: &Item) -> usize {
        // A cast of a float saturates, so no value falls outside.
        (((item.centre(self.axis) - self.low) * self.per_metre) as usize).min(self.bins - 1)
    }
}

struct Items<'a>(&'a mut [Item]);

/// Grows the tree over `corners`; also says which triangle goes where.
pub(super) fn grow(corners: &[Corners], job: &Job<'_>) -> (Vec<Node>, Vec<u32>) {
    let mut items: Vec<Item> =
        corners.iter().zip(0..).map(|(c, id)| Item { bounds: Aabb::of(c), id }).collect();
    let nodes = grow::grow(Items(&mut items), job);
    (nodes, items.iter().map(|item| item.id).collect())
}

/// The best cut along one axis: its cost, and the first bin of the right half.
fn best(items: &[Item], scale: &Scale) -> (f64, usize) {
    let mut bins = [NO_ITEMS; BINS];
    for item in items {
        bins[scale.bin(item)].add(&Bin { bounds: item.bounds, count: 1 });
    }
    let bins = &bins[..scale.bins];
    let mut costs = [0.0; BINS];
    let mut rest = NO_ITEMS;
    for (bin, cost) in bins.iter().zip(&mut costs).rev() {
        rest.add(bin);
        *cost = rest.cost();
    }
    let mut best = (f64::INFINITY, usize::MAX, 1);
    let mut left = NO_ITEMS;
    for (at, bin) in bins.iter().enumerate().take(scale.bins - 1) {
        left.add(bin);
        let cost = left.cost() + costs[at + 1];
        // Triangles on one line have no area: only balance keeps their tree shallow.
        let skew = (2 * left.count).abs_diff(items.len());
        if cost < best.0 || (cost == best.0 && skew < best.1) {
            best = (cost, skew, at + 1);
        }
    }
    (best.0, best.2)
}

impl Parts for Items<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn cut(&mut self, range: Range<usize>) -> usize {
        let items = &mut self.0[range];
        let mut chosen: Option<(f64, usize, Scale)> = None;
        for scale in (0..3).filter_map(|axis| Scale::of(items, axis)) {
            let (cost, at) = best(items, &scale);
            if chosen.is_none_or(|(least, ..)| cost < least) {
                chosen = Some((cost, at, scale));
            }
        }
        let Some((_, at, scale)) = chosen else { return items.len() / 2 };
        // The first bin is never empty, and neither is the last one: both halves get something.
        let (mut left, mut right) = (0, items.len());
        while left < right {
            if scale.bin(&items[left]) < at {
                left += 1;
            } else {
                right -= 1;
                items.swap(left, right);
            }
        }
        left
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at_mut(at);
        (Self(left), Self(right))
    }

    fn settle(&mut self, range: Range<usize>) {
        self.0[range].sort_unstable_by_key(|item| item.id);
    }
}
