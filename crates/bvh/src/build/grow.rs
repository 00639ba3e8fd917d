//! Growing a tree: ranges of triangles are cut until they fit a leaf, nodes laid out in preorder.
//!
//! The largest ranges are cut one after the other, each by all threads together; the next ones one
//! by one, by whichever thread is free, and their halves put on a pile; small ones are grown to
//! whole subtrees by one thread. The subtrees are then joined in order of their first triangle.
//! Where a range is cut depends on its triangles alone, so the result is the same for any number
//! of threads.

use super::team;
use geometry::Aabb;
use model::Node;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Triangles that can be cut in two, again and again. What a build is, beside its rule.
pub(super) trait Parts: Sized + Send {
    /// What a cut finds out about each half, for the next cut to build on.
    type Known: Send;

    /// How many triangles.
    fn len(&self) -> usize;

    /// Reorders the triangles of `range`, at least two, so that the left half comes first; up to
    /// `threads` may help.
    fn cut(&mut self, range: Range<usize>, known: Self::Known, threads: usize) -> Cut<Self::Known>;

    /// Everything before `at`, and everything from there on.
    fn split_at(self, at: usize) -> (Self, Self);

    /// Writes the numbers of the triangles of a leaf, `range`, in ascending order; returns the box
    /// of all of them.
    fn settle(&mut self, range: Range<usize>, known: Self::Known, ids: &mut [u32]) -> Aabb;
}

/// A range in two halves.
pub(super) struct Cut<K> {
    /// The box of both.
    pub(super) bounds: Aabb,
    /// How many triangles are left; neither half is empty.
    pub(super) left: usize,
    /// What is known of the left half and of the right one.
    pub(super) known: [K; 2],
}

/// What every build is told.
pub(super) struct Job<'a> {
    /// Most triangles in a leaf.
    pub(super) leaf_size: usize,
    /// Threads, at least 1.
    pub(super) threads: usize,
    /// Hears of triangles placed since it was last called.
    pub(super) progress: &'a (dyn Fn(u64) + Sync),
}

/// Subtrees below this size are not worth handing to another thread.
const GRAIN_MIN: usize = 4096;
/// Pieces per thread: enough that uneven ones even out.
const PIECES: usize = 8;
/// A range is cut by all threads if it holds more than 1/SHARE of what would be one thread's.
const SHARE: usize = 2;
/// How many triangles are placed between two calls of `progress`.
const STRIDE: u64 = 8192;

/// How many of `threads` are worth their start for `count` triangles; at least 1.
pub(super) fn worthwhile(threads: usize, count: usize) -> usize {
    threads.clamp(1, count / GRAIN_MIN + 1)
}

/// Triangles that wait for a thread.
struct Piece<'a, P: Parts> {
    /// Number of the first one in leaf order.
    first: usize,
    parts: P,
    known: P::Known,
    /// Where their order goes.
    order: &'a mut [u32],
}

/// A subtree; links to nodes count from its own root.
struct Grown {
    first: usize,
    nodes: Vec<Node>,
    depth: u32,
}

/// A range of `count` triangles from `first` was cut behind `left` of them.
struct Mark {
    first: usize,
    count: usize,
    left: usize,
    bounds: Aabb,
}

struct Pile<'a, P: Parts> {
    open: Vec<Piece<'a, P>>,
    /// Threads at work on a piece: they may still add to `open`.
    busy: usize,
    cuts: Vec<Mark>,
    grown: Vec<Grown>,
}

struct Yard<'a, P: Parts> {
    pile: Mutex<Pile<'a, P>>,
    changed: Condvar,
}

/// Whoever holds this is `busy`. Dropped in a panic too, so that nobody waits for a dead thread.
struct Busy<'y, 'a, P: Parts>(&'y Yard<'a, P>);

impl<'a, P: Parts> Yard<'a, P> {
    fn pile(&self) -> MutexGuard<'_, Pile<'a, P>> {
        self.pile.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A piece to work on, or `None` when all is done.
    fn take(&self) -> Option<(Piece<'a, P>, Busy<'_, 'a, P>)> {
        let mut pile = self.pile();
        loop {
            if let Some(piece) = pile.open.pop() {
                pile.busy += 1;
                return Some((piece, Busy(self)));
            }
            if pile.busy == 0 {
                return None;
            }
            pile = self.changed.wait(pile).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl<P: Parts> Drop for Busy<'_, '_, P> {
    fn drop(&mut self) {
        self.0.pile().busy -= 1;
        self.0.changed.notify_all();
    }
}

/// Grows the tree over `parts`: nodes in preorder, the order of triangles, the depth.
pub(super) fn grow<P: Parts>(
    parts: P,
    known: P::Known,
    job: &Job<'_>,
) -> (Vec<Node>, Vec<u32>, u32) {
    let count = parts.len();
    let mut order = vec![0; count];
    let whole = Piece { first: 0, parts, known, order: &mut order };
    let threads = job.threads;
    if threads == 1 {
        let Grown { nodes, depth, .. } = subtree(whole, job);
        return (nodes, order, depth);
    }
    let (mut cuts, mut open, mut large) = (Vec::new(), Vec::new(), vec![whole]);
    while let Some(piece) = large.pop() {
        if piece.parts.len() <= (count / (threads * SHARE)).max(GRAIN_MIN) {
            open.push(piece);
        } else {
            let (mark, halves) = halved(piece, threads);
            cuts.push(mark);
            large.extend(halves);
        }
    }
    // The largest ones first: they are taken from the end.
    open.sort_by_key(|piece| piece.parts.len());
    let pile = Pile { open, busy: 0, cuts, grown: Vec::new() };
    let yard = Yard { pile: Mutex::new(pile), changed: Condvar::new() };
    let grain = (count / (threads * PIECES)).max(GRAIN_MIN);
    team::each(vec![(); threads], |()| work(&yard, grain, job));
    let pile = yard.pile.into_inner().unwrap_or_else(PoisonError::into_inner);
    let (nodes, depth) = join(count, pile.cuts, pile.grown, threads);
    (nodes, order, depth)
}

fn halved<P: Parts>(piece: Piece<'_, P>, threads: usize) -> (Mark, [Piece<'_, P>; 2]) {
    let Piece { first, mut parts, known, order } = piece;
    let count = parts.len();
    let Cut { bounds, left, known: [known_left, known_right] } =
        parts.cut(0..count, known, threads);
    let (near, far) = parts.split_at(left);
    let (order_left, order_right) = order.split_at_mut(left);
    let halves = [
        Piece { first: first + left, parts: far, known: known_right, order: order_right },
        Piece { first, parts: near, known: known_left, order: order_left },
    ];
    (Mark { first, count, left, bounds }, halves)
}

fn work<P: Parts>(yard: &Yard<'_, P>, grain: usize, job: &Job<'_>) {
    while let Some((piece, _busy)) = yard.take() {
        if piece.parts.len() > grain {
            let (mark, halves) = halved(piece, 1);
            let mut pile = yard.pile();
            pile.cuts.push(mark);
            pile.open.extend(halves);
            drop(pile);
            yard.changed.notify_all();
        } else {
            let grown = subtree(piece, job);
            yard.pile().grown.push(grown);
        }
    }
}

/// A range still to do.
struct Open<K> {
    range: Range<usize>,
    known: K,
    /// The node whose right child it is, if it is one.
    parent: Option<usize>,
    depth: u32,
}

/// All nodes over one piece, in preorder.
fn subtree<P: Parts>(piece: Piece<'_, P>, job: &Job<'_>) -> Grown {
    let Piece { first, mut parts, known, order } = piece;
    let count = parts.len();
    let mut nodes = Vec::with_capacity(2 * count.div_ceil(job.leaf_size));
    let mut open = vec![Open { range: 0..count, known, parent: None, depth: 1 }];
    let (mut placed, mut deepest) = (0, 0);
    while let Some(Open { range, known, parent, depth }) = open.pop() {
        let node = nodes.len();
        if let Some(parent) = parent {
            link(&mut nodes, parent, node);
        }
        if range.len() <= job.leaf_size {
            let (start, count) = (range.start, range.len());
            let bounds = parts.settle(range.clone(), known, &mut order[range]);
            nodes.push(leaf(bounds, first + start, count));
            deepest = deepest.max(depth);
            placed += count as u64;
            if placed >= STRIDE {
                (job.progress)(placed);
                placed = 0;
            }
        } else {
            let Cut { bounds, left, known: [near, far] } = parts.cut(range.clone(), known, 1);
            let (left, depth) = (range.start + left, depth + 1);
            nodes.push(interior(bounds));
            open.push(Open { range: left..range.end, known: far, parent: Some(node), depth });
            open.push(Open { range: range.start..left, known: near, parent: None, depth });
        }
    }
    if placed > 0 {
        (job.progress)(placed);
    }
    Grown { first, nodes, depth: deepest }
}

/// Joins the subtrees below the nodes at which large ranges were cut; says how deep the tree is.
fn join(
    count: usize,
    mut cuts: Vec<Mark>,
    mut grown: Vec<Grown>,
    threads: usize,
) -> (Vec<Node>, u32) {
    cuts.sort_unstable_by_key(|cut| (cut.first, cut.count));
    grown.sort_unstable_by_key(|piece| piece.first);
    let total = cuts.len() + grown.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    let mut nodes = vec![interior(Aabb::EMPTY); total];
    let mut rest = nodes.as_mut_slice();
    // Where subtrees go is laid out first, then they are copied, which takes longer.
    let (mut copies, mut links, mut next, mut deepest) = (Vec::new(), Vec::new(), 0, 0);
    let mut pieces = grown.iter();
    let mut open = vec![Open { range: 0..count, known: (), parent: None, depth: 1 }];
    while let Some(Open { range, parent, depth, .. }) = open.pop() {
        links.extend(parent.map(|parent| (parent, next)));
        let at = cuts.binary_search_by_key(&(range.start, range.len()), |c| (c.first, c.count));
        if let Ok(at) = at {
            let (left, depth) = (range.start + cuts[at].left, depth + 1);
            if let Some(node) = rest.split_off_first_mut() {
                *node = interior(cuts[at].bounds);
            }
            open.push(Open { range: left..range.end, known: (), parent: Some(next), depth });
            open.push(Open { range: range.start..left, known: (), parent: None, depth });
            next += 1;
        } else if let Some(piece) = pieces.next() {
            // Ranges that were not cut come in order of their first triangle, and so do subtrees.
            deepest = deepest.max(depth - 1 + piece.depth);
            if let Some(place) = rest.split_off_mut(..piece.nodes.len()) {
                copies.push((piece.nodes.as_slice(), place, next));
            }
            next += piece.nodes.len();
        }
    }
    team::deal(copies, threads, |(from, to, root)| {
        for (node, place) in from.iter().zip(to) {
            let shift = if node.is_leaf() { 0 } else { root as u32 };
            *place = Node { link: node.link + shift, ..*node };
        }
    });
    for (parent, child) in links {
        link(&mut nodes, parent, child);
    }
    (nodes, deepest)
}

fn leaf(bounds: Aabb, first: usize, count: usize) -> Node {
    Node { bounds: without_negative_zero(bounds), link: first as u32, count: count as u32 }
}

fn interior(bounds: Aabb) -> Node {
    Node { bounds: without_negative_zero(bounds), link: 0, count: 0 }
}

fn link(nodes: &mut [Node], parent: usize, child: usize) {
    nodes[parent].link = child as u32;
}

/// Which zero is the lesser is up to the machine; so that trees have the same bytes, all are +0.
fn without_negative_zero(box_: Aabb) -> Aabb {
    Aabb { min: box_.min.map(|x| x + 0.0), max: box_.max.map(|x| x + 0.0) }
}
