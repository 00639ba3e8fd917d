//! The binary encoding of headers and records. The only place that uses bincode.
//!
//! The encoding is fixed-width and little-endian, and [`ENCODED_MAX`] bounds both directions.
//! bincode is unmaintained; it can be replaced by changing these two function bodies and the
//! version number in [`crate::file`]. `codec/tests.rs` pins the bytes, so that no update changes
//! them unnoticed. Bulk arrays never pass through here: they are plain data, cast by bytemuck.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use serde::{Serialize, de::DeserializeOwned};

/// Maximum length of an encoded value, in bytes: enough for the names of 65,536 parts.
pub const ENCODED_MAX: usize = 8 << 20;

const FORM: Configuration<LittleEndian, Fixint, Limit<ENCODED_MAX>> =
    bincode::config::standard().with_fixed_int_encoding().with_limit::<ENCODED_MAX>();

/// A value could not be encoded, or bytes are not the encoding of one.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodecError {
    /// The value is too long: shorten its names.
    #[error("encoded length {0} is above {ENCODED_MAX} bytes")]
    TooLong(usize),
    /// The value cannot be encoded.
    #[error("value cannot be encoded: {0}")]
    Encode(String),
    /// The bytes are damaged or of another version.
    #[error("bytes cannot be decoded: {0}")]
    Decode(String),
    /// The bytes hold more than one value: damaged or of another version.
    #[error("decoding used {used} of {given} bytes")]
    Trailing {
        /// Number of bytes used by the value.
        used: usize,
        /// Number of bytes given.
        given: usize,
    },
}

/// Encodes a value.
///
/// # Errors
///
/// The encoding is longer than [`ENCODED_MAX`], or the type cannot be encoded.
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(value, FORM)
        .map_err(|fault| CodecError::Encode(fault.to_string()))?;
    // The configured limit applies to decoding only.
    if bytes.len() > ENCODED_MAX { Err(CodecError::TooLong(bytes.len())) } else { Ok(bytes) }
}

/// Decodes a value that takes all of `bytes`.
///
/// # Errors
///
/// The bytes are not such a value, too many, too few, or claim more than [`ENCODED_MAX`].
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let (value, used) = bincode::serde::decode_from_slice(bytes, FORM)
        .map_err(|fault| CodecError::Decode(fault.to_string()))?;
    if used == bytes.len() {
        Ok(value)
    } else {
        Err(CodecError::Trailing { used, given: bytes.len() })
    }
}

#[cfg(test)]
mod tests;
