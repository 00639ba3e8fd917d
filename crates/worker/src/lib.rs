//! The worker process: takes jobs, intersects triangles, returns hits.
//!
//! ```text
//! job channel --batch--> for each job: executor over the sealed models --hits--> result channel
//!                        status line: beat, started job, credits
//! ```
//!
//! # Invariants
//!
//! - A worker keeps nothing between batches but scratch memory, and copies of sections where it is
//!   told to copy: a new incarnation needs no history.
//! - Hits are written straight into shared memory. A result is loaned only when the coordinator has
//!   room for it (credits), so no send can fail for a full queue.
//! - A panic in a job costs that job, not the worker: it answers with a NACK.
//! - A batch is answered, whatever it holds: `answered` moves past one that was turned away, too.
//!
//! With the feature `faults` a worker that is started for it misbehaves on order.
//!
//! It does not know candidates, requests or harm, and it never parses a mesh.

mod answer;
mod copy;
#[cfg(feature = "faults")]
mod fault;
mod serve;

pub use serve::{WorkerError, run};
