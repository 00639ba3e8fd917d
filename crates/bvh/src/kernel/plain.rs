//! The plain walk: two boxes at a time, two triangles at a time. It documents the algorithm.
//!
//! It pops a pair of nodes, opens the larger one, and keeps the children whose boxes overlap; where
//! two leaves meet, their triangles are tested. Ericson, *Real-Time Collision Detection* (2005),
//! section 6.3. Triangles that do not reach the other leaf's box are left out first, so that most
//! pairs of leaves cost a few box tests; each triangle of B is moved into A's frame once per pair
//! of leaves.

use super::End;
use super::found::{Found, Halt, Sums};
use crate::NodePair;
use crate::descent::{Descent, side_to_open};
use body::Node;
use geometry::{Bounds, Corners, DVec3, Triangle, triangle};
use std::ops::{ControlFlow, Range};

/// Maximum number of triangles of A that are processed together; a larger leaf is split.
const BATCH: usize = 64;

/// A triangle of A that reaches the box of B's leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    triangle: Triangle,
    bounds: Bounds,
    number: u32,
}

/// Allocates scratch for one batch.
pub(super) fn scratch() -> Vec<Near> {
    Vec::with_capacity(BATCH)
}

/// Walks everything below the pairs on the stack; what is not done at the end is left there.
///
/// The stack never exceeds `room`: a step pops one pair and pushes at most two, one level deeper in
/// one tree, so at most one pair waits per level of both trees, plus one.
pub(super) fn walk(
    stack: &mut Vec<NodePair>,
    room: usize,
    budget: u64,
    near: &mut Vec<Near>,
    found: &mut Found<'_>,
) -> End {
    let task = found.task;
    let descent = Descent::new(&task.a, &task.b, &task.pose);
    let mut leaves = Leaves { near, found };
    while let Some(&pair) = stack.last() {
        if leaves.found.spent() >= budget {
            return End::OutOfBudget;
        }
        if leaves.found.beat().is_break() {
            return End::Stopped;
        }
        let (node_a, node_b) = descent.nodes(pair);
        let Some(side) = side_to_open(node_a, node_a.is_leaf(), node_b, node_b.is_leaf()) else {
            match leaves.test(node_a, node_b) {
                ControlFlow::Continue(()) => _ = stack.pop(),
                ControlFlow::Break(Halt::Answered) => stack.clear(),
                ControlFlow::Break(Halt::Stopped) => return End::Stopped,
            }
            continue;
        };
        if stack.len() >= room {
            return End::OutOfBudget;
        }
        stack.pop();
        descent.open(pair, side, &mut leaves.found.counters, |pair| stack.push(pair));
    }
    End::Complete
}

/// A pair of leaves whose boxes overlap.
struct Leaves<'l, 'a> {
    near: &'l mut Vec<Near>,
    found: &'l mut Found<'a>,
}

impl Leaves<'_, '_> {
    /// Tests all triangles of one leaf of A against all of one leaf of B.
    fn test(&mut self, leaf_a: &Node, leaf_b: &Node) -> ControlFlow<Halt> {
        let before: Sums = self.found.sums;
        let tested = self.test_batches(leaf_a, leaf_b);
        if tested == ControlFlow::Break(Halt::Stopped) {
            self.found.sums = before;
        }
        tested
    }

    fn test_batches(&mut self, leaf_a: &Node, leaf_b: &Node) -> ControlFlow<Halt> {
        if self.found.is_beaten(leaf_a.link, leaf_a.count) {
            return ControlFlow::Continue(());
        }
        let box_a = leaf_a.bounds.bounds();
        let box_b = self.found.task.pose.bounds(&leaf_b.bounds);
        let end = leaf_a.link + leaf_a.count;
        for start in (leaf_a.link..end).step_by(BATCH) {
            self.gather(start..end.min(start + BATCH as u32), &box_b);
            if self.near.is_empty() {
                continue;
            }
            for number in leaf_b.link..leaf_b.link + leaf_b.count {
                self.found.beat()?;
                self.test_one(number, &box_a)?;
            }
        }
        ControlFlow::Continue(())
    }

    /// Collects the triangles of A that reach `box_b`, the box of B's leaf in A's frame.
    fn gather(&mut self, batch: Range<u32>, box_b: &Bounds) {
        self.near.clear();
        self.found.counters.nb += u64::from(batch.end - batch.start);
        for number in batch {
            let triangle = stored(&self.found.task.a.corners[number as usize]);
            let bounds = triangle.bounds();
            if bounds.overlaps(box_b) {
                self.near.push(Near { triangle, bounds, number });
            }
        }
    }

    /// Tests triangle `b` of B against the gathered ones of A, whose leaf has the box `box_a`.
    fn test_one(&mut self, b: u32, box_a: &Bounds) -> ControlFlow<Halt> {
        let task = self.found.task;
        let moved = task.pose.triangle(&task.b.corners[b as usize]);
        let bounds = moved.bounds();
        self.found.counters.nb += 1;
        if !bounds.overlaps(box_a) {
            return ControlFlow::Continue(());
        }
        self.found.counters.nb += self.near.len() as u64;
        for Near { triangle, bounds: bounds_a, number: a } in self.near.iter() {
            if !bounds_a.overlaps(&bounds) || self.found.known(*a, b) {
                continue;
            }
            self.found.counters.np += 1;
            if triangle::intersect(triangle, &moved) {
                self.found.take([&[*a], &[b]], [*a, b], |_, supports, directions| {
                    for point in triangle::contact(triangle, &moved).points() {
                        supports.add(directions, *point);
                    }
                })?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// A stored triangle of A, which is already in A's frame; f64 holds f32 exactly.
fn stored(corners: &Corners) -> Triangle {
    Triangle(corners.map(|corner| DVec3::from_array(corner.map(f64::from))))
}
