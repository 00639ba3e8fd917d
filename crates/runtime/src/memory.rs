//! Memory that processes share, and files as memory.
//!
//! - [`SealedMemory`]: written once, then read-only for every process; the kernel enforces it.
//! - [`StatusMemory`]: the one page that all may write, a [`StatusPage`] of atomics.
//! - [`WrittenWords`], [`ReadWords`]: words that one process writes and others read.
//! - [`FileMap`]: a private copy of a file.
//!
//! All start on a page, so anything that needs up to 4096-byte alignment may be read in place.

mod file;
mod sealed;
mod status;
mod words;

pub use file::FileMap;
pub use sealed::SealedMemory;
pub use status::StatusMemory;
pub use words::{ReadWords, WrittenWords};

#[cfg(doc)]
use protocol::StatusPage;

#[cfg(test)]
mod tests;
