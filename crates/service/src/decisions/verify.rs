//! Checks the decisions of a folder: every byte, their chain, and their signatures.

use super::{DECISION_HEAD, DecisionError, DecisionFile, Rest, name, numbers};
use record::chain::{parse_head, same_key};
use record::{ChainError, HeadProof, Proof, SignedStatement, StatementKind, VerifyingKey};
use runtime::{InputKind, input};
use std::path::Path;

/// What [`verify_decisions`] has found.
#[derive(Clone, Debug, PartialEq)]
pub struct VerifiedDecisions {
    /// Decisions that there are.
    pub count: u64,
    /// Number of the first one in its chain: the files before it were deleted, by the service or
    /// by others. Unknown, and 0, in a chain that is not signed.
    pub first: u64,
    /// Bytes at the ends of files that are no whole decision: a service left them that was killed,
    /// and the next one went on before them.
    pub torn_bytes: u64,
    /// Hash of the last decision; zeros if there is none.
    pub last: [u8; 32],
    /// What the signer of the last file states; `None`: nobody signed it.
    pub statement: Option<SignedStatement>,
    /// What was proved.
    pub proof: Proof,
}

/// Checks a service's folder of decisions; with the key that must have signed them, and a copy of
/// an earlier head, if there are any.
///
/// # Errors
///
/// If one was changed, exchanged, renamed or removed, but for whole files from the front; or with a
/// key, if one is not signed with it.
pub fn verify_decisions(
    folder: &Path,
    key: Option<VerifyingKey>,
    copy: Option<&Path>,
) -> Result<VerifiedDecisions, DecisionError> {
    let path = folder.join(DECISION_HEAD);
    let mut check = Check::new(key);
    // Before the decisions: what is written meanwhile comes after it.
    if path.try_exists()? {
        check.take_head(&path)?;
    }
    if let Some(copy) = copy {
        check.take_head(copy)?;
    }
    let files = numbers(folder)?;
    for (at, number) in files.iter().enumerate() {
        check.take_file(folder, *number, at + 1 == files.len())?;
    }
    check.finish(&path)
}

struct Check {
    key: Option<VerifyingKey>,
    /// The head, and copies of earlier ones.
    heads: Vec<(String, SignedStatement)>,
    /// The statement that all others must agree with, and its file; `Some(None)`: none is signed.
    signer: Option<Option<(String, SignedStatement)>>,
    statement: Option<SignedStatement>,
    /// Number of the last file.
    file: Option<u64>,
    first: u64,
    /// Number of the next decision.
    next: u64,
    last: [u8; 32],
    /// Bytes after the last decision of a file, and the error if no file disowns them.
    torn: Option<(u64, Option<DecisionError>)>,
    torn_bytes: u64,
}

impl Check {
    fn new(key: Option<VerifyingKey>) -> Self {
        Self {
            key,
            heads: Vec::new(),
            signer: None,
            statement: None,
            file: None,
            first: 0,
            next: 0,
            last: [0; 32],
            torn: None,
            torn_bytes: 0,
        }
    }

    fn take_head(&mut self, path: &Path) -> Result<(), DecisionError> {
        let name = path.display().to_string();
        let bytes = input::bytes(path, InputKind::ChainHead)?;
        let head = parse_head(&name, &bytes, StatementKind::DecisionHead)?;
        self.signed_by(&name, Some(&head))?;
        self.heads.push((name, head));
        Ok(())
    }

    /// Whether all are signed alike, and with the given key.
    fn signed_by(
        &mut self,
        name: &str,
        statement: Option<&SignedStatement>,
    ) -> Result<(), ChainError> {
        let name = name.to_owned();
        match (statement, &self.signer) {
            (None, Some(Some(_))) => return Err(ChainError::Unsigned { name }),
            (None, _) if self.key.is_some() => return Err(ChainError::Unsigned { name }),
            (Some(_), Some(None)) => return Err(ChainError::Signed { name }),
            (Some(signed), Some(Some((of, first)))) => {
                same_key(&name, signed, Some(first.signer))?;
                if signed.statement.chain != first.statement.chain {
                    return Err(ChainError::OtherChain { name, of: of.clone() });
                }
            }
            (Some(signed), None) => same_key(&name, signed, self.key)?,
            (None, _) => {}
        }
        if self.signer.is_none() {
            self.signer = Some(statement.map(|signed| (name, signed.clone())));
        }
        Ok(())
    }

    fn take_file(
        &mut self,
        folder: &Path,
        number: u64,
        is_last: bool,
    ) -> Result<(), DecisionError> {
        let path = name(folder, number);
        let text = path.display().to_string();
        let bytes = input::bytes(&path, InputKind::Decisions)?;
        let file = DecisionFile::parse(&text, &bytes).map_err(|error| match error {
            DecisionError::Foreign => DecisionError::ForeignIn { path: path.clone() },
            error => error,
        })?;
        self.signed_by(&text, file.statement.as_ref())?;
        if file.number != number {
            return Err(DecisionError::Renamed { path, found: file.number });
        }
        let first = file.statement.as_ref().map(|signed| signed.statement.number);
        match self.file {
            // The files before it were deleted.
            None => {
                (self.first, self.last) = (first.unwrap_or(0), file.before);
                self.next = self.first;
            }
            Some(before) => {
                let follows = file.before == self.last && first.is_none_or(|n| n == self.next);
                match (self.torn.take(), follows) {
                    // The writer of this file has gone on before what was torn.
                    (torn, true) => self.torn_bytes += torn.map_or(0, |(bytes, _)| bytes),
                    (Some((_, Some(error))), false) => return Err(error),
                    (_, false) if before + 1 != number => {
                        return Err(DecisionError::Gap { path });
                    }
                    (_, false) => {
                        let before = name(folder, before).display().to_string();
                        return Err(ChainError::Previous { name: text, before }.into());
                    }
                }
                if before + 1 != number {
                    return Err(DecisionError::Gap { path });
                }
            }
        }
        let counted = self.heads.first().map_or(0, |(_, head)| head.statement.number);
        let is_signed = file.statement.is_some();
        let changed = |number: usize, next: u64| DecisionError::ChangedIn {
            path: path.clone(),
            number,
            is_after_head: is_signed && next >= counted,
        };
        // Bytes after the last sound decision.
        let mut torn = file.body.len() as u64;
        let mut fault = None;
        let mut entries = file.entries();
        let mut whole = 0;
        for (at, entry) in entries.by_ref().enumerate() {
            let right = entry.number().is_none_or(|number| number == self.next);
            let Some(hash) = entry.checked(&self.last).filter(|_| right) else {
                fault = Some(changed(at, self.next));
                break;
            };
            for (head, signed) in &self.heads {
                let states = &signed.statement;
                if states.number == self.next + 1 && states.hash != hash {
                    let (name, record) = (head.clone(), text);
                    return Err(ChainError::OtherHead { name, record }.into());
                }
            }
            (self.last, whole) = (hash, at + 1);
            torn -= entry.bytes.len() as u64;
            self.next += 1;
        }
        if let (Rest::Changed, None) = (entries.rest, &fault) {
            fault = Some(changed(whole, self.next));
        }
        match (is_last, fault) {
            (true, Some(error)) => return Err(error),
            (true, None) => self.torn_bytes += torn,
            (false, fault) => self.torn = (torn > 0).then_some((torn, fault)),
        }
        self.statement = file.statement;
        self.file = Some(number);
        Ok(())
    }

    fn finish(self, path: &Path) -> Result<VerifiedDecisions, DecisionError> {
        let found = self.next;
        for (name, signed) in &self.heads {
            let stated = signed.statement.number;
            if stated > found {
                return Err(ChainError::Cut { name: name.clone(), stated, found }.into());
            }
        }
        let signer = self.signer.flatten().map(|(_, signed)| signed.signer);
        let proof = match self.key.or(signer) {
            None => Proof::Unsigned,
            Some(key) => {
                let own = path.display().to_string();
                let head = self.heads.iter().find(|(name, _)| *name == own);
                let Some((_, head)) = head else {
                    return Err(ChainError::NoHead { name: own }.into());
                };
                let count = head.statement.number;
                let head = Some(HeadProof { count, after: found - count });
                match self.key {
                    None => Proof::OfUnknownKey { key },
                    Some(key) => Proof::Signed { key, head },
                }
            }
        };
        Ok(VerifiedDecisions {
            count: found - self.first,
            first: self.first,
            torn_bytes: self.torn_bytes,
            last: self.last,
            statement: self.statement,
            proof,
        })
    }
}
