//! First contact of two bodies that both move and turn: when they touch, may touch, or do not.
//!
//! ```text
//! pieces of the motion, earliest first
//!   interval ──▶ pairs of nodes whose boxes may overlap meanwhile ──none──▶ excluded
//!      ▲              │                               │ short interval: pairs of triangles
//!      └── halves ◀───┘ are handed down               └──▶ exact tests at poses ──▶ certain
//!                                                                └──none──▶ possible
//! ```
//!
//! Time and space are divided together: nodes are opened until they are about as large as what they
//! move in the interval; then the interval is halved, and its halves begin with the pairs that it
//! left. So what was excluded once is not visited again. The halves are those of
//! [`geometry::motion::TimeInterval`]. Where motion is straight, a time before which nothing
//! touches is found at once, and halves that end before it are left out (`clearance.rs`).
//!
//! # What is decided
//!
//! A pair of triangles is *open* in a short interval if that does not call it apart
//! ([`TimeInterval::are_apart`]). In longer intervals, and for boxes of nodes, only such axes are
//! tried along which what is apart is so in each short interval within, for the same test of
//! triangles. So the answer depends on triangles alone: trees, leaves, the order of tests and
//! memory do not matter. The first interval with an open pair decides: if a pair touches exactly at
//! one of a few poses, contact is certain; else it is possible, and a little further on certain
//! contact is sought still.
//!
//! Memory is bounded: where an interval leaves too many pairs, its halves begin with the roots.

use super::{BEAT_TESTS, QueryWatch};
use crate::descent::side_to_open;
use crate::{Counters, NodePair, Side};
use body::{BodyView, Node};
use geometry::Corners;
use geometry::motion::{MovingBodies, PathPiece, RelativeMotion, TimeInterval};
use std::ops::ControlFlow;

mod clearance;
mod triangles;

/// Maximum number of pairs of nodes that are kept for later intervals.
const PAIRS_MAX: usize = 1 << 18;

/// Nodes are opened while they are larger than this many times what B moves in the interval. With a
/// quarter as much, contacts of cars took twice as long: what touches late in an interval is then
/// visited at every size.
const NODE_TRAVELS: f64 = 2.0;

/// The triangles of two leaves are looked at if one of these is larger than this many times what B
/// moves in the interval; else later.
const LEAF_TRAVELS: f64 = 4.0;

/// After an interval in which contact is possible, certain contact is sought for this many times
/// its length.
const PATIENCE: f64 = 32.0;

/// When do B and A first touch?
#[derive(Clone, Copy, Debug)]
pub struct TurningTask<'a> {
    /// The body in whose frame triangles are tested: the ego.
    pub a: BodyView<'a>,
    /// The other body.
    pub b: BodyView<'a>,
    /// The motion of both.
    pub motion: RelativeMotion<'a>,
    /// Contact that is not certain is possible within this distance (m).
    pub resolution_m: f64,
}

/// When bodies touch, as far as triangles tell; times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum First {
    /// Never: a proof.
    Never,
    /// Triangles touch exactly at a pose of the motion, and not before another time.
    Certain {
        /// The time of the pose.
        time_s: f64,
        /// Nothing touches before.
        clear_before_s: f64,
        /// Source ids of two triangles that touch then, of A's and of B's.
        ids: [u32; 2],
    },
    /// Triangles come within the resolution of each other, but no pose was found at which any
    /// touch.
    Possible {
        /// Nothing touches before.
        clear_before_s: f64,
        /// Where the interval ends in which contact is possible.
        to_s: f64,
        /// The least source ids, of A's triangle and of B's, of a pair that is open then.
        ids: [u32; 2],
    },
    /// The budget did not suffice.
    Open {
        /// Nothing touches before.
        clear_before_s: f64,
    },
}

/// How a search ended, and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningOutcome {
    /// What was found.
    pub first: First,
    /// Tests of boxes, and of triangles whose boxes overlap.
    pub counters: Counters,
    /// Intervals of time that were looked at.
    pub intervals: u64,
}

/// Scratch of the search, reusable: at most some 3 MB.
#[derive(Clone, Debug, Default)]
pub struct TurningKernel {
    /// Pairs that intervals left, those of an interval before those of its halves.
    pairs: Vec<NodePair>,
    /// The next interval last.
    frames: Vec<Frame>,
    /// Pairs to be tested in the interval at hand.
    open: Vec<NodePair>,
    /// Pairs that come near each other, and when: shares of an interval. What is next comes last.
    nearing: Vec<(f64, NodePair)>,
    /// Pairs of triangles, by their numbers in leaf order, that are open in a short interval.
    touching: Vec<[u32; 2]>,
}

/// An interval that is still to be searched.
#[derive(Clone, Copy, Debug)]
struct Frame {
    interval: TimeInterval,
    /// The pairs it begins with: positions in [`TurningKernel::pairs`]. What comes after them is of
    /// earlier intervals.
    begin: [usize; 2],
    /// How long the shortest interval around it is of which it was sought until when it is clear
    /// (s).
    sought_s: f64,
}

impl TurningKernel {
    /// Scratch without capacity; it grows as needed.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Searches all of both bodies and the whole motion with at most `budget` tests, but for those
    /// of one pair of leaves, or until `watch` ends it.
    ///
    /// # Panics
    ///
    /// A number in a tree is out of range: a damaged tree must not produce an answer.
    pub fn run(
        &mut self,
        task: &TurningTask<'_>,
        (budget, watch): (u64, QueryWatch<'_>),
    ) -> TurningOutcome {
        let boxes = [task.a.bounds(), task.b.bounds()];
        let mut search = Search {
            task,
            bodies: MovingBodies::new(&task.motion, [&boxes[0], &boxes[1]]),
            kernel: self,
            budget,
            watch,
            watched: 0,
            counters: Counters::default(),
            intervals: 0,
            clear_s: f64::NEG_INFINITY,
            possible: None,
        };
        let first = if task.a.nodes.is_empty() || task.b.nodes.is_empty() {
            First::Never
        } else {
            search.run()
        };
        TurningOutcome { first, counters: search.counters, intervals: search.intervals }
    }
}

/// The first interval in which contact is possible.
#[derive(Clone, Copy, Debug)]
struct Possible {
    from_s: f64,
    to_s: f64,
    ids: [u32; 2],
}

impl Possible {
    /// When certain contact is no longer sought.
    fn give_up_s(&self) -> f64 {
        self.to_s + PATIENCE * (self.to_s - self.from_s)
    }

    fn first(&self) -> First {
        First::Possible { clear_before_s: self.from_s, to_s: self.to_s, ids: self.ids }
    }
}

impl<'a> TurningTask<'a> {
    /// Source ids of two triangles.
    fn ids(&self, [a, b]: [u32; 2]) -> [u32; 2] {
        [self.a.source_ids[a as usize], self.b.source_ids[b as usize]]
    }

    fn corners(&self, [a, b]: [u32; 2]) -> [&'a Corners; 2] {
        [&self.a.corners[a as usize], &self.b.corners[b as usize]]
    }
}

/// The state of one search, apart from its scratch.
struct Search<'s, 'a> {
    task: &'s TurningTask<'a>,
    bodies: MovingBodies,
    kernel: &'s mut TurningKernel,
    budget: u64,
    watch: QueryWatch<'s>,
    /// Tests up to the last call of it.
    watched: u64,
    counters: Counters,
    intervals: u64,
    /// Nothing touches before (s), or what does is [`Search::possible`].
    clear_s: f64,
    possible: Option<Possible>,
}

impl<'a> Search<'_, 'a> {
    fn run(&mut self) -> First {
        let motion = self.task.motion;
        for piece in motion.pieces() {
            if let ControlFlow::Break(first) = self.piece(&piece) {
                return first;
            }
        }
        self.possible.map_or(First::Never, |possible| possible.first())
    }

    /// Searches one piece: its intervals depth first, so that they come in the order of time.
    fn piece(&mut self, piece: &PathPiece) -> ControlFlow<First> {
        self.kernel.pairs.clear();
        self.kernel.pairs.push(NodePair::ROOTS);
        self.kernel.frames.clear();
        let interval = TimeInterval::of(&self.task.motion, &self.bodies, piece);
        self.kernel.frames.push(Frame { interval, begin: [0, 1], sought_s: f64::INFINITY });
        while let Some(mut frame) = self.kernel.frames.pop() {
            let interval = &frame.interval;
            if interval.to_s <= self.clear_s {
                continue;
            }
            self.check_time(interval)?;
            self.kernel.pairs.truncate(frame.begin[1]);
            if interval.is_short(self.task.resolution_m) || interval.middle_s().is_none() {
                self.decide(&frame)?;
                continue;
            }
            // Part of it is clear: the other part is looked at once it is alone.
            if interval.from_s >= self.clear_s {
                frame.begin = self.refine(&frame)?;
                if frame.begin[0] < frame.begin[1] && frame.may_be_clear(self.task.resolution_m) {
                    match self.clear_until_s(interval, frame.begin)? {
                        None => continue,
                        Some(time_s) => self.clear_s = time_s,
                    }
                    frame.sought_s = interval.lasts_s();
                }
            }
            if frame.begin[0] < frame.begin[1]
                && let Some(halves) = interval.halves(&self.task.motion, &self.bodies, piece)
            {
                let [first, second] = halves.map(|interval| Frame { interval, ..frame });
                self.kernel.frames.extend([second, first]);
            }
        }
        ControlFlow::Continue(())
    }

    /// Ends the search if what is possible was followed for long enough, or without budget.
    fn check_time(&mut self, interval: &TimeInterval) -> ControlFlow<First> {
        self.intervals += 1;
        match self.possible {
            Some(possible) if interval.from_s >= possible.give_up_s() => {
                ControlFlow::Break(possible.first())
            }
            _ => self.check_budget(interval),
        }
    }

    fn check_budget(&mut self, interval: &TimeInterval) -> ControlFlow<First> {
        let tests = self.counters.tests();
        let since = tests - self.watched;
        let mut is_over = tests >= self.budget;
        if since >= BEAT_TESTS {
            self.watched = tests;
            is_over |= (self.watch)(since).is_break();
        }
        if !is_over {
            return ControlFlow::Continue(());
        }
        let clear_before_s = self.possible.map_or(interval.from_s, |possible| possible.from_s);
        ControlFlow::Break(First::Open { clear_before_s })
    }

    /// Appends the pairs that an interval leaves to those kept, and returns where they are.
    fn refine(&mut self, Frame { interval, begin, .. }: &Frame) -> ControlFlow<First, [usize; 2]> {
        self.kernel.open.clear();
        let from = self.kernel.pairs.len();
        if interval.is_far() {
            self.counters.nb += 1;
            return ControlFlow::Continue([from, from]);
        }
        let least = (interval.travel_m() * NODE_TRAVELS) as f32;
        let least_leaf = (interval.travel_m() * LEAF_TRAVELS) as f32;
        let is_small = |node: &Node| size(node) < least;
        for at in begin[0]..begin[1] {
            self.kernel.open.push(self.kernel.pairs[at]);
            while let Some(pair) = self.kernel.open.pop() {
                self.check_budget(interval)?;
                let Some((a, b)) = self.meeting(interval, pair) else { continue };
                let (small_a, small_b) = (is_small(a), is_small(b));
                let side = side_to_open(a, a.is_leaf() || small_a, b, b.is_leaf() || small_b);
                if let Some(side) = side {
                    self.open(pair, side, (a, b));
                    continue;
                }
                let are_leaves = a.is_leaf() && b.is_leaf() && size(a).max(size(b)) >= least_leaf;
                if are_leaves && !self.any_open(interval, (a, b)) {
                    continue;
                }
                if self.kernel.pairs.len() < PAIRS_MAX {
                    self.kernel.pairs.push(pair);
                } else {
                    self.kernel.pairs.truncate(from);
                    self.kernel.pairs.push(NodePair::ROOTS);
                    self.kernel.open.clear();
                    return ControlFlow::Continue([from, self.kernel.pairs.len()]);
                }
            }
        }
        ControlFlow::Continue([from, self.kernel.pairs.len()])
    }

    /// The nodes of a pair, if their boxes may overlap in the interval.
    fn meeting(&mut self, interval: &TimeInterval, pair: NodePair) -> Option<(&'a Node, &'a Node)> {
        let (a, b) = self.nodes(pair);
        self.counters.nb += 1;
        interval.may_meet(&a.bounds, &b.bounds).then_some((a, b))
    }

    fn nodes(&self, pair: NodePair) -> (&'a Node, &'a Node) {
        let TurningTask { a, b, .. } = *self.task;
        (&a.nodes[pair.a as usize], &b.nodes[pair.b as usize])
    }

    fn open(&mut self, pair: NodePair, side: Side, nodes: (&Node, &Node)) {
        self.kernel.open.extend_from_slice(&children(pair, side, nodes));
    }
}

/// The pairs that one node of a pair, no leaf, opens to.
fn children(pair: NodePair, side: Side, (a, b): (&Node, &Node)) -> [NodePair; 2] {
    match side {
        Side::A => [NodePair { a: a.link, ..pair }, NodePair { a: pair.a + 1, ..pair }],
        Side::B => [NodePair { b: b.link, ..pair }, NodePair { b: pair.b + 1, ..pair }],
    }
}

/// The longest side of a node's box (m).
fn size(node: &Node) -> f32 {
    [0, 1, 2].map(|axis| node.bounds.extent(axis)).into_iter().fold(0.0, f32::max)
}
