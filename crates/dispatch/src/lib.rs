//! Work distribution: schemes, leases, the transfer ledger and supervision.
//!
//! A state machine: events in (time, result, death, silence), effects out (send, kill). It owns no
//! clock, thread or channel, so the live coordinator and a simulator run the same code. A small
//! trait, [`JobSource`], supplies jobs and takes their results; this crate does not know about
//! triangles or harm.
//!
//! # Invariants
//!
//! - A job is executed at least once and closed exactly once, whatever is lost, late or repeated:
//!   `dispatcher/tests.rs`.
//! - Only eligible cores get jobs, so no queue ever overflows: same tests.
//! - No core holds more sections than its capacity, and the ledger equals its recomputation from
//!   the log: `cache_model/tests.rs`, `dispatcher/tests.rs`.
//! - A worker is killed, or a job abandoned, only for its own faults, never for those of others:
//!   `dispatcher/tests/faults.rs`. A crash loop ends: `restart.rs`.
//! - Nothing here depends on hash order or reads a clock, so equal events at equal times give equal
//!   effects.

mod cache_model;
mod dispatcher;
mod quarantine;
mod restart;
mod scheme;
mod supervise;

pub use cache_model::{Cache, CacheModel, Thrash, Transfer};
#[cfg(feature = "faults")]
pub use dispatcher::DispatcherFlaw;
pub use dispatcher::{
    Closed, Counts, Dispatcher, Effect, Event, Fence, Job, JobSource, LogEntry, Progress, Queues,
    Why,
};
pub use restart::{Intensity, Leave, Restarts};
pub use scheme::{
    BestMatchLoad, CoreView, LowestMatch, MatchScheme, Matching, RandomMatch, RoundRobin,
};
pub use supervise::{Liveness, Patience, Pulse, StartPatience, StartPulse, StartWatch, Watch};
