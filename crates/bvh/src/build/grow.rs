//! Growing a tree: ranges of triangles are cut until they fit a leaf, nodes laid out in preorder.
//!
//! The largest ranges are cut by all threads together, the next ones by one thread each; of their
//! halves it goes on with one, and leaves the other to whoever is free. Small ranges are grown to
//! whole subtrees by one thread; how small, depends on how many wait. The subtrees are then joined
//! in order of their first triangle. Where a range is cut depends on its triangles alone, so the
//! result is the same for any number of threads.

use super::Hierarchy;
use super::thread_pool::BuildPool;
use body::Node;
use bytemuck::zeroed_vec;
use geometry::Aabb;
use rayon::Scope;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Triangles that can be cut in two, again and again. What a build is, beside its rule.
pub(super) trait Parts: Sized + Send {
    /// What a cut finds out about each half, for the next cut to build on.
    type Known: Send;

    /// How many triangles.
    fn len(&self) -> usize;

    /// Reorders the triangles of `range`, at least two, so that the left half comes first; all of
    /// `pool` may help.
    fn cut(
        &mut self,
        range: Range<usize>,
        known: Self::Known,
        pool: &BuildPool,
    ) -> Cut<Self::Known>;

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
    /// Who builds.
    pub(super) pool: &'a BuildPool,
    /// Hears of what was placed.
    pub(super) progress: Progress<'a>,
}

/// Says how many triangles were placed, each time that there are enough.
pub(super) struct Progress<'a> {
    say: &'a (dyn Fn(u64) + Sync),
    unsaid: AtomicU64,
}

/// Fewer triangles are not worth starting another thread.
const THREAD_MIN: usize = 4096;
/// A range of fewer triangles is not worth cutting by all threads together. With this and
/// `GRAIN_MIN` at 4096, two threads took a tenth longer for 10,000 triangles.
const LARGE_MIN: usize = 8192;
/// Pieces per thread while enough of them wait.
const PIECES: usize = 8;
/// No smaller ones then.
const GRAIN_MIN: usize = 1024;
/// How many times finer they are cut while fewer wait than there are threads, so that the last ones
/// end together: of two threads, one had nothing to do for a tenth of the time at the end of a tree
/// of 10,000 triangles, and so for a hundredth.
const FINER: usize = 8;
/// Subtrees below this size are not worth handing to another thread.
const FINE_MIN: usize = 256;
/// A range is cut by all threads if it holds more than 1/SHARE of what would be one thread's.
const SHARE: usize = 2;
/// How many triangles are placed before that is said.
const STRIDE: u64 = 8192;

/// Those of `threads` that are worth their start for `count` triangles: at least 1.
#[must_use]
pub fn worth_starting(threads: usize, count: usize) -> usize {
    threads.clamp(1, count / THREAD_MIN + 1)
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

/// A tree in parts.
#[derive(Default)]
struct Made {
    /// The ranges above the subtrees.
    cuts: Vec<Mark>,
    grown: Vec<Grown>,
}

/// A tree that is still to be joined: only then are there nodes in preorder. Before, what was cut
/// to grow it can be freed, and the nodes have its memory.
pub(super) struct Forest {
    order: Vec<u32>,
    made: Made,
}

/// A tree that several threads grow.
struct ParallelBuild<'j> {
    job: &'j Job<'j>,
    /// Larger ranges are cut by all threads together.
    large: usize,
    /// Larger ranges are cut, the others grown, while enough pieces wait.
    grain: usize,
    /// The same while they do not.
    fine: usize,
    /// Pieces that wait for a thread.
    waiting: AtomicUsize,
    made: Mutex<Made>,
}

/// Room for the order of so many triangles, to be asked for before all that is cut: it stays when
/// that is freed, and between its parts it would keep them from becoming one piece of memory.
pub(super) fn order(count: usize) -> Vec<u32> {
    vec![0; count]
}

/// Grows the tree over `parts`.
pub(super) fn grow<P: Parts>(
    parts: P,
    known: P::Known,
    mut order: Vec<u32>,
    job: &Job<'_>,
) -> Forest {
    let count = parts.len();
    let whole = Piece { first: 0, parts, known, order: &mut order };
    let made = if job.pool.is_alone() {
        Made { cuts: Vec::new(), grown: vec![subtree(whole, job)] }
    } else {
        let threads = job.pool.threads();
        let grain = (count / (threads * PIECES)).max(GRAIN_MIN);
        let build = ParallelBuild {
            job,
            large: (count / (threads * SHARE)).max(LARGE_MIN),
            grain,
            fine: (grain / FINER).max(FINE_MIN),
            waiting: AtomicUsize::new(0),
            made: Mutex::default(),
        };
        rayon::scope(|scope| build.work(scope, whole));
        build.made.into_inner().unwrap_or_else(PoisonError::into_inner)
    };
    job.progress.say();
    Forest { order, made }
}

impl Forest {
    /// Nodes in preorder, the order of triangles, the depth.
    pub(super) fn joined(self, pool: &BuildPool) -> Hierarchy {
        let Self { order, made: Made { cuts, mut grown } } = self;
        let (nodes, depth) = match grown.pop_if(|_| cuts.is_empty()) {
            Some(whole) => (whole.nodes, whole.depth),
            None => join(order.len(), cuts, grown, pool),
        };
        Hierarchy { nodes, order, depth }
    }
}

impl<'a> Progress<'a> {
    /// `say` is told of triangles placed since it was last called, by whichever thread.
    pub(super) fn new(say: &'a (dyn Fn(u64) + Sync)) -> Self {
        Self { say, unsaid: AtomicU64::new(0) }
    }

    /// So many more were placed.
    fn add(&self, placed: u64) {
        if self.unsaid.fetch_add(placed, Ordering::Relaxed) + placed >= STRIDE {
            self.say();
        }
    }

    /// Says what was not said yet.
    fn say(&self) {
        let placed = self.unsaid.swap(0, Ordering::Relaxed);
        if placed > 0 {
            (self.say)(placed);
        }
    }
}

impl ParallelBuild<'_> {
    /// Pieces of more triangles than this are cut now, the others grown.
    fn grain(&self) -> usize {
        let enough = self.waiting.load(Ordering::Relaxed) >= self.job.pool.threads();
        if enough { self.grain } else { self.fine }
    }

    fn made(&self) -> MutexGuard<'_, Made> {
        self.made.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work<'s, P: Parts + 's>(&'s self, scope: &Scope<'s>, mut piece: Piece<'s, P>) {
        while piece.parts.len() > self.grain() {
            // Who waits for others to cut their part may begin another piece meanwhile, on the same
            // stack: that goes no deeper than there are large pieces side by side, which are few.
            let is_large = piece.parts.len() > self.large;
            let pool = if is_large { self.job.pool } else { &BuildPool::ALONE };
            let (mark, [far, near]) = halved(piece, pool);
            self.made().cuts.push(mark);
            self.waiting.fetch_add(1, Ordering::Relaxed);
            scope.spawn(|scope| {
                self.waiting.fetch_sub(1, Ordering::Relaxed);
                self.work(scope, far);
            });
            piece = near;
        }
        let grown = subtree(piece, self.job);
        self.made().grown.push(grown);
    }
}

fn halved<'a, P: Parts>(piece: Piece<'a, P>, pool: &BuildPool) -> (Mark, [Piece<'a, P>; 2]) {
    let Piece { first, mut parts, known, order } = piece;
    let count = parts.len();
    let Cut { bounds, left, known: [known_left, known_right] } = parts.cut(0..count, known, pool);
    let (near, far) = parts.split_at(left);
    let (order_left, order_right) = order.split_at_mut(left);
    let halves = [
        Piece { first: first + left, parts: far, known: known_right, order: order_right },
        Piece { first, parts: near, known: known_left, order: order_left },
    ];
    (Mark { first, count, left, bounds }, halves)
}

/// A range still to do.
struct Open<K> {
    range: Range<usize>,
    known: K,
    /// The node whose right child it is, if it is one.
    parent: Option<usize>,
    depth: u32,
}

/// Room for the nodes over so many triangles: enough where leaves are two thirds full, as those of
/// cars are. Nodes that outgrow it are copied to new memory.
fn capacity(count: usize, leaf_size: usize) -> usize {
    (3 * count.div_ceil(leaf_size)).min(2 * count)
}

/// All nodes over one piece, in preorder.
fn subtree<P: Parts>(piece: Piece<'_, P>, job: &Job<'_>) -> Grown {
    let Piece { first, mut parts, known, order } = piece;
    let count = parts.len();
    let mut nodes = Vec::with_capacity(capacity(count, job.leaf_size));
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
                job.progress.add(std::mem::take(&mut placed));
            }
        } else {
            let Cut { bounds, left, known: [near, far] } =
                parts.cut(range.clone(), known, &BuildPool::ALONE);
            let (left, depth) = (range.start + left, depth + 1);
            nodes.push(interior(bounds));
            open.push(Open { range: left..range.end, known: far, parent: Some(node), depth });
            open.push(Open { range: range.start..left, known: near, parent: None, depth });
        }
    }
    job.progress.add(placed);
    Grown { first, nodes, depth: deepest }
}

/// Joins the subtrees below the nodes at which large ranges were cut; says how deep the tree is.
fn join(
    count: usize,
    mut cuts: Vec<Mark>,
    mut grown: Vec<Grown>,
    pool: &BuildPool,
) -> (Vec<Node>, u32) {
    cuts.sort_unstable_by_key(|cut| (cut.first, cut.count));
    grown.sort_unstable_by_key(|piece| piece.first);
    let total = cuts.len() + grown.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    // New pages stay untouched until whoever copies a subtree comes to its place.
    let mut nodes: Vec<Node> = zeroed_vec(total);
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
    pool.each(copies, |(from, to, root)| {
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
