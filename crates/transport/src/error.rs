//! Two kinds of errors, for two kinds of readers.
//!
//! [`OpenError`] is for a person at a terminal: it explains. [`UseError`] occurs inside a request
//! and is for a program: it is small, and each variant says what to do next.

use core::error::Error;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// A domain or a link could not be opened. Start-up must stop.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The name of the instance cannot be part of a path.
    #[error("instance name '{name}' must be 1 to 12 letters out of a-z, 0-9 and '-'")]
    Name {
        /// What was given.
        name: String,
    },
    /// Another service has this name. Exit with 75.
    #[error("instance '{instance}' is already served by process {pid}")]
    Taken {
        /// The instance.
        instance: String,
        /// Who serves it, if known.
        pid: String,
    },
    /// No service runs as this instance.
    #[error("no service is running as instance '{instance}' in {folder}")]
    NoService {
        /// The instance.
        instance: String,
        /// Where its folder would be.
        folder: String,
    },
    /// Another user may have made a folder, or may change it. Exit with 78.
    #[error("'{path}' cannot be trusted: {why}")]
    Untrusted {
        /// The folder.
        path: String,
        /// Why not.
        why: String,
        /// What helps.
        remedy: String,
    },
    /// A group of clients cannot reach the files of its service. Exit with 78.
    #[error("'{path}' is closed to group {group}, to which the service is lent")]
    Closed {
        /// The folder.
        path: String,
        /// The group's number.
        group: u32,
    },
    /// The service has all the clients, or all the listeners, that it takes. Exit with 75.
    #[error("instance '{instance}' is busy: it has all {most} {whom} that it takes")]
    Full {
        /// The instance.
        instance: String,
        /// Maximum number of them.
        most: usize,
        /// "clients" or "listeners".
        whom: &'static str,
    },
    /// The folder makes the name of the root too long for iceoryx2.
    #[error("'{root}' has more than {most} bytes: choose a shorter folder or instance")]
    RootTooLong {
        /// The root.
        root: String,
        /// Maximum number of bytes.
        most: usize,
    },
    /// The text does not name a domain.
    #[error("'{text}' is not the name of a run, as its coordinator writes it")]
    Text {
        /// What was given.
        text: String,
    },
    /// Coordinator and worker are different programs. Exit with 76.
    #[error("version skew on '{channel}': this program is build {ours}, the other end is {theirs}")]
    Skew {
        /// The service that was to be opened.
        channel: String,
        /// Build of this program.
        ours: String,
        /// Build of the program that created the service, if known.
        theirs: String,
    },
    /// A call of the system or of iceoryx2 failed.
    #[error("cannot {step} '{what}'")]
    Failed {
        /// What was to be done.
        step: &'static str,
        /// The file or service that it was to be done to.
        what: String,
        /// The error that it returned.
        source: Box<dyn Error + Send + Sync>,
    },
}

impl OpenError {
    /// Whether the two ends are different programs, so that retrying is useless.
    #[must_use]
    pub fn is_skew(&self) -> bool {
        matches!(self, Self::Skew { .. })
    }

    /// Whether a file or folder was not there.
    pub(crate) fn is_absent(&self) -> bool {
        let Self::Failed { source, .. } = self else { return false };
        let is_no_entry = source.downcast_ref::<std::io::Error>().map(std::io::Error::kind)
            == Some(std::io::ErrorKind::NotFound);
        is_no_entry || source.downcast_ref() == Some(&rustix::io::Errno::NOENT)
    }

    /// For `map_err`.
    pub(crate) fn at<'a, E: Error + Send + Sync + 'static>(
        step: &'static str,
        what: &'a str,
    ) -> impl FnOnce(E) -> Self + use<'a, E> {
        move |source| Self::Failed { step, what: what.to_owned(), source: Box::new(source) }
    }
}

impl Diagnostic for OpenError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Skew { .. } => FailureKind::Skew,
            Self::Name { .. }
            | Self::Text { .. }
            | Self::RootTooLong { .. }
            | Self::Closed { .. }
            | Self::Untrusted { .. } => FailureKind::Configuration,
            Self::Taken { .. } | Self::NoService { .. } | Self::Full { .. } => {
                FailureKind::TryAgain
            }
            Self::Failed { .. } => FailureKind::Resources,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Untrusted { remedy, .. } => return Some(remedy.into()),
            Self::Closed { path, group } => {
                return Some(
                    format!(
                        "chgrp {group} {path} && chmod g+x {path}, or set `folder` in the \
                         deployment file to one that the group can enter"
                    )
                    .into(),
                );
            }
            Self::Skew { .. } => "start both from the same program",
            Self::Name { .. } | Self::Text { .. } | Self::RootTooLong { .. } => {
                "correct `instance` and `folder` in the deployment file"
            }
            Self::Taken { .. } => "stop the other one, or choose another instance",
            Self::NoService { .. } => "start it: trolley serve DEPLOYMENT.toml",
            Self::Full { .. } => {
                "try again later, or end one of them; a dead one goes within seconds"
            }
            Self::Failed { .. } => "/dev/shm and the folder must be writable and large enough",
        };
        Some(remedy.into())
    }
}

/// An operation on an open channel failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UseError {
    /// Not sent: the peer is slow, dead, or not connected yet, or another message is still open.
    /// The work goes back to pending.
    #[error("no free slot")]
    Full,
    /// More words than a message can hold. Split it.
    #[error("message is longer than the channel's messages")]
    TooLong,
    /// The channel is gone. Carry on without the peer until it is replaced.
    #[error("channel is gone")]
    Broken,
}
