//! Why a run could not be finished.

use diagnostic::{Diagnostic, FailureKind};
use runtime::Exit;
use std::borrow::Cow;
use transport::OpenError;

/// A run that could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum WorkerPoolError {
    /// A system call failed.
    #[error(transparent)]
    System(#[from] runtime::OsError),
    /// A channel could not be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The machine lacks a requirement.
    #[error("{0}")]
    MissingRequirement(super::MissingRequirement),
    /// A worker ended before it greeted.
    #[error("worker {worker} ended at start-up with {exit}: its own message is above")]
    ExitedAtStart {
        /// Which one.
        worker: u8,
        /// How.
        exit: Exit,
    },
    /// A worker did not greet in time.
    #[error(
        "worker {worker} did not greet ({how}), {ms} ms after the start: is the machine \
             overloaded, or was the process stopped?"
    )]
    HandshakeTimeout {
        /// Which one.
        worker: u8,
        /// What it was seen to do: stopped, silent, hung.
        how: &'static str,
        /// How long was waited (ms).
        ms: u64,
    },
    /// All workers are lost and jobs are open.
    #[error(
        "no worker is left and {open} of {jobs} jobs are open; lost: {lost}. Start again; if it \
         happens again, run with --in-process to see whether a body is the cause"
    )]
    NobodyLeft {
        /// Open jobs.
        open: u64,
        /// Jobs in all.
        jobs: u64,
        /// How each worker ended.
        lost: String,
    },
    /// A copied section does not fit the memory of its worker.
    #[error(
        "thrashed: worker {core} holds {held} of {budget} bytes and needs {bytes} more for a \
         section, and nothing is evicted",
        core = .0.core, held = .0.held, budget = .0.budget, bytes = .0.bytes
    )]
    Thrashed(dispatch::Thrash),
    /// SIGINT, SIGTERM, SIGQUIT or SIGHUP came.
    #[error("interrupted")]
    Interrupted,
}

impl Diagnostic for WorkerPoolError {
    fn kind(&self) -> FailureKind {
        match self {
            Self::System(error) => error.kind(),
            Self::Open(open) => open.kind(),
            Self::MissingRequirement(missing) => missing.kind(),
            Self::ExitedAtStart { .. }
            | Self::HandshakeTimeout { .. }
            | Self::NobodyLeft { .. }
            | Self::Thrashed(_) => FailureKind::Resources,
            Self::Interrupted => FailureKind::Interrupted,
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Open(open) => open.remedy(),
            Self::Thrashed(_) => Some(
                "more --depth makes sections smaller, --memory-budget allows more memory".into(),
            ),
            Self::MissingRequirement(missing) => missing.remedy(),
            Self::System(_)
            | Self::ExitedAtStart { .. }
            | Self::HandshakeTimeout { .. }
            | Self::NobodyLeft { .. }
            | Self::Interrupted => None,
        }
    }
}
