//! What the check of records has proved, in words.

use crate::key::VerifyingKey;
use core::fmt;

/// What was proved of records whose bytes are intact.
///
/// ```
/// use trolley_record::{HeadProof, Proof, SigningKey};
///
/// assert!(Proof::Unsigned.to_string().contains("shows accidents, not forgery"));
/// let key = SigningKey::from_seed(&[1; 32]).verifying_key();
/// let head = Some(HeadProof { count: 7, after: 0 });
/// assert!(Proof::Signed { key, head }.to_string().contains("none of the first 7 is missing"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Proof {
    /// There is no signature.
    Unsigned,
    /// All are signed with one key, but no key was given to compare it with.
    OfUnknownKey {
        /// That key. It may be a forger's own.
        key: VerifyingKey,
    },
    /// All are signed with the key that was given.
    Signed {
        /// That key.
        key: VerifyingKey,
        /// What the head of the chain shows; `None` if one record was checked by itself.
        head: Option<HeadProof>,
    },
}

/// What the signed head of a chain shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeadProof {
    /// How many it states.
    pub count: u64,
    /// How many there are after those: their writer ended before it wrote the next head.
    pub after: u64,
}

impl Proof {
    /// Its name in documents.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Unsigned => "unsigned",
            Self::OfUnknownKey { .. } => "signed-key-not-checked",
            Self::Signed { .. } => "signed",
        }
    }
}

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unsigned => f.write_str(
                "not signed: this shows accidents, not forgery. Bit rot and lost or exchanged \
                 files are found, but whoever can write these files can make the whole chain anew",
            ),
            Self::OfUnknownKey { key } => write!(
                f,
                "signed with the key {key}, which was not compared with any: this shows accidents, \
                 not forgery, since a forger can sign with a key of his own. Give the signer's \
                 public key: --key FILE"
            ),
            Self::Signed { key, head } => {
                write!(f, "signed with the given key {key}: nothing was changed since. ")?;
                match head {
                    None => f.write_str("Other records of its chain were not looked at"),
                    Some(HeadProof { count, after: 0 }) => write!(
                        f,
                        "By the signed head, none of the first {count} is missing. If the folder \
                         as a whole was replaced by an older state of it, or by another chain of \
                         this signer, only a copy of the head kept elsewhere shows it: --head COPY"
                    ),
                    Some(HeadProof { count, after }) => write!(
                        f,
                        "By the signed head, none of the first {count} is missing; {after} more \
                         signed after it. This is what a writer leaves that ends before it writes \
                         the next head, and no sign of forgery; the next writer goes on from \
                         here. Nothing shows whether still more came after it"
                    ),
                }
            }
        }
    }
}
