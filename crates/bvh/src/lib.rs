//! Bounding volume hierarchies over triangles, and which triangles of two bodies intersect.
//!
//! ```text
//! triangles --Tree::build--> Tree --query--> pairs, sets, touches
//! ```
//!
//! For plain triangles this is all that is needed: see the example in [`query`]. A [`body::Body`]
//! has such a tree together with its mass, parts and zones. A task on two bodies can be split into
//! jobs, for several threads ([`parallel`]) or for worker processes under a coordinator:
//!
//! ```text
//! Mesh --build::body--> Body        front::front: both trees down to the distribution depth
//! Body --build::rebuild--> Body       |  overlapping node pairs, one job each
//!                                     v
//! section: what a job needs         kernel::Kernel::run: one job, to hits, sums and supports
//! ```
//!
//! The method is that of Wiseman and Grinberg, *The Trolley Problem Version of Autonomous Vehicles*
//! (Open Transp. J. 12, 2018): hierarchies of axis-aligned boxes with a split that keeps the parts
//! short, descended to a distribution depth, the overlapping pairs handed to several cores.
//!
//! This crate does no I/O, reads no clock, and does not know about harm or about who runs a job.
//!
//! # Invariants
//!
//! - A tree is a pure function of triangles, build and leaf size, independent of the number of
//!   threads: `build/tests.rs`.
//! - No intersecting pair is lost by a box test: `placement/tests.rs`.
//! - Each pair of triangles is in at most one job of a front, each intersecting pair in exactly
//!   one: `front/tests.rs`.
//! - Hit sets, pairs, their count and hash, zones and supports do not depend on tree, build, depth
//!   or leaf size, nor on where a budget cuts a job: `kernel/tests.rs`, `query/tests.rs`.
//! - Whether a body lies inside a closed one is exact: `query/containment/tests.rs`.
//! - Nothing recurses, and [`kernel::Kernel::run`] allocates nothing.

pub mod build;
pub mod front;
pub mod kernel;
pub mod parallel;
pub mod placement;
pub mod query;
pub mod reach;
pub mod section;
pub mod support;
pub mod tree;

mod descent;
mod float_order;
mod hits;

pub use build::{
    Build, BuildError, BuildOptions, Hierarchy, body, build, in_threads, rebuild, worth_starting,
};
pub use front::{NodePair, front, front_where};
pub use kernel::sweep::{OpenPair, SweepKernel, SweepLimits, SweepSink, SweepTask, Witness};
pub use kernel::{End, Kernel, Outcome, Question, Side, Sink, Task, Walk};
pub use placement::Placement;
pub use reach::reach;
pub use tree::Tree;

/// Work done, in the terms of the cost model T = Nb·Cb + Np·Cp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Tests of two boxes, whether of nodes or of triangles.
    pub nb: u64,
    /// Tests of two triangles.
    pub np: u64,
}

impl Counters {
    /// Tests of both kinds, which a budget bounds.
    #[must_use]
    pub fn tests(&self) -> u64 {
        self.nb + self.np
    }

    /// Adds the work of `other`.
    pub fn add(&mut self, other: &Self) {
        self.nb += other.nb;
        self.np += other.np;
    }
}

#[cfg(test)]
mod fixtures;
