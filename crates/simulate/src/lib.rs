//! Virtual cores: the dispatcher of the live coordinator, driven by a recorded trace and by costs.
//!
//! ```text
//! a real run --jobs: sections, Nb, Np, hits--> Trace ─┐
//! calibration ──────────────────────────────▶ Costs ──┴▶ machine::run ──▶ time, transfer, messages
//! ```
//!
//! Every decision is made by [`dispatch`] itself; only time is simulated here. A worker is a server
//! that takes its jobs in order, the coordinator a server that takes events in order; [`Costs`]
//! gives the cost of a step of either. So transfer and messages are exact for the order in which
//! results arrive here, and time is a prediction, to be validated against real runs.
//!
//! # Invariants
//!
//! - Equal input gives equal output; no time is shorter than the work shared out evenly, nor longer
//!   than all of it done by one: `machine/tests.rs`.
//! - Costs are recovered from times computed with them: `costs/tests.rs`.
//!
//! `faults`, behind the feature of that name, drives the same dispatcher through a world of
//! injected faults.
//!
//! When the memory of a core runs out there are three answers: the run stops
//! ([`dispatch::Cache::Fixed`]), sections are evicted and sent again
//! ([`dispatch::Cache::Recent`]), or they lie in virtual memory ([`Paging`]).
//!
//! It does not model caches beyond the sections that workers hold, memory bandwidth that cores
//! share, or other programs on the machine.

mod costs;
#[cfg(any(test, feature = "faults"))]
pub mod faults;
mod machine;
mod paging;
mod trace;

pub use costs::{Costs, Sample, fit, fit_copies};
pub use machine::{Home, Prepared, Setup, SimulatedRun, run};
pub use paging::Paging;
pub use trace::{JobTrace, TaskTrace, Trace};
