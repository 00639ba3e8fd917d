//! The service: answers the requests of planners, one at a time, for months.
//!
//! ```text
//! requests --RequestQueue: received at once, queued, or answered busy--> one at a time:
//!     ranker.rs: checked values --coordinator::rank_courses, by workers or in-process-->
//!     answer.rs: WireAnswer --> the client; then listeners; then the decision file
//! beside it: a thread that cleans up after dead clients and writes files
//! ```
//!
//! # Invariants
//!
//! - Whatever a client sends, it gets an answer or a refusal with a reason, and the next request is
//!   unaffected: `ask/tests.rs`, `tests/processes/serve.rs` at the top level.
//! - The ranking is that of `trolley rank` in every bit: `tests/processes/serve.rs`, over members
//!   `tests/processes/members.rs`.
//! - The queue, the pools and the files are bounded: nothing grows with the number of requests.
//! - While a request is executed, no file is written and nothing is waited for but workers.
//!
//! Whoever watches it, systemd or [`supervise`], hears from the thread that answers, also while a
//! request is worked on: `manager.rs`, `tests/processes/supervise.rs`.
//!
//! It reads no files: its caller hands over checked settings and sealed bodies.

mod answer;
mod ask;
mod backend;
mod decisions;
mod deployment;
mod footprint;
mod housekeeping;
mod in_process;
mod manager;
mod metrics;
mod ranker;
mod request_queue;
mod run;
mod stats;
mod supervisor;

pub use ask::{of_scenario, seat_number};
pub use decisions::{
    DECISION_HEAD, Decision, DecisionError, DecisionSigner, VerifiedDecisions, read_decisions,
    verify_decisions,
};
pub use deployment::{
    ClientGroup, Decisions, Deployment, DeploymentError, Idle, Metrics, Model, ModelSource,
    Realtime, SCHEMA, TEXT_BYTES_MAX,
};
pub use footprint::{ProcessBound, ResourceBounds, SealedModels};
pub use in_process::InProcess;
pub use run::{MissingRealtime, ServiceConfig, ServiceError, serve};
pub use supervisor::{SupervisorError, supervise};
