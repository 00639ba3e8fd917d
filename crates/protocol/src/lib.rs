//! Plain-data messages between the processes, and the names of things in them.
//!
//! Every message is a slice of 64-bit words behind a 64-byte [`Head`]; what the words mean is said
//! by [`job`] and [`chunk`] (coordinator to worker) and [`result`] (worker to coordinator). The
//! [`status`] page is the one thing that both sides may look at while it changes. What clients of
//! the service exchange with it stands in [`public`].
//!
//! # Invariants
//!
//! - Every bit pattern of a message is a value: no padding, no `bool`, no `enum`, no pointer. What
//!   a peer scribbled is a wrong value at worst, and [`Head::accept`] turns it away.
//! - Layouts are pinned by assertions beside the types; [`LAYOUT`] names them all.
//! - Layouts are the same with and without the feature `faults`: the words of orders are there, and
//!   nobody reads them.
//! - This crate does no I/O and reads no clock. It does not know what a triangle is.

pub mod chunk;
#[cfg(feature = "faults")]
pub mod fault;
pub mod head;
pub mod id;
pub mod job;
pub mod launch;
pub mod public;
pub mod result;
pub mod status;

pub use chunk::{Array, Piece};
#[cfg(feature = "faults")]
pub use fault::{FaultCommand, InjectedFault};
pub use head::{Head, MessageKind, Reject, seal, verify};
pub use id::{Boot, Incarnation, JobId, RequestId, Section, TaskId};
pub use job::{WireJob, WireQuestion, WireTask};
pub use launch::Launch;
pub use result::{Summary, WireSide};
pub use status::{CoordinatorLine, StatusPage, WorkerLine, WorkerState};

/// Version of all layouts of this crate: part of every header and of every service's attributes.
pub const LAYOUT: u32 = 2;

/// How many workers the status page has room for.
pub const WORKERS_MAX: usize = 16;
