//! Opening what a person named: every failure names the file and says what to do.

use body::file;
use diagnostic::{Failure, chain};
use runtime::FileMap;
use std::io::ErrorKind;
use std::path::Path;

/// Reads a file of any kind.
///
/// # Errors
///
/// If there is no such file, or it is none that can be read.
pub fn bytes(path: &Path) -> Result<FileMap, Failure> {
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
#[must_use]
pub fn room(len: usize) -> file::Aligned {
    let mut room = file::Aligned::zeroed(len);
    runtime::realtime::large_pages(room.bytes_mut());
    room
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
