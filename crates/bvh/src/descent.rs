//! One step down a pair of trees: shared by the front and by the walk of a job.

use crate::{Counters, NodePair, Placement, Side};
use body::{BodyView, Node};
use geometry::RelativePose;

/// Two trees and their relative pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent<'a> {
    pub(crate) nodes_a: &'a [Node],
    pub(crate) nodes_b: &'a [Node],
    pub(crate) placement: Placement,
}

impl<'a> Descent<'a> {
    pub(crate) fn new(a: &BodyView<'a>, b: &BodyView<'a>, pose: &RelativePose) -> Self {
        Self { nodes_a: a.nodes, nodes_b: b.nodes, placement: Placement::of(a, b, pose) }
    }

    /// The two nodes of a pair.
    #[inline]
    pub(crate) fn nodes(&self, pair: NodePair) -> (&'a Node, &'a Node) {
        (&self.nodes_a[pair.a as usize], &self.nodes_b[pair.b as usize])
    }

    /// Whether the boxes of a pair are apart: one test.
    pub(crate) fn apart(&self, pair: NodePair, counters: &mut Counters) -> bool {
        let (a, b) = self.nodes(pair);
        counters.nb += 1;
        self.placement.apart(&self.placement.box_a(&a.bounds), &self.placement.box_b(&b.bounds))
    }

    /// Opens the node of `pair` on `side`, which must not be a leaf: calls `keep` with the right
    /// pair below, then the left one, if their boxes overlap; so on a stack the left one ends up on
    /// top. Takes two tests; the box of the other side is prepared once.
    #[inline]
    pub(crate) fn open(
        &self,
        pair: NodePair,
        side: Side,
        counters: &mut Counters,
        mut keep: impl FnMut(NodePair),
    ) {
        let placement = &self.placement;
        let (node_a, node_b) = self.nodes(pair);
        counters.nb += 2;
        match side {
            Side::A => {
                let other = placement.box_b(&node_b.bounds);
                for a in [node_a.link, pair.a + 1] {
                    let own = placement.box_a(&self.nodes_a[a as usize].bounds);
                    if !placement.apart(&own, &other) {
                        keep(NodePair { a, ..pair });
                    }
                }
            }
            Side::B => {
                let other = placement.box_a(&node_a.bounds);
                for b in [node_b.link, pair.b + 1] {
                    let own = placement.box_b(&self.nodes_b[b as usize].bounds);
                    if !placement.apart(&other, &own) {
                        keep(NodePair { b, ..pair });
                    }
                }
            }
        }
    }
}

/// Which of two nodes to open: the larger one, unless it is a leaf. `None` if both are.
#[inline]
pub(crate) fn side_to_open(a: &Node, ends_a: bool, b: &Node, ends_b: bool) -> Option<Side> {
    match (ends_a, ends_b) {
        (true, true) => None,
        (true, false) => Some(Side::B),
        (false, true) => Some(Side::A),
        (false, false) if a.bounds.half_area() >= b.bounds.half_area() => Some(Side::A),
        (false, false) => Some(Side::B),
    }
}
