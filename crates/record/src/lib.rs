//! The decision record: one file per request, chained to the one before it.
//!
//! ```text
//! RecordContent --encode(link)--> bytes of a file --Chain::next(name, bytes), file by file--> ok
//!       ^                              |            checks the hash of the file, and that of the
//!       +-------decode(bytes)----------+            one before it
//! ```
//!
//! It holds everything that the answer was made from: the texts of scenario, policy, curves and
//! paths, the hash of every body, the settings, and which jobs were done; and what was decided, as
//! it was printed. So the answer can be recomputed, on another machine, and compared byte for byte.
//!
//! It says nothing of persons but kind and seat. It complements the recorders of UN R157 (DSSAD)
//! and R160 (EDR); it does not claim to comply with them.
//!
//! Pure: bytes in, bytes out; the caller opens files.
//!
//! # Invariants
//!
//! - Every changed byte of a file is detected, and so is truncation: `file/tests.rs`.
//! - A record that is missing, exchanged, renamed or out of order is detected, except at the end of
//!   an unsigned chain, where no later record refers to it: `chain/tests.rs`.
//! - Whoever lacks the key can change nothing of a signed chain, but replace it as a whole by an
//!   older state of it or by another chain of the same signer: `chain/tests/forgery.rs`.
//! - Whatever ends a writer, the chain passes the check and can be continued:
//!   `chain/tests/forgery.rs`.
//! - Nothing in a file is trusted before its hash is checked.

pub mod chain;
pub mod content;
pub mod file;
pub mod key;
mod named;
pub mod proof;
pub mod statement;

pub use chain::{Chain, ChainError, HEAD_FILE, Resume};
pub use content::{
    Edge, Mode, OpenStep, PoseQuestion, RecordContent, RecordedBody, RecordedEnd, RecordedJob,
    RecordedRound, RecordedSearch, RecordedSource, RecordedSpan, RecordedStage, RecordedText,
    RecordedUntil, Settings, hash_of_text,
};
pub use file::{Link, RecordError, RecordSigner, decode, encode};
pub use key::{KeyError, SigningKey, VerifyingKey};
pub use proof::{HeadProof, Proof};
pub use statement::{
    ChainId, Provenance, RecordedDeployment, SignedStatement, Statement, StatementKind,
};
