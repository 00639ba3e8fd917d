//! The wide walk: eight boxes against eight, and eight pairs of triangles at once, in f32 rounded
//! outward; what these leave is decided one by one.
//!
//! Where two leaves meet, only the travels at which their boxes overlap matter, a short piece of
//! the motion. The triangles of each that may meet the other leaf meanwhile are placed in a frame
//! close to both at the begin of that piece ([`geometry::patch`]).

use super::due::Due;
use super::static_wide::{self, Tree, entrance, leaf};
use super::{End, OpenPair, Search, SweepTask};
use crate::NodePair;
use crate::kernel::boxes::{self, Passing};
use body::WideNode;
use body::wide::LANES;
use fearless_simd::Simd;
use fearless_simd_macros::simd;
use geometry::patch::{LANES as EIGHT, SweptPairs, down, up};
use geometry::{Aabb, Patch, Posed};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

/// Scratch of the wide walk, allocated once.
#[derive(Clone, Debug)]
pub(super) struct Scratch {
    patch_a: Patch,
    patch_b: Patch,
    pairs: SweptPairs,
    /// Numbers of triangles of A and of B that are not apart, and the travel from when on they may
    /// touch (m from the reference).
    left: BinaryHeap<Reverse<Due>>,
    start_a: [WideNode; static_wide::BLOCKS],
    start_b: [WideNode; static_wide::BLOCKS],
}

/// Maximum number of pairs of triangles that wait together.
const LEFT_MAX: usize = 1 << 11;

impl Scratch {
    pub(super) fn new() -> Self {
        Self {
            patch_a: Patch::default(),
            patch_b: Patch::default(),
            pairs: SweptPairs::default(),
            left: BinaryHeap::with_capacity(LEFT_MAX),
            start_a: [WideNode::EMPTY; static_wide::BLOCKS],
            start_b: [WideNode::EMPTY; static_wide::BLOCKS],
        }
    }
}

/// The frames for the wide walk, if it is possible for this task.
pub(super) fn frames(task: &SweepTask<'_>) -> Option<Passing> {
    let trees = !task.a.wide.is_empty() && !task.b.wide.is_empty();
    trees.then(|| Passing::of(&task.a, &task.b, &task.pose, &task.sweep)).flatten()
}

/// One walk. Pairs of the frontier are of wide nodes, except at the end: there of binary ones.
struct Walk<'w, 't, 's, 'a> {
    frames: &'w Passing,
    patch_a: &'w mut Patch,
    patch_b: &'w mut Patch,
    pairs: &'w mut SweptPairs,
    left: &'w mut BinaryHeap<Reverse<Due>>,
    tree_a: Tree<'t>,
    tree_b: Tree<'t>,
    search: &'w mut Search<'s, 'a>,
}

/// Walks everything below `start`; what is not done at the end is left in the frontier.
#[simd]
pub(super) fn walk<S: Simd>(
    simd: S,
    frames: &Passing,
    start: NodePair,
    scratch: &mut Scratch,
    search: &mut Search<'_, '_>,
) -> End {
    let task = search.task;
    let Scratch { patch_a, patch_b, pairs, left, start_a, start_b } = scratch;
    let pair =
        NodePair { a: entrance(&task.a, start.a, start_a), b: entrance(&task.b, start.b, start_b) };
    let mut walk = Walk {
        frames,
        patch_a,
        patch_b,
        pairs,
        left,
        tree_a: Tree { nodes: task.a.wide, start: start_a },
        tree_b: Tree { nodes: task.b.wide, start: start_b },
        search,
    };
    walk.keep_one(pair);
    let end = walk.run(simd);
    let (tree_a, tree_b) = (walk.tree_a, walk.tree_b);
    search
        .frontier
        .rename(|pair| NodePair { a: tree_a.node(pair.a).root, b: tree_b.node(pair.b).root });
    end
}

impl Walk<'_, '_, '_, '_> {
    /// Adds the pair where the job starts.
    fn keep_one(&mut self, pair: NodePair) {
        let (a, b) = (self.tree_a.node(pair.a), self.tree_b.node(pair.b));
        self.search.counters.nb += 1;
        let [first_m, last_m] = self.frames.travels_of(&a.bounds, &b.bounds);
        let sweep = &self.search.task.sweep;
        let matters = first_m <= last_m
            && f64::from(first_m) <= self.search.limit_m()
            && f64::from(last_m) >= sweep.from_m();
        if matters {
            self.search.frontier.push(OpenPair { pair, from_m: first_m });
        }
    }

    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) -> End {
        loop {
            let open = match self.search.next() {
                ControlFlow::Continue(open) => open,
                ControlFlow::Break(end) => return end,
            };
            if let Some(next) = self.search.frontier.peek() {
                self.tree_a.prefetch(simd, next.pair.a);
                self.tree_b.prefetch(simd, next.pair.b);
            }
            let pair = open.pair;
            let (a, b) = (self.tree_a.node(pair.a), self.tree_b.node(pair.b));
            let stacked = self.search.frontier.stacked();
            match (a.leaf(), b.leaf()) {
                (None, None) => self.open_both(simd, a, b),
                (None, Some(leaf)) => self.open_a(simd, a, &leaf.bounds, pair.b),
                (Some(leaf), None) => self.open_b(simd, &leaf.bounds, b, pair.a),
                (Some(_), Some(_)) => self.collect(simd, open),
            }
            self.search.frontier.sort_stack(stacked);
        }
    }

    #[inline(always)]
    fn open_both<S: Simd>(&mut self, simd: S, a: &WideNode, b: &WideNode) {
        let limit = self.limit();
        let (used_a, used_b) = (boxes::used(simd, a), boxes::used(simd, b));
        self.count(used_a, used_b);
        let mut first = [0.0; LANES * LANES];
        let mut meeting = self.frames.meet(simd, (a, used_a), (b, used_b), limit, &mut first);
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize;
            let pair = NodePair { a: a.child(at / LANES), b: b.child(at % LANES) };
            self.search.frontier.push(OpenPair { pair, from_m: first[at] });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_a<S: Simd>(&mut self, simd: S, a: &WideNode, b: &Aabb, number_b: u32) {
        let limit = self.limit();
        let used = boxes::used(simd, a);
        self.count(used, 1);
        let (meeting, first) = self.frames.meet_one_of_b(simd, a, b, limit);
        let mut meeting = meeting & used;
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            let pair = NodePair { a: a.child(at), b: number_b };
            self.search.frontier.push(OpenPair { pair, from_m: first[at] });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn open_b<S: Simd>(&mut self, simd: S, a: &Aabb, b: &WideNode, number_a: u32) {
        let limit = self.limit();
        let used = boxes::used(simd, b);
        self.count(1, used);
        let (meeting, first) = self.frames.meet_one_of_a(simd, a, b, limit);
        let mut meeting = meeting & used;
        while meeting != 0 {
            let at = meeting.trailing_zeros() as usize % LANES;
            let pair = NodePair { a: number_a, b: b.child(at) };
            self.search.frontier.push(OpenPair { pair, from_m: first[at] });
            meeting &= meeting - 1;
        }
    }

    #[inline(always)]
    fn count(&mut self, lanes_a: u64, lanes_b: u64) {
        self.search.counters.nb += u64::from(lanes_a.count_ones() * lanes_b.count_ones());
    }

    /// The travel after which contact does not matter, rounded up (m).
    #[inline(always)]
    fn limit(&self) -> f32 {
        up(self.search.limit_m())
    }

    /// Decides the triangles of two leaves, unless others are more urgent on a closer look.
    #[inline(always)]
    fn collect<S: Simd>(&mut self, simd: S, OpenPair { pair, from_m }: OpenPair) {
        let (a, b) = (leaf(self.tree_a.from(pair.a)), leaf(self.tree_b.from(pair.b)));
        let task = self.search.task;
        let limit_m = self.search.limit_m();
        let [first, last] = self.frames.travels_of(&a[0].bounds, &b[0].bounds);
        let travels = [f64::from(first), f64::from(last)];
        self.search.counters.nb += 2;
        let [first_m, last_m] = self.frames.slabs_travels(&a[0], &b[0], travels);
        let begin_m = first_m.max(task.sweep.from_m());
        let end_m = last_m.min(limit_m);
        if begin_m > end_m {
            return;
        }
        // The bound of its boxes is lower: it comes up again with that of its slabs, and is then
        // decided.
        let bound = down(first_m);
        let is_later =
            bound > from_m && self.search.frontier.peek().is_some_and(|next| next.from_m < bound);
        if is_later {
            self.search.frontier.push(OpenPair { pair, from_m: bound });
            return;
        }
        self.search.counters.nb += u64::from(a[0].count + b[0].count);
        let pose = task.pose.moved(task.sweep.direction() * begin_m);
        let posed = Posed::new(&pose, task.a.corners, task.b.corners);
        let patches = (&mut *self.patch_a, &mut *self.patch_b);
        let travels = [begin_m, end_m];
        let close = self.frames.pack(simd, &posed, (a, b), travels, &task.sweep, patches);
        let Some((close, window)) = close else { return };
        let (of_a, of_b) = (&*self.patch_a, &*self.patch_b);
        self.search.counters.nb += (of_a.triangles().len() * of_b.triangles().len()) as u64;
        for at in (0..of_b.triangles().len()).step_by(EIGHT) {
            self.pairs.take(simd, of_a, (of_b, at), &window);
            if self.pairs.is_full() || at + EIGHT >= of_b.triangles().len() {
                self.search.counters.np += self.pairs.len() as u64;
                self.pairs.sift(simd, (&posed, &close), &window);
                let (a, b, first) = self.pairs.drain();
                for ((a, b), first) in a.iter().zip(b).zip(first) {
                    if self.left.len() == LEFT_MAX {
                        decide(self.search, self.left, begin_m);
                    }
                    self.left.push(Reverse(Due::new(*first, [*a, *b])));
                }
            }
        }
        decide(self.search, self.left, begin_m);
    }
}

/// Decides pairs of triangles, those first that may touch first.
fn decide(search: &mut Search<'_, '_>, left: &mut BinaryHeap<Reverse<Due>>, reference_m: f64) {
    while let Some(Reverse(due)) = left.pop() {
        if reference_m + f64::from(due.travel_m()) > search.limit_m() {
            break;
        }
        search.test(due.numbers());
    }
    left.clear();
}
