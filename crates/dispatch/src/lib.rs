//! Who works on what: schemes, leases, the transfer ledger and supervision.
//!
//! A state machine: events in (time, result, death, silence), effects out (send, kill). It owns no
//! clock, no thread and no channel, so the live coordinator and a simulator drive the same code. It
//! asks a small trait, [`JobSource`], for jobs and hands it what they found; it does not know what a
//! triangle or a harm is.
//!
//! # Invariants
//!
//! - A job is executed at least once and closed exactly once, whatever is lost, late or repeated:
//!   `dispatcher/tests.rs`.
//! - Only eligible cores get jobs, so no queue ever overflows: same tests.
//! - No core holds more sections than it may, and the ledger equals its recomputation from the log:
//!   `ledger/tests.rs`, `dispatcher/tests.rs`.
//! - A worker is killed for what it did, a job abandoned for what it did, and neither for what
//!   others did: `dispatcher/tests/faults.rs`. A crash loop ends: `restart.rs`.
//! - Nothing here depends on a hash order or reads a clock, so equal events at equal times give
//!   equal effects.

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
pub use supervise::{Liveness, Patience, Pulse, Watch};
