//! The file of one record.
//!
//! ```text
//! offset  0  magic      8   "TROLREC" and a line feed
//!         8  version    4   VERSION
//!        12  spare      4   zero
//!        16  length     8   of the whole file
//!        24  number     8   place in its chain, from 0
//!        32  previous  32   hash of the record before; zeros for the first
//!        64  hash      32   BLAKE3 of the file with this field zero
//!        96  RecordContent         [`body::codec`]
//! ```
//!
//! All numbers are little-endian. The length is checked first, then the hash, then the form.

use crate::content::RecordContent;
use crate::key::SigningKey;
use crate::statement::{
    ChainId, Provenance, STATEMENT_MAX, SignedStatement, Statement, StatementError, StatementKind,
};
use body::codec;
use bytemuck::{Pod, Zeroable};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// First eight bytes of every record.
pub const MAGIC: [u8; 8] = *b"TROLREC\n";
/// Version of the layout and of [`RecordContent`]. Another one is refused.
pub const VERSION: u32 = 19;
/// Version of a record with a signed statement: programs that know of none refuse it.
pub const VERSION_SIGNED: u32 = 20;

/// The head of a record.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Head {
    magic: [u8; 8],
    version: u32,
    statement: u32,
    length: u64,
    number: u64,
    previous: [u8; 32],
    hash: [u8; 32],
}

const HEAD: usize = size_of::<Head>();
const _: () = assert!(HEAD == 96);

/// Greatest length of a record's file (bytes).
pub const LENGTH_MAX: usize = HEAD + codec::ENCODED_MAX + STATEMENT_MAX;

/// A record's place in its chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Place, from 0.
    pub number: u64,
    /// Hash of the record before; zeros for the first.
    pub previous: [u8; 32],
    /// Hash of this record.
    pub hash: [u8; 32],
}

/// Bytes that are not a trustworthy record.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RecordError {
    /// Not a record.
    #[error("not a decision record: it does not begin with \"TROLREC\"")]
    Foreign,
    /// Written by another version.
    #[error("decision record of version {0}, this program reads version {VERSION}")]
    Version(u32),
    /// Truncated or extended.
    #[error("the record states {stated} bytes and has {found}: it was cut or added to")]
    Length {
        /// The length that the head states.
        stated: u64,
        /// The actual length.
        found: u64,
    },
    /// Changed since it was written.
    #[error("the record was changed since it was written: its hash does not match its bytes")]
    Hash,
    /// Its statement is none, or its signature is not valid.
    #[error("the record's statement: {0}")]
    Statement(StatementError),
    /// The statement was made for another record.
    #[error(
        "the record is not the signed one: it was changed after it was signed and given a new \
         hash, or has the statement of another one"
    )]
    NotSigned,
    /// Does not decode although its hash matches.
    #[error("the record cannot be read: {0}")]
    Content(codec::CodecError),
    /// Too large to write.
    #[error("the record cannot be written: {0}")]
    TooLong(codec::CodecError),
}

impl Diagnostic for RecordError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::TooLong(_) => FailureKind::Resources,
            _ => FailureKind::Input,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Foreign => "name a file that --record wrote",
            Self::Version(_) => "use the program of the build that the record was written by",
            Self::Length { .. } | Self::Hash | Self::Statement(_) | Self::NotSigned => {
                "use another copy of the records, and compare"
            }
            Self::Content(_) => "the writer was at fault: keep the file and report it",
            Self::TooLong(_) => {
                "a smaller distribution depth makes fewer jobs: lower --depth; and paths in CSV \
                 files need fewer states"
            }
        };
        Some(remedy.into())
    }
}

/// A key, and what it signs beside a record.
#[derive(Clone, Debug)]
pub struct RecordSigner<'k> {
    /// The key.
    pub key: &'k SigningKey,
    /// The chain.
    pub chain: ChainId,
    /// When, where, by what.
    pub provenance: Provenance,
}

impl RecordSigner<'_> {
    /// The text of a statement.
    #[must_use]
    pub fn sign(&self, kind: StatementKind, number: u64, hash: [u8; 32]) -> String {
        let (chain, provenance) = (self.chain, self.provenance.clone());
        Statement { kind, chain, number, hash, provenance }.sign(self.key)
    }
}

/// The file of a record that comes after `previous`, and its link.
///
/// # Errors
///
/// If the record is longer than [`LENGTH_MAX`].
pub fn encode(
    record: &RecordContent,
    previous: Option<&Link>,
    signer: Option<&RecordSigner<'_>>,
) -> Result<(Vec<u8>, Link), RecordError> {
    let body = codec::encode(record).map_err(RecordError::TooLong)?;
    let number = previous.map_or(0, |link| link.number + 1);
    let sign =
        |hash| signer.map_or_else(String::new, |s| s.sign(StatementKind::Record, number, hash));
    // The hash covers the length of the statement, which has as many bytes for every hash.
    let statement = sign([0; 32]).len();
    let mut head = Head {
        magic: MAGIC,
        version: if signer.is_some() { VERSION_SIGNED } else { VERSION },
        statement: statement as u32,
        length: (HEAD + body.len() + statement) as u64,
        number,
        previous: previous.map_or([0; 32], |link| link.hash),
        hash: [0; 32],
    };
    head.hash = hash_of(&head, &body);
    let file = [bytemuck::bytes_of(&head), &body, sign(head.hash).as_bytes()].concat();
    Ok((file, head.link()))
}

/// A record, its place in the chain, and who signed it, if anybody.
pub type DecodedRecord = (RecordContent, Link, Option<SignedStatement>);

/// The record of a file; all bytes are checked.
///
/// # Errors
///
/// If any byte is not as [`encode`] wrote it.
pub fn decode(bytes: &[u8]) -> Result<DecodedRecord, RecordError> {
    let (head, body, statement) = split(bytes)?;
    let record = codec::decode(body).map_err(RecordError::Content)?;
    Ok((record, head.link(), statement))
}

/// The place of a file in its chain, and who signed it, if anybody; all bytes are checked, but the
/// content is not read.
///
/// # Errors
///
/// If any byte is not as [`encode`] wrote it.
pub fn link(bytes: &[u8]) -> Result<(Link, Option<SignedStatement>), RecordError> {
    let (head, _, statement) = split(bytes)?;
    Ok((head.link(), statement))
}

impl Head {
    fn link(&self) -> Link {
        Link { number: self.number, previous: self.previous, hash: self.hash }
    }
}

fn split(bytes: &[u8]) -> Result<(Head, &[u8], Option<SignedStatement>), RecordError> {
    let found = bytes.len() as u64;
    if !bytes.starts_with(&MAGIC) {
        return Err(RecordError::Foreign);
    }
    let Some((head, rest)) = bytes.split_at_checked(HEAD) else {
        return Err(RecordError::Length { stated: HEAD as u64, found });
    };
    let head: Head = bytemuck::pod_read_unaligned(head);
    if ![VERSION, VERSION_SIGNED].contains(&head.version) {
        return Err(RecordError::Version(head.version));
    }
    if head.length != found || bytes.len() > LENGTH_MAX {
        return Err(RecordError::Length { stated: head.length, found });
    }
    let end = rest.len().checked_sub(head.statement as usize);
    let Some((body, statement)) = end.and_then(|end| rest.split_at_checked(end)) else {
        return Err(RecordError::Hash);
    };
    if hash_of(&head, body) != head.hash {
        return Err(RecordError::Hash);
    }
    match (head.version, statement) {
        (VERSION, []) => Ok((head, body, None)),
        (VERSION, _) => Err(RecordError::Statement(StatementError::Form)),
        _ => {
            let signed = SignedStatement::parse(statement).map_err(RecordError::Statement)?;
            let Statement { kind, number, hash, .. } = signed.statement;
            if (kind, number, hash) != (StatementKind::Record, head.number, head.hash) {
                return Err(RecordError::NotSigned);
            }
            Ok((head, body, Some(signed)))
        }
    }
}

fn hash_of(head: &Head, body: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::bytes_of(&Head { hash: [0; 32], ..*head }));
    hasher.update(body);
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
pub(crate) mod tests;
