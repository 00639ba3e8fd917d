//! The operating system as this project sees it: memory, processes, cores, clocks, waiting.
//!
//! | module | what it gives |
//! |---|---|
//! | [`clock`] | monotonic time, CPU time, randomness: the only clock there is |
//! | [`input`] | files of people and strangers: regular ones, up to a limit |
//! | [`machine`] | its name, and what it grants: file descriptors, shared memory |
//! | [`memory`] | the sealed model store, the status page, files read into aligned memory |
//! | [`output`] | files written whole, which replace regular files alone |
//! | [`process`] | children that die with their parent and are never left as zombies |
//! | [`affinity`] | which cores there are, staying on one, calling somebody there |
//! | [`counters`] | instructions and cache misses of a process, where there are counters |
//! | [`wait`] | one epoll over eventfds, children, a timer and signals |
//! | [`guard`] | the end of a process within a bound, whatever hangs in it |
//! | [`futex`] | sleeping on a word of the status page |
//! | [`realtime`] | locked memory, fixed priority, page faults; and what is missing for them |
//! | [`heap`] | an allocator that counts |
//!
//! # Invariants
//!
//! - Time is CLOCK_MONOTONIC: the wall clock may jump, and is read for signed statements alone.
//! - No process can change what is sealed: `memory/tests.rs`.
//! - A [`process::Child`] is dead and reaped once it was dropped, and dies when the thread that
//!   spawned it ends, whatever ended it: `process/tests.rs`.
//! - A process with a [`Guard`] ends within 2 s of the first signal, whatever hangs in it:
//!   `tests/processes/guard.rs`.
//! - No call on the way of a request blocks without a bound that the caller named.
//! - This crate knows nothing of iceoryx2, of messages, or of triangles; of `protocol` it knows the
//!   layout of the status page alone.

#![expect(unsafe_code, reason = "mappings, fork and exec have no safe interface")]

pub mod affinity;
pub mod clock;
pub mod counters;
pub mod error;
pub mod futex;
pub mod guard;
pub mod heap;
pub mod input;
pub mod machine;
pub mod memory;
pub mod output;
pub mod process;
pub mod realtime;
#[cfg(test)]
mod testing;
pub mod wait;

pub use error::{OsError, Result};
pub use guard::Guard;
pub use input::{InputError, InputKind};
pub use memory::{FileMap, ReadWords, SealedMemory, StatusMemory, WrittenWords};
pub use output::OutputError;
pub use process::{Child, Exit, Spawn};
pub use wait::{EventFd, Poller, Wake};
