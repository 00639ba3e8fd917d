//! Why a service cannot start or continue.

use crate::decisions::DecisionError;
use coordinator::WorkerPoolError;
use diagnostic::{Diagnostic, FailureKind};
use record::ChainError as E;
use std::borrow::Cow;
use transport::OpenError;

/// A real-time setting that the operating system refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingRealtime {
    /// What.
    pub what: String,
    /// Why.
    pub why: String,
}

/// The service cannot start or continue.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// Its channels cannot be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// Its workers cannot be started.
    #[error(transparent)]
    WorkerPool(#[from] WorkerPoolError),
    /// The operating system refused.
    #[error(transparent)]
    System(#[from] runtime::OsError),
    /// Decisions cannot be kept.
    #[error("cannot keep decisions in {folder}: {source}")]
    Files {
        /// Where.
        folder: String,
        /// Why.
        source: DecisionError,
    },
    /// The housekeeping thread cannot be started.
    #[error("no thread can be started: {0}")]
    Thread(std::io::Error),
    /// Real time is required, but not available.
    #[error("no real time: {}", .0.iter()
        .map(|missing| format!("{} ({})", missing.what, missing.why))
        .collect::<Vec<_>>().join("; "))]
    NoRealtime(Vec<MissingRealtime>),
    /// Memory for the histograms ran out.
    #[error("no memory is left for histograms")]
    Memory,
}

impl Diagnostic for ServiceError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Open(error) => error.kind(),
            Self::WorkerPool(error) => error.kind(),
            Self::System(error) => error.kind(),
            Self::Files { source: DecisionError::Chain(error), .. } => match error {
                E::Signed { .. } | E::Unsigned { .. } | E::Key { .. } => FailureKind::Configuration,
                _ => FailureKind::Input,
            },
            Self::Files { source, .. } => source.kind(),
            Self::Thread(_) => FailureKind::System,
            Self::NoRealtime(_) => FailureKind::NoRealtime,
            Self::Memory => FailureKind::Resources,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Open(error) => error.remedy(),
            Self::WorkerPool(error) => error.remedy(),
            Self::System(error) => error.remedy(),
            Self::Files { source: DecisionError::Chain(error), .. } => Some(match error {
                E::Signed { .. } => {
                    "they are signed: add --sign KEY, or name another folder".into()
                }
                E::Unsigned { .. } => "a signed chain begins in a folder of its own".into(),
                E::Key { .. } => "sign with the key of this chain, or name another folder".into(),
                _ => "keep this folder to look into it, and name another one".into(),
            }),
            Self::Files { source, .. } => source.remedy(),
            Self::Thread(_) => None,
            Self::NoRealtime(_) => Some(
                "raise LimitRTPRIO and LimitMEMLOCK (see tools/systemd), or start without \
                 --require-rt"
                    .into(),
            ),
            Self::Memory => None,
        }
    }
}
