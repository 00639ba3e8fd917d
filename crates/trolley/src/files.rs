//! Writing a file whole or not at all.
//!
//! The bytes go to a temporary file in the same folder, then take the name in one step: readers
//! see the old file or the new one, and a failure leaves the old one as it was.

use diagnostic::{Failure, FailureKind};
use std::fs::Permissions;
use std::io::{self, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

/// Refuses a target that could not be written, before work is spent on it.
///
/// `source` is the file that is read: it must not be replaced by what is made of it.
///
/// # Errors
///
/// If the folder is not there, or the name is that of a folder, a device or the source.
pub fn check(target: &Path, source: Option<&Path>) -> Result<(), Failure> {
    let refuse = |fault: &str, help: &str| {
        let fault = format!("{}: {fault}", target.display());
        Err(Failure::new(FailureKind::System, fault).with_remedy(help))
    };
    let folder = folder(target);
    if !folder.is_dir() {
        return refuse("its folder does not exist", "make the folder, or name another output");
    }
    match std::fs::metadata(target) {
        Ok(about) if about.is_dir() => return refuse("this is a folder", "name a file in it"),
        // Taking the name of /dev/null would remove it for everybody.
        Ok(about) if !about.is_file() => {
            return refuse("this is no regular file", "name a regular file");
        }
        _ => {}
    }
    let same = source.is_some_and(
        |source| matches!((source.canonicalize(), target.canonicalize()), (Ok(a), Ok(b)) if a == b),
    );
    if same {
        return refuse("this is the input itself", "name another output");
    }
    Ok(())
}

/// Writes `bytes` under the name `target`, replacing what had it.
///
/// # Errors
///
/// If the folder cannot be written to or has no room.
pub fn replace(target: &Path, bytes: &[u8]) -> Result<(), Failure> {
    // A link stays a link: what it points at is replaced.
    let place = target.canonicalize().unwrap_or_else(|_| target.to_owned());
    write(&place, bytes).map_err(|error| {
        let code = match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => FailureKind::Resources,
            _ => FailureKind::System,
        };
        Failure::new(code, format!("{}: cannot be written: {error}", target.display()))
            .with_remedy("the folder must be writable and have room")
    })
}

fn write(place: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = tempfile::Builder::new()
        .prefix(".trolley-")
        .permissions(Permissions::from_mode(0o666)) // the umask takes away what it must
        .tempfile_in(folder(place))?;
    file.write_all(bytes)?;
    file.as_file().sync_data()?;
    file.persist(place).map_err(|error| error.error)?;
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}
