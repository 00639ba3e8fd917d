//! The model file: one body with its tree, read in place.
//!
//! ```text
//! offset  0  magic      8   "TROLLEY" and a line feed
//!         8  version    4   VERSION
//!        12  sections   4   SECTIONS
//!        16  length     8   of the whole file, a multiple of 64
//!        24  meta       8   length of the encoded Meta
//!        32  hash      32   BLAKE3 of the file with this field zero
//!        64  table      8 × 32: tag, element size, offset, count, spare
//!       320  Meta       [`crate::codec`], then zeros up to a multiple of 64
//!         -  arrays     nodes, wide nodes, wide of node, corners, source ids, parts, zones,
//!                       dropped, each 64-aligned
//! ```
//!
//! All numbers are little-endian. [`view`] checks everything that a later traversal relies on, so
//! that a damaged file can neither cause a panic nor give wrong results: the hash first, then every
//! link, box and range. [`quick_view`] skips hash and content for memory that was verified once and
//! is sealed since. This module does no I/O: the caller maps or reads the file.

mod check;

use crate::{Body, BodyView, Meta, codec};
use bytemuck::{Pod, Zeroable};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::ops::Range;

pub use check::{COORDINATE_MAX_M, check_body};

/// The first eight bytes of every model file.
pub const MAGIC: [u8; 8] = *b"TROLLEY\n";

/// Version of the layout and of [`Meta`]. Other versions are rejected.
pub const VERSION: u32 = 6;

/// Alignment of the arrays and of the file itself, in bytes: one cache line.
pub const ALIGN: usize = 64;

const SECTIONS: usize = 8;
const NAMES: [&str; SECTIONS] =
    ["nodes", "wide nodes", "wide of node", "corners", "source ids", "parts", "zones", "dropped"];
const ELEMENT_BYTES: [usize; SECTIONS] = [32, 256, 4, 36, 4, 2, 2, 8];
const TABLE_AT: usize = size_of::<Head>();
const META_AT: usize = TABLE_AT + SECTIONS * size_of::<Section>();

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Head {
    magic: [u8; 8],
    version: u32,
    sections: u32,
    length: u64,
    meta: u64,
    hash: [u8; 32],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Section {
    tag: u32,
    element: u32,
    offset: u64,
    count: u64,
    spare: u64,
}

const _: () = {
    assert!(size_of::<Head>() == 64);
    assert!(size_of::<Section>() == 32);
    assert!(META_AT.is_multiple_of(ALIGN));
    // Arrays are stored in their memory layout.
    assert!(cfg!(target_endian = "little"));
};

/// The bytes are not a trustworthy model file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// Not a model file.
    #[error("not a model file: it does not begin with \"TROLLEY\"")]
    Foreign,
    /// Written by another version.
    #[error("model file of version {0}, this program reads version {VERSION}")]
    Version(u32),
    /// The length differs from the stated one.
    #[error("file has {found} bytes, its header says {stated}")]
    Length {
        /// The stated length in bytes; for a truncated header, the minimum.
        stated: u64,
        /// The actual length in bytes.
        found: u64,
    },
    /// The bytes are not aligned to [`ALIGN`].
    #[error("bytes do not lie at a multiple of {ALIGN} in memory")]
    Unaligned,
    /// The content hash does not match.
    #[error("content hash does not match: the file is damaged")]
    Hash,
    /// The table or the metadata is malformed.
    #[error("{place}: {what}")]
    Malformed {
        /// The section or field.
        place: &'static str,
        /// The problem.
        what: String,
    },
}

impl Diagnostic for FileError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Foreign => "make a model file with: trolley model import MESH -o MODEL.trolley",
            Self::Version(_) => "import the mesh again with this program",
            Self::Length { .. } | Self::Hash | Self::Malformed { .. } => {
                "the copy is damaged: copy it again, or import the mesh again"
            }
            Self::Unaligned => "map the file, or read it into file::Aligned",
        };
        Some(remedy.into())
    }
}

fn malformed(place: &'static str, what: impl Into<String>) -> FileError {
    FileError::Malformed { place, what: what.into() }
}

/// A buffer aligned to [`ALIGN`], for files that are read instead of mapped.
#[derive(Debug, Default)]
pub struct Aligned {
    room: Vec<u8>,
    /// The range within `room`, whose memory does not move.
    place: Range<usize>,
}

impl Aligned {
    /// Creates a buffer of `length` zeros, to be overwritten. Memory is allocated lazily as pages
    /// are written.
    #[must_use]
    pub fn zeroed(len: usize) -> Self {
        let room = vec![0; len + ALIGN - 1];
        let start = room.as_ptr().align_offset(ALIGN);
        Self { room, place: start..start + len }
    }

    /// Copies bytes to an aligned buffer.
    #[must_use]
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut copy = Self::zeroed(bytes.len());
        copy.bytes_mut().copy_from_slice(bytes);
        copy
    }

    /// The bytes, aligned to [`ALIGN`].
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.room[self.place.clone()]
    }

    /// The bytes, to be overwritten.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.room[self.place.clone()]
    }
}

/// Encodes a body as a model file.
///
/// # Errors
///
/// The body violates an invariant that [`view`] checks, or its metadata exceeds
/// [`codec::ENCODED_MAX`]: such a file could never be read again.
pub fn encode(body: &Body) -> Result<Vec<u8>, FileError> {
    check_body(&body.meta, &body.view())?;
    let meta =
        codec::encode(&body.meta).map_err(|fault| malformed("metadata", fault.to_string()))?;
    let arrays: [&[u8]; SECTIONS] = [
        bytemuck::cast_slice(&body.nodes),
        bytemuck::cast_slice(&body.wide.nodes),
        bytemuck::cast_slice(&body.wide.of),
        bytemuck::cast_slice(&body.corners),
        bytemuck::cast_slice(&body.source_ids),
        bytemuck::cast_slice(&body.part_of),
        bytemuck::cast_slice(&body.zones),
        bytemuck::cast_slice(&body.dropped),
    ];
    let mut at = (META_AT + meta.len()).next_multiple_of(ALIGN);
    let mut table = [Section::zeroed(); SECTIONS];
    for (tag, array) in arrays.iter().enumerate() {
        table[tag] = Section {
            tag: tag as u32,
            element: ELEMENT_BYTES[tag] as u32,
            offset: at as u64,
            count: (array.len() / ELEMENT_BYTES[tag]) as u64,
            spare: 0,
        };
        at = (at + array.len()).next_multiple_of(ALIGN);
    }
    let mut head = Head {
        magic: MAGIC,
        version: VERSION,
        sections: SECTIONS as u32,
        length: at as u64,
        meta: meta.len() as u64,
        hash: [0; 32],
    };
    let mut bytes = vec![0_u8; at];
    bytes[..TABLE_AT].copy_from_slice(bytemuck::bytes_of(&head));
    bytes[TABLE_AT..META_AT].copy_from_slice(bytemuck::bytes_of(&table));
    bytes[META_AT..META_AT + meta.len()].copy_from_slice(&meta);
    for (section, array) in table.iter().zip(arrays) {
        let start = section.offset as usize;
        bytes[start..start + array.len()].copy_from_slice(array);
    }
    head.hash = hash_of(&head, &bytes);
    bytes[..TABLE_AT].copy_from_slice(bytemuck::bytes_of(&head));
    Ok(bytes)
}

/// Opens a model file in place and checks all of it, in time proportional to its length.
///
/// `bytes` must be aligned to [`ALIGN`], as mapped files are; see [`Aligned`].
///
/// # Errors
///
/// Anything differs from what [`encode`] writes.
pub fn view(bytes: &[u8]) -> Result<(Meta, BodyView<'_>), FileError> {
    let head = head(bytes)?;
    if hash_of(&head, bytes) != head.hash {
        return Err(FileError::Hash);
    }
    let (meta, body) = quick_view(bytes)?;
    check_body(&meta, &body)?;
    Ok((meta, body))
}

/// Opens a model file in place and checks that its arrays lie inside it, but not their content.
///
/// For memory that [`view`] accepted once and that cannot have been written to since.
///
/// # Errors
///
/// The header, the table or the metadata is malformed.
pub fn quick_view(bytes: &[u8]) -> Result<(Meta, BodyView<'_>), FileError> {
    if !bytes.as_ptr().addr().is_multiple_of(ALIGN) {
        return Err(FileError::Unaligned);
    }
    let head = head(bytes)?;
    let meta_end = usize::try_from(head.meta)
        .ok()
        .filter(|length| *length <= codec::ENCODED_MAX)
        .and_then(|length| META_AT.checked_add(length))
        .filter(|end| *end <= bytes.len())
        .ok_or_else(|| malformed("metadata", format!("its length is {}", head.meta)))?;
    let meta: Meta = codec::decode(&bytes[META_AT..meta_end])
        .map_err(|fault| malformed("metadata", fault.to_string()))?;
    let table: [Section; SECTIONS] = bytemuck::pod_read_unaligned(&bytes[TABLE_AT..META_AT]);
    let mut arrays: [&[u8]; SECTIONS] = [&[]; SECTIONS];
    let mut at = meta_end.next_multiple_of(ALIGN);
    for (tag, section) in table.iter().enumerate() {
        arrays[tag] = section
            .place(tag, at)
            .and_then(|(start, end)| bytes.get(start..end))
            .ok_or_else(|| malformed(NAMES[tag], format!("its place is wrong: {section:?}")))?;
        at = (at + arrays[tag].len()).next_multiple_of(ALIGN);
    }
    if at != bytes.len() {
        return Err(FileError::Length { stated: at as u64, found: bytes.len() as u64 });
    }
    let body = BodyView {
        nodes: cast(arrays[0], 0)?,
        wide: cast(arrays[1], 1)?,
        wide_of: cast(arrays[2], 2)?,
        corners: cast(arrays[3], 3)?,
        source_ids: cast(arrays[4], 4)?,
        part_of: cast(arrays[5], 5)?,
        zones: cast(arrays[6], 6)?,
        dropped: cast(arrays[7], 7)?,
    };
    Ok((meta, body))
}

/// The content hash stated in a model file, hexadecimal: its identity in records.
///
/// # Errors
///
/// The header is malformed. The hash itself is only checked by [`view`].
pub fn content_hash(bytes: &[u8]) -> Result<String, FileError> {
    Ok(blake3::Hash::from_bytes(head(bytes)?.hash).to_hex().to_string())
}

fn head(bytes: &[u8]) -> Result<Head, FileError> {
    let found = bytes.len() as u64;
    let cut = FileError::Length { stated: META_AT as u64, found };
    if !bytes.starts_with(&MAGIC) {
        // A truncated file is distinguished from a foreign one, but an empty one is foreign.
        return Err(if !bytes.is_empty() && MAGIC.starts_with(bytes) {
            cut
        } else {
            FileError::Foreign
        });
    }
    if bytes.len() < META_AT {
        return Err(cut);
    }
    let head: Head = bytemuck::pod_read_unaligned(&bytes[..TABLE_AT]);
    if head.version != VERSION {
        return Err(FileError::Version(head.version));
    }
    if head.sections != SECTIONS as u32 {
        return Err(malformed("header", format!("it states {} sections", head.sections)));
    }
    if head.length != found {
        return Err(FileError::Length { stated: head.length, found });
    }
    Ok(head)
}

impl Section {
    /// First byte and end of a section that must begin at `at`.
    fn place(&self, tag: usize, at: usize) -> Option<(usize, usize)> {
        let stated = (self.tag as usize, self.element as usize, self.offset, self.spare);
        let length = usize::try_from(self.count).ok()?.checked_mul(ELEMENT_BYTES[tag])?;
        let end = at.checked_add(length)?;
        // Leave space to align the end, so that the next position cannot overflow.
        end.checked_add(ALIGN)?;
        (stated == (tag, ELEMENT_BYTES[tag], at as u64, 0)).then_some((at, end))
    }
}

fn cast<T: Pod>(bytes: &[u8], tag: usize) -> Result<&[T], FileError> {
    bytemuck::try_cast_slice(bytes).map_err(|fault| malformed(NAMES[tag], fault.to_string()))
}

fn hash_of(head: &Head, bytes: &[u8]) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::bytes_of(&Head { hash: [0; 32], ..*head }));
    hasher.update(&bytes[TABLE_AT..]);
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests;
