//! A fault in a data file (curves, policies): file, place, what is wrong, what would be right.

use core::ops::Range;
use diagnostic::{Diagnostic, FailureKind};
use keys::Twice;
use std::borrow::Cow;

/// A data file that is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {what}")]
pub struct DataFileError {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub what: String,
    /// What would be right.
    pub remedy: String,
}

impl Diagnostic for DataFileError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn place(&self) -> Option<String> {
        Some(format!("{}:{}:{}", self.file, self.line, self.column))
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}

/// A text being read, and the file name for errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) file: &'a str,
    pub(crate) text: &'a str,
}

impl Source<'_> {
    /// The line of a place in the text, from 1.
    pub(crate) fn line(&self, span: Range<usize>) -> usize {
        self.text.get(..span.start).unwrap_or("").matches('\n').count() + 1
    }

    /// A fault at a place in the text.
    pub(crate) fn fault(
        &self,
        span: Range<usize>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> DataFileError {
        let before = self.text.get(..span.start).unwrap_or("");
        let line = self.line(span);
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        let file = self.file.to_owned();
        DataFileError { file, line, column, what: what.into(), remedy: remedy.into() }
    }

    /// A fault that the TOML reader found. `keys` lists what belongs in such a file.
    pub(crate) fn malformed(&self, error: &toml::de::Error, keys: &str) -> DataFileError {
        const TRAITS: [&str; 6] = ["age", "sex", "gender", "condition", "race", "disability"];
        let span = error.span().unwrap_or(0..0);
        if let Some(twice) = Twice::in_toml(self.text, error) {
            return self.fault(span, twice.what(), Twice::REMEDY);
        }
        let message = error.message();
        let trait_ = TRAITS.iter().find(|t| message.contains(&format!("unknown field `{t}`")));
        let remedy = match trait_ {
            Some(t) => format!(
                "remove it: harm is never weighed by {t}; persons carry kind, body and seat only"
            ),
            None => keys.to_owned(),
        };
        self.fault(span, message, remedy)
    }
}
