//! The wide walk: both trees descended together, eight boxes against eight, and eight pairs of
//! triangles at once.
//!
//! ```text
//! pop a pair of wide nodes --boxes::meet--> 64 bits --> interior: pairs of children, pushed
//!                                                   \-> leaves: patches --eight pairs--> exact
//! ```
//!
//! It finds what the plain walk finds. Where two leaves meet, those triangles of each that may meet
//! the other leaf are stored side by side in a frame close to both ([`geometry::patch`]); their
//! pairs with overlapping boxes are collected, and tested eight at once.

use super::boxes::{self, Frames, LEAF_MAX};
use super::found::{Found, Halt};
use super::{End, Question, Task};
use crate::{NodePair, section};
use body::wide::{LANES, LEAF_LANES};
use body::{BodyView, WideLeaf, WideNode};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use geometry::patch::{Close, LANES as EIGHT, Pairs, Places};
use geometry::simd::prefetch;
use geometry::{Aabb, Directions, Patch, Posed, Supports, triangle};
use std::ops::ControlFlow;

/// Pairs of lanes of two wide nodes.
pub(super) const LANE_PAIRS: usize = LANES * LANES;

/// Wide nodes of a leaf.
pub(super) const BLOCKS: usize = LEAF_MAX.div_ceil(LEAF_LANES);

/// The number of the first node where a job starts inside a wide node or wide leaf.
pub(super) const START: u32 = u32::MAX - BLOCKS as u32;

/// Maximum number of stack entries for trees with this many levels together.
///
/// A step pops one pair and pushes at most 64, one level deeper in at least one tree. A wide tree
/// is no deeper than the binary one; where that is thousands of levels deep, the wide one is much
/// shallower, so the capacity is limited, and a job that exceeds it ends early.
pub(super) fn stack_room(levels: usize) -> usize {
    const ROOM_MAX: usize = 1 << 18;
    ((LANE_PAIRS - 1) * levels + 1 + LANE_PAIRS).min(ROOM_MAX)
}

/// Scratch of the wide walk, allocated once.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    patch_a: Patch,
    patch_b: Patch,
    pairs: Pairs,
    start_a: [WideNode; BLOCKS],
    start_b: [WideNode; BLOCKS],
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self {
            patch_a: Patch::default(),
            patch_b: Patch::default(),
            pairs: Pairs::default(),
            start_a: [WideNode::EMPTY; BLOCKS],
            start_b: [WideNode::EMPTY; BLOCKS],
        }
    }
}

/// One walk. Pairs on its stack are of wide nodes, except at the start and end: there of binary
/// ones.
struct Walk<'w, 'a> {
    frames: &'w Frames,
    stack: &'w mut Vec<NodePair>,
    room: usize,
    patch_a: &'w mut Patch,
    patch_b: &'w mut Patch,
    pairs: &'w mut Pairs,
    tree_a: Tree<'w>,
    tree_b: Tree<'w>,
    posed: Posed<'a>,
    found: &'w mut Found<'a>,
}

/// The wide nodes of one body, and the one where a job starts.
#[derive(Clone, Copy)]
pub(super) struct Tree<'w> {
    pub(super) nodes: &'w [WideNode],
    pub(super) start: &'w [WideNode],
}

impl<'w> Tree<'w> {
    /// The node with this number, and those after it.
    #[inline(always)]
    pub(super) fn from(&self, number: u32) -> &'w [WideNode] {
        if number == START { self.start } else { &self.nodes[number as usize..] }
    }

    #[inline(always)]
    pub(super) fn node(&self, number: u32) -> &'w WideNode {
        &self.from(number)[0]
    }

    /// Prefetches a node.
    #[inline(always)]
    pub(super) fn prefetch<S: Simd>(&self, simd: S, number: u32) {
        prefetch(simd, self.nodes, number as usize);
    }
}

/// The frames for the wide walk, if it is possible under this pose.
pub(super) fn frames(task: &Task<'_>) -> Option<Frames> {
    let trees = !task.a.wide.is_empty() && !task.b.wide.is_empty();
    trees.then(|| Frames::of(&task.a, &task.b, &task.pose)).flatten()
}

/// Walks everything below the one pair on the stack; what is not done at the end is left there.
#[simd]
pub(super) fn walk<S: Simd>(
    simd: S,
    frames: &Frames,
    stack: &mut Vec<NodePair>,
    room: usize,
    budget: u64,
    scratch: &mut Scratch,
    found: &mut Found<'_>,
) -> End {
    let task = found.task;
    let Some(start) = stack.pop() else { return End::Complete };
    let Scratch { patch_a, patch_b, pairs, start_a, start_b } = scratch;
    stack.push(NodePair {
        a: entrance(&task.a, start.a, start_a),
        b: entrance(&task.b, start.b, start_b),
    });
    let mut walk = Walk {
        frames,
        stack,
        room,
        patch_a,
        patch_b,
        pairs,
        tree_a: Tree { nodes: task.a.wide, start: start_a },
        tree_b: Tree { nodes: task.b.wide, start: start_b },
        posed: Posed::new(&task.pose, task.a.corners, task.b.corners),
        found,
    };
    let end = match walk.run(simd, budget) {
        ControlFlow::Continue(end) => end,
        ControlFlow::Break(Halt::Answered) => {
            walk.stack.clear();
            End::Complete
        }
        ControlFlow::Break(Halt::Stopped) => End::Stopped,
    };
    for pair in walk.stack.iter_mut() {
        let (a, b) = (walk.tree_a.node(pair.a).root, walk.tree_b.node(pair.b).root);
        *pair = NodePair { a, b };
    }
    end
}

/// Adds the contact of two triangles that intersect.
#[simd]
fn measure<S: Simd>(
    simd: S,
    posed: &Posed<'_>,
    pair: [u32; 2],
    supports: &mut Supports,
    directions: &Directions,
) {
    let [a, b] = posed.triangles(pair);
    supports.add_all(simd, directions, triangle::contact(&a, &b).points());
}

/// The number of the wide node that corresponds to `root` of the binary tree; if there is none,
/// `start` is built for it: the lanes below `root` of the wide node or leaf that contains it.
pub(super) fn entrance(body: &BodyView<'_>, root: u32, start: &mut [WideNode]) -> u32 {
    let at = body.wide_of[root as usize];
    let holder = &body.wide[at as usize];
    if holder.root == root {
        return at;
    }
    let (nodes, triangles) =
        (section::nodes_of(body.nodes, root), section::triangles(body.nodes, root));
    if holder.leaf().is_some() {
        let count = leaf(&body.wide[at as usize..]).len();
        start[..count].copy_from_slice(&body.wide[at as usize..][..count]);
        for leaf in start[..count].iter_mut().filter_map(WideNode::leaf_mut) {
            leaf.root = root;
            let first = leaf.first;
            let here = |lane: &usize| triangles.contains(&(first + *lane as u32));
            (0..LEAF_LANES).filter(|lane| !here(lane)).for_each(|lane| leaf.clear(lane));
        }
        return START;
    }
    let node = &mut start[0];
    *node = *holder;
    (node.bounds, node.root) = (body.nodes[root as usize].bounds, root);
    for lane in (0..LANES).filter(|lane| !holder.is_empty(*lane)) {
        if !nodes.contains(&body.wide[holder.child(lane) as usize].root) {
            node.clear(lane);
        }
    }
    START
}

/// The leaf that begins here: one or several nodes.
#[inline(always)]
pub(super) fn leaf(nodes: &[WideNode]) -> &[WideLeaf] {
    WideLeaf::all(&nodes[..nodes[0].run() as usize])
}

impl Walk<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, budget: u64) -> ControlFlow<Halt, End> {
        while let Some(&pair) = self.stack.last() {
            if self.found.spent() >= budget || self.stack.len() + LANE_PAIRS > self.room {
                return ControlFlow::Continue(End::OutOfBudget);
            }
            self.found.beat()?;
            self.stack.pop();
            // The next pair on the stack, unless this one pushes something above it.
            if let Some(next) = self.stack.last() {
                self.tree_a.prefetch(simd, next.a);
                self.tree_b.prefetch(simd, next.b);
            }
            let (a, b) = (self.tree_a.node(pair.a), self.tree_b.node(pair.b));
            match (a.leaf(), b.leaf()) {
                (None, None) => self.open_both(simd, a, b),
                (None, Some(leaf)) => self.open_a(simd, a, &leaf.bounds, pair.b),
                (Some(leaf), None) => self.open_b(simd, &leaf.bounds, b, pair.a),
                (Some(_), Some(_)) => self.collect(simd, pair)?,
            }
        }
        ControlFlow::Continue(End::Complete)
    }

    #[inline(always)]
    fn open_both<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode) {
        let mut meeting = self.frames.meet(simd, a, b);
        self.count(boxes::used(simd, a), boxes::used(simd, b));
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize;
            self.stack.push(NodePair { a: a.child(at / LANES), b: b.child(at % LANES) });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_a<S: Simd>(&mut self, simd: S, a: &WideNode, b: &Aabb, number_b: u32) {
        let mut meeting = self.frames.meet_one_of_b(simd, a, b);
        self.count(boxes::used(simd, a), 1);
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            self.stack.push(NodePair { a: a.child(at), b: number_b });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_b<S: Simd>(&mut self, simd: S, a: &Aabb, b: &WideNode, number_a: u32) {
        let mut meeting = self.frames.meet_one_of_a(simd, a, b);
        self.count(1, boxes::used(simd, b));
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            self.stack.push(NodePair { a: number_a, b: b.child(at) });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn count(&mut self, lanes_a: u64, lanes_b: u64) {
        self.found.counters.nb += u64::from(lanes_a.count_ones() * lanes_b.count_ones());
    }

    /// Tests the triangles of two leaves. If the sink stops, the pair is open again.
    #[inline(always)]
    fn collect<S: Simd>(&mut self, simd: S, pair: NodePair) -> ControlFlow<Halt> {
        let (a, b) = (leaf(self.tree_a.from(pair.a)), leaf(self.tree_b.from(pair.b)));
        let first = [a[0].first, b[0].first];
        if self.found.is_beaten(first[0], a[0].count) {
            return ControlFlow::Continue(());
        }
        let known = self.known(first);
        let patches = (&mut *self.patch_a, &mut *self.patch_b);
        self.found.counters.nb += u64::from(a[0].count + b[0].count);
        let Some(close) = self.frames.pack(simd, &self.posed, (a, b), known.as_ref(), patches)
        else {
            return ControlFlow::Continue(());
        };
        self.found.await_hits(simd, [self.patch_a.triangles(), self.patch_b.triangles()]);
        let before = self.found.sums;
        let tested = self.test(simd, &close, first);
        if let ControlFlow::Break(Halt::Stopped) = tested {
            self.found.sums = before;
            self.stack.push(pair);
        }
        tested
    }

    /// Tests every triangle of one patch against every one of the other, from number `first` on.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, close: &Close, first: [u32; 2]) -> ControlFlow<Halt> {
        let (a, b) = (&*self.patch_a, &*self.patch_b);
        self.found.counters.nb += (a.triangles().len() * b.triangles().len()) as u64;
        for at in (0..b.triangles().len()).step_by(EIGHT) {
            self.pairs.take(simd, a, (b, at));
            if self.pairs.is_full() || at + EIGHT >= b.triangles().len() {
                self.found.counters.np += self.pairs.len() as u64;
                self.pairs.sift(simd, &self.posed, close);
                let posed = &self.posed;
                self.found.take(self.pairs.drain(), first, |pair, supports, directions| {
                    measure(simd, posed, pair, supports, directions);
                })?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Which triangles of two leaves need not be tested against each other: those known to be hit,
    /// if only sets are computed. Counted from the leaves' first.
    #[inline(always)]
    fn known(&self, first: [u32; 2]) -> Option<[Places; 2]> {
        let (a, b) = (&self.found.hits_a, &self.found.hits_b);
        let is_asked = self.found.task.question == Question::Sets;
        is_asked.then(|| [a.places(first[0]), b.places(first[1])])
    }
}
