//! Settings that are written as their names: a record says them in words, and its bytes stay the
//! same when another one is added.

use crate::content::Mode;
use body::Build;
use scenario::Scheme;
use serde::{Deserialize as _, Deserializer, Serializer, de::Error as _};

/// Something with a name.
pub(crate) trait Named: Copy + 'static {
    /// All values.
    const ALL: &'static [Self];

    /// Its name in records.
    fn name(self) -> &'static str;

    /// What a record means by a name.
    fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|known| known.name() == name)
    }
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

    fn from_name(name: &str) -> Option<Self> {
        Self::from_name(name)
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
    T::from_name(&name).ok_or_else(|| D::Error::custom(format!("\"{name}\" is not known")))
}

#[cfg(test)]
mod tests {
    //! Names that records have used are still read.
    use super::*;
    use body::codec;

    #[derive(serde::Deserialize)]
    struct Tree(#[serde(with = "crate::named")] Build);

    #[test]
    fn the_former_name_of_the_papers_split_is_read() {
        for name in ["paper", "seed"] {
            let bytes = codec::encode(&name).expect("short");
            assert_eq!(codec::decode::<Tree>(&bytes).expect("known").0, Build::Paper, "{name}");
        }
        assert!(codec::decode::<Tree>(&codec::encode(&"oak").expect("short")).is_err());
    }
}
