//! What a job has found so far, and where its hits go; shared by all walks.

use super::{End, Outcome, Question, Side, Sink, Task};
use crate::Counters;
use crate::hits::Hits;
use fearless_simd::Simd;
use geometry::patch::Places;
use geometry::simd::prefetch;
use geometry::{Directions, Supports, hash};
use std::ops::ControlFlow;

/// Maximum number of tests between two calls of [`Sink::beat`], apart from those of one step.
pub const BEAT_TESTS: u64 = 1024;

/// What is called about every [`BEAT_TESTS`] tests of a query, with how many were done since; if it
/// returns `Break` the query ends as if its budget were spent.
pub type QueryWatch<'w> = &'w mut dyn FnMut(u64) -> ControlFlow<()>;

/// The cost, in tests, of recording an intersecting pair and measuring its contact along all
/// directions: a budget stands for time, and with many hits most of the time is spent on them.
pub(super) const PAIR_TESTS: u64 = 24;

/// Why a job ends before everything is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Halt {
    /// The question is answered, whatever else there is.
    Answered,
    /// The sink stopped the job: what was tested last is open again.
    Stopped,
}

/// The sums of a job, in which nothing must count twice.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pairs: u64,
    hash: u64,
}

/// What a job has found so far.
pub(super) struct Found<'a> {
    pub(super) task: &'a Task<'a>,
    pub(super) hits_a: &'a mut Hits,
    pub(super) hits_b: &'a mut Hits,
    pub(super) counters: Counters,
    /// If the sink stops the job, the current step is tested again by another job: the sums are
    /// then reset to their earlier values. Sets, zones and supports need no reset.
    pub(super) sums: Sums,
    sink: &'a mut dyn Sink,
    /// If only the least pair counts: the least id of A so far.
    least_a: Option<u32>,
    /// Number of tests at which the sink is called next.
    beat_at: u64,
    zones_a: u16,
    zones_b: u16,
    supports: Supports,
}

impl<'a> Found<'a> {
    pub(super) fn new(
        task: &'a Task<'a>,
        hits_a: &'a mut Hits,
        hits_b: &'a mut Hits,
        sink: &'a mut dyn Sink,
    ) -> Self {
        Self {
            task,
            hits_a,
            hits_b,
            counters: Counters::default(),
            sums: Sums::default(),
            least_a: sink.seeks_least().then_some(u32::MAX),
            sink,
            beat_at: BEAT_TESTS,
            zones_a: 0,
            zones_b: 0,
            supports: Supports::EMPTY,
        }
    }

    pub(super) fn outcome(self, end: End) -> Outcome {
        // Which of two zeros is the greater depends on the machine, so all become +0.
        let supports = Supports(self.supports.0.map(|s| s + 0.0));
        Outcome {
            end,
            counters: self.counters,
            pairs: self.sums.pairs,
            hash: self.sums.hash,
            zones_a: self.zones_a,
            zones_b: self.zones_b,
            supports,
        }
    }

    /// The part of the budget that was spent: all tests, and the other costs of hits.
    #[inline]
    pub(super) fn spent(&self) -> u64 {
        self.counters.tests() + PAIR_TESTS * self.sums.pairs
    }

    /// Reports progress to the sink when due.
    #[inline]
    pub(super) fn beat(&mut self) -> ControlFlow<Halt> {
        let tests = self.counters.tests();
        if tests < self.beat_at {
            return ControlFlow::Continue(());
        }
        self.beat_at = tests + BEAT_TESTS;
        self.sink.beat(tests).map_break(|()| Halt::Stopped)
    }

    /// Whether the pair cannot add to the result.
    #[inline]
    pub(super) fn known(&self, a: u32, b: u32) -> bool {
        self.task.question == Question::Sets && self.hits_a.has(a) && self.hits_b.has(b)
    }

    /// Whether no pair of these triangles of A, a range of their numbers, can add to the result.
    #[inline]
    pub(super) fn is_beaten(&self, first: u32, count: u32) -> bool {
        let Some(least) = self.least_a else { return false };
        let ids = &self.task.a.source_ids[first as usize..(first + count) as usize];
        ids.iter().all(|id| *id > least)
    }

    /// Announces which triangles of A and of B will be tested, each body's in ascending order.
    /// Hits, ids and zones are prefetched: the time between this call and [`Found::take`] hides the
    /// memory latency.
    #[inline(always)]
    pub(super) fn await_hits<S: Simd>(&self, simd: S, [a, b]: [&[u32]; 2]) {
        for (view, triangles) in [(&self.task.a, a), (&self.task.b, b)] {
            // A cache line holds 16 ids or 32 zones.
            for some in triangles.chunks(8) {
                prefetch(simd, view.source_ids, some[0] as usize);
                prefetch(simd, view.source_ids, some[some.len() - 1] as usize);
                prefetch(simd, view.zones, some[0] as usize);
            }
        }
    }

    /// Records that these triangles of A intersect those of B at the same positions.
    ///
    /// Those of either body are in [`Places`] counted from number `first`. `measure` adds the
    /// contact of a pair to the supports; it is called only where that is needed.
    #[inline]
    pub(super) fn take(
        &mut self,
        [a, b]: [&[u32]; 2],
        first: [u32; 2],
        mut measure: impl FnMut([u32; 2], &mut Supports, &Directions),
    ) -> ControlFlow<Halt> {
        if a.is_empty() {
            return ControlFlow::Continue(());
        }
        if self.task.question == Question::Touches {
            self.sums.pairs = 1;
            // The question is answered, whether or not the sink stops.
            let _ = (self.sink.hit(Side::A, a[0]), self.sink.hit(Side::B, b[0]));
            return ControlFlow::Break(Halt::Answered);
        }
        let is_pairs = self.task.question == Question::Pairs;
        if is_pairs {
            // All at once: few sinks list pairs, and the others are called only once.
            self.sink.pairs(a, b).map_break(|()| Halt::Stopped)?;
        }
        let (view_a, view_b) = (&self.task.a, &self.task.b);
        if let Some(least) = &mut self.least_a {
            *least = a.iter().fold(*least, |least, a| least.min(view_a.source_ids[*a as usize]));
            return ControlFlow::Continue(());
        }
        let (mut places, mut hash) = ([Places::default(); 2], 0_u64);
        for (&a, &b) in a.iter().zip(b) {
            places[0].insert((a - first[0]) as usize);
            places[1].insert((b - first[1]) as usize);
            if is_pairs {
                let ids = (view_a.source_ids[a as usize], view_b.source_ids[b as usize]);
                hash = hash.wrapping_add(hash::pair_term(ids.0, ids.1));
            }
        }
        if is_pairs {
            self.sums.pairs += a.len() as u64;
            self.sums.hash = self.sums.hash.wrapping_add(hash);
            if let Some(directions) = self.task.directions {
                for (&a, &b) in a.iter().zip(b) {
                    measure([a, b], &mut self.supports, directions);
                }
            }
        }
        let [of_a, of_b] = places;
        let new = self.hits_a.insert_places(first[0], &of_a);
        self.tell(Side::A, first[0], &new)?;
        let new = self.hits_b.insert_places(first[1], &of_b);
        self.tell(Side::B, first[1], &new)
    }

    /// Reports new hits to the sink.
    #[inline(always)]
    fn tell(&mut self, side: Side, first: u32, new: &Places) -> ControlFlow<Halt> {
        let (zones, of) = match side {
            Side::A => (&mut self.zones_a, self.task.a.zones),
            Side::B => (&mut self.zones_b, self.task.b.zones),
        };
        for (word, mut bits) in (0..).zip(new.words()) {
            while bits != 0 {
                let triangle = first + u64::BITS * word + bits.trailing_zeros();
                *zones |= of[triangle as usize].0;
                self.sink.hit(side, triangle).map_break(|()| Halt::Stopped)?;
                bits &= bits - 1;
            }
        }
        ControlFlow::Continue(())
    }
}
