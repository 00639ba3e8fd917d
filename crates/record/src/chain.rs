//! A chain of records: each names the hash of the one before it. The head of a signed chain states
//! how many there are.
//!
//! ```text
//! 000000.record <-- 000001.record <-- 000002.record      each signed, if the chain is
//!                                          ^-- chain.head: 3 records, hash of the last; signed
//! ```
//!
//! The head of an empty chain comes first. Then a record is written, then the head; a writer that
//! finds the head one record behind writes it before anything else. So whatever ends a writer, the
//! head is at most one record behind, and never ahead: only somebody else can cause anything else.

mod resume;

pub use resume::{Resume, resume};

use crate::file::{Link, RecordError, link};
use crate::key::VerifyingKey;
use crate::proof::{HeadProof, Proof};
use crate::statement::{ChainId, SignedStatement, StatementError, StatementKind};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// Name of the file of a head, beside its records.
pub const HEAD_FILE: &str = "chain.head";

/// Name of the file of a record.
#[must_use]
pub fn file_name(number: u64) -> String {
    format!("{number:06}.record")
}

/// The number that a file's name gives to its record; `None` if it is not one of [`file_name`].
/// Folders before the name are ignored.
#[must_use]
pub fn number_of(name: &str) -> Option<u64> {
    let name = name.rsplit('/').next()?;
    let number = name.strip_suffix(".record")?.parse().ok()?;
    (file_name(number) == name).then_some(number)
}

/// A record, a head or a file of decisions that does not fit its chain.
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
    /// The head itself.
    #[error("{name}: {error}")]
    Head {
        /// Its file.
        name: String,
        /// What is wrong with it.
        error: StatementError,
    },
    /// A statement of something else.
    #[error("{name}: this is the statement of a {found}, not of the {expected} of this chain")]
    Kind {
        /// Its file.
        name: String,
        /// What it is of.
        found: &'static str,
        /// What it should be of.
        expected: &'static str,
    },
    /// The file is called otherwise than its number.
    #[error("{name}: the record in it is number {found}: the file was renamed or exchanged")]
    FileName {
        /// Its file.
        name: String,
        /// The number inside.
        found: u64,
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
    /// Nobody signed it.
    #[error("{name}: it is not signed")]
    Unsigned {
        /// Its file.
        name: String,
    },
    /// It is signed, and the chain is not.
    #[error("{name}: it is signed, and those before it are not")]
    Signed {
        /// Its file.
        name: String,
    },
    /// Another key signed it.
    #[error("{name}: it is signed with the key {found}, not with {expected}")]
    Key {
        /// Its file.
        name: String,
        /// The key that signed it.
        found: Box<VerifyingKey>,
        /// The key that should have.
        expected: Box<VerifyingKey>,
    },
    /// It is one of another chain.
    #[error("{name}: it belongs to another chain than {of}")]
    OtherChain {
        /// Its file.
        name: String,
        /// A file of this chain.
        of: String,
    },
    /// The head is not there.
    #[error("{name} is missing: nothing shows whether records were taken away from the end")]
    NoHead {
        /// Its file.
        name: String,
    },
    /// There are fewer than the head states.
    #[error("{name} states {stated}, and there are {found}: the last ones were taken away")]
    Cut {
        /// Its file.
        name: String,
        /// How many it states.
        stated: u64,
        /// How many there are.
        found: u64,
    },
    /// The head is about another last record.
    #[error("{record}: {name} was signed for another record with this number")]
    OtherHead {
        /// The head's file.
        name: String,
        /// The record's file.
        record: String,
    },
    /// The head is older than a crash explains.
    #[error(
        "{name} states {stated}, and there are {found}: a crash leaves one more at most, so this \
         head is an older one, and there may have been still more records"
    )]
    Stale {
        /// Its file.
        name: String,
        /// How many it states.
        stated: u64,
        /// How many there are.
        found: u64,
    },
}

impl Diagnostic for ChainError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Record { error, .. } => return error.remedy(),
            Self::Key { .. } => {
                "give the public key of the signer; if this is it, the file is not the signer's"
            }
            Self::Unsigned { .. } | Self::Signed { .. } => {
                "keep signed and unsigned records in different folders; if all of these were \
                 signed, use another copy of them"
            }
            Self::Head { .. } | Self::NoHead { .. } | Self::Stale { .. } => {
                "use the newest copy of chain.head; one that was copied before the records is older"
            }
            Self::Cut { .. } => "use a copy of the records that is as new as the head",
            _ => "use another copy of the records, and compare",
        };
        Some(remedy.into())
    }
}

/// The check of a chain, record by record.
///
/// ```
/// use trolley_record::{Chain, Proof};
///
/// let chain = Chain::new(None);
/// assert_eq!(chain.finish("chain.head"), Ok(Proof::Unsigned));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Chain {
    key: Option<VerifyingKey>,
    head: Option<(String, SignedStatement)>,
    /// Heads of this chain that were kept elsewhere.
    copies: Vec<(String, SignedStatement)>,
    /// Who signs, which chain it is, and the file that says so; `Some(None)`: nobody signs.
    signer: Option<Option<(VerifyingKey, ChainId, String)>>,
    last: Option<(String, Link)>,
}

impl Chain {
    /// An empty chain, and the key that must have signed it, if it is known.
    #[must_use]
    pub fn new(key: Option<VerifyingKey>) -> Self {
        Self { key, ..Self::default() }
    }

    /// Takes the head of the chain, from the bytes of its file, before any record.
    ///
    /// # Errors
    ///
    /// If it is none, or the key did not sign it.
    pub fn head(&mut self, name: &str, bytes: &[u8]) -> Result<(), ChainError> {
        self.head = Some((name.to_owned(), self.checked_head(name, bytes)?));
        Ok(())
    }

    /// Takes a copy of an earlier head of this chain: its records must still be there.
    ///
    /// # Errors
    ///
    /// If it is none, or is not one of this chain.
    pub fn copy_of_head(&mut self, name: &str, bytes: &[u8]) -> Result<(), ChainError> {
        let head = self.checked_head(name, bytes)?;
        self.copies.push((name.to_owned(), head));
        Ok(())
    }

    fn checked_head(&mut self, name: &str, bytes: &[u8]) -> Result<SignedStatement, ChainError> {
        let head = parse_head(name, bytes, StatementKind::Head)?;
        self.signed_by(name, Some(&head))?;
        Ok(head)
    }

    /// Takes the next file of the chain: its path and its bytes.
    ///
    /// # Errors
    ///
    /// If its bytes were changed, it is not the one that was written next, its name is that of
    /// another one, or it is not signed as the chain is.
    pub fn next(
        &mut self,
        name: &str,
        bytes: &[u8],
    ) -> Result<(Link, Option<SignedStatement>), ChainError> {
        let name = name.to_owned();
        let (link, statement) = match link(bytes) {
            Ok(found) => found,
            Err(error) => return Err(ChainError::Record { name, error }),
        };
        self.signed_by(&name, statement.as_ref())?;
        if number_of(&name) != Some(link.number) {
            return Err(ChainError::FileName { name, found: link.number });
        }
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
        for (head, signed) in self.head.iter().chain(&self.copies) {
            let states = &signed.statement;
            if states.number == link.number + 1 && states.hash != link.hash {
                return Err(ChainError::OtherHead { name: head.clone(), record: name });
            }
        }
        self.last = Some((name, link));
        Ok((link, statement))
    }

    /// Who must have signed this file: the given key, or else who signed the first one.
    fn signed_by(
        &mut self,
        name: &str,
        statement: Option<&SignedStatement>,
    ) -> Result<(), ChainError> {
        let name = name.to_owned();
        let first = self.signer.as_ref().map(Option::as_ref);
        match (statement, first) {
            (None, Some(Some(_))) => return Err(ChainError::Unsigned { name }),
            (None, _) if self.key.is_some() => return Err(ChainError::Unsigned { name }),
            (Some(_), Some(None)) => return Err(ChainError::Signed { name }),
            (None, _) => {}
            (Some(signed), first) => {
                let first_key = first.flatten().map(|(key, ..)| *key);
                same_key(&name, signed, self.key.or(first_key))?;
                if let Some(Some((_, chain, of))) = first
                    && *chain != signed.statement.chain
                {
                    return Err(ChainError::OtherChain { name, of: of.clone() });
                }
            }
        }
        if self.signer.is_none() {
            self.signer = Some(statement.map(|it| (it.signer, it.statement.chain, name)));
        }
        Ok(())
    }

    /// What was proved. `head` is the name of the head's file, for messages.
    ///
    /// # Errors
    ///
    /// If the head is missing, or does not fit the last record.
    pub fn finish(&self, head: &str) -> Result<Proof, ChainError> {
        let found = self.last.as_ref().map_or(0, |(_, link)| link.number + 1);
        for (name, signed) in self.head.iter().chain(&self.copies) {
            let stated = signed.statement.number;
            if stated > found {
                return Err(ChainError::Cut { name: name.clone(), stated, found });
            }
        }
        let signer = self.signer.as_ref().and_then(Option::as_ref).map(|(key, ..)| *key);
        let Some(key) = self.key.or(signer) else { return Ok(Proof::Unsigned) };
        let Some((name, signed)) = &self.head else {
            return Err(ChainError::NoHead { name: head.to_owned() });
        };
        let stated = signed.statement.number;
        if found - stated > 1 {
            return Err(ChainError::Stale { name: name.clone(), stated, found });
        }
        Ok(match self.key {
            None => Proof::OfUnknownKey { key },
            Some(key) => {
                let after = found - stated;
                Proof::Signed { key, head: Some(HeadProof { count: stated, after }) }
            }
        })
    }

    /// What was proved of one record by itself, without its chain.
    #[must_use]
    pub fn finish_single(&self) -> Proof {
        let signer = self.signer.as_ref().and_then(Option::as_ref).map(|(key, ..)| *key);
        match (signer, self.key) {
            (Some(key), Some(_)) => Proof::Signed { key, head: None },
            (Some(key), None) => Proof::OfUnknownKey { key },
            (None, _) => Proof::Unsigned,
        }
    }

    /// Takes a record by itself: its bytes, its name if it is one that numbers it, and its signer.
    ///
    /// # Errors
    ///
    /// As [`Chain::next`], but for its place in the chain.
    pub fn single(&mut self, name: &str, bytes: &[u8]) -> Result<(), ChainError> {
        let (name, found) = (name.to_owned(), link(bytes));
        let (link, statement) = match found {
            Ok(found) => found,
            Err(error) => return Err(ChainError::Record { name, error }),
        };
        self.signed_by(&name, statement.as_ref())?;
        named_alike(&name, link.number)
    }
}

/// Checks that a name, if it is one that numbers a record, is that of this record.
///
/// # Errors
///
/// If it is that of another one.
pub fn named_alike(name: &str, found: u64) -> Result<(), ChainError> {
    match number_of(name) {
        Some(number) if number != found => {
            Err(ChainError::FileName { name: name.to_owned(), found })
        }
        _ => Ok(()),
    }
}

/// Reads the head of a chain from the bytes of its file.
///
/// # Errors
///
/// If it is none of this kind.
pub fn parse_head(
    name: &str,
    bytes: &[u8],
    kind: StatementKind,
) -> Result<SignedStatement, ChainError> {
    let name = name.to_owned();
    match SignedStatement::parse(bytes) {
        Err(error) => Err(ChainError::Head { name, error }),
        Ok(head) if head.statement.kind != kind => {
            let (found, expected) = (head.statement.kind.name(), kind.name());
            Err(ChainError::Kind { name, found, expected })
        }
        Ok(head) => Ok(head),
    }
}

/// Checks that the expected key signed.
///
/// # Errors
///
/// If it was another one.
pub fn same_key(
    name: &str,
    signed: &SignedStatement,
    expected: Option<VerifyingKey>,
) -> Result<(), ChainError> {
    match expected {
        Some(expected) if expected != signed.signer => Err(ChainError::Key {
            name: name.to_owned(),
            found: Box::new(signed.signer),
            expected: Box::new(expected),
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests;
