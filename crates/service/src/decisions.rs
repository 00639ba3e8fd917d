//! Requests and their answers, kept in bounded and chained files.
//!
//! ```text
//! decisions-00000007.bin: [magic 8] [number of the file 8] [hash before 32]  then per decision
//!                         [length 8] [its complement 8] [Ask] [Answer 10016] [hash 32]
//! signed:                 [the same 48] [length 8] [statement, signed]       then per decision
//!                         [the same] [number 8] [time 8] [hash 32] [signature 64]
//! decisions.head:         of signed ones: how many there are, and the hash of the last; signed
//! ```
//!
//! Of a request the bytes that count are kept, and the length is theirs. Its complement tells a
//! changed length from a decision that was not written to its end.
//!
//! A hash is BLAKE3 over the hash before it and what is between; the first of a file continues the
//! last of the file before. When a file is full, the next begins, and the oldest is deleted.
//! Removing whole files from the front cannot be detected from the rest, and from the end only in a
//! signed chain. A statement of a file is of its first decision's number and the hash of its first
//! 48 bytes.
//!
//! The head is written each second, after the decisions that it counts are on the disk. So a
//! service that is killed leaves decisions after its head, and maybe half a decision at the end of
//! a file; the next one begins a new file after the last whole decision.

mod book;
mod verify;

pub(crate) use book::Book;
pub use book::DecisionSigner;
pub use verify::{VerifiedDecisions, verify_decisions};

use bytemuck::Zeroable as _;
use diagnostic::{Diagnostic, FailureKind};
use protocol::public::{Ask, WireAnswer};
use record::{ChainError, SignedStatement, StatementKind, VerifyingKey};
use runtime::{InputError, InputKind, OutputError, input};
use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// Name of the file of a signed head, beside the decisions.
pub const DECISION_HEAD: &str = "decisions.head";

const MAGIC: [u8; 8] = *b"TROLDC3\n";
const MAGIC_SIGNED: [u8; 8] = *b"TROLDS3\n";
/// What files of any version begin with.
const MAGIC_ANY: [&[u8]; 2] = [b"TROLDC", b"TROLDS"];
/// Magic, number of the file, hash before it.
const START: usize = 8 + 8 + 32;
/// Length of the request, and its complement.
const LENGTHS: usize = 16;
/// What follows the request, besides the answer: a hash, or number, time, hash and signature.
const END: usize = size_of::<WireAnswer>() + 32;
const END_SIGNED: usize = size_of::<WireAnswer>() + 8 + 8 + 32 + 64;
/// What a decision's signature is of, before its hash: nothing else that is signed begins so.
const SIGNED: &[u8] = b"trolley decision 1\n";

/// A stored decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The request.
    pub ask: Box<Ask>,
    /// The answer.
    pub answer: WireAnswer,
}

/// A file of decisions that cannot be trusted.
#[derive(Debug, thiserror::Error)]
pub enum DecisionError {
    /// It cannot be read.
    #[error(transparent)]
    Unread(#[from] InputError),
    /// The folder cannot be read, or a file not be written.
    #[error("decisions cannot be read or written: {0}")]
    System(#[from] io::Error),
    /// The head cannot be written.
    #[error(transparent)]
    Unwritten(#[from] OutputError),
    /// It is not a file of decisions.
    #[error("this is not a file of decisions")]
    Foreign,
    /// As [`DecisionError::Foreign`], of a folder.
    #[error("{}: this is not a file of decisions", path.display())]
    ForeignIn {
        /// The file.
        path: PathBuf,
    },
    /// Another version of this program wrote it.
    #[error("{}: decisions of another version of the layout", path.display())]
    OtherVersion {
        /// The file.
        path: PathBuf,
    },
    /// It has been changed since it was written.
    #[error("decision {0} was changed since it was written: its hash does not match")]
    Changed(usize),
    /// It has been changed since it was written, and the file is one of a folder.
    #[error(
        "{}: decision {number} of this file was changed since it was written{}", path.display(),
        if *is_after_head { ", or torn by a loss of power: the head does not count it yet" }
        else { "" }
    )]
    ChangedIn {
        /// The file.
        path: PathBuf,
        /// Its place in the file, from 0.
        number: usize,
        /// Whether the head does not count it.
        is_after_head: bool,
    },
    /// The file has the name of another one.
    #[error("{}: this is file {found} of its chain: it was renamed or exchanged", path.display())]
    Renamed {
        /// The file.
        path: PathBuf,
        /// The number in it.
        found: u64,
    },
    /// Files before it are missing, and others before them are not.
    #[error("{}: the file before it is missing, and older ones are not", path.display())]
    Gap {
        /// The file.
        path: PathBuf,
    },
    /// Its statement is of another file.
    #[error("{}: the signed statement in it is of another file", path.display())]
    OtherStatement {
        /// The file.
        path: PathBuf,
    },
    /// It does not fit its chain.
    #[error(transparent)]
    Chain(#[from] ChainError),
}

impl Diagnostic for DecisionError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::System(_) => FailureKind::System,
            Self::Unwritten(error) => error.kind(),
            _ => FailureKind::Input,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Unread(error) => error.remedy(),
            Self::Unwritten(error) => error.remedy(),
            Self::System(_) => Some("`decisions` needs a folder that may be written to".into()),
            Self::Foreign => Some("name a file that a service wrote".into()),
            Self::OtherVersion { .. } => {
                Some("keep decisions in a new folder; these are read by what wrote them".into())
            }
            Self::Chain(error) => error.remedy(),
            _ => Some("compare with a copy kept elsewhere".into()),
        }
    }
}

/// Reads a file of decisions and checks its chain. A file cut in the middle of an entry yields the
/// entries before it.
///
/// # Errors
///
/// If the file cannot be read, is not a file of decisions, or was changed.
pub fn read_decisions(path: &Path) -> Result<Vec<Decision>, DecisionError> {
    let bytes = input::bytes(path, InputKind::Decisions)?;
    let file = DecisionFile::parse(&path.display().to_string(), &bytes)?;
    let (mut before, mut decisions) = (file.before, Vec::new());
    let mut entries = file.entries();
    for (number, entry) in entries.by_ref().enumerate() {
        before = entry.checked(&before).ok_or(DecisionError::Changed(number))?;
        decisions.push(entry.decision().ok_or(DecisionError::Changed(number))?);
    }
    match entries.rest {
        Rest::Torn(_) => Ok(decisions),
        Rest::Changed => Err(DecisionError::Changed(decisions.len())),
    }
}

/// The bytes of a file of decisions.
struct DecisionFile<'b> {
    number: u64,
    before: [u8; 32],
    /// Who signed it; `None`: nobody.
    statement: Option<SignedStatement>,
    body: &'b [u8],
}

/// The bytes of one decision.
#[derive(Clone, Copy)]
struct Entry<'b> {
    bytes: &'b [u8],
    signer: Option<VerifyingKey>,
}

/// The whole decisions of a file, one after the other.
struct Entries<'b> {
    signer: Option<VerifyingKey>,
    /// What is left.
    rest: Rest<'b>,
}

/// Bytes after the last whole decision.
#[derive(Clone, Copy)]
enum Rest<'b> {
    /// Maybe one that was not written to its end.
    Torn(&'b [u8]),
    /// One whose length was changed: where it ends is not known.
    Changed,
}

impl<'b> Iterator for Entries<'b> {
    type Item = Entry<'b>;

    fn next(&mut self) -> Option<Entry<'b>> {
        let Rest::Torn(bytes) = self.rest else { return None };
        let lengths = bytes.first_chunk::<LENGTHS>()?;
        let Some(length) = request_length(lengths) else {
            self.rest = Rest::Changed;
            return None;
        };
        let end = if self.signer.is_some() { END_SIGNED } else { END };
        let (entry, rest) = bytes.split_at_checked(LENGTHS + length + end)?;
        self.rest = Rest::Torn(rest);
        Some(Entry { bytes: entry, signer: self.signer })
    }
}

/// The length of a request from the beginning of its decision; `None` if it was changed.
fn request_length(lengths: &[u8; LENGTHS]) -> Option<usize> {
    let [mut length, mut complement] = [[0; 8]; 2];
    length.copy_from_slice(&lengths[..8]);
    complement.copy_from_slice(&lengths[8..]);
    let [length, complement] = [length, complement].map(u64::from_le_bytes);
    let known = usize::try_from(length).ok().filter(|_| length == !complement);
    known.filter(|length| (Ask::BYTES_MIN..=size_of::<Ask>()).contains(length))
}

impl<'b> DecisionFile<'b> {
    /// Reads the beginning of a file; `name` is its path.
    fn parse(name: &str, bytes: &'b [u8]) -> Result<Self, DecisionError> {
        let (start, rest) = bytes.split_at_checked(START).ok_or(DecisionError::Foreign)?;
        let (mut number, mut before) = ([0; 8], [0; 32]);
        number.copy_from_slice(&start[8..16]);
        before.copy_from_slice(&start[16..]);
        let number = u64::from_le_bytes(number);
        if start[..8] == MAGIC {
            return Ok(Self { number, before, statement: None, body: rest });
        }
        if is_of_other_version(&start[..8]) {
            return Err(DecisionError::OtherVersion { path: name.into() });
        }
        if start[..8] != MAGIC_SIGNED {
            return Err(DecisionError::Foreign);
        }
        let (length, rest) = rest.split_at_checked(8).ok_or(DecisionError::Foreign)?;
        let mut length_bytes = [0; 8];
        length_bytes.copy_from_slice(length);
        let length = usize::try_from(u64::from_le_bytes(length_bytes)).unwrap_or(usize::MAX);
        let (text, body) = rest.split_at_checked(length).ok_or(DecisionError::Foreign)?;
        let statement = record::chain::parse_head(name, text, StatementKind::DecisionFile)?;
        if statement.statement.hash != *blake3::hash(start).as_bytes() {
            return Err(DecisionError::OtherStatement { path: name.into() });
        }
        Ok(Self { number, before, statement: Some(statement), body })
    }

    /// Its whole entries.
    fn entries(&self) -> Entries<'b> {
        let signer = self.statement.as_ref().map(|signed| signed.signer);
        Entries { signer, rest: Rest::Torn(self.body) }
    }
}

impl Entry<'_> {
    /// Where request and answer end.
    fn decision_end(&self) -> usize {
        let end = if self.signer.is_some() { END_SIGNED } else { END };
        self.bytes.len() - end + size_of::<WireAnswer>()
    }

    /// `None` if the count of states in the request is not that of its bytes.
    fn decision(&self) -> Option<Decision> {
        let end = self.decision_end();
        let (ask, answer) =
            self.bytes[LENGTHS..end].split_at(end - LENGTHS - size_of::<WireAnswer>());
        let mut decision = Decision { ask: Ask::new(0.0), answer: WireAnswer::zeroed() };
        decision.ask.fill(ask)?;
        bytemuck::bytes_of_mut(&mut decision.answer).copy_from_slice(answer);
        Some(decision)
    }

    /// Its number in its chain; `None` if it is not signed.
    fn number(&self) -> Option<u64> {
        let end = self.decision_end();
        let mut number = [0; 8];
        number.copy_from_slice(&self.bytes[end..end + 8]);
        self.signer.map(|_| u64::from_le_bytes(number))
    }

    /// The hash that it states, and its signature.
    fn stated(&self) -> ([u8; 32], [u8; 64]) {
        let end = self.decision_end();
        let at = if self.signer.is_some() { end + 16 } else { end };
        let (mut hash, mut signature) = ([0; 32], [0; 64]);
        hash.copy_from_slice(&self.bytes[at..at + 32]);
        if self.signer.is_some() {
            signature.copy_from_slice(&self.bytes[at + 32..]);
        }
        (hash, signature)
    }

    /// Its hash, if it is that of its bytes after the one before, and was signed by its file's
    /// signer, if there is one.
    fn checked(&self, before: &[u8; 32]) -> Option<[u8; 32]> {
        let (stated, signature) = self.stated();
        let end = self.decision_end() + if self.signer.is_some() { 16 } else { 0 };
        let hash = link(before, &self.bytes[..end]);
        let is_signed =
            || self.signer.is_none_or(|key| key.has_signed(&[SIGNED, &hash].concat(), &signature));
        (hash == stated && is_signed()).then_some(hash)
    }
}

/// Whether a file that begins so was written by another version.
fn is_of_other_version(magic: &[u8]) -> bool {
    let is_known = magic == MAGIC || magic == MAGIC_SIGNED;
    !is_known && MAGIC_ANY.iter().any(|any| magic.starts_with(any))
}

fn link(before: &[u8; 32], bytes: &[u8]) -> [u8; 32] {
    *blake3::Hasher::new().update(before).update(bytes).finalize().as_bytes()
}

fn name(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("decisions-{number:08}.bin"))
}

/// Numbers of the files there are, ascending.
fn numbers(folder: &Path) -> io::Result<Vec<u64>> {
    let mut numbers = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name();
        let number = name.to_str().and_then(|name| {
            name.strip_prefix("decisions-")?.strip_suffix(".bin")?.parse::<u64>().ok()
        });
        numbers.extend(number);
    }
    numbers.sort_unstable();
    Ok(numbers)
}

#[cfg(test)]
mod tests;
