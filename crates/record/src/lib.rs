//! The decision record: one file per request, chained to the one before it.
//!
//! ```text
//! RecordContent --encode(link)--> bytes of a file        verify: hash of the file, hash of the one before
//!    ^----decode(bytes)--- bytes of a file        Chain::next(name, bytes), file after file
//! ```
//!
//! It holds everything that the answer was made from: the texts of scenario, policy and curves, the
//! hash of every body, the settings, and which jobs were done; and what was decided, as it was
//! printed. So the answer can be made again, on another machine, and compared byte for byte.
//!
//! It says nothing of persons but kind and seat. It complements the recorders of UN R157 (DSSAD)
//! and R160 (EDR); it does not claim to comply with them.
//!
//! Pure: bytes in, bytes out; whoever calls it opens files.
//!
//! # Invariants
//!
//! - Every changed byte of a file is found, and so is a cut one: `file/tests.rs`.
//! - A record that is missing, exchanged or out of turn is found, except at the end of a chain,
//!   where nothing follows that could know it: `chain/tests.rs`.
//! - Nothing of a file is believed before its hash is checked.

pub mod chain;
pub mod content;
pub mod file;
mod named;

pub use chain::{Chain, ChainError};
pub use content::{
    Edge, Mode, PoseQuestion, RecordContent, RecordedBody, RecordedEnd, RecordedJob,
    RecordedMoment, RecordedSource, RecordedSpan, RecordedStage, RecordedText, Settings,
    hash_of_text,
};
pub use file::{Link, RecordError, decode, encode};
