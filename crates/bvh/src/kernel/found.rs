//! What a job has found so far, and where its hits go: the same for every walk.

use super::{End, Outcome, Question, Side, Sink, Task};
use crate::Counters;
use crate::hits::Hits;
use fearless_simd::Simd;
use geometry::patch::Places;
use geometry::simd::prefetch;
use geometry::{Directions, Supports, hash};
use std::ops::ControlFlow;

/// Most tests between two calls of [`Sink::beat`], but for those of one step of the walk.
pub const BEAT_TESTS: u64 = 1024;

/// What it costs to take in a pair that intersects, with its contact measured along all directions,
/// in tests: a budget is of time, and where everything meets hits take most of it.
const PAIR_TESTS: u64 = 24;

/// Why a job ends before everything is tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Halt {
    /// The question is answered, whatever else there is.
    Answered,
    /// The sink said stop: what was tested last is open again.
    Stopped,
}

/// The sums of a job, in which nothing may count twice.
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
    /// Should the sink say stop, what belongs together is tested again by somebody else: then the
    /// sums go back to what they were before. Sets, zones and supports need not.
    pub(super) sums: Sums,
    sink: &'a mut dyn Sink,
    /// Tests at which the sink hears from us next.
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
            sink,
            beat_at: BEAT_TESTS,
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
            pairs: self.sums.pairs,
            hash: self.sums.hash,
            zones_a: self.zones_a,
            zones_b: self.zones_b,
            supports,
        }
    }

    /// What was spent of a budget: all tests, and what hits cost besides.
    #[inline]
    pub(super) fn spent(&self) -> u64 {
        self.counters.tests() + PAIR_TESTS * self.sums.pairs
    }

    /// Tells the sink how far we are, if it is time.
    #[inline]
    pub(super) fn beat(&mut self) -> ControlFlow<Halt> {
        let tests = self.counters.tests();
        if tests < self.beat_at {
            return ControlFlow::Continue(());
        }
        self.beat_at = tests + BEAT_TESTS;
        self.sink.beat(tests).map_break(|()| Halt::Stopped)
    }

    /// Whether the pair cannot add to what is asked.
    #[inline]
    pub(super) fn known(&self, a: u32, b: u32) -> bool {
        self.task.question == Question::Sets && self.hits_a.has(a) && self.hits_b.has(b)
    }

    /// Hears which triangles of A and of B will be tested, each body's in ascending order. What is
    /// written down of hits, ids and zones, is on its way from now on: between here and
    /// [`Found::take`] is time for it to come from memory.
    #[inline(always)]
    pub(super) fn await_hits<S: Simd>(&self, simd: S, [a, b]: [&[u32]; 2]) {
        for (view, triangles) in [(&self.task.a, a), (&self.task.b, b)] {
            // A line of the cache holds 16 ids, 32 zones.
            for some in triangles.chunks(8) {
                prefetch(simd, view.source_ids, some[0] as usize);
                prefetch(simd, view.source_ids, some[some.len() - 1] as usize);
                prefetch(simd, view.zones, some[0] as usize);
            }
        }
    }

    /// Takes in that these triangles of A intersect those of B in the same places.
    ///
    /// Those of either body are in [`Places`] counted from number `first` on. `measure` adds the
    /// contact of a pair to the supports; it is called only where that is asked.
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
            // The question is answered, whether or not the sink wants more.
            let _ = (self.sink.hit(Side::A, a[0]), self.sink.hit(Side::B, b[0]));
            return ControlFlow::Break(Halt::Answered);
        }
        let is_pairs = self.task.question == Question::Pairs;
        if is_pairs {
            // All at once: who lists them is rare, and who does not is asked once.
            self.sink.pairs(a, b).map_break(|()| Halt::Stopped)?;
        }
        let (view_a, view_b) = (&self.task.a, &self.task.b);
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

    /// Tells the sink of new hits.
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
