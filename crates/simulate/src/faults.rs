//! A world of injected faults: the dispatcher of the live coordinator among workers that crash,
//! hang, stop and misreport, on channels that lose, repeat, delay, reorder and corrupt messages.
//!
//! ```text
//! seed ──▶ requests with known answers ──▶ world: workers, channels, time ──▶ what was answered
//!     └──▶ which faults, where, how often ─┘        │                             │
//!                                          dispatch::Dispatcher, Watch, Restarts  └─▶ the laws
//! ```
//!
//! Every decision of the coordinator is made by `dispatch` itself; time is virtual. Whether a fault
//! strikes is drawn from the seed and the name of the place alone, so that leaving out a kind of
//! fault does not move the others: that is how a failure is shrunk ([`shrink()`]).
//!
//! # Laws, checked after each request
//!
//! - *Never wrong*: a complete answer is that of a world without faults, and the bounds of any
//!   other hold it.
//! - *Counted once*: each job is closed exactly once, and no sum holds one twice.
//! - *In time*: an answer comes by its deadline or, without one, in bounded time.
//! - *No job lost*: jobs done, cut, abandoned and late are all jobs.
//! - *No false kill*: no worker is killed that merely waits for a core.
//! - *Poison*: no job takes more than two workers down.
//!
//! `faults/tests.rs` checks that each kind of fault strikes, and that deliberately flawed
//! dispatchers are caught; `faults/model.rs` explores all states of small worlds.

mod kind;
mod rng_key;
mod shrink;
mod tally;
mod work;
mod world;

pub use kind::{Faults, SimulatedFault};
pub use shrink::{Shrunk, shrink};
pub use tally::Tally;
pub use world::{FaultLimits, Violation, run};

#[cfg(test)]
mod model;
#[cfg(test)]
mod tests;
