//! The wide walk: both trees descended together, eight boxes against eight, triangles in batches.
//!
//! ```text
//! pop a pair of wide nodes --boxes::meet--> 64 bits --> interior: pairs of children, pushed
//!                                                   \-> leaves: candidates --64 at a time--> exact
//! ```
//!
//! It finds what the plain walk finds. Pairs of triangles whose boxes meet wait until there are
//! enough for a batch; a *lot* is those of one pair of leaves, so that whatever ends the walk early
//! can open the pair of leaves again whose candidates were not all tested.

use super::boxes::{self, Frames};
use super::found::{Found, Halt, Sums};
use super::{End, Question, Task};
use crate::{NodePair, section};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use geometry::batch::{self, BATCH, Batch};
use model::wide::LANES;
use model::{BodyView, WideNode};
use std::ops::ControlFlow;

/// Pairs of lanes of two wide nodes.
const LANE_PAIRS: usize = LANES * LANES;

/// Candidates that wait at most: a pair of leaves may add all its lanes to what is no batch yet.
const WAITING: usize = BATCH + LANE_PAIRS;

/// The number of the node that a job starts with, where it is a part of a wide node.
const START: u32 = u32::MAX;

/// Most entries of a stack for trees with so many levels together.
///
/// A step pops one pair and pushes at most 64, one level deeper in at least one tree. A wide tree
/// is no deeper than the binary one; where that is thousands deep, the wide one is far from it, so
/// the room has a limit, and a job that should ever exceed it ends early.
pub(super) fn stack_room(levels: usize) -> usize {
    const ROOM_MAX: usize = 1 << 18;
    ((LANE_PAIRS - 1) * levels + 1 + LANE_PAIRS).min(ROOM_MAX)
}

/// Scratch of the wide walk, allocated once.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    waiting: Vec<[u32; 2]>,
    lots: Vec<Lot>,
    start_a: WideNode,
    start_b: WideNode,
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self {
            waiting: Vec::with_capacity(WAITING),
            lots: Vec::with_capacity(WAITING),
            start_a: WideNode::EMPTY,
            start_b: WideNode::EMPTY,
        }
    }
}

/// The candidates of one pair of leaves.
#[derive(Clone, Copy, Debug)]
struct Lot {
    pair: NodePair,
    /// Its first candidate among those that wait.
    from: usize,
    /// The sums before its first hit.
    before: Option<Sums>,
}

/// One walk. Pairs on its stack are of wide nodes, but when it begins and ends, of binary ones.
struct Walk<'w, 'a> {
    frames: Frames,
    stack: &'w mut Vec<NodePair>,
    room: usize,
    waiting: &'w mut Vec<[u32; 2]>,
    lots: &'w mut Vec<Lot>,
    tree_a: Tree<'w>,
    tree_b: Tree<'w>,
    batch: Batch<'a>,
    found: &'w mut Found<'a>,
}

/// The wide nodes of one body, and the one that a job starts with.
struct Tree<'w> {
    nodes: &'w [WideNode],
    start: &'w WideNode,
}

impl<'w> Tree<'w> {
    #[inline(always)]
    fn node(&self, number: u32) -> &'w WideNode {
        if number == START { self.start } else { &self.nodes[number as usize] }
    }
}

/// Whether the bodies can be walked so under this pose.
pub(super) fn frames(task: &Task<'_>) -> Option<Frames> {
    let trees = !task.a.wide.is_empty() && !task.b.wide.is_empty();
    trees.then(|| Frames::of(&task.a, &task.b, &task.pose)).flatten()
}

/// Walks everything below the one pair on the stack; what is not done when it ends lies there.
#[simd]
pub(super) fn walk<S: Simd>(
    simd: S,
    frames: Frames,
    stack: &mut Vec<NodePair>,
    room: usize,
    budget: u64,
    scratch: &mut Scratch,
    found: &mut Found<'_>,
) -> End {
    let task = found.task;
    let Some(start) = stack.pop() else { return End::Complete };
    let Scratch { waiting, lots, start_a, start_b } = scratch;
    waiting.clear();
    lots.clear();
    stack.push(NodePair {
        a: entrance(&task.a, start.a, start_a),
        b: entrance(&task.b, start.b, start_b),
    });
    let mut walk = Walk {
        frames,
        stack,
        room,
        waiting,
        lots,
        tree_a: Tree { nodes: task.a.wide, start: start_a },
        tree_b: Tree { nodes: task.b.wide, start: start_b },
        batch: Batch::new(&task.pose, task.a.corners, task.b.corners),
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

/// [`batch::intersecting`] as a function of its own: it is large, and called from several places.
#[simd]
fn intersecting<S: Simd>(simd: S, batch: &Batch<'_>, pairs: &[[u32; 2]]) -> u64 {
    batch::intersecting(simd, batch, pairs)
}

/// The number of the wide node that stands for `root` of the binary tree; where there is none,
/// `start` is made to be it: the lanes below `root` of the wide node that holds it.
fn entrance(body: &BodyView<'_>, root: u32, start: &mut WideNode) -> u32 {
    let at = body.wide_of[root as usize];
    let holder = &body.wide[at as usize];
    if holder.root == root {
        return at;
    }
    *start = WideNode { bounds: body.nodes[root as usize].bounds, root, ..*holder };
    let (nodes, triangles) =
        (section::nodes_of(body.nodes, root), section::triangles(body.nodes, root));
    for lane in (0..LANES).filter(|lane| !holder.is_empty(*lane)) {
        let link = holder.link[lane];
        let below = if holder.is_leaf() {
            triangles.contains(&link)
        } else {
            nodes.contains(&body.wide[link as usize].root)
        };
        if !below {
            start.clear(lane);
        }
    }
    START
}

impl Walk<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, budget: u64) -> ControlFlow<Halt, End> {
        while let Some(&pair) = self.stack.last() {
            if self.found.counters.tests() + self.waiting.len() as u64 >= budget
                || self.stack.len() + LANE_PAIRS > self.room
            {
                self.settle(simd)?;
                return ControlFlow::Continue(End::OutOfBudget);
            }
            if let ControlFlow::Break(halt) = self.found.beat() {
                self.reopen(0);
                return ControlFlow::Break(halt);
            }
            self.stack.pop();
            let (a, b) = (self.tree_a.node(pair.a), self.tree_b.node(pair.b));
            match (a.is_leaf(), b.is_leaf()) {
                (false, false) => self.open_both(simd, a, b),
                (false, true) => self.open_a(simd, a, b, pair.b),
                (true, false) => self.open_b(simd, a, b, pair.a),
                (true, true) => self.collect(simd, a, b, pair)?,
            }
        }
        self.settle(simd)?;
        ControlFlow::Continue(End::Complete)
    }

    #[inline(always)]
    fn open_both<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode) {
        let mut meeting = self.frames.meet(simd, a, b);
        self.count(boxes::used(simd, a), boxes::used(simd, b));
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize;
            self.stack.push(NodePair { a: a.link[at / LANES], b: b.link[at % LANES] });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_a<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode, number_b: u32) {
        let mut meeting = self.frames.meet_one_of_b(simd, a, &b.bounds);
        self.count(boxes::used(simd, a), 1);
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            self.stack.push(NodePair { a: a.link[at], b: number_b });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_b<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode, number_a: u32) {
        let mut meeting = self.frames.meet_one_of_a(simd, &a.bounds, b);
        self.count(1, boxes::used(simd, b));
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            self.stack.push(NodePair { a: number_a, b: b.link[at] });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn count(&mut self, lanes_a: u64, lanes_b: u64) {
        self.found.counters.nb += u64::from(lanes_a.count_ones() * lanes_b.count_ones());
    }

    /// Adds the candidates of two leaves.
    #[inline(always)]
    fn collect<S: Simd>(
        &mut self,
        simd: S,
        a: &WideNode,
        b: &WideNode,
        pair: NodePair,
    ) -> ControlFlow<Halt> {
        let from = self.waiting.len();
        self.lots.push(Lot { pair, from, before: None });
        self.collect_lanes(simd, a, b);
        if a.count.max(b.count) as usize > LANES {
            self.collect_blocks(simd, a, b, pair)?;
        }
        if self.waiting.len() == from {
            self.lots.pop();
        } else if self.waiting.len() >= BATCH || self.found.task.question == Question::Touches {
            self.settle(simd)?;
        }
        ControlFlow::Continue(())
    }

    /// Adds the candidates of two leaves of several nodes each, but for those of the first two.
    #[inline(never)]
    fn collect_blocks<S: Simd>(
        &mut self,
        simd: S,
        a: &WideNode,
        b: &WideNode,
        pair: NodePair,
    ) -> ControlFlow<Halt> {
        let blocks = |node: &WideNode| node.count.div_ceil(LANES as u32);
        for (i, j) in (0..blocks(a)).flat_map(|i| (0..blocks(b)).map(move |j| (i, j))).skip(1) {
            if let ControlFlow::Break(halt) = self.found.beat() {
                // Only this lot can have been tested in part.
                self.found.sums = self.lots[0].before.unwrap_or(self.found.sums);
                self.reopen(0);
                return ControlFlow::Break(halt);
            }
            if self.waiting.len() > WAITING - LANE_PAIRS {
                self.test(simd)?;
                // What was tested so far belongs to this lot, at the last.
                self.lots.drain(..self.lots.len() - 1);
                self.lots[0].from = 0;
            }
            let a = if i == 0 { a } else { &self.tree_a.nodes[(pair.a + i) as usize] };
            let b = if j == 0 { b } else { &self.tree_b.nodes[(pair.b + j) as usize] };
            self.collect_lanes(simd, a, b);
        }
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn collect_lanes<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode) {
        let mut meeting = self.frames.meet(simd, a, b);
        self.count(boxes::used(simd, a), boxes::used(simd, b));
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize;
            let (a, b) = (a.link[at / LANES], b.link[at % LANES]);
            if !self.found.known(a, b) {
                self.waiting.push([a, b]);
            }
            meeting &= meeting - 1;
        }
    }

    /// Tests all that wait; then no lot is open.
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S) -> ControlFlow<Halt> {
        self.test(simd)?;
        self.lots.clear();
        ControlFlow::Continue(())
    }

    /// Tests all that wait.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S) -> ControlFlow<Halt> {
        let mut lot = 0;
        for start in (0..self.waiting.len()).step_by(BATCH) {
            let end = self.waiting.len().min(start + BATCH);
            let mut hits = intersecting(simd, &self.batch, &self.waiting[start..end]);
            self.found.counters.np += (end - start) as u64;
            while hits != 0 {
                let at = start + hits.trailing_zeros() as usize;
                while self.lots.get(lot + 1).is_some_and(|next| next.from <= at) {
                    lot += 1;
                }
                let before = *self.lots[lot].before.get_or_insert(self.found.sums);
                let (batch, pair) = (&self.batch, self.waiting[at]);
                if let ControlFlow::Break(halt) = self.found.take(pair, || batch.triangles(pair)) {
                    if halt == Halt::Stopped {
                        self.found.sums = before;
                        self.reopen(lot);
                    }
                    return ControlFlow::Break(halt);
                }
                hits &= hits - 1;
            }
        }
        self.waiting.clear();
        ControlFlow::Continue(())
    }

    /// Puts the pairs of leaves from this lot on back on the stack: the walk ends.
    #[cold]
    fn reopen(&mut self, lot: usize) {
        for lot in self.lots.drain(..).skip(lot) {
            self.stack.push(lot.pair);
        }
        self.waiting.clear();
    }
}
