//! Opens files given by the user: every failure names the file and the remedy.

use body::file;
use diagnostic::{Failure, chain};
use runtime::FileMap;
use std::io::ErrorKind;
use std::path::Path;

/// Reads a file of any kind.
///
/// # Errors
///
/// There is no such file, or it cannot be read.
pub fn bytes(path: &Path) -> Result<FileMap, Failure> {
    // Opening a folder succeeds and only reading it fails: check first.
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

/// Allocates a buffer for a model file of this many bytes: in large pages, since queries access it
/// randomly.
#[must_use]
pub fn zeroed_buffer(len: usize) -> file::Aligned {
    let mut buffer = file::Aligned::zeroed(len);
    runtime::realtime::large_pages(buffer.bytes_mut());
    buffer
}

/// A suggestion for a missing file.
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
