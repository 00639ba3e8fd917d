//! Writing a file completely or not at all.
//!
//! The bytes are written to a temporary file in the same folder, which is then renamed. Readers see
//! the old file or the new one, and a failure leaves the old one as it was.
//!
//! ```
//! # let folder = std::env::temp_dir().join(format!("trolley-files-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! use trolley::files;
//!
//! let target = folder.join("answer.json");
//! files::check(&target, None)?;
//! files::replace(&target, b"{}")?;
//! # assert_eq!(trolley::read_text(&target)?, "{}");
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

use diagnostic::{Failure, FailureKind};
use std::fs::Permissions;
use std::io::{self, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

/// Checks that a target can be written, before work is spent on it.
///
/// `source` is the file that is read: the target must be another one.
///
/// ```
/// use trolley::files::check;
///
/// let source = std::path::Path::new("../../config/scenarios/small.toml");
/// assert!(check(source, Some(source)).is_err(), "it would replace its input");
/// assert!(check("no-such-folder/answer.json".as_ref(), None).is_err());
/// ```
///
/// # Errors
///
/// If the folder does not exist, or the target is a folder, a device or the source.
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
        // Replacing /dev/null would remove it for everybody.
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

/// Writes `bytes` to the file `target`, replacing it if it exists.
///
/// ```
/// # let folder = std::env::temp_dir().join(format!("trolley-replace-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// let target = folder.join("note.txt");
/// trolley::files::replace(&target, b"first")?;
/// trolley::files::replace(&target, b"second")?;
/// assert_eq!(trolley::read_text(&target)?, "second");
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the folder cannot be written to or is full.
pub fn replace(target: &Path, bytes: &[u8]) -> Result<(), Failure> {
    // A link stays a link: its target is replaced.
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
        .permissions(Permissions::from_mode(0o666)) // less the umask
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
