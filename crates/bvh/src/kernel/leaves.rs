//! Where two leaves meet: their triangles against each other.
//!
//! Triangles that do not reach the other leaf's box are left out first, so that most pairs of
//! leaves cost a few box tests; each triangle of B is moved into A's frame once per pair of leaves.

use super::{BEAT_TESTS, End, Outcome, Question, Side, Sink, Task};
use crate::Counters;
use crate::hits::Hits;
use geometry::{Bounds, Corners, DVec3, Supports, Triangle, hash, triangle};
use model::Node;
use std::ops::{ControlFlow, Range};

/// Triangles of A that are looked at together; a larger leaf is taken in parts.
const BATCH: usize = 64;

/// A triangle of A that reaches the box of B's leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    triangle: Triangle,
    bounds: Bounds,
    number: u32,
}

/// Scratch for one batch.
pub(super) fn scratch() -> Vec<Near> {
    Vec::with_capacity(BATCH)
}

/// Why a job ends before all leaves are tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Halt {
    /// The question is answered, whatever else there is.
    Answered,
    /// The sink said stop: the pair of leaves at hand is open again.
    Stopped,
}

/// What a job has found so far, and where its hits go.
pub(super) struct Leaves<'a, S> {
    task: &'a Task<'a>,
    hits_a: &'a mut Hits,
    hits_b: &'a mut Hits,
    near: &'a mut Vec<Near>,
    sink: &'a mut S,
    pub(super) counters: Counters,
    /// Tests at which the sink hears from us next.
    beat_at: u64,
    pairs: u64,
    hash: u64,
    zones_a: u16,
    zones_b: u16,
    supports: Supports,
}

impl<'a, S: Sink> Leaves<'a, S> {
    pub(super) fn new(
        task: &'a Task<'a>,
        hits_a: &'a mut Hits,
        hits_b: &'a mut Hits,
        near: &'a mut Vec<Near>,
        sink: &'a mut S,
    ) -> Self {
        Self {
            task,
            hits_a,
            hits_b,
            near,
            sink,
            counters: Counters::default(),
            beat_at: BEAT_TESTS,
            pairs: 0,
            hash: 0,
            zones_a: 0,
            zones_b: 0,
            supports: Supports::EMPTY,
        }
    }

    pub(super) fn outcome(self, end: End) -> Outcome {
        // Which zero is the greater is up to the machine, so all are +0.
        let supports = Supports(self.supports.0.map(|s| s + 0.0));
        Outcome {
            end,
            counters: self.counters,
            pairs: self.pairs,
            hash: self.hash,
            zones_a: self.zones_a,
            zones_b: self.zones_b,
            supports,
        }
    }

    /// Tells the sink how far we are, if it is time.
    #[inline]
    pub(super) fn beat(&mut self) -> ControlFlow<()> {
        let tests = self.counters.tests();
        if tests < self.beat_at {
            return ControlFlow::Continue(());
        }
        self.beat_at = tests + BEAT_TESTS;
        self.sink.beat(tests)
    }

    /// Tests all triangles of one leaf of A against all of one leaf of B.
    pub(super) fn test(&mut self, leaf_a: &Node, leaf_b: &Node) -> ControlFlow<Halt> {
        // Should the sink say stop, this pair is tested again by somebody else: its share of the
        // sums must not count twice. Sets, zones and supports may.
        let before = (self.pairs, self.hash);
        let tested = self.test_batches(leaf_a, leaf_b);
        if tested == ControlFlow::Break(Halt::Stopped) {
            (self.pairs, self.hash) = before;
        }
        tested
    }

    fn test_batches(&mut self, leaf_a: &Node, leaf_b: &Node) -> ControlFlow<Halt> {
        let box_a = leaf_a.bounds.bounds();
        let box_b = self.task.pose.bounds(&leaf_b.bounds);
        let end = leaf_a.link + leaf_a.count;
        for start in (leaf_a.link..end).step_by(BATCH) {
            self.gather(start..end.min(start + BATCH as u32), &box_b);
            if self.near.is_empty() {
                continue;
            }
            for number in leaf_b.link..leaf_b.link + leaf_b.count {
                self.beat().map_break(|()| Halt::Stopped)?;
                self.test_one(number, &box_a)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Collects the triangles of A that reach `box_b`, the box of B's leaf in A's frame.
    fn gather(&mut self, batch: Range<u32>, box_b: &Bounds) {
        self.near.clear();
        self.counters.nb += u64::from(batch.end - batch.start);
        for number in batch {
            let triangle = stored(&self.task.a.corners[number as usize]);
            let bounds = triangle.bounds();
            if bounds.overlaps(box_b) {
                self.near.push(Near { triangle, bounds, number });
            }
        }
    }

    /// Tests triangle `b` of B against those gathered of A, whose leaf has the box `box_a`.
    fn test_one(&mut self, b: u32, box_a: &Bounds) -> ControlFlow<Halt> {
        let moved = self.task.pose.triangle(&self.task.b.corners[b as usize]);
        let bounds = moved.bounds();
        self.counters.nb += 1;
        if !bounds.overlaps(box_a) {
            return ControlFlow::Continue(());
        }
        self.counters.nb += self.near.len() as u64;
        for i in 0..self.near.len() {
            let Near { triangle, bounds: bounds_a, number: a } = &self.near[i];
            let (triangle, a) = (*triangle, *a);
            if !bounds_a.overlaps(&bounds) {
                continue;
            }
            let known =
                self.task.question == Question::Sets && self.hits_a.has(a) && self.hits_b.has(b);
            if known {
                continue;
            }
            self.counters.np += 1;
            if triangle::intersect(&triangle, &moved) {
                self.found(a, b, &triangle, &moved)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Takes in that triangle `a` of A and triangle `b` of B intersect.
    fn found(&mut self, a: u32, b: u32, of_a: &Triangle, of_b: &Triangle) -> ControlFlow<Halt> {
        if self.task.question == Question::Touches {
            self.pairs = 1;
            // The question is answered, whether or not the sink wants more.
            let _ = (self.sink.hit(Side::A, a), self.sink.hit(Side::B, b));
            return ControlFlow::Break(Halt::Answered);
        }
        let (view_a, view_b) = (&self.task.a, &self.task.b);
        self.zones_a |= view_a.zones[a as usize].0;
        self.zones_b |= view_b.zones[b as usize].0;
        if self.task.question == Question::Pairs {
            self.pairs += 1;
            let ids = (view_a.source_ids[a as usize], view_b.source_ids[b as usize]);
            self.hash = self.hash.wrapping_add(hash::pair_term(ids.0, ids.1));
            if let Some(directions) = self.task.directions {
                for point in triangle::contact(of_a, of_b).points() {
                    self.supports.add(directions, *point);
                }
            }
        }
        if self.hits_a.insert(a) {
            self.sink.hit(Side::A, a).map_break(|()| Halt::Stopped)?;
        }
        if self.hits_b.insert(b) {
            self.sink.hit(Side::B, b).map_break(|()| Halt::Stopped)?;
        }
        ControlFlow::Continue(())
    }
}

/// A stored triangle of A: it is in A's frame already, and f64 holds f32 exactly.
fn stored(corners: &Corners) -> Triangle {
    Triangle(corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
}
