//! The model file: one body with its tree, opened in place.
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
//! All numbers are little-endian. [`view`] checks everything that a later walk relies on, so that a
//! damaged file can neither panic nor mislead: the hash first, then every link, box and range.
//! [`quick_view`] skips hash and content for memory that was verified once and is sealed since.
//! This module opens nothing: the caller maps or reads the file.

mod check;

use crate::{Body, BodyView, Meta, codec};
use bytemuck::{Pod, Zeroable};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::ops::Range;

pub use check::{COORDINATE_MAX_M, check_body};

/// First eight bytes of every model file.
pub const MAGIC: [u8; 8] = *b"TROLLEY\n";

/// Version of the layout and of [`Meta`]. Another version is refused, never guessed at.
pub const VERSION: u32 = 4;

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
    // Arrays are stored as they lie in memory.
    assert!(cfg!(target_endian = "little"));
};

/// Bytes are not a model file that can be trusted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// Not a model file.
    #[error("not a model file: it does not begin with \"TROLLEY\"")]
    Foreign,
    /// Written by another version.
    #[error("model file of version {0}, this program reads version {VERSION}")]
    Version(u32),
    /// Shorter or longer than it says.
    #[error("file has {found} bytes, its header says {stated}")]
    Length {
        /// Bytes that the header states; for a cut header, the least that there must be.
        stated: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// The bytes do not lie at a multiple of [`ALIGN`] in memory.
    #[error("bytes do not lie at a multiple of {ALIGN} in memory")]
    Unaligned,
    /// The content hash does not match.
    #[error("content hash does not match: the file is damaged")]
    Hash,
    /// The table or the metadata is malformed.
    #[error("{place}: {what}")]
    Malformed {
        /// Which section or field.
        place: &'static str,
        /// What is wrong with it.
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

/// Bytes in memory that lie at a multiple of [`ALIGN`], for files that are read and not mapped.
#[derive(Debug, Default)]
pub struct Aligned {
    room: Vec<u8>,
    /// Where in `room`, which does not move.
    place: Range<usize>,
}

impl Aligned {
    /// So many zeros, to be overwritten. Those of a large file are no memory yet: it comes as they
    /// are written.
    #[must_use]
    pub fn zeroed(len: usize) -> Self {
        let room = vec![0; len + ALIGN - 1];
        let start = room.as_ptr().align_offset(ALIGN);
        Self { room, place: start..start + len }
    }

    /// Copies bytes to where they can be viewed.
    #[must_use]
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut copy = Self::zeroed(bytes.len());
        copy.bytes_mut().copy_from_slice(bytes);
        copy
    }

    /// The bytes, at a multiple of [`ALIGN`].
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.room[self.place.clone()]
    }

    /// The same, to be overwritten.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut self.room[self.place.clone()]
    }
}

/// Writes a body as a model file.
///
/// # Errors
///
/// If the body breaks an invariant that [`view`] holds, or its metadata is above
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

/// Opens a model file in place and checks all of it: time in proportion to its length.
///
/// `bytes` must lie at a multiple of [`ALIGN`], as mapped files do; see [`Aligned`].
///
/// # Errors
///
/// If anything is not as [`encode`] writes it.
pub fn view(bytes: &[u8]) -> Result<(Meta, BodyView<'_>), FileError> {
    let head = head(bytes)?;
    if hash_of(&head, bytes) != head.hash {
        return Err(FileError::Hash);
    }
    let (meta, body) = quick_view(bytes)?;
    check_body(&meta, &body)?;
    Ok((meta, body))
}

/// Opens a model file in place and checks that its arrays lie inside it, not what they hold.
///
/// For memory that [`view`] accepted once and that nobody can have written to since.
///
/// # Errors
///
/// If the header, the table or the metadata is malformed.
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

/// The content hash that a model file states, hexadecimal: its identity in records.
///
/// # Errors
///
/// If the header is malformed. The hash itself is checked by [`view`] alone.
pub fn content_hash(bytes: &[u8]) -> Result<String, FileError> {
    Ok(blake3::Hash::from_bytes(head(bytes)?.hash).to_hex().to_string())
}

fn head(bytes: &[u8]) -> Result<Head, FileError> {
    let found = bytes.len() as u64;
    let cut = FileError::Length { stated: META_AT as u64, found };
    if !bytes.starts_with(&MAGIC) {
        // A cut file is told apart from a foreign one, but no bytes at all are foreign.
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
        // Room to align the end, so that the next place cannot overflow.
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
