//! Why a file is not read: its name, what is wrong, the remedy.

use super::InputKind;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::fs::FileType;
use std::io::{self, ErrorKind};
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

/// A file is not read.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// There is no such file.
    #[error("{}: there is no such file", path.display())]
    Missing {
        /// The path.
        path: PathBuf,
    },
    /// This user may not read it.
    #[error("{}: this user may not read it", path.display())]
    Denied {
        /// The path.
        path: PathBuf,
    },
    /// It is a folder, a pipe, a socket or a device.
    #[error("{}: this is a {what}, not a file", path.display())]
    Irregular {
        /// The path.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// It is longer than its kind may be.
    #[error("{}: {} bytes are too many for {}: the limit is {}", path.display(),
        length.map_or_else(|| format!("more than {}", kind.bytes_max()), |n| n.to_string()),
        kind.name(), kind.bytes_max())]
    TooLong {
        /// The path.
        path: PathBuf,
        /// Its length (bytes), if it has an end.
        length: Option<u64>,
        /// What it was to be.
        kind: InputKind,
    },
    /// It is secret, and others may read it.
    #[error("{}: this key is secret, and others may read or change it: its mode is {mode:04o}",
        path.display())]
    Exposed {
        /// The path.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// It is not UTF-8.
    #[error("{}: not UTF-8 from byte {byte} on", path.display())]
    NotText {
        /// The path.
        path: PathBuf,
        /// The first byte that is wrong.
        byte: usize,
    },
    /// Opening or reading it failed.
    #[error("{}: cannot be read", path.display())]
    System {
        /// The path.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

impl InputError {
    /// What an error of the system means.
    pub(crate) fn of_io(path: &Path, error: io::Error) -> Self {
        let path = path.to_owned();
        match error.kind() {
            ErrorKind::NotFound => Self::Missing { path },
            ErrorKind::PermissionDenied => Self::Denied { path },
            _ => Self::System { path, source: error },
        }
    }

    /// A file of a type that is not read.
    pub(super) fn irregular(path: &Path, is: FileType) -> Self {
        let what = match () {
            () if is.is_dir() => "folder",
            () if is.is_fifo() => "pipe",
            () if is.is_socket() => "socket",
            () => "device",
        };
        Self::Irregular { path: path.to_owned(), what }
    }
}

impl Diagnostic for InputError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Exposed { .. } => FailureKind::Configuration,
            _ => FailureKind::Input,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(match self {
            Self::Missing { path } => nearby(path).into(),
            Self::Denied { .. } => "change its permissions, or copy it".into(),
            Self::Irregular { what: "folder", .. } => "name the file in it".into(),
            Self::Irregular { .. } => "name a regular file: save its content to one first".into(),
            Self::TooLong { kind: InputKind::Mesh, .. } => "reduce the mesh, or split it".into(),
            Self::TooLong { .. } => "is this the right file?".into(),
            Self::Exposed { path, .. } => {
                format!("chmod 600 {}; if others had access to it, make a new key", path.display())
                    .into()
            }
            Self::NotText { .. } => "is this the right file? save it as UTF-8".into(),
            Self::System { .. } => "name a regular file that can be read".into(),
        })
    }
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
