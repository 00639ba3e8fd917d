//! Until when nothing touches in an interval: found without dividing it.
//!
//! Halving an interval excludes what it must, but slowly where bodies pass each other closely: each
//! part is as short as the gap is wide. Where motion is straight, the time at which boxes of nodes,
//! and then triangles, come near each other follows from their chords
//! ([`geometry::motion::NearSpans`]). So one descent, the nearest pair first, finds a time before
//! which nothing is near. Nothing that a short interval would call open is left out: that comes
//! within the resolution, and a quarter more counts as near. So the answer is the same bits.

use super::{First, Frame, Search, children};
use crate::NodePair;
use crate::descent::side_to_open;
use body::Node;
use geometry::motion::{NearSpans, TimeInterval};
use std::ops::ControlFlow;

/// How near counts, in resolutions.
const NEAR: f64 = 1.25;

/// Motion is straight if nothing is off its chord by more than this many resolutions. Where bodies
/// turn, chords are good only in intervals so short that halving them takes less: with a whole
/// resolution, contacts of cars that turn took 8 to 24 % more instructions.
const OFF_CHORD: f64 = 1e-3;

/// Of shorter travels, in resolutions, nothing is sought: few halvings are left.
const TRAVELS: f64 = 64.0;

/// After it was sought in an interval, it is so again in parts that are this much shorter.
const SHORTER: f64 = 4.0;

/// Maximum number of tests for one interval.
const TESTS_MAX: u64 = 1 << 16;

impl Frame {
    /// Whether it is worth while to seek until when nothing touches in it.
    pub(super) fn may_be_clear(&self, resolution_m: f64) -> bool {
        let [margin_a, margin_b] = self.interval.margins_m();
        margin_a.max(margin_b) <= OFF_CHORD * resolution_m
            && self.interval.travel_m() >= TRAVELS * resolution_m
            && self.interval.lasts_s() * SHORTER <= self.sought_s
    }
}

impl Search<'_, '_> {
    /// A time in an interval before which nothing touches of what these pairs hold, by their
    /// positions; `None`: all of it is clear.
    pub(super) fn clear_until_s(
        &mut self,
        interval: &TimeInterval,
        [from, to]: [usize; 2],
    ) -> ControlFlow<First, Option<f64>> {
        let spans = interval.near_spans(NEAR * self.task.resolution_m);
        let begun = self.counters.tests();
        let mut first = f64::INFINITY;
        for at in from..to {
            self.kernel.nearing.clear();
            self.near(&spans, self.kernel.pairs[at], first);
            while let Some((share, pair)) = self.kernel.nearing.pop() {
                self.check_budget(interval)?;
                if self.counters.tests() - begun > TESTS_MAX {
                    return ControlFlow::Continue(Some(interval.from_s));
                }
                if share >= first {
                    continue;
                }
                let (a, b) = self.nodes(pair);
                match side_to_open(a, a.is_leaf(), b, b.is_leaf()) {
                    Some(side) => self.open_near(&spans, children(pair, side, (a, b)), first),
                    None => first = self.first_near((interval, &spans), (a, b), first),
                }
            }
        }
        ControlFlow::Continue(first.is_finite().then(|| interval.time_s(first)))
    }

    /// Keeps a pair that is near before a share.
    fn near(&mut self, spans: &NearSpans, pair: NodePair, before: f64) {
        let (a, b) = self.nodes(pair);
        self.counters.nb += 1;
        if let Some(span) = spans.of_boxes(&a.bounds, &b.bounds)
            && span.from < before
        {
            self.kernel.nearing.push((span.from, pair));
        }
    }

    /// Keeps the children of a pair, as far as they are near before a share; the one that is so
    /// first ends up on top.
    fn open_near(&mut self, spans: &NearSpans, children: [NodePair; 2], before: f64) {
        let at = self.kernel.nearing.len();
        for child in children {
            self.near(spans, child, before);
        }
        if let [next, last] = &mut self.kernel.nearing[at..]
            && next.0 < last.0
        {
            core::mem::swap(next, last);
        }
    }

    /// The first share at which triangles of two leaves are near, if that is before another.
    fn first_near(
        &mut self,
        (interval, spans): (&TimeInterval, &NearSpans),
        (a, b): (&Node, &Node),
        mut first: f64,
    ) -> f64 {
        let task = self.task;
        for of_b in b.link..b.link + b.count {
            let corners_b = &task.b.corners[of_b as usize];
            let moved = interval.moved_b(corners_b);
            for of_a in a.link..a.link + a.count {
                self.counters.np += 1;
                let corners_a = &task.a.corners[of_a as usize];
                let pair = (corners_a, corners_b);
                if let Some(span) = spans.of_triangles(interval, pair, &moved, first) {
                    first = first.min(span.from);
                }
            }
        }
        first
    }
}
