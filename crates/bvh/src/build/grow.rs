//! Growing a tree: ranges of triangles are cut until they fit a leaf, nodes laid out in preorder.
//!
//! Large ranges are cut one by one, by whichever thread is free, and their halves put on a pile;
//! small ones are grown to whole subtrees by one thread. The subtrees are then joined in order of
//! their first triangle. Where a range is cut depends on its triangles alone, so the result is the
//! same for any number of threads.

use geometry::Aabb;
use model::Node;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Triangles that can be cut in two, again and again. What a build is, beside its rule.
pub(super) trait Parts: Sized + Send {
    /// How many triangles.
    fn len(&self) -> usize;

    /// Reorders the triangles of `range`, at least two, so that its first k are the left half;
    /// returns k, which leaves neither half empty.
    fn cut(&mut self, range: Range<usize>) -> usize;

    /// Everything before `at`, and everything from there on.
    fn split_at(self, at: usize) -> (Self, Self);

    /// Brings the triangles of a leaf, `range`, in ascending order.
    fn settle(&mut self, range: Range<usize>);
}

/// What every build is told.
pub(super) struct Job<'a> {
    /// Most triangles in a leaf.
    pub(super) leaf_size: usize,
    /// Threads; 0 is 1.
    pub(super) threads: usize,
    /// Hears of triangles placed since it was last called.
    pub(super) progress: &'a (dyn Fn(u64) + Sync),
}

/// Subtrees below this size are not worth handing to another thread.
const GRAIN_MIN: usize = 4096;
/// Pieces per thread: enough that uneven ones even out.
const PIECES: usize = 8;
/// How many triangles are placed between two calls of `progress`.
const STRIDE: u64 = 8192;

const NO_BOX: Node = Node { bounds: Aabb::EMPTY, link: 0, count: 0 };

/// A range that waits for a thread. `first` is the number of its first triangle in leaf order.
struct Piece<P> {
    first: usize,
    parts: P,
}

/// A subtree; links to nodes count from its own root.
struct Grown {
    first: usize,
    nodes: Vec<Node>,
}

/// A range of `count` triangles from `first` was cut behind `left` of them.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cut {
    first: usize,
    count: usize,
    left: usize,
}

struct Pile<P> {
    open: Vec<Piece<P>>,
    /// Threads at work on a piece: they may still add to `open`.
    busy: usize,
    cuts: Vec<Cut>,
    grown: Vec<Grown>,
}

struct Yard<P> {
    pile: Mutex<Pile<P>>,
    changed: Condvar,
}

/// Whoever holds this is `busy`. Dropped in a panic too, so that nobody waits for a dead thread.
struct Busy<'a, P>(&'a Yard<P>);

impl<P> Yard<P> {
    fn pile(&self) -> MutexGuard<'_, Pile<P>> {
        self.pile.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A piece to work on, or `None` when all is done.
    fn take(&self) -> Option<(Piece<P>, Busy<'_, P>)> {
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

impl<P> Drop for Busy<'_, P> {
    fn drop(&mut self) {
        self.0.pile().busy -= 1;
        self.0.changed.notify_all();
    }
}

/// Grows the tree over `parts`: nodes in preorder, without boxes.
pub(super) fn grow<P: Parts>(parts: P, job: &Job<'_>) -> Vec<Node> {
    let count = parts.len();
    let threads = job.threads.clamp(1, count / GRAIN_MIN + 1);
    let grain = if threads == 1 { count } else { (count / (threads * PIECES)).max(GRAIN_MIN) };
    let yard = Yard {
        pile: Mutex::new(Pile {
            open: vec![Piece { first: 0, parts }],
            busy: 0,
            cuts: Vec::new(),
            grown: Vec::new(),
        }),
        changed: Condvar::new(),
    };
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|| work(&yard, grain, job));
        }
        work(&yard, grain, job);
    });
    let pile = yard.pile.into_inner().unwrap_or_else(PoisonError::into_inner);
    join(count, pile.cuts, pile.grown)
}

fn work<P: Parts>(yard: &Yard<P>, grain: usize, job: &Job<'_>) {
    while let Some((Piece { first, mut parts }, _busy)) = yard.take() {
        let count = parts.len();
        if count > grain {
            let left = parts.cut(0..count);
            let (near, far) = parts.split_at(left);
            let mut pile = yard.pile();
            pile.cuts.push(Cut { first, count, left });
            pile.open.push(Piece { first: first + left, parts: far });
            pile.open.push(Piece { first, parts: near });
            drop(pile);
            yard.changed.notify_all();
        } else {
            let nodes = subtree(first, &mut parts, job);
            yard.pile().grown.push(Grown { first, nodes });
        }
    }
}

/// All nodes over one piece, in preorder.
fn subtree<P: Parts>(first: usize, parts: &mut P, job: &Job<'_>) -> Vec<Node> {
    let count = parts.len();
    let mut nodes = Vec::with_capacity(2 * count.div_ceil(job.leaf_size));
    // Ranges still to do, each with the node whose right child it is.
    let mut open = vec![(0..count, None)];
    let mut placed = 0;
    while let Some((range, parent)) = open.pop() {
        let node = nodes.len();
        if let Some(parent) = parent {
            link(&mut nodes, parent, node);
        }
        if range.len() <= job.leaf_size {
            parts.settle(range.clone());
            nodes.push(leaf(first + range.start, range.len()));
            placed += range.len() as u64;
            if placed >= STRIDE {
                (job.progress)(placed);
                placed = 0;
            }
        } else {
            let left = range.start + parts.cut(range.clone());
            nodes.push(NO_BOX);
            open.push((left..range.end, Some(node)));
            open.push((range.start..left, None));
        }
    }
    if placed > 0 {
        (job.progress)(placed);
    }
    nodes
}

/// Joins the subtrees below the nodes at which large ranges were cut.
fn join(count: usize, mut cuts: Vec<Cut>, mut grown: Vec<Grown>) -> Vec<Node> {
    if let [whole] = grown.as_mut_slice() {
        return std::mem::take(&mut whole.nodes);
    }
    cuts.sort_unstable();
    grown.sort_unstable_by_key(|piece| piece.first);
    let mut nodes =
        Vec::with_capacity(cuts.len() + grown.iter().map(|p| p.nodes.len()).sum::<usize>());
    let mut pieces = grown.into_iter();
    let mut open = vec![(0..count, None)];
    while let Some((range, parent)) = open.pop() {
        let node = nodes.len();
        if let Some(parent) = parent {
            link(&mut nodes, parent, node);
        }
        let at = cuts.binary_search_by_key(&(range.start, range.len()), |c| (c.first, c.count));
        if let Ok(at) = at {
            let left = range.start + cuts[at].left;
            nodes.push(NO_BOX);
            open.push((left..range.end, Some(node)));
            open.push((range.start..left, None));
        } else {
            // Ranges that were not cut come in order of their first triangle, and so do subtrees.
            let piece = pieces.next().map_or(Vec::new(), |piece| piece.nodes);
            nodes.extend(piece.into_iter().map(|n| match n.count {
                0 => Node { link: n.link + node as u32, ..n },
                _ => n,
            }));
        }
    }
    nodes
}

fn leaf(first: usize, count: usize) -> Node {
    Node { bounds: Aabb::EMPTY, link: first as u32, count: count as u32 }
}

fn link(nodes: &mut [Node], parent: usize, child: usize) {
    nodes[parent].link = child as u32;
}
