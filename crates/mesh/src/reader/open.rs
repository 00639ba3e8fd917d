//! Opens files given by the user: every failure names the file and the remedy.

use body::file;
use diagnostic::Failure;
use runtime::{FileMap, InputKind};
use std::path::Path;

/// Reads a file of this kind.
///
/// # Errors
///
/// There is no such file, it cannot be read, is not a regular file, or is too long.
pub fn bytes(path: &Path, kind: InputKind) -> Result<FileMap, Failure> {
    Ok(FileMap::open(path, kind)?)
}

/// Allocates a buffer for a model file of this many bytes: in large pages, since queries access it
/// randomly.
#[must_use]
pub fn zeroed_buffer(len: usize) -> file::Aligned {
    let mut buffer = file::Aligned::zeroed(len);
    runtime::realtime::large_pages(buffer.bytes_mut());
    buffer
}
