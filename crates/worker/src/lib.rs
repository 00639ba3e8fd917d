//! The worker process: takes jobs, intersects triangles, returns hits.
//!
//! ```text
//! job channel --batch--> for each job: executor over the sealed models --hits--> result channel
//!                        status line: beat, started job, credits
//! ```
//!
//! # Invariants
//!
//! - A worker keeps nothing between batches but scratch memory and, where it is told to copy,
//!   copies of sections: a new incarnation needs no history.
//! - Hits are written straight into shared memory. A result is loaned only when the coordinator has
//!   capacity for it (credits), so no send can fail because of a full queue.
//! - A panic in a job costs that job, not the worker: it answers with a NACK.
//! - Every batch is answered: `answered` moves past rejected batches too.
//!
//! With the feature `faults`, a worker started for it obeys fault commands.
//!
//! It does not know candidates, requests or harm, and it never parses a mesh.

mod answer;
mod call;
mod copy;
#[cfg(feature = "faults")]
mod fault;
mod look;
mod serve;

pub use serve::{WorkerError, run};
