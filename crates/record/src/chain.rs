//! A chain of records: each names the hash of the one before it.

use crate::file::{Link, RecordError, link};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// The end of a chain that was checked so far.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chain {
    last: Option<(String, Link)>,
}

/// A record that is not the next one of its chain.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChainError {
    /// The record itself.
    #[error("{name}: {error}")]
    Record {
        /// Its file.
        name: String,
        /// What is wrong with it.
        error: RecordError,
    },
    /// One or more records are missing before it.
    #[error("{name}: it is number {found} of its chain where {expected} should come")]
    Number {
        /// Its file.
        name: String,
        /// The number that it states.
        found: u64,
        /// The number that should come next.
        expected: u64,
    },
    /// The record before it is not the one that it was written after.
    #[error("{name}: it was written after another record than {before}")]
    Previous {
        /// Its file.
        name: String,
        /// The file before it; "none" for the first.
        before: String,
    },
}

impl Diagnostic for ChainError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some("use another copy of the records, and compare".into())
    }
}

impl Chain {
    /// Takes the next file of the chain.
    ///
    /// # Errors
    ///
    /// If its bytes were changed, or it is not the one that was written next.
    pub fn next(&mut self, name: &str, bytes: &[u8]) -> Result<Link, ChainError> {
        let name = name.to_owned();
        let link = match link(bytes) {
            Ok(link) => link,
            Err(error) => return Err(ChainError::Record { name, error }),
        };
        let (expected, previous, before) = match &self.last {
            None => (0, [0; 32], "none"),
            Some((before, last)) => (last.number + 1, last.hash, before.as_str()),
        };
        if link.number != expected {
            return Err(ChainError::Number { name, found: link.number, expected });
        }
        if link.previous != previous {
            return Err(ChainError::Previous { name, before: before.to_owned() });
        }
        self.last = Some((name, link));
        Ok(link)
    }

    /// The last link; `None` of an empty chain.
    #[must_use]
    pub fn last(&self) -> Option<&Link> {
        self.last.as_ref().map(|(_, link)| link)
    }
}

#[cfg(test)]
mod tests;
