//! Where a writer goes on: after the last record of a folder, and only if its chain is signed as
//! the next record will be.

use super::{ChainError, HEAD_FILE, same_key};
use crate::file::Link;
use crate::key::VerifyingKey;
use crate::statement::{ChainId, SignedStatement};

/// Where a writer goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resume {
    /// The chain; `None`: none was begun yet, or it is not signed.
    pub chain: Option<ChainId>,
    /// Whether the head must be written first: for a chain that begins, or a writer that ended
    /// between a record and the head.
    pub needs_head: bool,
}

/// Where a writer with this key, or without one, goes on after the last record of a folder: its
/// name, its place, and who signed it.
///
/// # Errors
///
/// If the folder holds records that are not signed so, or the head does not fit them.
pub fn resume(
    last: Option<(&str, Link, Option<&SignedStatement>)>,
    head: Option<&SignedStatement>,
    key: Option<VerifyingKey>,
) -> Result<Resume, ChainError> {
    let name = || HEAD_FILE.to_owned();
    let (statement, found) = match last {
        None => (None, 0),
        Some((name, link, statement)) => {
            match (statement, key) {
                (None, Some(_)) => return Err(ChainError::Unsigned { name: name.to_owned() }),
                (Some(signed), _) => same_key(name, signed, key)?,
                (None, None) => {}
            }
            (statement, link.number + 1)
        }
    };
    let (Some(_), Some(head)) = (key, head) else {
        return match (statement.or(head), key) {
            // A record without a signature would end the chain for good.
            (Some(_), None) => Err(ChainError::Signed { name: name() }),
            (Some(_), Some(_)) => Err(ChainError::NoHead { name: name() }),
            (None, _) => Ok(Resume { chain: None, needs_head: key.is_some() }),
        };
    };
    same_key(HEAD_FILE, head, key)?;
    let (stated, chain) = (head.statement.number, head.statement.chain);
    if stated > found {
        return Err(ChainError::Cut { name: name(), stated, found });
    }
    if found - stated > 1 {
        return Err(ChainError::Stale { name: name(), stated, found });
    }
    if let Some((record, link, Some(signed))) = last {
        if signed.statement.chain != chain {
            return Err(ChainError::OtherChain { name: record.to_owned(), of: name() });
        }
        let fits = if stated == found { link.hash } else { link.previous };
        if head.statement.hash != fits {
            return Err(ChainError::OtherHead { name: name(), record: record.to_owned() });
        }
    }
    Ok(Resume { chain: Some(chain), needs_head: stated < found })
}
