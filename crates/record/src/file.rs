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
use body::codec;
use bytemuck::{Pod, Zeroable};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// First eight bytes of every record.
pub const MAGIC: [u8; 8] = *b"TROLREC\n";
/// Version of the layout and of [`RecordContent`]. Another one is refused.
pub const VERSION: u32 = 3;

/// The head of a record.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Head {
    magic: [u8; 8],
    version: u32,
    spare: u32,
    length: u64,
    number: u64,
    previous: [u8; 32],
    hash: [u8; 32],
}

const HEAD: usize = size_of::<Head>();
const _: () = assert!(HEAD == 96);

/// Greatest length of a record's file (bytes).
pub const LENGTH_MAX: usize = HEAD + codec::ENCODED_MAX;

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
    /// Does not decode although its hash matches.
    #[error("the record cannot be read: {0}")]
    Content(codec::CodecError),
    /// Too large to write.
    #[error("the record cannot be written: {0}; a smaller distribution depth makes fewer jobs")]
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
            Self::Length { .. } | Self::Hash => "use another copy of the records, and compare",
            Self::Content(_) => "the writer was at fault: keep the file and report it",
            Self::TooLong(_) => "lower --depth",
        };
        Some(remedy.into())
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
) -> Result<(Vec<u8>, Link), RecordError> {
    let body = codec::encode(record).map_err(RecordError::TooLong)?;
    let mut head = Head {
        magic: MAGIC,
        version: VERSION,
        spare: 0,
        length: (HEAD + body.len()) as u64,
        number: previous.map_or(0, |link| link.number + 1),
        previous: previous.map_or([0; 32], |link| link.hash),
        hash: [0; 32],
    };
    head.hash = hash_of(&head, &body);
    let link = Link { number: head.number, previous: head.previous, hash: head.hash };
    Ok(([bytemuck::bytes_of(&head), &body].concat(), link))
}

/// The record of a file and its place in the chain; all bytes are checked.
///
/// # Errors
///
/// If any byte is not as [`encode`] wrote it.
pub fn decode(bytes: &[u8]) -> Result<(RecordContent, Link), RecordError> {
    let (head, body) = split(bytes)?;
    let record = codec::decode(body).map_err(RecordError::Content)?;
    Ok((record, Link { number: head.number, previous: head.previous, hash: head.hash }))
}

/// The place of a file in its chain; all bytes are checked, but the content is not read.
///
/// # Errors
///
/// If any byte is not as [`encode`] wrote it.
pub fn link(bytes: &[u8]) -> Result<Link, RecordError> {
    let (head, _) = split(bytes)?;
    Ok(Link { number: head.number, previous: head.previous, hash: head.hash })
}

fn split(bytes: &[u8]) -> Result<(Head, &[u8]), RecordError> {
    let found = bytes.len() as u64;
    if !bytes.starts_with(&MAGIC) {
        return Err(RecordError::Foreign);
    }
    let Some((head, body)) = bytes.split_at_checked(HEAD) else {
        return Err(RecordError::Length { stated: HEAD as u64, found });
    };
    let head: Head = bytemuck::pod_read_unaligned(head);
    if head.version != VERSION {
        return Err(RecordError::Version(head.version));
    }
    if head.length != found || bytes.len() > LENGTH_MAX {
        return Err(RecordError::Length { stated: head.length, found });
    }
    if hash_of(&head, body) != head.hash {
        return Err(RecordError::Hash);
    }
    Ok((head, body))
}

fn hash_of(head: &Head, body: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::bytes_of(&Head { hash: [0; 32], ..*head }));
    hasher.update(body);
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
pub(crate) mod tests;
