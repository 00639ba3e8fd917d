//! Files of people and of strangers: regular files alone, read up to the limit of their kind.
//!
//! ```text
//! path --open, without waiting--> descriptor --fstat--> regular, not too long --read--> bytes
//! ```
//!
//! A pipe could block forever and a device never end; what was examined is what is read, since the
//! descriptor is the same. A file that grows meanwhile is read no further than its limit.
//!
//! The standard input, named `/dev/stdin`, may be a pipe or a terminal; the limit holds there, too.

mod error;
#[cfg(test)]
mod tests;

pub use error::InputError;

use rustix::fs::OFlags;
use rustix::io::Errno;
use std::fs::{File, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;

/// A kind of input. All limits on the length of files are here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputKind {
    /// A policy.
    Policy,
    /// A set of injury curves.
    Curves,
    /// Parameters of contact and dynamics.
    Parameters,
    /// A scenario.
    Scenario,
    /// A path of a scenario, in a file of its own.
    MotionPath,
    /// A deployment.
    Deployment,
    /// A fault plan.
    Plan,
    /// A library of bodies by type, for traffic.
    BodyLibrary,
    /// Recorded or written traffic.
    Traffic,
    /// A trace of a simulator.
    Trace,
    /// The world poses of two bodies.
    Poses,
    /// A decision record.
    Record,
    /// A file of decisions that a service wrote.
    Decisions,
    /// A page or figure that a measurement wrote.
    Measurement,
    /// A mesh, or a file beside it that it names.
    Mesh,
    /// The settings beside a mesh.
    SideFile,
    /// A model file.
    Model,
    /// A key, secret or public.
    Key,
    /// The head of a chain of records.
    ChainHead,
}

const KIB: u64 = 1 << 10;
const MIB: u64 = 1 << 20;

impl InputKind {
    /// All kinds.
    pub const ALL: [Self; 19] = [
        Self::Policy,
        Self::Curves,
        Self::Parameters,
        Self::Scenario,
        Self::MotionPath,
        Self::Deployment,
        Self::Plan,
        Self::BodyLibrary,
        Self::Traffic,
        Self::Trace,
        Self::Poses,
        Self::Record,
        Self::Decisions,
        Self::Measurement,
        Self::Mesh,
        Self::SideFile,
        Self::Model,
        Self::Key,
        Self::ChainHead,
    ];

    /// Maximum length (bytes).
    #[must_use]
    pub const fn bytes_max(self) -> u64 {
        match self {
            // 24 numbers and comments; three lines; ten.
            Self::Poses | Self::Key | Self::ChainHead => 64 * KIB,
            // What people write by hand has a few hundred lines.
            Self::Policy
            | Self::Curves
            | Self::Parameters
            | Self::MotionPath
            | Self::Deployment
            | Self::Plan
            | Self::BodyLibrary
            | Self::SideFile => MIB,
            // 16 candidates, 32 parties, 64 states a path, with every key in full precision.
            Self::Scenario => 4 * MIB,
            // Sixteen candidates, every job, and four of the texts above.
            Self::Record => 8 * MIB + 4 * KIB,
            Self::Measurement => 16 * MIB,
            // An hour of a crossing with 100 obstacles has 30 MB.
            Self::Traffic => 64 * MIB,
            // A minute at 100 Hz with 300 objects, or ten seconds with a map in each message.
            Self::Trace => 256 * MIB,
            // Four million triangles: 330 MB as a model file, most meshes less.
            Self::Mesh | Self::Model => 1024 * MIB,
            // 37,000 decisions about three candidates; a service writes half as many to a file.
            Self::Decisions => 1024 * MIB,
        }
    }

    /// The kind in words: "a policy".
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Policy => "a policy",
            Self::Curves => "a set of curves",
            Self::Parameters => "a set of parameters",
            Self::Scenario => "a scenario",
            Self::MotionPath => "a path",
            Self::Deployment => "a deployment",
            Self::Plan => "a fault plan",
            Self::BodyLibrary => "a library of bodies",
            Self::Traffic => "a traffic file",
            Self::Trace => "a trace",
            Self::Poses => "two poses",
            Self::Record => "a decision record",
            Self::Decisions => "a file of decisions",
            Self::Measurement => "a file of a measurement",
            Self::Mesh => "a mesh",
            Self::SideFile => "the settings of a mesh",
            Self::Model => "a model file",
            Self::Key => "a key",
            Self::ChainHead => "the head of a chain of records",
        }
    }
}

/// Opens a regular file that is not too long; returns its length (bytes), too.
///
/// # Errors
///
/// If it cannot be opened, is no regular file, or is longer than its kind may be.
pub fn open(path: &Path, kind: InputKind) -> Result<(File, u64), InputError> {
    let (file, length) = regular(path)?;
    if length > kind.bytes_max() {
        return Err(InputError::TooLong { path: path.to_owned(), length: Some(length), kind });
    }
    Ok((file, length))
}

/// Opens a regular file of any length, for those who read a part of it; returns its length (bytes),
/// too.
///
/// # Errors
///
/// If it cannot be opened, or is no regular file.
pub fn regular(path: &Path) -> Result<(File, u64), InputError> {
    // Without NONBLOCK, opening a pipe waits for a writer; without NOCTTY, a terminal becomes ours.
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let mut options = OpenOptions::new();
    options.read(true).custom_flags(flags.bits().cast_signed());
    let file = options.open(path).map_err(|error| match Errno::from_io_error(&error) {
        // So answer sockets, and devices that nothing is behind.
        Some(Errno::NXIO | Errno::NODEV) => match std::fs::metadata(path) {
            Ok(about) => InputError::irregular(path, about.file_type()),
            Err(error) => InputError::of_io(path, error),
        },
        _ => InputError::of_io(path, error),
    })?;
    let about = file.metadata().map_err(|error| InputError::of_io(path, error))?;
    if !about.is_file() {
        return Err(InputError::irregular(path, about.file_type()));
    }
    Ok((file, about.len()))
}

/// Reads a file, or what comes on the standard input.
///
/// # Errors
///
/// As [`open`], or if it cannot be read.
pub fn bytes(path: &Path, kind: InputKind) -> Result<Vec<u8>, InputError> {
    match open(path, kind) {
        Err(InputError::Irregular { .. }) if path == Path::new("/dev/stdin") => {
            bounded(&mut io::stdin().lock(), path, 0, kind)
        }
        opened => {
            let (mut file, length) = opened?;
            bounded(&mut file, path, length, kind)
        }
    }
}

/// Reads to the end, at most up to the limit and one byte more.
fn bounded(
    source: &mut dyn Read,
    path: &Path,
    expected: u64,
    kind: InputKind,
) -> Result<Vec<u8>, InputError> {
    let most = kind.bytes_max();
    let mut bytes = Vec::with_capacity(expected.min(most) as usize);
    let read = source.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| InputError::of_io(path, error))?;
    if bytes.len() as u64 > most {
        return Err(InputError::TooLong { path: path.to_owned(), length: None, kind });
    }
    Ok(bytes)
}

/// Reads a text, as [`bytes()`].
///
/// # Errors
///
/// As [`bytes()`], or if it is not UTF-8.
pub fn text(path: &Path, kind: InputKind) -> Result<String, InputError> {
    utf8(path, bytes(path, kind)?)
}

/// Reads a text that nobody but its owner may read: a secret key.
///
/// # Errors
///
/// As [`text`], or if others may read or change it.
pub fn secret_text(path: &Path, kind: InputKind) -> Result<String, InputError> {
    let (mut file, length) = open(path, kind)?;
    // Of the file that is open, whatever its path names meanwhile.
    let about = file.metadata().map_err(|error| InputError::of_io(path, error))?;
    let mode = about.mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(InputError::Exposed { path: path.to_owned(), mode });
    }
    utf8(path, bounded(&mut file, path, length, kind)?)
}

fn utf8(path: &Path, bytes: Vec<u8>) -> Result<String, InputError> {
    String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        InputError::NotText { path: path.to_owned(), byte }
    })
}

/// Reads the first bytes of a regular file; returns how many, 0 if there is no such file.
#[must_use]
pub fn start(path: &Path, into: &mut [u8]) -> usize {
    regular(path).ok().and_then(|(mut file, _)| file.read(into).ok()).unwrap_or(0)
}
