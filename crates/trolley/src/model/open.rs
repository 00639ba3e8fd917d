//! Opening a model file that a person named: every failure names the file and says what to do.

use body::{BodyView, Meta, file};
use diagnostic::Failure;
use std::io::Read as _;
use std::path::Path;

pub use mesh::reader::open::{bytes, room};

/// A copy of a model file: a file may change while it is mapped, what was verified must not.
///
/// # Errors
///
/// If there is no such file, or it is none that can be read.
pub fn copy(path: &Path) -> Result<file::Aligned, Failure> {
    let map = bytes(path)?;
    let mut copy = room(map.bytes().len());
    copy.bytes_mut().copy_from_slice(map.bytes());
    Ok(copy)
}

/// All of a model file, verified.
///
/// # Errors
///
/// If the bytes are no sound model file.
pub fn view<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Meta, BodyView<'a>), Failure> {
    file::view(bytes).map_err(|error| Failure::from(error).at(path.display()))
}

/// Whether a file is called, or begins like, a model file.
#[must_use]
pub fn is_model(path: &Path) -> bool {
    let is_named = path.extension().is_some_and(|end| end == "trolley");
    is_named || is_regular(path) && begins_like_a_model(path)
}

/// Opening a pipe would wait for a writer.
fn is_regular(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|about| about.is_file())
}

fn begins_like_a_model(path: &Path) -> bool {
    let mut start = [0; file::MAGIC.len()];
    let read = std::fs::File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == file::MAGIC
}
