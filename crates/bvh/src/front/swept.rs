//! The front of a body that moves: pairs of nodes in the order in which they may touch first,
//! opened down to the distribution depth one by one, so that what cannot matter is never opened.

use super::NodePair;
use crate::descent::{Descent, side_to_open};
use crate::kernel::sweep::{OpenPair, SweepTask};
use crate::placement::Passage;
use crate::{Counters, Side};
use geometry::patch::down;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// When pairs of nodes may touch first, for one motion.
#[derive(Debug)]
pub struct SweepBounds<'a> {
    descent: Descent<'a>,
    passage: Passage,
    to_m: f64,
}

impl<'a> SweepBounds<'a> {
    /// The bounds for a task.
    #[must_use]
    pub fn new(task: &SweepTask<'a>) -> Self {
        let descent = Descent::new(&task.a, &task.b, &task.pose);
        let passage = Passage::new(&descent.placement, &task.sweep);
        Self { descent, passage, to_m: task.sweep.to_m() }
    }

    /// The travel before which nothing below both nodes touches, rounded down (m); `None` if
    /// nothing does within the motion. One test.
    ///
    /// # Panics
    ///
    /// A node does not exist.
    #[must_use]
    pub fn first_m(&self, pair: NodePair) -> Option<f32> {
        let (a, b) = self.descent.nodes(pair);
        let placement = &self.descent.placement;
        let boxes = (placement.box_a(&a.bounds), placement.box_b(&b.bounds));
        let [first, _] = self.passage.travels(placement, &boxes.0, &boxes.1)?;
        (first <= self.to_m).then(|| down(first))
    }
}

/// A pair that waits, with the depths of its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Waiting {
    open: OpenPair,
    depths: [u32; 2],
}

impl Eq for Waiting {}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let order = other.open.from_m.total_cmp(&self.open.from_m);
        order.then_with(|| other.open.pair.cmp(&self.open.pair))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Pairs of nodes that wait, the earliest first.
#[derive(Clone, Debug, Default)]
pub struct SweptFront {
    waiting: BinaryHeap<Waiting>,
}

/// The depth of a pair that is not opened any further.
const DEEP: u32 = u32::MAX;

impl SweptFront {
    /// Removes all pairs, and keeps the memory.
    pub fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Begins with the roots, if they may touch within the motion.
    pub fn begin(&mut self, bounds: &SweepBounds<'_>, counters: &mut Counters) {
        self.clear();
        counters.nb += 1;
        let exist = !bounds.descent.nodes_a.is_empty() && !bounds.descent.nodes_b.is_empty();
        if let Some(from_m) = exist.then(|| bounds.first_m(NodePair::ROOTS)).flatten() {
            let open = OpenPair { pair: NodePair::ROOTS, from_m };
            self.waiting.push(Waiting { open, depths: [0, 0] });
        }
    }

    /// Adds a pair that is handed out as it is.
    pub fn push(&mut self, open: OpenPair) {
        self.waiting.push(Waiting { open, depths: [DEEP; 2] });
    }

    /// The next pair of nodes at `depth`, or of shallower leaves; `None` if there is none that may
    /// touch up to `limit_m`.
    pub fn next(
        &mut self,
        bounds: &SweepBounds<'_>,
        depth: u32,
        limit_m: f64,
        counters: &mut Counters,
    ) -> Option<OpenPair> {
        while let Some(Waiting { open, depths }) = self.waiting.pop() {
            if f64::from(open.from_m) > limit_m {
                self.waiting.clear();
                return None;
            }
            let (a, b) = bounds.descent.nodes(open.pair);
            let (ends_a, ends_b) =
                (a.is_leaf() || depths[0] >= depth, b.is_leaf() || depths[1] >= depth);
            let full = self.waiting.len() + 2 > super::PAIRS_MAX;
            let Some(side) = side_to_open(a, ends_a || full, b, ends_b || full) else {
                return Some(open);
            };
            let NodePair { a: of_a, b: of_b } = open.pair;
            let (children, depths) = match side {
                Side::A => (
                    [a.link, of_a + 1].map(|a| NodePair { a, b: of_b }),
                    [depths[0] + 1, depths[1]],
                ),
                Side::B => (
                    [b.link, of_b + 1].map(|b| NodePair { a: of_a, b }),
                    [depths[0], depths[1] + 1],
                ),
            };
            counters.nb += 2;
            for pair in children {
                let Some(from_m) = bounds.first_m(pair) else { continue };
                // Bounds only narrow on the way down.
                let from_m = from_m.max(open.from_m);
                if f64::from(from_m) <= limit_m {
                    self.waiting.push(Waiting { open: OpenPair { pair, from_m }, depths });
                }
            }
        }
        None
    }

    /// The travel before which nothing that waits touches (m); `None` if nothing waits.
    #[must_use]
    pub fn first_m(&self) -> Option<f32> {
        self.waiting.peek().map(|waiting| waiting.open.from_m)
    }

    /// Drops what begins after a travel (m), if all does.
    pub fn drop_after(&mut self, limit_m: f64) {
        if self.first_m().is_some_and(|first| f64::from(first) > limit_m) {
            self.waiting.clear();
        }
    }

    /// Number of pairs that wait.
    #[must_use]
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The pairs that wait, in no particular order.
    pub fn iter(&self) -> impl Iterator<Item = OpenPair> + '_ {
        self.waiting.iter().map(|waiting| waiting.open)
    }
}
