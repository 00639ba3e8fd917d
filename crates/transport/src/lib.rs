//! Shared-memory channels between the coordinator and its workers. The only crate that names
//! iceoryx2.
//!
//! ```text
//! Domain::create ---- CoordinatorLink::create(who) == jobs: Sender,   results: Receiver
//! Domain::open   ---- WorkerLink::open(who)        == jobs: Receiver, results: Sender
//!
//! Sender   --loan--> OpenMessage --words, send--> (gone; dropped unsent, it comes back)
//! Receiver --take--> a private copy whose checksum was checked
//! ```
//!
//! # Invariants
//!
//! - The coordinator creates and holds every service; workers only open. A worker killed at any
//!   moment leaves nothing half-made: `link/tests.rs`.
//! - No call on an open channel blocks, and nothing is overwritten: a full queue is an error.
//! - Every incarnation has services of its own, so there is no late mail from the dead.
//! - A domain that is dropped leaves nothing behind, one that was killed is swept by the next:
//!   `domain/tests.rs`.
//!
//! It does not know what the words of a message mean.
#![expect(unsafe_code, reason = "iceoryx2 asks for proof that samples are initialised and plain")]

mod channel;
mod domain;
mod error;
mod link;

pub use channel::{Arrived, OpenMessage, Receiver, Sender};
pub use domain::{Domain, sweep};
pub use error::{OpenError, UseError};
pub use link::{CoordinatorLink, Sizes, WorkerLink};
