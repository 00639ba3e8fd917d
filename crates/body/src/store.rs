//! The model store: the model files of all bodies of an instance, concatenated.
//!
//! ```text
//! words:  [magic] [bodies] [offset, length]...   then each model file at a multiple of 64 bytes
//! ```
//!
//! It is written once, sealed by the kernel, and mapped read-only by every process; so its files
//! are verified when it is filled, and later only their layout is checked.

use crate::file::{self, ALIGN, FileError};
use crate::{BodyView, Meta};

const MAGIC: u64 = u64::from_le_bytes(*b"TROLSTOR");

fn round_up(bytes: usize) -> usize {
    bytes.div_ceil(ALIGN) * ALIGN
}

fn offsets(files: &[&[u8]]) -> (Vec<usize>, usize) {
    let mut at = round_up(16 + 16 * files.len());
    let starts = files.iter().map(|file| {
        let start = at;
        at += round_up(file.len());
        start
    });
    (starts.collect(), at)
}

/// The size in bytes of a store with these model files.
#[must_use]
pub fn length(files: &[&[u8]]) -> usize {
    offsets(files).1
}

/// Fills a store.
///
/// # Panics
///
/// `bytes` is shorter than [`length`].
pub fn fill(bytes: &mut [u8], files: &[&[u8]]) {
    let word = |value: usize| (value as u64).to_le_bytes();
    bytes[..8].copy_from_slice(&MAGIC.to_le_bytes());
    bytes[8..16].copy_from_slice(&word(files.len()));
    for (number, (start, file)) in offsets(files).0.into_iter().zip(files).enumerate() {
        let entry = 16 + 16 * number;
        bytes[entry..entry + 8].copy_from_slice(&word(start));
        bytes[entry + 8..entry + 16].copy_from_slice(&word(file.len()));
        bytes[start..start + file.len()].copy_from_slice(file);
    }
}

/// Returns the bodies of a store, in order.
///
/// # Errors
///
/// This is not a store, or the layout of a body is not that of a model file.
pub fn open(bytes: &[u8]) -> Result<Vec<(Meta, BodyView<'_>)>, FileError> {
    let word = |at: usize| -> Result<usize, FileError> {
        let word = bytes.get(at..at + 8).and_then(|word| word.try_into().ok());
        word.map(|word| u64::from_le_bytes(word) as usize).ok_or(FileError::Foreign)
    };
    if word(0)? != MAGIC as usize {
        return Err(FileError::Foreign);
    }
    let bodies = word(8)?;
    if bodies > bytes.len() / 16 {
        return Err(FileError::Foreign);
    }
    let body = |number: usize| {
        let (start, length) = (word(16 + 16 * number)?, word(24 + 16 * number)?);
        let end = start.checked_add(length).ok_or(FileError::Foreign)?;
        file::quick_view(bytes.get(start..end).ok_or(FileError::Foreign)?)
    };
    (0..bodies).map(body).collect()
}
