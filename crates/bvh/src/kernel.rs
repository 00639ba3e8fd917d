//! One job: everything below one node of A and one node of B, reduced to hits, sums and supports.
//!
//! Two walks give the same answer: `plain` documents the algorithm, one pair of boxes at a time;
//! `wide` tests eight boxes against eight, and eight pairs of triangles. Both are bounded in three
//! ways: by a stack of proven size, by a budget of tests, and by a sink that may stop the job. If a
//! job ends early, the pairs left on the stack cover exactly what was not tested.

use crate::hits::Hits;
use crate::{Counters, NodePair, section};
use body::BodyView;
use fearless_simd::dispatch;
use found::Found;
use geometry::simd::Level;
use geometry::{Directions, RelativePose, Supports};
use std::ops::ControlFlow;

mod boxes;
mod found;
mod plain;
pub mod sweep;
pub mod turning;
mod wide;

pub use found::{BEAT_TESTS, QueryWatch};

/// Maximum number of tests in one step, which is never interrupted: all boxes of two leaves against
/// each other, all boxes of each against the other leaf, and all triangles.
pub const STEP_TESTS: u64 = (2 * boxes::LEAF_MAX * boxes::LEAF_MAX + 2 * boxes::LEAF_MAX) as u64;

/// The most of a budget that one step spends: its tests, and what else its pairs cost.
pub const STEP_SPENT: u64 =
    STEP_TESTS + found::PAIR_TESTS * (boxes::LEAF_MAX * boxes::LEAF_MAX) as u64;

/// The budget for [`Kernel::run`] with which a job's tests never exceed the larger of `budget` and
/// one step: the budget is checked after each step.
#[must_use]
pub const fn within(budget: u64) -> u64 {
    let budget = budget.saturating_sub(STEP_TESTS);
    if budget == 0 { 1 } else { budget }
}

/// Minimum number of triangles that are tested together, as if they were one leaf.
pub const LEAF_TRIANGLES: usize = body::wide::LEAF_TRIANGLES;

/// How a job traverses its trees; the answer is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walk {
    /// Eight boxes against eight at once. Bodies beyond the range of f32 use the plain walk.
    #[default]
    Wide,
    /// Two boxes at a time.
    Plain,
}

/// What to compute for a pair of bodies at one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Is there any hit? The first one ends the job; which one that is depends on the trees.
    Touches,
    /// Which triangles are hit? Pairs whose triangles are both known to be hit need not be tested.
    Sets,
    /// All intersecting pairs: count and hash, the triangles hit, the supports of the contact.
    Pairs,
}

/// A question about two bodies at one pose. Jobs are parts of it.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The body in whose frame the test takes place: the ego.
    pub a: BodyView<'a>,
    /// The other body.
    pub b: BodyView<'a>,
    /// The pose of B relative to A.
    pub pose: RelativePose,
    /// What to compute.
    pub question: Question,
    /// Directions, in A's frame, in which [`Question::Pairs`] measures the contact.
    pub directions: Option<&'a Directions>,
}

/// One of the two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The ego.
    A,
    /// The other body.
    B,
}

/// Receives hits as they are found. `Break` ends the job as [`End::Stopped`].
pub trait Sink {
    /// Called with each hit triangle, by its number in leaf order: once per job and triangle.
    ///
    /// A `Break` may mean that this hit was not accepted: the pair of nodes it belongs to remains
    /// open. So a sink must accept at least the hits of two leaves, of [`LEAF_TRIANGLES`] triangles
    /// each or as many as the tree was built with, or their job will never complete.
    fn hit(&mut self, side: Side, triangle: u32) -> ControlFlow<()>;

    /// Called with intersecting pairs: triangles of A and those of B at the same positions, by
    /// their numbers in leaf order. Only for [`Question::Pairs`], each pair once per job.
    ///
    /// A `Break` leaves open what these pairs belong to, as with [`Sink::hit`]. Wherever a job
    /// stops, the first [`Outcome::pairs`] of the pairs reported in it count; those reported later
    /// belong to what remains, and are reported again by the job that does it.
    fn pairs(&mut self, _a: &[u32], _b: &[u32]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Whether of all pairs only that with the least source ids counts, A's first: then leaves that
    /// cannot have it are not tested, and [`Outcome::pairs`], hashes and hits are not those of all.
    /// Only for [`Question::Pairs`].
    fn seeks_least(&self) -> bool {
        false
    }

    /// Called about every [`BEAT_TESTS`] tests with the number of tests done in this job so far.
    fn beat(&mut self, tests: u64) -> ControlFlow<()>;
}

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The question is answered for everything that the job covers; nothing remains.
    Complete,
    /// The sink stopped the job; [`Kernel::remaining`] is open.
    Stopped,
    /// The budget (or the stack) did not suffice; [`Kernel::remaining`] is open.
    OutOfBudget,
}

/// The result of a job, apart from the hits that went to the sink.
///
/// All fields but `counters` depend only on the triangles tested, and merge by sum (`pairs`,
/// `hash`, wrapping), bitwise or (`zones_a`, `zones_b`) and maximum (`supports`): a job and the
/// jobs over its remainder merge to the whole, wherever it was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// Work done.
    pub counters: Counters,
    /// Intersecting pairs. For `Touches`: 1 if there is one, else 0. For `Sets`: 0, since not all
    /// are tested.
    pub pairs: u64,
    /// Wrapping sum of [`geometry::hash::pair_term`] of source ids; 0 except for `Pairs`.
    pub hash: u64,
    /// Zones of A's hit triangles; 0 for `Touches`.
    pub zones_a: u16,
    /// Zones of B's hit triangles; 0 for `Touches`.
    pub zones_b: u16,
    /// Supports of the contact, in A's frame, in metres; empty except for `Pairs` with directions.
    pub supports: Supports,
}

impl Outcome {
    /// What was spent of the budget: all tests, and the other costs of intersecting pairs. It is
    /// below the budget, or exceeds it by less than [`STEP_SPENT`].
    #[must_use]
    pub fn spent(&self) -> u64 {
        self.counters.tests() + found::PAIR_TESTS * self.pairs
    }
}

/// Scratch for jobs, allocated once.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Waiting pairs, at most `room`.
    stack: Vec<NodePair>,
    room: usize,
    hits_a: Hits,
    hits_b: Hits,
    near: Vec<plain::Near>,
    scratch: wide::Scratch,
    walk: Walk,
    level: Level,
}

impl Kernel {
    /// Creates a kernel with capacity for any job over trees of these depths and numbers of
    /// triangles.
    #[must_use]
    pub fn with_room(depth_a: u32, depth_b: u32, triangles_a: usize, triangles_b: usize) -> Self {
        let room = stack_room(depth_a, depth_b);
        Self {
            stack: Vec::with_capacity(room),
            room,
            hits_a: Hits::with_room(triangles_a),
            hits_b: Hits::with_room(triangles_b),
            near: plain::scratch(),
            scratch: wide::Scratch::new(),
            walk: Walk::default(),
            level: Level::new(),
        }
    }

    /// Sets the walk of later jobs.
    pub fn set_walk(&mut self, walk: Walk) {
        self.walk = walk;
    }

    /// Sets the vector instructions of later jobs, instead of the widest of this processor.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// Ensures capacity for larger bodies, between jobs; allocates only if there is too little.
    pub fn ensure_room(
        &mut self,
        depth_a: u32,
        depth_b: u32,
        triangles_a: usize,
        triangles_b: usize,
    ) {
        self.room = self.room.max(stack_room(depth_a, depth_b));
        self.stack.reserve_exact(self.room.saturating_sub(self.stack.len()));
        self.hits_a.ensure_room(triangles_a);
        self.hits_b.ensure_room(triangles_b);
    }

    /// Runs one job: everything below `start`, whose boxes are taken to overlap.
    ///
    /// `budget` bounds the tests of boxes and triangles together; the other costs of intersecting
    /// pairs are counted as tests. It is checked between steps, and two leaves are one step, so it
    /// may be exceeded by the tests of two leaves ([`within`]). Any budget above 0 makes progress.
    /// Nothing is allocated.
    ///
    /// If the trees are deeper than the kernel has capacity for, the job ends as
    /// [`End::OutOfBudget`], and the jobs over the remainder start deeper.
    ///
    /// # Panics
    ///
    /// There is no capacity for the triangles below `start` (see [`Kernel::ensure_room`]), or a
    /// number in a tree is out of range: a damaged tree must not produce an answer.
    pub fn run(
        &mut self,
        task: &Task<'_>,
        start: NodePair,
        budget: u64,
        sink: &mut dyn Sink,
    ) -> Outcome {
        self.stack.clear();
        self.stack.push(start);
        self.hits_a.clear(&section::triangles(task.a.nodes, start.a));
        self.hits_b.clear(&section::triangles(task.b.nodes, start.b));
        let mut found = Found::new(task, &mut self.hits_a, &mut self.hits_b, sink);
        let (stack, room) = (&mut self.stack, self.room);
        let end = match wide::frames(task).filter(|_| self.walk == Walk::Wide) {
            Some(ref frames) => {
                let scratch = &mut self.scratch;
                dispatch!(self.level, simd => {
                    wide::walk(simd, frames, stack, room, budget, scratch, &mut found)
                })
            }
            None => plain::walk(stack, room, budget, &mut self.near, &mut found),
        };
        found.outcome(end)
    }

    /// The pairs that the last job left open, its own included: they cover everything that it did
    /// not test, each pair of triangles once. Empty after [`End::Complete`].
    #[must_use]
    pub fn remaining(&self) -> &[NodePair] {
        &self.stack
    }
}

fn stack_room(depth_a: u32, depth_b: u32) -> usize {
    wide::stack_room(depth_a as usize + depth_b as usize)
}

#[cfg(test)]
mod tests;
