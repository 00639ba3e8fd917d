//! Keys that stand twice in a text: which, and where both of them stand.
//!
//! ```text
//! text + error of the TOML reader --Twice::in_toml--> the key and both its lines, if that is it
//! JSON                            --Twice::in_json--> the first such key of any object
//! ```
//!
//! The readers say only where the second one is, or take the last silently. Texts are searched only
//! once they are refused (TOML), or in one pass (JSON).
//!
//! ```
//! let text = "mass_kg = 1\nname = \"a\"\nmass_kg = 2\n";
//! let error = toml::from_str::<toml::Table>(text).unwrap_err();
//! let twice = trolley_keys::Twice::in_toml(text, &error).ok_or("another fault")?;
//! assert_eq!(twice.what(), "\"mass_kg\" stands here a second time: it is in line 1 already");
//! assert_eq!(twice.second, 23..30);
//! # Ok::<(), &str>(())
//! ```

mod json;
#[cfg(test)]
mod tests;
mod toml_text;

use std::ops::Range;

/// A key, or the table or list of that name, that stands twice in one table or object.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Twice {
    /// The key as it is written, cut to 60 characters, without quotes.
    pub key: String,
    /// Where it first stands, in bytes of the text; `None` if that is not known.
    pub first: Option<Range<usize>>,
    /// Where it stands again, in bytes of the text.
    pub second: Range<usize>,
    /// The line of `first`, from 1.
    first_line: Option<usize>,
}

impl Twice {
    /// What to do about it.
    pub const REMEDY: &str = "leave one of them out: each key and each table stands once";

    /// The key that the TOML reader refused because it stands twice; `None` if it refused the text
    /// for another reason.
    ///
    /// `error` is that of reading `text`.
    #[must_use]
    pub fn in_toml(text: &str, error: &toml::de::Error) -> Option<Self> {
        // The wording is held by `tests.rs`.
        if error.message() != toml_text::DUPLICATE {
            return None;
        }
        let second = error.span()?;
        Some(Self::new(text, toml_text::first(text, &second), second))
    }

    /// The first key that stands twice in one object of a JSON text; `None` if there is none, or
    /// the text is no JSON before it.
    #[must_use]
    pub fn in_json(text: &str) -> Option<Self> {
        let [first, second] = json::twice(text)?;
        Some(Self::new(text, Some(first), second))
    }

    fn new(text: &str, first: Option<Range<usize>>, second: Range<usize>) -> Self {
        /// A key may be as long as its file.
        const SHOWN: usize = 60;
        let written = text.get(second.clone()).unwrap_or_default().trim();
        let bare = written.trim_matches(['"', '\'']);
        let mut key: String = bare.chars().take(SHOWN).collect::<String>();
        if bare.chars().nth(SHOWN).is_some() {
            key.push('…');
        }
        let first_line = first.as_ref().map(|first| line_of(text, first.start));
        Self { key, first, second, first_line }
    }

    /// The fault as a sentence without a full stop, for the place of the second one.
    #[must_use]
    pub fn what(&self) -> String {
        let first = self.first_line;
        let first = first.map_or(String::new(), |line| format!(": it is in line {line} already"));
        format!("{:?} stands here a second time{first}", self.key)
    }
}

/// The line of a byte, from 1.
fn line_of(text: &str, byte: usize) -> usize {
    text.as_bytes()[..byte.min(text.len())].iter().filter(|byte| **byte == b'\n').count() + 1
}
