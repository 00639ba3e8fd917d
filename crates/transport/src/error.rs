//! Two kinds of errors, for two kinds of readers: a person at a terminal, and a running request.

/// A channel or domain could not be opened. Start-up must stop.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The system refused.
    #[error("cannot {step} \"{name}\": {source}")]
    System {
        /// What was being done.
        step: &'static str,
        /// To what.
        name: String,
        /// Why not.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The other end is of another build.
    #[error("\"{name}\" was made by another build of this program than {build}")]
    Skew {
        /// The channel.
        name: String,
        /// Our build.
        build: String,
    },
    /// An instance name that cannot be part of a path.
    #[error("instance name \"{0}\" is not 1 to 12 of a-z, 0-9 and -")]
    Instance(String),
}

impl OpenError {
    pub(crate) fn system<E>(step: &'static str, name: &str) -> impl FnOnce(E) -> Self
    where
        E: Into<Box<dyn std::error::Error + Send + Sync>>,
    {
        move |source| Self::System { step, name: name.to_owned(), source: source.into() }
    }

    /// For errors of iceoryx2, some of which are plain enums.
    pub(crate) fn shown<E: core::fmt::Debug>(
        step: &'static str,
        name: &str,
    ) -> impl FnOnce(E) -> Self {
        move |source| Self::System {
            step,
            name: name.to_owned(),
            source: format!("{source:?}").into(),
        }
    }
}

/// An open channel could not do as asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UseError {
    /// No slot is free, or nobody listens: the peer is slow or dead. The message is gone; what it
    /// asked for goes back to pending.
    #[error("no free slot")]
    Full,
    /// The channel is gone. Carry on without the peer until it is replaced.
    #[error("channel is gone")]
    Broken,
}
