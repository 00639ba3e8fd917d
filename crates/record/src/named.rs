//! Settings that are written as their names: a record says them in words, and its bytes stay the
//! same when another one is added.

use crate::content::Mode;
use body::Build;
use scenario::Scheme;
use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

/// Something with a name.
pub(crate) trait Named: Copy + 'static {
    /// All there are.
    const ALL: &'static [Self];

    /// What a record calls it.
    fn name(self) -> &'static str;
}

impl Named for Mode {
    const ALL: &'static [Self] = &Self::ALL;

    fn name(self) -> &'static str {
        self.name()
    }
}

impl Named for Build {
    const ALL: &'static [Self] = &Self::ALL;

    fn name(self) -> &'static str {
        self.name()
    }
}

impl Named for Scheme {
    const ALL: &'static [Self] = &Self::ALL;

    fn name(self) -> &'static str {
        self.name()
    }
}

/// For `#[serde(with = "named")]`.
pub(crate) fn serialize<T: Named, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(value.name())
}

/// For `#[serde(with = "named")]`.
pub(crate) fn deserialize<'de, T: Named, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    let name = String::deserialize(from)?;
    let known = T::ALL.iter().find(|known| known.name() == name);
    known.copied().ok_or_else(|| D::Error::custom(format!("\"{name}\" is not known")))
}
