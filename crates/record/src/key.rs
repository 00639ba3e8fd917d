//! Keys: Ed25519 (RFC 8032) in the files that `openssl` writes: PKCS#8 and SPKI, as PEM.
//!
//! ```sh
//! openssl genpkey -algorithm ed25519 -out key.pem       # secret: for --sign
//! openssl pkey -in key.pem -pubout -out key.pub         # public: for --key
//! ```

use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use ed25519_dalek::pkcs8::{DecodePrivateKey as _, DecodePublicKey as _};
use std::borrow::Cow;

const SECRET: &str = "-----BEGIN PRIVATE KEY-----";
const PUBLIC: &str = "-----BEGIN PUBLIC KEY-----";

/// A text that is not the key that is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// A public key where a secret one is needed.
    #[error("this is a public key: records are signed with the secret one")]
    Public,
    /// A secret key where a public one is needed.
    #[error("this is a secret key: signatures are checked with the public one")]
    Secret,
    /// Not a secret key.
    #[error("this is no secret Ed25519 key: PKCS#8 as PEM, without a passphrase")]
    NotSecret,
    /// Not a public key, or one with which anybody could sign.
    #[error("this is no public Ed25519 key: SPKI as PEM")]
    NotPublic,
}

impl Diagnostic for KeyError {
    fn kind(&self) -> FailureKind {
        FailureKind::Configuration
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Public => "name the file of the secret key, which openssl genpkey wrote",
            Self::NotSecret => "make one: openssl genpkey -algorithm ed25519 -out key.pem",
            Self::Secret | Self::NotPublic => {
                "make it from the secret one: openssl pkey -in key.pem -pubout -out key.pub"
            }
        };
        Some(remedy.into())
    }
}

/// A secret key. Its bytes are overwritten when it is dropped.
#[derive(Clone)]
pub struct SigningKey(ed25519_dalek::SigningKey);

impl SigningKey {
    /// The key of a seed, which must be random and secret.
    #[must_use]
    pub fn from_seed(seed: &[u8; 32]) -> Self {
        Self(ed25519_dalek::SigningKey::from_bytes(seed))
    }

    /// Reads the text of a secret key: PKCS#8 as PEM.
    ///
    /// # Errors
    ///
    /// If the text is none, or is a public key.
    pub fn from_pem(text: &str) -> Result<Self, KeyError> {
        if text.contains(PUBLIC) {
            return Err(KeyError::Public);
        }
        match ed25519_dalek::SigningKey::from_pkcs8_pem(text.trim()) {
            Ok(key) => Ok(Self(key)),
            // What is wrong with a secret is not for a log.
            Err(_secret) => Err(KeyError::NotSecret),
        }
    }

    /// The public key that belongs to it.
    #[must_use]
    pub fn verifying_key(&self) -> VerifyingKey {
        VerifyingKey(self.0.verifying_key())
    }

    /// Signs a message: 64 bytes, the same each time.
    #[must_use]
    pub fn sign(&self, message: &[u8]) -> [u8; 64] {
        use ed25519_dalek::Signer as _;
        self.0.sign(message).to_bytes()
    }
}

impl fmt::Debug for SigningKey {
    /// Names the key, and shows nothing of the secret.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "SigningKey of {:?}", self.verifying_key())
    }
}

/// A public key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct VerifyingKey(ed25519_dalek::VerifyingKey);

impl VerifyingKey {
    /// The key of these bytes.
    ///
    /// # Errors
    ///
    /// If they are no key, or one with which anybody could sign.
    pub fn from_bytes(bytes: &[u8; 32]) -> Result<Self, KeyError> {
        match ed25519_dalek::VerifyingKey::from_bytes(bytes) {
            Ok(key) if !key.is_weak() => Ok(Self(key)),
            _ => Err(KeyError::NotPublic),
        }
    }

    /// Reads the text of a public key: SPKI as PEM.
    ///
    /// # Errors
    ///
    /// If the text is none, or is a secret key.
    pub fn from_pem(text: &str) -> Result<Self, KeyError> {
        if text.contains(SECRET) {
            return Err(KeyError::Secret);
        }
        match ed25519_dalek::VerifyingKey::from_public_key_pem(text.trim()) {
            Ok(key) if !key.is_weak() => Ok(Self(key)),
            _ => Err(KeyError::NotPublic),
        }
    }

    /// Its 32 bytes.
    #[must_use]
    pub fn to_bytes(self) -> [u8; 32] {
        self.0.to_bytes()
    }

    /// Whether the secret key that belongs to this one made this signature of this message.
    #[must_use]
    pub fn has_signed(&self, message: &[u8], signature: &[u8; 64]) -> bool {
        let signature = ed25519_dalek::Signature::from_bytes(signature);
        // Strictly: no second signature can be made from a valid one, and no weak key is accepted.
        self.0.verify_strict(message, &signature).is_ok()
    }
}

impl fmt::Display for VerifyingKey {
    /// All 64 digits: keys that share their first ones are easily made.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&hex(self.0.as_bytes()))
    }
}

impl fmt::Debug for VerifyingKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VerifyingKey({self})")
    }
}

/// Bytes as hexadecimal digits.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The bytes of exactly this many hexadecimal digits.
pub(crate) fn unhex<const N: usize>(text: &str) -> Option<[u8; N]> {
    let mut bytes = [0; N];
    if text.len() != 2 * N {
        return None;
    }
    for (byte, pair) in bytes.iter_mut().zip(text.as_bytes().chunks_exact(2)) {
        let [high, low] = [0, 1].map(|at| char::from(pair[at]).to_digit(16));
        *byte = (high? * 16 + low?) as u8;
    }
    Some(bytes)
}

#[cfg(test)]
pub(crate) mod tests;
