//! Files that are written completely or not at all, and that replace nothing but a regular file.
//!
//! ```text
//! bytes --> temporary file in the same folder --rename--> target
//! ```
//!
//! Readers see the old file or the new one, and a failure leaves the old one as it was. A rename
//! takes the place of whatever is there: of `/dev/null` for everybody. So the target must not exist
//! or be a regular file. A link to a regular file stays, and its target is replaced; any other link
//! is refused.

#[cfg(test)]
mod tests;

use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::fs::{self, Permissions};
use std::io::{self, ErrorKind, Write as _};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// A file is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// There is no folder to write it to.
    #[error("{}: its folder does not exist", path.display())]
    NoFolder {
        /// The path.
        path: PathBuf,
    },
    /// It is a folder, a pipe, a socket, a device, or a link to nothing.
    #[error("{}: this is a {what}, not a file that can be replaced", path.display())]
    Irregular {
        /// The path.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// It is the file that is read.
    #[error("{}: this is the input itself", path.display())]
    Input {
        /// The path.
        path: PathBuf,
    },
    /// Writing it failed.
    #[error("{}: cannot be written", path.display())]
    System {
        /// The path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl Diagnostic for OutputError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::System { source, .. }
                if matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded) =>
            {
                FailureKind::Resources
            }
            _ => FailureKind::System,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::NoFolder { .. } => "make the folder, or name another output",
            Self::Irregular { what: "folder", .. } => "name a file in it",
            Self::Irregular { .. } => "name a regular file, or one that does not exist yet",
            Self::Input { .. } => "name another output",
            Self::System { .. } => "the folder must be writable and have room",
        };
        Some(remedy.into())
    }
}

/// Checks that a target can be written, before work is spent on it. `source` is the file that is
/// read: the target must be another one.
///
/// # Errors
///
/// If the folder does not exist, or the target is no regular file, or the source.
pub fn check(target: &Path, source: Option<&Path>) -> Result<(), OutputError> {
    let path = target.to_owned();
    if !folder(target).is_dir() {
        return Err(OutputError::NoFolder { path });
    }
    let place = place(target)?;
    let same = source.and_then(|source| source.canonicalize().ok()).is_some_and(|s| s == place);
    if same {
        return Err(OutputError::Input { path });
    }
    Ok(())
}

/// Writes `bytes` to the file `target`, replacing it if it exists. They are on the disk then.
///
/// # Errors
///
/// If the target is no regular file, or its folder cannot be written to or is full.
pub fn replace(target: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    // Less the umask.
    write(target, bytes, |file| file.sync_data(), 0o666)
}

/// As [`replace`], for a file that is soon replaced again: readable by all, and not waited for.
///
/// # Errors
///
/// As [`replace`].
pub fn publish(target: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let readable = |file: &fs::File| file.set_permissions(Permissions::from_mode(0o644));
    write(target, bytes, readable, 0o644)
}

fn write(
    target: &Path,
    bytes: &[u8],
    finish: impl FnOnce(&fs::File) -> io::Result<()>,
    mode: u32,
) -> Result<(), OutputError> {
    let fail = |source| OutputError::System { path: target.to_owned(), source };
    let place = place(target)?;
    let mut file = tempfile::Builder::new()
        .prefix(".trolley-")
        .permissions(Permissions::from_mode(mode))
        .tempfile_in(folder(&place))
        .map_err(fail)?;
    file.write_all(bytes).and_then(|()| finish(file.as_file())).map_err(fail)?;
    file.persist(&place).map_err(|error| fail(error.error))?;
    Ok(())
}

/// What is replaced: the target, or what it links to.
fn place(target: &Path) -> Result<PathBuf, OutputError> {
    let path = || target.to_owned();
    let irregular = |what| OutputError::Irregular { path: path(), what };
    let fail = |source| OutputError::System { path: path(), source };
    let link = match fs::symlink_metadata(target) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(path()),
        about => about.map_err(fail)?,
    };
    let is = match fs::metadata(target) {
        Err(_) if link.is_symlink() => return Err(irregular("link to nothing")),
        about => about.map_err(fail)?.file_type(),
    };
    match () {
        // It ends in a folder that exists, so there is a path without links.
        () if is.is_file() => target.canonicalize().map_err(fail),
        () if is.is_dir() => Err(irregular("folder")),
        () if is.is_fifo() => Err(irregular("pipe")),
        () if is.is_socket() => Err(irregular("socket")),
        () => Err(irregular("device")),
    }
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}
