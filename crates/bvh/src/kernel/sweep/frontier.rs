//! The pairs of nodes that wait to be opened: the earliest first, in bounded memory.

use super::due::Due;
use crate::NodePair;
use std::cmp::Reverse;
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

impl OpenPair {
    /// Those of the same travel by their nodes, so that the order of tests depends on the trees
    /// alone.
    #[inline]
    fn due(self) -> Due {
        Due::new(self.from_m, [self.pair.a, self.pair.b])
    }

    #[inline]
    fn of(due: Due) -> Self {
        let [a, b] = due.numbers();
        Self { pair: NodePair { a, b }, from_m: due.travel_m() }
    }
}

/// Waiting pairs. While there are more than can be kept in order, the others form a stack that goes
/// first, so that they stay few.
#[derive(Clone, Debug)]
pub(super) struct Frontier {
    ordered: BinaryHeap<Reverse<Due>>,
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
            self.ordered.push(Reverse(open.due()));
        } else {
            self.stack.push(open);
        }
    }

    /// What [`Frontier::pop`] would return.
    #[inline]
    pub(super) fn peek(&self) -> Option<OpenPair> {
        let ordered = || self.ordered.peek().map(|Reverse(due)| OpenPair::of(*due));
        self.stack.last().copied().or_else(ordered)
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Option<OpenPair> {
        let ordered = || self.ordered.pop().map(|Reverse(due)| OpenPair::of(due));
        self.stack.pop().or_else(ordered)
    }

    /// Drops pairs at the end that begin after a travel (m): of the stack those on top, of the
    /// ordered ones all if the first does.
    pub(super) fn drop_after(&mut self, limit_m: f64) {
        while self.stack.last().is_some_and(|open| f64::from(open.from_m) > limit_m) {
            self.stack.pop();
        }
        let first = self.ordered.peek();
        if first.is_some_and(|Reverse(due)| f64::from(due.travel_m()) > limit_m) {
            self.ordered.clear();
        }
    }

    /// Puts the pairs pushed last, from number `from` of the stack on, in order: the earliest on
    /// top.
    pub(super) fn sort_stack(&mut self, from: usize) {
        self.stack[from..].sort_unstable_by_key(|open| Reverse(open.due()));
    }

    /// Number of pairs on the stack.
    pub(super) fn stacked(&self) -> usize {
        self.stack.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = OpenPair> + '_ {
        let ordered = self.ordered.iter().map(|Reverse(due)| OpenPair::of(*due));
        self.stack.iter().copied().chain(ordered)
    }

    /// Changes every pair, in place: its nodes, not its travel.
    pub(super) fn rename(&mut self, mut name: impl FnMut(NodePair) -> NodePair) {
        self.stack.iter_mut().for_each(|open| open.pair = name(open.pair));
        let mut ordered = std::mem::take(&mut self.ordered).into_vec();
        for Reverse(due) in &mut ordered {
            let open = OpenPair::of(*due);
            *due = OpenPair { pair: name(open.pair), ..open }.due();
        }
        // Neither conversion allocates; the order is restored in linear time.
        self.ordered = BinaryHeap::from(ordered);
    }
}
