//! The laboratory: measures, stress-tests and simulates the engine, without being part of it.
//!
//! | module | question |
//! |---|---|
//! | [`measure`] | how schemes, depths, buffers and transfer perform, and what steps cost |
//! | [`latency`] | how long a service takes, compared with the same work in this process |
//! | [`certify`] | whether bounds, deadlines and budgets hold, on random requests |
//! | [`inject`] | how answers change when faults are injected into real processes |
//! | [`validate`] | how figures compare with crash tests, and with what any sane model satisfies |
//! | [`simulate`] | whether the dispatcher survives simulated faults, in virtual time |
//!
//! Each takes plain options and returns a report, as a document and as text. Bodies are loaded and
//! sealed by [`trolley::bodies`] alone. Long work reports its progress: [`SyncProgress`].
//!
//! It prints nothing and parses no command line.

pub mod certify;
pub mod inject;
pub mod latency;
pub mod measure;
mod pair;
mod progress;
pub mod simulate;
pub mod validate;

pub use pair::PairName;
pub use progress::SyncProgress;
