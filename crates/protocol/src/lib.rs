//! Plain-data messages between the processes, and the ids used in them.
//!
//! Every message is a slice of 64-bit words after a 64-byte [`Head`]; the words are defined by
//! [`job`] and [`chunk`] (coordinator to worker) and [`result`] (worker to coordinator). The
//! [`status`] page is the only data that both sides may read while it changes. [`public`] defines
//! what clients exchange with the service.
//!
//! # Invariants
//!
//! - Every bit pattern of a message is a value: no padding, no `bool`, no `enum`, no pointer. A
//!   misbehaving peer can at worst send a wrong value, and [`Head::accept`] rejects it.
//! - Layouts are pinned by assertions beside the types; [`LAYOUT`] names them all.
//! - Layouts are the same with and without the feature `faults`: without it, the words of fault
//!   commands exist but are not read.
//! - This crate does no I/O and reads no clock. It does not know about triangles.

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
pub use job::{WireJob, WireLook, WireQuestion, WireTask};
pub use launch::Launch;
pub use result::{Summary, WireSide};
pub use status::{CoordinatorLine, StatusPage, WorkerLine, WorkerState};

/// Version of all layouts of this crate: part of every header and of every service's attributes.
pub const LAYOUT: u32 = 3;

/// Maximum number of workers on the status page.
pub const WORKERS_MAX: usize = 16;
