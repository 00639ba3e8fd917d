//! The wide walk: both trees descended together, eight boxes against eight, triangles in batches.
//!
//! ```text
//! pop a pair of wide nodes --boxes::meet--> 64 bits --> interior: pairs of children, pushed
//!                                                   \-> leaves: candidates --64 at a time--> exact
//! ```
//!
//! It finds what the plain walk finds. Where two leaves meet, those triangles of each are packed
//! that may meet the other leaf, and then each of A is tested against eight of B at once. Pairs of
//! triangles whose boxes meet wait until there are enough for a batch; a *lot* is those of one pair
//! of leaves, so that whatever ends the walk early can open the pair of leaves again whose
//! candidates were not all tested.

use super::boxes::{self, Frames, LEAF_MAX, Packed, WAITING};
use super::found::{Found, Halt, Sums};
use super::{End, Question, Task};
use crate::{NodePair, section};
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use geometry::batch::{self, BATCH, Batch};
use geometry::{Directions, Supports, triangle};
use model::wide::LANES;
use model::{BodyView, WideNode};
use std::ops::ControlFlow;

/// Pairs of lanes of two wide nodes.
const LANE_PAIRS: usize = LANES * LANES;

/// Wide nodes of a leaf.
const BLOCKS: usize = LEAF_MAX / LANES;

/// The number of the first node of what a job starts with, where that is part of a wide node or
/// wide leaf.
const START: u32 = u32::MAX - BLOCKS as u32;

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
    waiting: [[u32; 2]; WAITING],
    lots: Vec<Lot>,
    packed_a: Packed,
    packed_b: Packed,
    start_a: [WideNode; BLOCKS],
    start_b: [WideNode; BLOCKS],
}

impl Scratch {
    pub(super) fn new() -> Self {
        Self {
            waiting: [[0; 2]; WAITING],
            lots: Vec::with_capacity(WAITING),
            packed_a: Packed::EMPTY,
            packed_b: Packed::EMPTY,
            start_a: [WideNode::EMPTY; BLOCKS],
            start_b: [WideNode::EMPTY; BLOCKS],
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
    frames: &'w Frames,
    stack: &'w mut Vec<NodePair>,
    room: usize,
    /// Candidates: the first `count` of these.
    waiting: &'w mut [[u32; 2]; WAITING],
    count: usize,
    lots: &'w mut Vec<Lot>,
    packed_a: &'w mut Packed,
    packed_b: &'w mut Packed,
    tree_a: Tree<'w>,
    tree_b: Tree<'w>,
    batch: Batch<'a>,
    found: &'w mut Found<'a>,
}

/// The wide nodes of one body, and the one that a job starts with.
struct Tree<'w> {
    nodes: &'w [WideNode],
    start: &'w [WideNode],
}

impl<'w> Tree<'w> {
    /// The node of this number, and those behind it.
    #[inline(always)]
    fn from(&self, number: u32) -> &'w [WideNode] {
        if number == START { self.start } else { &self.nodes[number as usize..] }
    }

    #[inline(always)]
    fn node(&self, number: u32) -> &'w WideNode {
        &self.from(number)[0]
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
    frames: &Frames,
    stack: &mut Vec<NodePair>,
    room: usize,
    budget: u64,
    scratch: &mut Scratch,
    found: &mut Found<'_>,
) -> End {
    let task = found.task;
    let Some(start) = stack.pop() else { return End::Complete };
    let Scratch { waiting, lots, packed_a, packed_b, start_a, start_b } = scratch;
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
        count: 0,
        lots,
        packed_a,
        packed_b,
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

/// Adds the contact of two triangles that intersect.
#[simd]
fn measure<S: Simd>(
    simd: S,
    batch: &Batch<'_>,
    pair: [u32; 2],
    supports: &mut Supports,
    directions: &Directions,
) {
    let [a, b] = batch.triangles(pair);
    supports.add_all(simd, directions, triangle::contact(&a, &b).points());
}

/// The number of the wide node that stands for `root` of the binary tree; where there is none,
/// `start` is made to be it: the lanes below `root` of the wide node or leaf that holds it.
fn entrance(body: &BodyView<'_>, root: u32, start: &mut [WideNode]) -> u32 {
    let at = body.wide_of[root as usize];
    let holder = &body.wide[at as usize];
    if holder.root == root {
        return at;
    }
    let bounds = body.nodes[root as usize].bounds;
    let (nodes, triangles) =
        (section::nodes_of(body.nodes, root), section::triangles(body.nodes, root));
    for (node, holder) in start.iter_mut().zip(blocks(&body.wide[at as usize..])) {
        *node = *holder;
        (node.bounds, node.root) = (bounds, root);
        for lane in (0..LANES).filter(|lane| !holder.is_empty(*lane)) {
            let below = if holder.is_leaf() {
                triangles.contains(&holder.triangle(lane))
            } else {
                nodes.contains(&body.wide[holder.child(lane) as usize].root)
            };
            if !below {
                node.clear(lane);
            }
        }
    }
    START
}

/// The nodes of the leaf that begins here; an interior node is alone.
#[inline(always)]
fn blocks(nodes: &[WideNode]) -> &[WideNode] {
    &nodes[..(nodes[0].count as usize).div_ceil(LANES).max(1)]
}

impl Walk<'_, '_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, budget: u64) -> ControlFlow<Halt, End> {
        while let Some(&pair) = self.stack.last() {
            if self.found.counters.tests() + self.count as u64 >= budget
                || self.stack.len() + LANE_PAIRS > self.room
            {
                self.settle(simd)?;
                return ControlFlow::Continue(End::OutOfBudget);
            }
            self.beat()?;
            self.stack.pop();
            let (a, b) = (self.tree_a.node(pair.a), self.tree_b.node(pair.b));
            match (a.is_leaf(), b.is_leaf()) {
                (false, false) => self.open_both(simd, a, b),
                (false, true) => self.open_a(simd, a, b, pair.b),
                (true, false) => self.open_b(simd, a, b, pair.a),
                (true, true) => self.collect(simd, pair)?,
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
            self.stack.push(NodePair { a: a.child(at / LANES), b: b.child(at % LANES) });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_a<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode, number_b: u32) {
        let mut meeting = self.frames.meet_one_of_b(simd, a, &b.bounds);
        self.count(boxes::used(simd, a), 1);
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            self.stack.push(NodePair { a: a.child(at), b: number_b });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_b<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode, number_a: u32) {
        let mut meeting = self.frames.meet_one_of_a(simd, &a.bounds, b);
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

    /// Adds the candidates of two leaves.
    #[inline(always)]
    fn collect<S: Simd>(&mut self, simd: S, pair: NodePair) -> ControlFlow<Halt> {
        let (a, b) = (blocks(self.tree_a.from(pair.a)), blocks(self.tree_b.from(pair.b)));
        self.frames.pack(simd, (a, b), (self.packed_a, self.packed_b));
        let (count_a, count_b) = (self.packed_a.triangles().len(), self.packed_b.triangles().len());
        self.found.counters.nb += u64::from(a[0].count + b[0].count) + (count_a * count_b) as u64;
        if count_a == 0 || count_b == 0 {
            return ControlFlow::Continue(());
        }
        let from = self.count;
        self.lots.push(Lot { pair, from, before: None });
        let sets = self.found.task.question == Question::Sets;
        let fresh = if sets { self.fresh() } else { u64::MAX };
        let mut row = 0;
        loop {
            let hits_a = &*self.found.hits_a;
            let only = |a| if sets && hits_a.has(a) { fresh } else { u64::MAX };
            (row, self.count) =
                self.packed_a.meet(simd, self.packed_b, row, only, self.waiting, self.count);
            if self.count < BATCH {
                break;
            }
            self.test(simd)?;
            // What was tested so far belongs to this lot, at the last.
            self.lots.drain(..self.lots.len() - 1);
            self.lots[0].from = 0;
            self.beat()?;
        }
        self.lots.pop_if(|lot| lot.from == self.count);
        if self.found.task.question == Question::Touches {
            self.settle(simd)?;
        }
        ControlFlow::Continue(())
    }

    /// Which of B's packed triangles are not known to be hit, bit j for the jth.
    fn fresh(&self) -> u64 {
        let triangles = self.packed_b.triangles().iter().enumerate();
        triangles.fold(0, |fresh, (j, &b)| fresh | u64::from(!self.found.hits_b.has(b)) << j)
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
        for start in (0..self.count).step_by(BATCH) {
            let end = self.count.min(start + BATCH);
            let mut hits = intersecting(simd, &self.batch, &self.waiting[start..end]);
            self.found.counters.np += (end - start) as u64;
            while hits != 0 {
                let at = start + hits.trailing_zeros() as usize;
                while self.lots.get(lot + 1).is_some_and(|next| next.from <= at) {
                    lot += 1;
                }
                let before = *self.lots[lot].before.get_or_insert(self.found.sums);
                let (batch, pair) = (&self.batch, self.waiting[at]);
                let taken = self.found.take(pair, |supports, directions| {
                    measure(simd, batch, pair, supports, directions);
                });
                if let ControlFlow::Break(halt) = taken {
                    if halt == Halt::Stopped {
                        self.found.sums = before;
                        self.reopen(lot);
                    }
                    return ControlFlow::Break(halt);
                }
                hits &= hits - 1;
            }
        }
        self.count = 0;
        ControlFlow::Continue(())
    }

    #[inline(always)]
    fn beat(&mut self) -> ControlFlow<Halt> {
        let beaten = self.found.beat();
        if beaten.is_break() {
            // The first lot may have been tested in part, the others were not.
            let before = self.lots.first().and_then(|lot| lot.before);
            self.found.sums = before.unwrap_or(self.found.sums);
            self.reopen(0);
        }
        beaten
    }

    /// Puts the pairs of leaves from this lot on back on the stack: the walk ends.
    #[cold]
    fn reopen(&mut self, lot: usize) {
        for lot in self.lots.drain(..).skip(lot) {
            self.stack.push(lot.pair);
        }
        self.count = 0;
    }
}
