//! Arguments that are one of several names.

use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Parses a value by its name.
pub(super) fn named<T: Copy + Send + Sync + 'static, const N: usize>(
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name)).try_map(move |word: String| {
        all.into_iter().find(|one| name(*one) == word).ok_or("there is nothing of that name")
    })
}
