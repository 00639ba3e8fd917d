//! Virtual cores: the dispatcher of the live coordinator, driven by a recorded trace and by costs.
//!
//! ```text
//! a real run --jobs: sections, Nb, Np, hits--> Trace ─┐
//! calibration ──────────────────────────────▶ Costs ──┴▶ machine::run ──▶ time, transfer, messages
//! ```
//!
//! Every decision is made by [`dispatch`] itself; only time is made up here. A worker is a server
//! that takes its jobs in order, the coordinator one that takes events in order; what a step of
//! either costs is in [`Costs`]. So transfer and messages are exact for the order in which results
//! arrive here, and time is a prediction, to be held against real runs before it is believed.
//!
//! # Invariants
//!
//! - Equal input gives equal output; no time is shorter than the work shared out evenly, nor longer
//!   than all of it done by one: `machine/tests.rs`.
//! - Costs are found again from times that follow from them: `costs/tests.rs`.
//!
//! `faults`, behind the feature of that name, drives the same dispatcher through a world in which
//! everything goes wrong.
//!
//! It knows nothing of caches beyond the ledger's, of memory bandwidth that cores share, or of
//! other programs on the machine.

mod costs;
#[cfg(any(test, feature = "faults"))]
pub mod faults;
mod machine;
mod trace;

pub use costs::{Costs, Sample, fit};
pub use machine::{Home, Setup, SimulatedRun, run};
pub use trace::{JobTrace, TaskTrace, Trace};
