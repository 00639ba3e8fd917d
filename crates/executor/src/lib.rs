//! Executes one job of a task: the same code in a worker and in the coordinator's own process.
//!
//! ```text
//! protocol::WireTask + bodies by number --> bvh::Task --Kernel::run--> hits: to the caller's sink
//!                                                                  rest: Summary, supports, pairs
//! protocol::WireLook + bodies + paths --> encounter::Look --Encounters::look--> LookOutcome
//! ```
//!
//! # Invariants
//!
//! - A task or job that names a body, a node or a question that does not exist is rejected before
//!   anything is tested: `tests.rs`.
//! - What a job finds depends only on the task, the bodies and the job, not on earlier jobs:
//!   `tests.rs`.
//!
//! It does not know where hits go, who made the request, or what time it is.

pub mod encounter;
pub mod motion;

use body::{BodyView, Meta};
use bvh::{Kernel, NodePair, Outcome, Question, Sink, kernel};
use geometry::{Directions, RelativePose};
use protocol::result::{SUPPORTS, WireEnd};
use protocol::{Summary, WireSide, WireTask};

/// Scratch for jobs, and values prepared for the current task. Kept across jobs and requests; it
/// allocates nothing while bodies are no larger than before.
#[derive(Debug)]
pub struct Executor {
    kernel: Kernel,
    /// Number of triangles of a body for which there is capacity.
    triangles: usize,
    prepared: Option<Prepared>,
}

/// The directions of a task, shared by its jobs.
#[derive(Debug)]
struct Prepared {
    /// The bits of the two vectors from which they were computed. Task numbers would not do:
    /// different requests use the same ones.
    of: [[u64; 3]; 2],
    directions: Directions,
}

/// Part of a task: everything below a pair of nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobInput {
    /// Where it starts.
    pub start: NodePair,
    /// Maximum number of box and triangle tests.
    pub budget: u64,
}

/// The result of a job, apart from the hits that went to the sink.
#[derive(Clone, Copy, Debug)]
pub struct Done {
    outcome: Outcome,
    rest: usize,
    has_supports: bool,
}

/// Why a job has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotDone {
    /// It names a body, a node or a question that does not exist.
    Unknown,
    /// The sink stopped the job.
    Stopped,
}

/// Encodes a hit for the wire.
#[must_use]
pub const fn hit(side: bvh::Side, triangle: u32) -> u32 {
    let side = match side {
        bvh::Side::A => WireSide::A,
        bvh::Side::B => WireSide::B,
    };
    protocol::result::hit(side, triangle)
}

impl Executor {
    /// Creates an executor with capacity for jobs of these bodies.
    #[must_use]
    pub fn with_room_for(bodies: &[(Meta, BodyView<'_>)]) -> Self {
        let (depth, triangles) = extent(bodies);
        let kernel = Kernel::with_room(depth, depth, triangles, triangles);
        Self { kernel, triangles, prepared: None }
    }

    /// Ensures capacity for jobs of other bodies; allocates only if these are larger.
    pub fn make_room_for(&mut self, bodies: &[(Meta, BodyView<'_>)]) {
        let (depth, triangles) = extent(bodies);
        self.triangles = self.triangles.max(triangles);
        self.kernel.ensure_room(depth, depth, self.triangles, self.triangles);
    }

    /// Executes a job; `body` looks up the bodies that its task names.
    ///
    /// # Errors
    ///
    /// The job names something that does not exist, or the sink stopped it.
    pub fn execute<'b>(
        &mut self,
        task: &WireTask,
        body: impl Fn(u32) -> Option<BodyView<'b>>,
        job: JobInput,
        sink: &mut dyn Sink,
    ) -> Result<Done, NotDone> {
        let question =
            protocol::WireQuestion::from_number(task.question).ok_or(NotDone::Unknown)?;
        let a = body(task.model_a).ok_or(NotDone::Unknown)?;
        let b = body(task.model_b).ok_or(NotDone::Unknown)?;
        let JobInput { start, budget } = job;
        if start.a as usize >= a.nodes.len() || start.b as usize >= b.nodes.len() {
            return Err(NotDone::Unknown);
        }
        let pose = RelativePose { rotation: task.rotation, translation: task.translation };
        let triangles = a.corners.len().max(b.corners.len());
        if triangles > self.triangles {
            self.triangles = triangles;
            self.kernel.ensure_room(0, 0, triangles, triangles);
        }
        let (question, directions) = match question {
            // It has no nodes: see `encounter`.
            protocol::WireQuestion::Look => return Err(NotDone::Unknown),
            protocol::WireQuestion::Touches => (Question::Touches, None),
            protocol::WireQuestion::Sets => (Question::Sets, None),
            protocol::WireQuestion::Pairs => {
                (Question::Pairs, directions(&mut self.prepared, task))
            }
        };
        let has_supports = directions.is_some();
        let asked = bvh::Task { a, b, pose, question, directions };
        let outcome = self.kernel.run(&asked, start, kernel::within(budget), sink);
        if outcome.end == bvh::End::Stopped {
            return Err(NotDone::Stopped);
        }
        Ok(Done { outcome, rest: self.rest().len(), has_supports })
    }

    /// The pairs of nodes that the last completed job left open: none unless it ran out of budget.
    #[must_use]
    pub fn rest(&self) -> &[NodePair] {
        self.kernel.remaining()
    }
}

/// The largest depth and number of triangles.
fn extent(bodies: &[(Meta, BodyView<'_>)]) -> (u32, usize) {
    let depth = bodies.iter().map(|(meta, _)| meta.depth).max().unwrap_or(1);
    (depth, bodies.iter().map(|(_, body)| body.corners.len()).max().unwrap_or(0))
}

/// The directions of a task: computed once for consecutive jobs of it.
fn directions<'p>(prepared: &'p mut Option<Prepared>, task: &WireTask) -> Option<&'p Directions> {
    let of = [task.u, task.z].map(|vector| vector.map(f64::to_bits));
    if prepared.as_ref().is_none_or(|made| made.of != of) {
        let directions = Directions::around(task.u.into(), task.z.into());
        *prepared = Some(Prepared { of, directions });
    }
    prepared.as_ref().map(|made| &made.directions)
}

impl Done {
    /// The summary of the job; the sink knows how many hits it took, the caller how long it ran.
    #[must_use]
    pub fn summary(&self, hits: u32, wall_ns: u64) -> Summary {
        let outcome = &self.outcome;
        let end = match outcome.end {
            bvh::End::Complete => WireEnd::Complete,
            bvh::End::Stopped | bvh::End::OutOfBudget => WireEnd::OutOfBudget,
        };
        Summary {
            nb: outcome.counters.nb,
            np: outcome.counters.np,
            pairs: outcome.pairs,
            hash: outcome.hash,
            wall_ns,
            zones_a: outcome.zones_a,
            zones_b: outcome.zones_b,
            end: end as u32,
            hits,
            rest: self.rest as u64,
            ..Summary::default()
        }
    }

    /// Supports of the contact, for a question about pairs.
    #[must_use]
    pub fn supports(&self) -> Option<&[f64; SUPPORTS]> {
        self.has_supports.then_some(&self.outcome.supports.0)
    }
}

#[cfg(test)]
mod tests;
