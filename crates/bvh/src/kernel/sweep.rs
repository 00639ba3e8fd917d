//! First contact: when a body that moves along a straight line first touches another one, and which
//! triangles touch then.
//!
//! ```text
//! the pair of nodes that may touch first --open--> pairs of children, by the travel from when on
//!                 ^                                 |           they may touch at the earliest
//!                 └── frontier: earliest first ◀────┤
//!                                                   └─ leaves: pairs of triangles ──▶ witnesses
//! ```
//!
//! The travels at which two boxes overlap, one of them moving, form an interval along each axis
//! (the slab test of T. Kay and J. Kajiya, *Ray Tracing Complex Scenes*, SIGGRAPH 1986); the latest
//! begin bounds the contact of all that lies within the boxes from below. Pairs are opened in the
//! order of these bounds (best first: P. Hart, N. Nilsson, B. Raphael, *A Formal Basis for the
//! Heuristic Determination of Minimum Cost Paths*, 1968), and those that cannot touch before the
//! best so far are left out. Only what is certainly *later* is: of several pairs that touch first
//! at the same travel, that with the least source ids is the witness, however trees, leaves and
//! jobs are cut.
//!
//! Two walks give the same answer: `plain` documents the algorithm; `wide` tests eight boxes
//! against eight, and filters eight pairs of triangles at once.

use super::{End, Walk, wide as static_wide};
use crate::placement::pass_apart;
use crate::{Counters, NodePair};
use body::BodyView;
use fearless_simd::dispatch;
use frontier::Frontier;
use geometry::simd::Level;
use geometry::sweep::{FirstTouch, first_contact};
use geometry::{DVec3, RelativePose, Sweep};
use std::cmp::Ordering;
use std::ops::ControlFlow;

mod due;
mod frontier;
mod plain;
mod wide;

pub use frontier::OpenPair;

/// When does B first touch A?
#[derive(Clone, Copy, Debug)]
pub struct SweepTask<'a> {
    /// The body in whose frame everything takes place: the ego.
    pub a: BodyView<'a>,
    /// The body that moves.
    pub b: BodyView<'a>,
    /// The pose of B relative to A at travel 0.
    pub pose: RelativePose,
    /// The motion of B, in A's frame. Put travel 0 near the bodies: the farther they are from each
    /// other there, the more rounding is allowed for.
    pub sweep: Sweep,
}

impl SweepTask<'_> {
    /// Whether the boxes of a pair of nodes are apart along an axis of A all along the motion.
    fn is_passing(&self, start: NodePair) -> bool {
        let (a, b) = (&self.a.nodes[start.a as usize], &self.b.nodes[start.b as usize]);
        pass_apart(&self.pose, [&a.bounds, &b.bounds], &self.sweep)
    }
}

/// Two triangles and the first travel at which they touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Witness {
    /// The first travel within the motion at which they touch (m).
    pub travel_m: f64,
    /// Source ids, of A's triangle and of B's.
    pub ids: [u32; 2],
    /// Their numbers in leaf order.
    pub triangles: [u32; 2],
    /// Where they touch then, in A's frame (m), rounded.
    pub point: DVec3,
}

impl Witness {
    /// The contact of two triangles, by their numbers in leaf order; `None` if they do not touch
    /// within the motion.
    ///
    /// # Panics
    ///
    /// A body has no such triangle.
    #[must_use]
    pub fn of(task: &SweepTask<'_>, triangles: [u32; 2]) -> Option<Self> {
        Self::within(task, &task.sweep, triangles)
    }

    fn within(task: &SweepTask<'_>, sweep: &Sweep, [a, b]: [u32; 2]) -> Option<Self> {
        let corners_a = &task.a.corners[a as usize];
        let moved = task.pose.triangle(&task.b.corners[b as usize]);
        let FirstTouch { travel_m, point } =
            first_contact(&geometry::Triangle::stored(corners_a), &moved, sweep)?;
        let ids = [task.a.source_ids[a as usize], task.b.source_ids[b as usize]];
        Some(Self { travel_m, ids, triangles: [a, b], point })
    }

    /// The order in which witnesses are reported: by travel, then by ids.
    #[must_use]
    pub fn order(&self, other: &Self) -> Ordering {
        self.travel_m.total_cmp(&other.travel_m).then(self.ids.cmp(&other.ids))
    }
}

/// Hears of the progress of a job, and may shorten or stop it.
pub trait SweepSink {
    /// Called with each witness that is among the earliest so far.
    fn found(&mut self, _witness: &Witness) {}

    /// Called about every [`super::BEAT_TESTS`] tests with the number of tests done in this job so
    /// far, and with the travel below which nothing can touch any more but what was found. Returns
    /// the travel (m) after which contact does not matter, as others have found some; infinity if
    /// that is not known.
    fn beat(&mut self, tests: u64, open_from_m: f64) -> ControlFlow<(), f64>;
}

/// A sink that neither hears nor says anything.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl SweepSink for Silent {
    fn beat(&mut self, _: u64, _: f64) -> ControlFlow<(), f64> {
        ControlFlow::Continue(f64::INFINITY)
    }
}

/// Limits of a job.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepLimits {
    /// Maximum number of tests of boxes and triangles, but for those of one step.
    pub budget: u64,
}

impl Default for SweepLimits {
    /// None.
    fn default() -> Self {
        Self { budget: u64::MAX }
    }
}

/// How a job ended, and what it took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepOutcome {
    /// [`End::OutOfBudget`] also where the job yielded: something remains.
    pub end: End,
    /// Tests of boxes, and of triangles that are not apart by their boxes.
    pub counters: Counters,
    /// Pairs of triangles that were decided one by one, as their projections are not apart.
    pub exact_tests: u64,
}

/// Scratch for jobs that seek first contact, allocated once.
#[derive(Clone, Debug)]
pub struct SweepKernel {
    frontier: Frontier,
    nearest: Nearest,
    scratch: wide::Scratch,
    walk: Walk,
    level: Level,
}

/// The earliest witnesses so far, in order.
#[derive(Clone, Debug)]
struct Nearest {
    found: Vec<Witness>,
    most: usize,
}

impl Nearest {
    /// The travel after which contact does not matter (m).
    fn limit_m(&self, to_m: f64) -> f64 {
        match self.found.last() {
            Some(last) if self.found.len() == self.most => last.travel_m,
            _ => to_m,
        }
    }

    /// Takes a witness if it is among the earliest.
    fn take(&mut self, witness: &Witness) -> bool {
        let at = self.found.partition_point(|found| found.order(witness).is_lt());
        if at == self.most {
            return false;
        }
        if self.found.len() == self.most {
            self.found.pop();
        }
        self.found.insert(at, *witness);
        true
    }
}

impl SweepKernel {
    /// Creates a kernel with capacity for any job over trees of these depths, which reports the
    /// `nearest` earliest pairs; 0 counts as 1.
    #[must_use]
    pub fn with_room(depth_a: u32, depth_b: u32, nearest: usize) -> Self {
        let most = nearest.max(1);
        Self {
            frontier: Frontier::with_room(super::stack_room(depth_a, depth_b)),
            nearest: Nearest { found: Vec::with_capacity(most), most },
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

    /// Sets how many pairs later jobs report, and ensures capacity for deeper trees; allocates only
    /// if there is too little.
    pub fn ensure_room(&mut self, depth_a: u32, depth_b: u32, nearest: usize) {
        self.frontier.ensure_room(super::stack_room(depth_a, depth_b));
        self.nearest.most = nearest.max(1);
        let most = self.nearest.most;
        self.nearest.found.clear();
        self.nearest.found.reserve(most);
    }

    /// Runs one job: everything below `start`. The earliest pairs are then
    /// [`SweepKernel::nearest`], as far as they touch within the motion.
    ///
    /// Nothing is allocated. If the trees are deeper than there is capacity for, the job ends as
    /// [`End::OutOfBudget`], and jobs over what remains start deeper.
    ///
    /// # Panics
    ///
    /// A number in a tree is out of range: a damaged tree must not produce an answer.
    pub fn run(
        &mut self,
        task: &SweepTask<'_>,
        start: NodePair,
        limits: SweepLimits,
        sink: &mut dyn SweepSink,
    ) -> SweepOutcome {
        self.frontier.clear();
        self.nearest.found.clear();
        // The plain walk, which documents the algorithm, does without.
        if self.walk == Walk::Wide && task.is_passing(start) {
            let counters = Counters { nb: 1, ..Counters::default() };
            return SweepOutcome { end: End::Complete, counters, exact_tests: 0 };
        }
        let mut search = Search {
            task,
            limits,
            frontier: &mut self.frontier,
            nearest: &mut self.nearest,
            sink,
            to_m: task.sweep.to_m(),
            counters: Counters::default(),
            exact_tests: 0,
            steps: 0,
            beat_at: super::BEAT_TESTS,
        };
        let frames = wide::frames(task).filter(|_| self.walk == Walk::Wide);
        let end = match frames {
            Some(ref frames) => {
                let scratch = &mut self.scratch;
                dispatch!(self.level, simd => wide::walk(simd, frames, start, scratch, &mut search))
            }
            None => plain::walk(start, &mut search),
        };
        SweepOutcome { end, counters: search.counters, exact_tests: search.exact_tests }
    }

    /// The earliest pairs of the last job, in the order of [`Witness::order`].
    #[must_use]
    pub fn nearest(&self) -> &[Witness] {
        &self.nearest.found
    }

    /// The pairs that the last job left open: they cover everything that it did not test and that
    /// may still matter. Empty after [`End::Complete`].
    pub fn remaining(&self) -> impl Iterator<Item = OpenPair> + '_ {
        self.frontier.iter()
    }
}

/// The state of one job, apart from its scratch.
struct Search<'s, 'a> {
    task: &'s SweepTask<'a>,
    limits: SweepLimits,
    frontier: &'s mut Frontier,
    nearest: &'s mut Nearest,
    sink: &'s mut dyn SweepSink,
    /// The travel after which contact does not matter (m), but for what is found here.
    to_m: f64,
    counters: Counters,
    exact_tests: u64,
    steps: u64,
    /// Number of tests at which the sink is called next.
    beat_at: u64,
}

impl Search<'_, '_> {
    /// The travel after which contact does not matter (m).
    #[inline]
    fn limit_m(&self) -> f64 {
        self.nearest.limit_m(self.to_m)
    }

    /// The next pair to open; or how the job ends. Pairs that cannot matter any more are dropped.
    fn next(&mut self) -> ControlFlow<End, OpenPair> {
        let limit_m = self.limit_m();
        let next = loop {
            match self.frontier.peek() {
                None => return ControlFlow::Break(End::Complete),
                Some(next) if f64::from(next.from_m) <= limit_m => break next,
                Some(_) => self.frontier.drop_after(limit_m),
            }
        };
        let tests = self.counters.tests();
        // The first step is always made: so every job makes progress.
        let may_end = self.steps > 0;
        if may_end && tests >= self.limits.budget || !self.frontier.has_room() {
            return ControlFlow::Break(End::OutOfBudget);
        }
        self.steps += 1;
        if tests >= self.beat_at {
            self.beat_at = tests + super::BEAT_TESTS;
            match self.sink.beat(tests, f64::from(next.from_m)) {
                ControlFlow::Continue(limit_m) => self.to_m = self.to_m.min(limit_m),
                ControlFlow::Break(()) => return ControlFlow::Break(End::Stopped),
            }
        }
        self.frontier.pop().map_or(ControlFlow::Break(End::Complete), ControlFlow::Continue)
    }

    /// Decides one pair of triangles.
    #[inline]
    fn test(&mut self, triangles: [u32; 2]) {
        self.exact_tests += 1;
        let sweep = self.task.sweep.until(self.limit_m());
        if let Some(witness) = Witness::within(self.task, &sweep, triangles)
            && self.nearest.take(&witness)
        {
            self.sink.found(&witness);
        }
    }
}

#[cfg(test)]
mod tests;
