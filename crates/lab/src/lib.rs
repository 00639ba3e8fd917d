//! The laboratory: everything that measures, tries, breaks and simulates the engine, and is no part
//! of it.
//!
//! | module | what it asks |
//! |---|---|
//! | [`measure`] | what schemes, depths, buffers and transfer are worth, and what steps cost |
//! | [`latency`] | how long a service takes, beside the same work in this process |
//! | [`certify`] | whether bounds, deadlines and budgets hold, on requests of chance |
//! | [`inject`] | what becomes of answers while faults are injected into real processes |
//! | [`simulate`] | the same of simulated ones, in virtual time |
//!
//! Each takes plain options and returns a report: a document for programs, and text for people.
//! Bodies are loaded and sealed by [`trolley::bodies`] alone. Long work tells how far it is:
//! [`SyncProgress`].
//!
//! It prints nothing and parses no command line.

pub mod certify;
pub mod inject;
pub mod latency;
pub mod measure;
mod pair;
mod progress;
pub mod simulate;

pub use pair::PairName;
pub use progress::SyncProgress;
