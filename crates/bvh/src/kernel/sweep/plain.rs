//! The plain walk: two boxes at a time, in f64. It documents the algorithm.
//!
//! It takes the pair of nodes that may touch first, opens the larger one, and keeps the children
//! that may touch within the motion; where two leaves meet, every pair of their triangles is
//! decided.

use super::{OpenPair, Search};
use crate::descent::{Descent, side_to_open};
use crate::placement::Passage;
use crate::{End, NodePair, Side};
use geometry::patch::down;
use std::ops::ControlFlow;

/// Walks everything below `start`; what is not done at the end is left in the frontier.
pub(super) fn walk(start: NodePair, search: &mut Search<'_, '_>) -> End {
    let task = search.task;
    let descent = Descent::new(&task.a, &task.b, &task.pose);
    let passage = Passage::new(&descent.placement, &task.sweep);
    let first_of = |pair: NodePair| {
        let (a, b) = descent.nodes(pair);
        let placement = &descent.placement;
        passage.travels(placement, &placement.box_a(&a.bounds), &placement.box_b(&b.bounds))
    };
    let keep = |pair: NodePair, search: &mut Search<'_, '_>| {
        search.counters.nb += 1;
        if let Some([first_m, _]) = first_of(pair)
            && first_m <= search.limit_m()
        {
            search.frontier.push(OpenPair { pair, from_m: down(first_m) });
        }
    };
    keep(start, search);
    loop {
        let pair = match search.next() {
            ControlFlow::Continue(open) => open.pair,
            ControlFlow::Break(end) => return end,
        };
        let (a, b) = descent.nodes(pair);
        let stacked = search.frontier.stacked();
        match side_to_open(a, a.is_leaf(), b, b.is_leaf()) {
            Some(Side::A) => {
                keep(NodePair { a: pair.a + 1, ..pair }, search);
                keep(NodePair { a: a.link, ..pair }, search);
            }
            Some(Side::B) => {
                keep(NodePair { b: pair.b + 1, ..pair }, search);
                keep(NodePair { b: b.link, ..pair }, search);
            }
            None => {
                for of_a in a.link..a.link + a.count {
                    for of_b in b.link..b.link + b.count {
                        search.counters.np += 1;
                        search.test([of_a, of_b]);
                    }
                }
            }
        }
        search.frontier.sort_stack(stacked);
    }
}
