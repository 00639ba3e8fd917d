//! What a signer states: which record, or which head of a chain, when, where, and by what program.
//!
//! ```text
//! trolley statement 1
//! of: record
//! chain: 32 digits
//! number: 7
//! hash: 64 digits
//! time: 2026-11-24T08:10:12.123456789Z
//! host: vehicle-7
//! deployment: quad-core 64 digits
//! build: 0.1.0+0123456789
//! key: 64 digits
//! signature: 128 digits
//! ```
//!
//! The signature is Ed25519 of all lines before its own, so that `openssl pkeyutl -verify -rawin`
//! can check it, too. There is one text of a statement, and no other is accepted: what is read must
//! be, byte for byte, what would be written.
//!
//! Time, host and deployment are what the signer's machine said of itself. A signature shows that
//! they were not changed since, not that they were right.

use crate::key::{SigningKey, VerifyingKey, hex, unhex};
use core::fmt::Write as _;
use core::time::Duration;
use std::time::UNIX_EPOCH;

/// Maximum length of a signed statement (bytes).
pub const STATEMENT_MAX: usize = 2048;
/// Longest host, deployment and build (bytes): a host has 64, an instance 49.
const WORD_MAX: usize = 256;

const FIRST: &str = "trolley statement 1";
const SIGNATURE: &str = "signature: ";

/// What a statement is of: one of these is none of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatementKind {
    /// A record: its number and its hash.
    Record,
    /// The head of a chain of records: how many there are, and the hash of the last.
    Head,
    /// A file of a service's decisions: the number of its first one, and the hash of its beginning.
    DecisionFile,
    /// The head of a chain of decisions: how many there are, and the hash of the last.
    DecisionHead,
}

impl StatementKind {
    const ALL: [Self; 4] = [Self::Record, Self::Head, Self::DecisionFile, Self::DecisionHead];

    /// Its name in the text of a statement.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Record => "record",
            Self::Head => "head of records",
            Self::DecisionFile => "file of decisions",
            Self::DecisionHead => "head of decisions",
        }
    }

    /// What its number counts.
    const fn number_key(self) -> &'static str {
        match self {
            Self::Record | Self::DecisionFile => "number",
            Self::Head | Self::DecisionHead => "count",
        }
    }
}

/// The deployment that something was made under.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedDeployment {
    /// Its instance name.
    pub name: String,
    /// BLAKE3 of the deployment file; `None` without one.
    pub hash: Option<[u8; 32]>,
}

/// When and where something was signed, as the machine itself said, and by what program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Provenance {
    /// Wall clock, since 1970-01-01 (UTC) (ns).
    pub written_ns: u64,
    /// Host name.
    pub host: String,
    /// The deployment; `None` if it has no name: the record itself holds the settings.
    pub deployment: Option<RecordedDeployment>,
    /// The build of the program.
    pub build: String,
}

/// The identity of a chain, drawn when it begins: records of two chains never fit each other, even
/// if one key signs both.
pub type ChainId = [u8; 16];

/// A statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Statement {
    /// What it is of.
    pub kind: StatementKind,
    /// The chain.
    pub chain: ChainId,
    /// A record's number, from 0; of a head, how many there are.
    pub number: u64,
    /// Hash of the record, or of the last one; zeros if there is none.
    pub hash: [u8; 32],
    /// When, where, by what.
    pub provenance: Provenance,
}

/// A statement whose signature is valid for the key that it names. Whether that key is one to be
/// trusted is for others to say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignedStatement {
    /// What is stated.
    pub statement: Statement,
    /// The key that signed it.
    pub signer: VerifyingKey,
}

/// Bytes that are not a signed statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StatementError {
    /// Something else, or cut.
    #[error("this is no signed statement of this program's version")]
    Form,
    /// Changed since it was signed.
    #[error("the signature is not valid: the statement was changed after it was signed")]
    Signature,
}

impl Statement {
    /// The text of the signed statement.
    #[must_use]
    pub fn sign(&self, key: &SigningKey) -> String {
        let mut text = self.text(&key.verifying_key());
        let signature = hex(&key.sign(text.as_bytes()));
        text += &format!("{SIGNATURE}{signature}\n");
        text
    }

    /// The lines that are signed.
    fn text(&self, signer: &VerifyingKey) -> String {
        let Self { kind, chain, number, hash, provenance } = self;
        let deployment = match &provenance.deployment {
            Some(known) => {
                let hash = known.hash.map_or_else(|| "-".to_owned(), |hash| hex(&hash));
                format!("{} {hash}", word(&known.name))
            }
            None => "none".to_owned(),
        };
        let values = [
            ("of", kind.name().to_owned()),
            ("chain", hex(chain)),
            (kind.number_key(), number.to_string()),
            ("hash", hex(hash)),
            ("time", time_text(provenance.written_ns)),
            ("host", word(&provenance.host)),
            ("deployment", deployment),
            ("build", word(&provenance.build)),
            ("key", signer.to_string()),
        ];
        let mut text = format!("{FIRST}\n");
        for (key, value) in values {
            let _infallible = writeln!(text, "{key}: {value}");
        }
        text
    }

    /// What the lines that are signed say; `None` if they are no statement.
    fn parse(text: &str) -> Option<SignedStatement> {
        let mut lines = text.lines();
        if lines.next() != Some(FIRST) {
            return None;
        }
        let mut value = |key: &str| lines.next()?.strip_prefix(key)?.strip_prefix(": ");
        let name = value("of")?;
        let kind = StatementKind::ALL.into_iter().find(|kind| kind.name() == name)?;
        let chain = unhex(value("chain")?)?;
        let number = value(kind.number_key())?.parse().ok()?;
        let hash = unhex(value("hash")?)?;
        let since = humantime::parse_rfc3339(value("time")?).ok()?.duration_since(UNIX_EPOCH);
        let written_ns = u64::try_from(since.ok()?.as_nanos()).ok()?;
        let host = value("host")?.to_owned();
        let deployment = match value("deployment")?.rsplit_once(' ') {
            None => None,
            Some((name, hash)) => {
                let hash = if hash == "-" { None } else { Some(unhex(hash)?) };
                Some(RecordedDeployment { name: name.to_owned(), hash })
            }
        };
        let build = value("build")?.to_owned();
        let signer = VerifyingKey::from_bytes(&unhex(value("key")?)?).ok()?;
        let provenance = Provenance { written_ns, host, deployment, build };
        let statement = Self { kind, chain, number, hash, provenance };
        // One text alone: spaces, signs, capitals and further lines are none of it.
        (statement.text(&signer) == text).then_some(SignedStatement { statement, signer })
    }
}

impl SignedStatement {
    /// Reads a signed statement, and checks its signature.
    ///
    /// # Errors
    ///
    /// If any byte is not as [`Statement::sign`] wrote it.
    pub fn parse(bytes: &[u8]) -> Result<Self, StatementError> {
        let text = str::from_utf8(bytes).ok().filter(|text| text.len() <= STATEMENT_MAX);
        let text = text.ok_or(StatementError::Form)?;
        let at = text.rfind(SIGNATURE).ok_or(StatementError::Form)?;
        let (signed, last) = text.split_at(at);
        let digits = last[SIGNATURE.len()..].strip_suffix('\n').ok_or(StatementError::Form)?;
        let signature = unhex(digits).filter(|bytes| hex(bytes) == digits);
        let (Some(found), Some(signature)) = (Statement::parse(signed), signature) else {
            return Err(StatementError::Form);
        };
        match found.signer.has_signed(signed.as_bytes(), &signature) {
            true => Ok(found),
            false => Err(StatementError::Signature),
        }
    }
}

impl Provenance {
    /// When, in words: RFC 3339, UTC.
    #[must_use]
    pub fn time(&self) -> String {
        time_text(self.written_ns)
    }
}

fn time_text(since_1970_ns: u64) -> String {
    let time = UNIX_EPOCH + Duration::from_nanos(since_1970_ns);
    humantime::format_rfc3339_nanos(time).to_string()
}

/// A word of a statement: one line, of bounded length.
fn word(text: &str) -> String {
    let line: String = text.chars().map(|c| if c.is_control() { '?' } else { c }).collect();
    let end = (0..=line.len().min(WORD_MAX)).rev().find(|at| line.is_char_boundary(*at));
    line[..end.unwrap_or(0)].to_owned()
}

#[cfg(test)]
pub(crate) mod tests;
