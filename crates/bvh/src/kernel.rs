//! One job: everything below one node of A and one node of B, to hits, sums and supports.
//!
//! Two walks give the same answer: `plain` explains how, one pair of boxes at a time; `wide` takes
//! eight boxes against eight, and eight pairs of triangles. Either is bounded three times over:
//! by a stack whose size is argued there, by a budget of tests, and by a sink that may say stop.
//! Whatever ends it early, the pairs that wait on the stack cover everything that was not tested,
//! and no more.

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
mod wide;

pub use found::BEAT_TESTS;

/// Most tests of one step, which nothing interrupts: all boxes of two leaves against each other,
/// all boxes of each against the other leaf, and all triangles.
pub const STEP_TESTS: u64 = (2 * boxes::LEAF_MAX * boxes::LEAF_MAX + 2 * boxes::LEAF_MAX) as u64;

/// The budget of [`Kernel::run`] under which a job's tests never exceed `budget`, or one step where
/// that is more: a step is looked at when it is done.
#[must_use]
pub const fn within(budget: u64) -> u64 {
    let budget = budget.saturating_sub(STEP_TESTS);
    if budget == 0 { 1 } else { budget }
}

/// Triangles that are tested together at least, as if they were one leaf.
pub const LEAF_TRIANGLES: usize = body::wide::LEAF_TRIANGLES;

/// How a job walks its trees: the answer is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walk {
    /// Eight boxes against eight at once. Bodies beyond the range of f32 are walked plainly.
    #[default]
    Wide,
    /// Two boxes at a time.
    Plain,
}

/// What is asked about a pair of bodies at one pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Is there any hit? The first one answers it: which one that is depends on the trees.
    Touches,
    /// Which triangles are hit? Pairs of which both are known to be hit need not be tested.
    Sets,
    /// All intersecting pairs: count and hash, the triangles hit, the supports of the contact.
    Pairs,
}

/// A question about two bodies at one pose. Jobs are parts of it.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// The body in whose frame the test takes place: the ego.
    pub a: BodyView<'a>,
    /// The other one.
    pub b: BodyView<'a>,
    /// B seen from A.
    pub pose: RelativePose,
    /// What is asked.
    pub question: Question,
    /// Directions in which [`Question::Pairs`] measures the contact, A's frame.
    pub directions: Option<&'a Directions>,
}

/// Which body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The ego.
    A,
    /// The other one.
    B,
}

/// Hears of hits as they are found. `Break` ends the job as [`End::Stopped`].
pub trait Sink {
    /// A triangle was hit, by its number in leaf order: once per job and triangle.
    ///
    /// A `Break` may mean that this hit was not taken: what it belongs to remains open.
    /// So a sink must take at least the hits of two leaves, of [`LEAF_TRIANGLES`] triangles each or
    /// as many as the tree was built with, or their job will never be done.
    fn hit(&mut self, side: Side, triangle: u32) -> ControlFlow<()>;

    /// Triangles of A intersect those of B in the same places, by their numbers in leaf order; told
    /// where [`Question::Pairs`] is asked, each pair once per job.
    ///
    /// A `Break` leaves open what these pairs belong to, as with [`Sink::hit`]. Wherever a job
    /// stops, of all pairs told in it the first [`Outcome::pairs`] count; those told after them
    /// belong to what remains, and will be told again by whoever does that.
    fn pairs(&mut self, _a: &[u32], _b: &[u32]) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// So many tests were done in this job up to now; called about every [`BEAT_TESTS`].
    fn beat(&mut self, tests: u64) -> ControlFlow<()>;
}

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The question is answered for all that the job covers; nothing remains.
    Complete,
    /// The sink said stop; [`Kernel::remaining`] is open.
    Stopped,
    /// The budget (or the stack) did not suffice; [`Kernel::remaining`] is open.
    OutOfBudget,
}

/// What a job found, beside the hits that went to the sink.
///
/// All but `counters` follow from the triangles tested alone, and merge by sum (`pairs`, `hash`,
/// wrapping), or (`zones_a`, `zones_b`) and maximum (`supports`): a job and the jobs over what it
/// left merge to the whole, wherever it was cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// How it ended.
    pub end: End,
    /// Work done.
    pub counters: Counters,
    /// Intersecting pairs. `Touches`: 1 if there is one, else 0. `Sets`: 0, not all are tested.
    pub pairs: u64,
    /// Wrapping sum of [`geometry::hash::pair_term`] of source ids; 0 unless `Pairs` was asked.
    pub hash: u64,
    /// Zones of A's hit triangles; 0 if only `Touches` was asked.
    pub zones_a: u16,
    /// Zones of B's hit triangles; 0 if only `Touches` was asked.
    pub zones_b: u16,
    /// Supports of the contact, A's frame, in metres; empty unless `Pairs` was asked with
    /// directions.
    pub supports: Supports,
}

/// Scratch for jobs, allocated once.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// Pairs that wait; `room` of them at most.
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
    /// Room for any job over trees of these depths with so many triangles.
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

    /// Walks otherwise from now on.
    pub fn set_walk(&mut self, walk: Walk) {
        self.walk = walk;
    }

    /// Uses these vector instructions from now on, and not the widest of this processor.
    pub fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// Makes room for larger bodies, between jobs; allocates only if there was none.
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
    /// `budget` bounds the tests of boxes and triangles together, and what intersecting pairs cost
    /// besides counts as tests. It is looked at between steps, and two leaves are one step, so it
    /// may be exceeded by the tests of two leaves ([`within`]). Any budget
    /// above 0 makes progress. Nothing is allocated.
    ///
    /// Should the trees be deeper than the kernel has room for, the job ends as
    /// [`End::OutOfBudget`], and the jobs over what remains start deeper.
    ///
    /// # Panics
    ///
    /// If there is no room for the triangles below `start` ([`Kernel::ensure_room`] makes it), or
    /// if a number in a tree is out of range: a damaged tree must not produce an answer.
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

    /// The pairs that the last job left open, its own included: they cover all that it did not
    /// test, each pair of triangles once. Empty after [`End::Complete`].
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
