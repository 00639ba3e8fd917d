//! Opening what a person named: every failure names the file and says what to do.

use body::{BodyView, Meta, file};
use diagnostic::{Failure, chain};
use runtime::FileMap;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

/// Reads a file of any kind.
pub(crate) fn bytes(path: &Path) -> Result<FileMap, Failure> {
    // A folder opens, and only reading it fails: say what it is first.
    if path.is_dir() {
        let fault = format!("{}: this is a folder, not a file", path.display());
        return Err(Failure::input(fault).with_remedy("name the file in it"));
    }
    FileMap::open(path).map_err(|error| match error.io_kind() {
        ErrorKind::NotFound => Failure::input(format!("{}: there is no such file", path.display()))
            .with_remedy(nearby(path)),
        ErrorKind::PermissionDenied => {
            Failure::input(format!("{}: this user may not read it", path.display()))
                .with_remedy("change its permissions, or copy it")
        }
        _ => Failure::input(format!("{}: {}", path.display(), chain(&error)))
            .with_remedy("name a regular file that can be read"),
    })
}

/// Room for a model file of so many bytes: in large pages, since a query reads here and there.
pub(crate) fn room(len: usize) -> file::Aligned {
    let mut room = file::Aligned::zeroed(len);
    runtime::realtime::large_pages(room.bytes_mut());
    room
}

/// A copy of a model file: a file may change while it is mapped, what was verified must not.
pub(crate) fn copy(path: &Path) -> Result<file::Aligned, Failure> {
    let map = bytes(path)?;
    let mut copy = room(map.bytes().len());
    copy.bytes_mut().copy_from_slice(map.bytes());
    Ok(copy)
}

/// What to try where a file is missing.
fn nearby(path: &Path) -> String {
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.is_dir() {
        format!("see what there is: ls {}", folder.display())
    } else {
        format!("there is no folder {} either: check the path", folder.display())
    }
}

/// All of a model file, verified.
pub(crate) fn view<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Meta, BodyView<'a>), Failure> {
    file::view(bytes).map_err(|error| Failure::from(error).at(path.display()))
}

/// Whether a file is called, or begins like, a model file.
pub(crate) fn is_model(path: &Path) -> bool {
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
