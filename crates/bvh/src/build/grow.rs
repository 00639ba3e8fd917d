//! Growing a tree: ranges of triangles are cut until they fit a leaf; nodes are laid out in
//! preorder.
//!
//! The largest ranges are cut by all threads together, the next ones by one thread each, which
//! continues with one half and leaves the other to an idle thread. Small ranges are grown to whole
//! subtrees by one thread; the threshold depends on how many ranges wait. The subtrees are then
//! joined in order of their first triangle. Where a range is cut depends only on its triangles, so
//! the result is the same for any number of threads.

use super::Hierarchy;
use super::thread_pool::BuildPool;
use body::Node;
use bytemuck::zeroed_vec;
use geometry::Aabb;
use rayon::Scope;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Triangles that can be cut in two repeatedly: the split rule of a build.
pub(super) trait Parts: Sized + Send {
    /// What a cut learns about each half, for use by the next cut.
    type Known: Send;

    /// Number of triangles.
    fn len(&self) -> usize;

    /// Reorders the triangles of `range`, at least two, so that the left half comes first; all
    /// threads of `pool` may help.
    fn cut(
        &mut self,
        range: Range<usize>,
        known: Self::Known,
        pool: &BuildPool,
    ) -> Cut<Self::Known>;

    /// Splits into everything before `at` and everything from there on.
    fn split_at(self, at: usize) -> (Self, Self);

    /// Writes the numbers of the triangles of a leaf, `range`, in ascending order; returns their
    /// bounding box.
    fn settle(&mut self, range: Range<usize>, known: Self::Known, ids: &mut [u32]) -> Aabb;
}

/// A range cut into two halves.
pub(super) struct Cut<K> {
    /// The bounding box of both.
    pub(super) bounds: Aabb,
    /// Number of triangles in the left half; neither half is empty.
    pub(super) left: usize,
    /// What is known of the left half and of the right one.
    pub(super) known: [K; 2],
}

/// Parameters of every build.
pub(super) struct Job<'a> {
    /// Maximum number of triangles in a leaf.
    pub(super) leaf_size: usize,
    /// The thread pool.
    pub(super) pool: &'a BuildPool,
    /// Receives the progress.
    pub(super) progress: Progress<'a>,
}

/// Reports how many triangles were placed, in steps.
pub(super) struct Progress<'a> {
    say: &'a (dyn Fn(u64) + Sync),
    unsaid: AtomicU64,
}

/// With fewer triangles, another thread is not worth starting.
const THREAD_MIN: usize = 4096;
/// A range of fewer triangles is not worth cutting by all threads together. With this and
/// `GRAIN_MIN` at 4096, two threads took a tenth longer for 10,000 triangles.
const LARGE_MIN: usize = 8192;
/// Pieces per thread while enough of them wait.
const PIECES: usize = 8;
/// Minimum piece size in that case.
const GRAIN_MIN: usize = 1024;
/// How many times finer pieces are cut while fewer wait than there are threads, so that threads
/// finish together: with two threads, one was idle for a tenth of the time at the end of a tree of
/// 10,000 triangles, and with this for a hundredth.
const FINER: usize = 8;
/// Subtrees below this size are not worth handing to another thread.
const FINE_MIN: usize = 256;
/// A range is cut by all threads if it holds more than 1/SHARE of one thread's share.
const SHARE: usize = 2;
/// Triangles placed between two progress reports.
const STRIDE: u64 = 8192;

/// The number of `threads` that are worth starting for `count` triangles: at least 1.
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
    /// Where their order is written.
    order: &'a mut [u32],
}

/// A subtree; node links are relative to its own root.
struct Grown {
    first: usize,
    nodes: Vec<Node>,
    depth: u32,
}

/// A range of `count` triangles from `first` was cut after `left` of them.
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

/// A tree whose parts are not joined yet: nodes get their preorder only then. What was needed to
/// cut can be freed before, and the nodes reuse its memory.
pub(super) struct Forest {
    order: Vec<u32>,
    made: Made,
}

/// A tree that several threads grow.
struct ParallelBuild<'j> {
    job: &'j Job<'j>,
    /// Larger ranges are cut by all threads together.
    large: usize,
    /// While enough pieces wait, larger ranges are cut and the others grown.
    grain: usize,
    /// The threshold while too few pieces wait.
    fine: usize,
    /// Number of pieces that wait for a thread.
    waiting: AtomicUsize,
    made: Mutex<Made>,
}

/// Allocates the order of `count` triangles. Call it before allocating the buffers for cutting: it
/// outlives them, and in between it would keep their memory from merging into one piece.
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
    /// Returns the nodes in preorder, the order of triangles and the depth.
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
    /// `say` is called with the number of triangles placed since its last call, from any thread.
    pub(super) fn new(say: &'a (dyn Fn(u64) + Sync)) -> Self {
        Self { say, unsaid: AtomicU64::new(0) }
    }

    /// Adds `placed` triangles.
    fn add(&self, placed: u64) {
        if self.unsaid.fetch_add(placed, Ordering::Relaxed) + placed >= STRIDE {
            self.say();
        }
    }

    /// Reports what is not reported yet.
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
            // A thread that waits for others to cut their part may start another piece meanwhile,
            // on the same stack: the depth is limited by the number of large pieces, which is
            // small.
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

/// A range still to be processed.
struct Open<K> {
    range: Range<usize>,
    known: K,
    /// The node whose right child this is, if any.
    parent: Option<usize>,
    depth: u32,
}

/// Capacity for the nodes over `count` triangles: enough if leaves are two thirds full, as those of
/// cars are. Beyond that, nodes are copied to new memory.
fn capacity(count: usize, leaf_size: usize) -> usize {
    (3 * count.div_ceil(leaf_size)).min(2 * count)
}

/// Builds all nodes over one piece, in preorder.
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

/// Joins the subtrees below the nodes at which large ranges were cut; returns the depth of the
/// tree.
fn join(
    count: usize,
    mut cuts: Vec<Mark>,
    mut grown: Vec<Grown>,
    pool: &BuildPool,
) -> (Vec<Node>, u32) {
    cuts.sort_unstable_by_key(|cut| (cut.first, cut.count));
    grown.sort_unstable_by_key(|piece| piece.first);
    let total = cuts.len() + grown.iter().map(|piece| piece.nodes.len()).sum::<usize>();
    // New pages stay untouched until a subtree is copied there.
    let mut nodes: Vec<Node> = zeroed_vec(total);
    let mut rest = nodes.as_mut_slice();
    // First the destinations of subtrees are laid out, then they are copied, which takes longer.
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

/// Which of two zeros is the lesser depends on the machine; all become +0, so that trees have the
/// same bytes.
fn without_negative_zero(box_: Aabb) -> Aabb {
    Aabb { min: box_.min.map(|x| x + 0.0), max: box_.max.map(|x| x + 0.0) }
}
