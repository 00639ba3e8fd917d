//! Opening what a person named: every failure names the file and says what to do.

use crate::failure::{Failure, chain};
use model::{BodyView, Meta, file};
use runtime::FileMap;
use std::io::ErrorKind;
use std::path::Path;

/// Reads a file of any kind.
pub(super) fn bytes(path: &Path) -> Result<FileMap, Failure> {
    // A folder opens, and only reading it fails: say what it is first.
    if path.is_dir() {
        let fault = format!("{}: this is a folder, not a file", path.display());
        return Err(Failure::input(fault).help("name the file in it"));
    }
    FileMap::open(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound => {
            Failure::input(format!("{}: there is no such file", path.display())).help(nearby(path))
        }
        ErrorKind::PermissionDenied => {
            Failure::input(format!("{}: this user may not read it", path.display()))
                .help("change its permissions, or copy it")
        }
        _ => Failure::input(format!("{}: {}", path.display(), chain(&error)))
            .help("name a regular file that can be read"),
    })
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
pub(super) fn view<'a>(path: &Path, bytes: &'a [u8]) -> Result<(Meta, BodyView<'a>), Failure> {
    file::view(bytes)
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())).help(error.help()))
}
