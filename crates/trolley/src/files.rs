//! Reading files up to a limit, and writing them completely or not at all.
//!
//! Whatever this library reads is a regular file, no longer than its [`InputKind`] may be: pipes,
//! devices, sockets and folders are refused at once. `/dev/stdin` may be a pipe; the limit holds.
//!
//! What is written goes to a temporary file in the same folder, which is then renamed. Readers see
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

use diagnostic::Failure;
use runtime::{input, output};
use std::path::Path;

/// A kind of file that is read, and its maximum length.
///
/// ```
/// use trolley::files::InputKind;
///
/// for kind in InputKind::ALL {
///     println!("{}: at most {} bytes", kind.name(), kind.bytes_max());
/// }
/// # assert_eq!(InputKind::Policy.bytes_max(), 1 << 20);
/// ```
pub use runtime::InputKind;

/// Reads a file of this kind.
///
/// ```
/// use trolley::files::{InputKind, bytes};
///
/// let pole = bytes("examples/data/pole.stl".as_ref(), InputKind::Mesh)?;
/// assert!(!pole.is_empty());
/// assert!(bytes("/dev/zero".as_ref(), InputKind::Mesh).is_err(), "it has no end");
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If it cannot be read, is no regular file, or is longer than its kind may be.
pub fn bytes(path: &Path, kind: InputKind) -> Result<Vec<u8>, Failure> {
    Ok(input::bytes(path, kind)?)
}

/// Reads a text of this kind.
///
/// ```
/// use trolley::files::{InputKind, text};
///
/// let policy = text("../../config/policies/default.toml".as_ref(), InputKind::Policy)?;
/// assert!(policy.contains("schema"));
/// assert!(text("no-such-file.toml".as_ref(), InputKind::Policy).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// As [`bytes()`], or if it is not UTF-8.
pub fn text(path: &Path, kind: InputKind) -> Result<String, Failure> {
    Ok(input::text(path, kind)?)
}

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
/// If the folder does not exist, or the target is a folder, pipe, socket, device or the source.
pub fn check(target: &Path, source: Option<&Path>) -> Result<(), Failure> {
    Ok(output::check(target, source)?)
}

/// Writes `bytes` to the file `target`, replacing it if it exists. A link to a file stays a link.
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
/// If the target is no regular file, or the folder cannot be written to or is full.
pub fn replace(target: &Path, bytes: &[u8]) -> Result<(), Failure> {
    Ok(output::replace(target, bytes)?)
}

#[cfg(test)]
mod tests {
    //! Each limit of a file is that of the parser behind it.
    use super::InputKind;

    #[test]
    fn what_a_reader_lets_pass_its_parser_accepts() {
        for (kind, most) in [
            // The longer of both forms; the reader of the other one refuses what is longer.
            (InputKind::Scenario, scenario::TEXT_BYTES_MAX),
            (InputKind::Deployment, service::TEXT_BYTES_MAX),
            (InputKind::Traffic, traffic::TEXT_BYTES_MAX),
            (InputKind::Poses, crate::poses::BYTES_MAX),
            (InputKind::Mesh, mesh::import::BYTES_MAX),
        ] {
            assert_eq!(kind.bytes_max(), most as u64, "{kind:?}");
        }
        assert!(InputKind::Record.bytes_max() >= record::file::LENGTH_MAX as u64);
        assert!(InputKind::Record.bytes_max() < 2 * record::file::LENGTH_MAX as u64);
    }
}
