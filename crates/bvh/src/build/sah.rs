//! The binned surface-area heuristic.
//!
//! Triangles are sorted into bins by the centre of their box, along all three axes in one pass; of
//! all cuts between two bins, the one with the least `half_area(left)·n(left) +
//! half_area(right)·n(right)` is taken, ties going to the most balanced, then to the lowest axis.
//! Wald, *On fast Construction of SAH-based Bounding Volume Hierarchies* (2007). Where no cut has a
//! cost, because all centres are the same or f32 overflows, the triangles are halved as they stand.
//!
//! A cut writes both halves to another buffer, preserving the order: no branch to predict, and the
//! triangles of a leaf stay ascending. Only counts and maxima are accumulated over triangles, so
//! the result does not depend on how they are partitioned among threads.

use super::grow::{self, Cut, Forest, Job, Parts};
use super::thread_pool::BuildPool;
use geometry::{Aabb, Corners};
use std::ops::Range;

/// Bins per axis.
const BINS: usize = 16;
/// Bins per axis for few triangles.
const BINS_FEW: usize = 8;
/// Up to this number, triangles count as few.
const FEW: usize = 16;

/// The reach (m) of a box along −x, −y, −z, a fourth lane, x, y, z, and another one.
///
/// So the union of two boxes is the lane-wise maximum, which the compiler can vectorise. For a
/// triangle, the last lane holds the bits of its number and the fourth one holds 1: their
/// difference is never subnormal, which would be slow on some machines.
type Reach = [f32; 8];

const NOTHING: Reach = [f32::NEG_INFINITY; 8];

fn reach(corners: &Corners, id: u32) -> Reach {
    let Aabb { min, max } = Aabb::of(corners);
    [-min[0], -min[1], -min[2], 1.0, max[0], max[1], max[2], f32::from_bits(id)]
}

fn include(sum: &mut Reach, other: &Reach) {
    for (x, y) in sum.iter_mut().zip(other) {
        *x = if *y > *x { *y } else { *x };
    }
}

fn bounds(reach: &Reach) -> Aabb {
    Aabb { min: [-reach[0], -reach[1], -reach[2]], max: [reach[4], reach[5], reach[6]] }
}

/// Half the surface area (m²); infinite for [`NOTHING`].
fn half_area(reach: &Reach) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|axis| reach[axis] + reach[axis + 4]);
    x * y + y * z + z * x
}

/// Twice the centre (m), and a fourth lane.
fn centre(reach: &Reach) -> [f32; 4] {
    std::array::from_fn(|lane| reach[lane + 4] - reach[lane])
}

/// The reach of a point.
fn reach_of_point(point: &[f32; 4]) -> Reach {
    std::array::from_fn(|lane| if lane < 4 { -point[lane] } else { point[lane - 4] })
}

/// Maps centres to bins: to the nearest of equally spaced posts, the first at the lowest centre and
/// the last at the highest one.
struct Scale {
    low: [f32; 4],
    per_metre: [f32; 4],
}

/// From here on floats are integers: a sum with this one is rounded to the nearest integer, which
/// then stands in its lowest bits.
const WHOLE: f32 = 8_388_608.0;

impl Scale {
    /// `centres` is the reach of all centres. `None` if f32 cannot hold their distances: bins must
    /// be reproducible numbers.
    fn new<const N: usize>(centres: &Reach) -> Option<Self> {
        let extent: [f32; 4] = std::array::from_fn(|lane| centres[lane + 4] + centres[lane]);
        let per_metre = extent.map(|extent| {
            let per_metre = (N - 1) as f32 / extent;
            // If all centres are the same, or nearly so, they all fall into the first bin.
            if per_metre < f32::INFINITY { per_metre } else { 0.0 }
        });
        let low = std::array::from_fn(|lane| -centres[lane]);
        extent[..3].iter().all(|extent| *extent < f32::INFINITY).then_some(Self { low, per_metre })
    }

    /// The bin of a centre along one axis, in the lowest bits.
    fn place(&self, centre: f32, axis: usize) -> u32 {
        ((centre - self.low[axis]) * self.per_metre[axis] + WHOLE).to_bits()
    }

    fn places(&self, item: &Reach) -> [u32; 4] {
        let centre = centre(item);
        std::array::from_fn(|lane| self.place(centre[lane], lane))
    }

    fn bin<const N: usize>(&self, item: &Reach, axis: usize) -> usize {
        self.place(item[axis + 4] - item[axis], axis) as usize % N
    }
}

/// The contents of the bins of the three axes.
#[derive(Clone)]
struct Bins<const N: usize> {
    reach: [[Reach; N]; 3],
    count: [[u32; N]; 3],
}

/// Where to cut: between two bins of one axis.
struct Best {
    cost: f32,
    skew: u32,
    axis: usize,
    /// The first bin of the right half.
    bin: usize,
}

impl<const N: usize> Bins<N> {
    const EMPTY: Self = Self { reach: [[NOTHING; N]; 3], count: [[0; N]; 3] };

    fn fill(&mut self, items: &[Reach], scale: &Scale) {
        for item in items {
            let places = scale.places(item);
            let axes = self.reach.iter_mut().zip(&mut self.count);
            for ((reach, count), place) in axes.zip(places) {
                let bin = place as usize % N;
                include(&mut reach[bin], item);
                count[bin] += 1;
            }
        }
    }

    fn add(&mut self, other: &Self) {
        for axis in 0..3 {
            for bin in 0..N {
                include(&mut self.reach[axis][bin], &other.reach[axis][bin]);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
    }

    /// The best cut, if any has a cost.
    fn best(&self, count: usize) -> Option<Best> {
        let none = Best { cost: f32::INFINITY, skew: u32::MAX, axis: 0, bin: 0 };
        let mut best = none;
        for axis in 0..3 {
            let (reaches, counts) = (&self.reach[axis], &self.count[axis]);
            let mut costs = [0.0; N];
            let (mut reach, mut right) = (NOTHING, 0);
            for bin in (1..N).rev() {
                include(&mut reach, &reaches[bin]);
                right += counts[bin];
                costs[bin] = half_area(&reach) * right as f32;
            }
            let (mut reach, mut left) = (NOTHING, 0);
            for bin in 1..N {
                include(&mut reach, &reaches[bin - 1]);
                left += counts[bin - 1];
                // An empty half costs ∞ · 0, which is NaN and thus not less than anything.
                let cost = half_area(&reach) * left as f32 + costs[bin];
                // Triangles on one line have no area: only balance keeps their tree shallow.
                let skew = (2 * left).abs_diff(count as u32);
                if cost < best.cost || (cost == best.cost && skew < best.skew) {
                    best = Best { cost, skew, axis, bin };
                }
            }
        }
        (best.cost < f32::INFINITY).then_some(best)
    }

    /// The number of triangles before and after a cut, and their boxes.
    fn halves(&self, cut: &Best) -> [(usize, Reach); 2] {
        [0..cut.bin, cut.bin..N].map(|half| {
            let mut reach = NOTHING;
            self.reach[cut.axis][half.clone()].iter().for_each(|other| include(&mut reach, other));
            (self.count[cut.axis][half].iter().sum::<u32>() as usize, reach)
        })
    }
}

/// Writes the items of both halves to their destination; returns the reach of their centres.
fn divide(
    items: &[Reach],
    [left, right]: [&mut [Reach]; 2],
    goes_right: impl Fn(&Reach) -> bool,
) -> [Reach; 2] {
    let mut centres = [NOTHING; 2];
    let (mut l, mut r) = (0, 0);
    for item in items {
        let goes_right = goes_right(item);
        // Every item is written to both halves and kept in one of them, except at their ends.
        if let Some(place) = left.get_mut(l) {
            *place = *item;
        }
        if let Some(place) = right.get_mut(r) {
            *place = *item;
        }
        l += usize::from(!goes_right);
        r += usize::from(goes_right);
        let centre = reach_of_point(&centre(item));
        let [of_left, of_right] = &mut centres;
        for lane in 0..8 {
            let (x, y) = (centre[lane], f32::NEG_INFINITY);
            let (near, far) = if goes_right { (y, x) } else { (x, y) };
            of_left[lane] = if near > of_left[lane] { near } else { of_left[lane] };
            of_right[lane] = if far > of_right[lane] { far } else { of_right[lane] };
        }
    }
    centres
}

/// What is known of a range.
pub(super) struct Known {
    reach: Reach,
    /// The reach of the doubled centres of its triangles.
    centres: Reach,
    /// Whether the items are in the second buffer.
    second: bool,
}

/// Two buffers of the same length: a range is in one of them.
struct Items<'a>([&'a mut [Reach]; 2]);

/// Grows the tree over `corners`.
pub(super) fn grow(corners: &[Corners], job: &Job<'_>) -> Forest {
    let n = corners.len();
    let order = grow::order(n);
    let (mut first, mut second) = (vec![[0.0; 8]; n], vec![[0.0; 8]; n]);
    let share = job.pool.share(n);
    let tasks = first.chunks_mut(share).zip(corners.chunks(share)).zip((0..).step_by(share));
    let known = job.pool.each(tasks.collect(), |((items, corners), first)| {
        sums(items.iter_mut().zip(corners).zip(first..).map(|((item, corners), id)| {
            *item = reach(corners, id);
            &*item
        }))
    });
    let [reach, centres] = both(&known);
    let known = Known { reach, centres, second: false };
    grow::grow(Items([&mut first, &mut second]), known, order, job)
}

/// The combined reach of items, and of their centres.
fn sums<'a>(items: impl IntoIterator<Item = &'a Reach>) -> [Reach; 2] {
    let [mut reach, mut centres] = [NOTHING; 2];
    for item in items {
        include(&mut reach, item);
        include(&mut centres, &reach_of_point(&centre(item)));
    }
    [reach, centres]
}

/// Combines pairs of sums.
fn both(pairs: &[[Reach; 2]]) -> [Reach; 2] {
    let mut sums = [NOTHING; 2];
    for pair in pairs {
        sums.iter_mut().zip(pair).for_each(|(sum, reach)| include(sum, reach));
    }
    sums
}

impl Items<'_> {
    fn cut_with<const N: usize>(
        &mut self,
        range: Range<usize>,
        known: Known,
        pool: &BuildPool,
    ) -> Cut<Known> {
        let [first, second] = &mut self.0;
        let (from, to) = if known.second { (second, first) } else { (first, second) };
        let (from, to) = (&from[range.clone()], &mut to[range]);
        let Some(scale) = Scale::new::<N>(&known.centres) else { return halved(from, known) };
        let (share, threads) = (pool.share(from.len()), pool.threads());
        let mut bins = Bins::<N>::EMPTY;
        let mut parts = Vec::new();
        if threads > 1 {
            parts = pool.each(from.chunks(share).collect(), |items| {
                let mut bins = Bins::<N>::EMPTY;
                bins.fill(items, &scale);
                bins
            });
            parts.iter().for_each(|part| bins.add(part));
        } else {
            bins.fill(from, &scale);
        }
        let Some(best) = bins.best(from.len()) else { return halved(from, known) };
        let [(left, reach_left), (_, reach_right)] = bins.halves(&best);
        let goes_right = |item: &Reach| scale.bin::<N>(item, best.axis) >= best.bin;
        let (mut near, mut far) = to.split_at_mut(left);
        let [centres_left, centres_right] = if threads > 1 {
            let mut tasks = Vec::new();
            for (items, bins) in from.chunks(share).zip(&parts) {
                let [(left, _), (right, _)] = bins.halves(&best);
                let (l, r);
                (l, near) = near.split_at_mut(left);
                (r, far) = far.split_at_mut(right);
                tasks.push((items, [l, r]));
            }
            both(&pool.each(tasks, |(items, halves)| divide(items, halves, goes_right)))
        } else {
            divide(from, [near, far], goes_right)
        };
        let second = !known.second;
        Cut {
            bounds: bounds(&known.reach),
            left,
            known: [
                Known { reach: reach_left, centres: centres_left, second },
                Known { reach: reach_right, centres: centres_right, second },
            ],
        }
    }
}

/// Halves the items in their current order.
fn halved(items: &[Reach], known: Known) -> Cut<Known> {
    let left = items.len() / 2;
    let (near, far) = items.split_at(left);
    let known_of = |items: &[Reach]| {
        let [reach, centres] = sums(items);
        Known { reach, centres, second: known.second }
    };
    Cut { bounds: bounds(&known.reach), left, known: [known_of(near), known_of(far)] }
}

impl Parts for Items<'_> {
    type Known = Known;

    fn len(&self) -> usize {
        self.0[0].len()
    }

    fn cut(&mut self, range: Range<usize>, known: Known, pool: &BuildPool) -> Cut<Known> {
        if range.len() > FEW {
            self.cut_with::<BINS>(range, known, pool)
        } else {
            self.cut_with::<BINS_FEW>(range, known, &BuildPool::ALONE)
        }
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let [first, second] = self.0.map(|items| items.split_at_mut(at));
        (Self([first.0, second.0]), Self([first.1, second.1]))
    }

    fn settle(&mut self, range: Range<usize>, known: Known, ids: &mut [u32]) -> Aabb {
        let items = &self.0[usize::from(known.second)][range];
        ids.iter_mut().zip(items).for_each(|(id, item)| *id = item[7].to_bits());
        bounds(&known.reach)
    }
}
