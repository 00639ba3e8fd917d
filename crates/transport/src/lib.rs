//! Shared-memory channels between coordinator and workers. The only crate that names iceoryx2.
//!
//! A [`Domain`] is one start of one coordinator: a name that no other run shares, so that two
//! instances, or a hundred tests, never meet. Within it each incarnation of a worker has a link: a
//! job channel and a result channel, created and held by the coordinator ([`CoordinatorLink`]) and
//! opened by the worker ([`WorkerLink`]). What planners use is separate: [`service`].
//!
//! ```text
//! Sender   --loan--> OpenMessage --words (in place), send(head, used)--> (gone)
//! Receiver --take--> a private, checked copy; the chunk goes back at once
//! ```
//!
//! # Invariants
//!
//! - No call on an open channel blocks. A full queue is [`UseError::Full`].
//! - A message is seen whole or not at all, and only with the right checksum, run and sender; what
//!   was never sent never arrives: `tests/kill.rs`, `link/tests.rs`.
//! - A service has one server at a time, and outlives clients that vanish: `service/tests.rs`.
//! - A domain leaves nothing behind once its creator dropped it; what a killed run left is removed
//!   by [`sweep_leftovers`], and never what a live run still uses: `domain/tests.rs`.
//! - All files lie in private folders, see [`folder`]: `folder/tests.rs`. A segment exists whole or
//!   not at all, and its memory is allocated: `segment/tests.rs`.
//! - A full file system is an error, and leaves a pool the memory of one more link:
//!   [`SegmentReserve`].
//! - The answer to every iceoryx2 question is written out in [`link`] and [`domain`]; its
//!   configuration files are never read.
//! - Once connected a loan allocates nothing: what iceoryx2 makes for each lies in memory that is
//!   kept (`kept.rs`).
//!
//! This crate does not know what jobs and results are, nor when a peer is dead: its pidfd and the
//! status page show that.

#![expect(unsafe_code, reason = "memory loaned by iceoryx2 has no safe interface for this")]

pub mod domain;
pub mod error;
pub mod folder;
mod ipc;
mod kept;
pub mod link;
mod place;
pub mod receiver;
mod reserve;
mod segment;
pub mod sender;
pub mod service;
mod wire;

pub use domain::{Domain, dead_instances, sweep_leftovers};
pub use error::{OpenError, UseError};
pub use folder::default_folder;
pub use link::{CoordinatorLink, Sizes, WorkerLink};
pub use place::remove_own_files;
pub use receiver::Receiver;
pub use reserve::SegmentReserve;
pub use sender::{OpenMessage, Sender};
pub use service::{Address, ClientPort, Pending, Server, TakenRequest, TopicSubscriber};

/// What has gone through one end of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Messages handed over or taken (rejected ones included).
    pub messages: u64,
    /// Bytes of their headers and of the payload that they use.
    pub bytes: u64,
    /// Cache lines of 64 bytes that these occupy, each message by itself. The queue's own indices
    /// are not included: an estimated two to four lines per message.
    pub lines: u64,
}

/// Cache lines that so many bytes from an address on lie in.
pub(crate) fn lines(address: usize, bytes: usize) -> u64 {
    const LINE: usize = 64;
    if bytes == 0 { 0 } else { ((address % LINE + bytes).div_ceil(LINE)) as u64 }
}
