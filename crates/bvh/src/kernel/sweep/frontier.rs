//! The pairs of nodes that wait to be opened: the earliest first, in bounded memory.

use crate::NodePair;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Maximum number of pairs that are kept in order. More are opened depth first: a pass at a
/// millimetre along two flanks may have a hundred thousand.
const ORDERED_MAX: usize = 1 << 12;

/// A pair of nodes, and the travel before which nothing below both can touch (m).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenPair {
    /// The nodes.
    pub pair: NodePair,
    /// Rounded down.
    pub from_m: f32,
}

/// The earliest is the greatest, as the heap takes it. Those of the same travel by their nodes, so
/// that the order of tests depends on the trees alone.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ordered(OpenPair);

impl Eq for Ordered {}

impl Ord for Ordered {
    fn cmp(&self, other: &Self) -> Ordering {
        let order = other.0.from_m.total_cmp(&self.0.from_m);
        order.then_with(|| other.0.pair.cmp(&self.0.pair))
    }
}

impl PartialOrd for Ordered {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Waiting pairs. While there are more than can be kept in order, the others form a stack that goes
/// first, so that they stay few.
#[derive(Clone, Debug)]
pub(super) struct Frontier {
    ordered: BinaryHeap<Ordered>,
    stack: Vec<OpenPair>,
    room: usize,
}

impl Frontier {
    /// `room` is what a depth-first walk needs.
    pub(super) fn with_room(room: usize) -> Self {
        let ordered = BinaryHeap::with_capacity(ORDERED_MAX);
        Self { ordered, stack: Vec::with_capacity(room), room }
    }

    pub(super) fn ensure_room(&mut self, room: usize) {
        self.room = self.room.max(room);
        self.stack.reserve_exact(self.room.saturating_sub(self.stack.len()));
    }

    pub(super) fn clear(&mut self) {
        self.ordered.clear();
        self.stack.clear();
    }

    /// Whether a step, which pushes at most 64 pairs, has room.
    pub(super) fn has_room(&self) -> bool {
        self.stack.len() + super::static_wide::LANE_PAIRS <= self.room
    }

    #[inline]
    pub(super) fn push(&mut self, open: OpenPair) {
        if self.ordered.len() < ORDERED_MAX {
            self.ordered.push(Ordered(open));
        } else {
            self.stack.push(open);
        }
    }

    /// What [`Frontier::pop`] would return.
    #[inline]
    pub(super) fn peek(&self) -> Option<OpenPair> {
        self.stack.last().copied().or_else(|| self.ordered.peek().map(|ordered| ordered.0))
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<OpenPair> {
        self.stack.pop().or_else(|| self.ordered.pop().map(|ordered| ordered.0))
    }

    /// Drops pairs at the end that begin after a travel (m): of the stack those on top, of the
    /// ordered ones all if the first does.
    pub(super) fn drop_after(&mut self, limit_m: f64) {
        while self.stack.last().is_some_and(|open| f64::from(open.from_m) > limit_m) {
            self.stack.pop();
        }
        let first = self.ordered.peek();
        if first.is_some_and(|ordered| f64::from(ordered.0.from_m) > limit_m) {
            self.ordered.clear();
        }
    }

    /// Puts the pairs pushed last, from number `from` of the stack on, in order: the earliest on
    /// top.
    pub(super) fn sort_stack(&mut self, from: usize) {
        self.stack[from..].sort_unstable_by_key(|open| Ordered(*open));
    }

    /// Number of pairs on the stack.
    pub(super) fn stacked(&self) -> usize {
        self.stack.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = OpenPair> + '_ {
        self.stack.iter().copied().chain(self.ordered.iter().map(|ordered| ordered.0))
    }

    /// Changes every pair, in place: its nodes, not its travel.
    pub(super) fn rename(&mut self, mut name: impl FnMut(NodePair) -> NodePair) {
        self.stack.iter_mut().for_each(|open| open.pair = name(open.pair));
        let mut ordered = std::mem::take(&mut self.ordered).into_vec();
        ordered.iter_mut().for_each(|open| open.0.pair = name(open.0.pair));
        // Neither conversion allocates; the order is restored in linear time.
        self.ordered = BinaryHeap::from(ordered);
    }
}
