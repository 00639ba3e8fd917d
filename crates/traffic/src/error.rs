//! What is wrong with a traffic file: file, place, fault and remedy, in that order.

use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::fmt;

/// Where in a traffic file a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrafficPlace {
    /// It is about the whole file.
    Whole,
    /// In a text.
    Line {
        /// From 1.
        line: u32,
        /// From 1.
        column: u32,
    },
    /// In a message of a trace, from 1.
    Message(u64),
}

#[cfg(test)]
impl TrafficPlace {
    pub(crate) fn line(self) -> u32 {
        if let Self::Line { line, .. } = self { line } else { 0 }
    }
}

impl fmt::Display for TrafficPlace {
    /// As it stands behind the file's name: ":3:1", ": message 7", or nothing.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line { line, column } => write!(out, ":{line}:{column}"),
            Self::Message(number) => write!(out, ": message {number}"),
        }
    }
}

/// A file that cannot be used.
///
/// ```
/// let text = "<commonRoad commonRoadVersion=\"2017a\"/>";
/// let error = trolley_traffic::read("a.xml", text, &Default::default()).unwrap_err();
/// assert!(error.to_string().starts_with("a.xml:1:1: <commonRoad>: version \"2017a\""));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}{place}: {what}")]
pub struct TrafficError {
    /// The file, as named by the caller.
    pub file: String,
    /// Where in it.
    pub place: TrafficPlace,
    /// Which element or object, and what is wrong with it, on one line.
    pub what: String,
    /// What to do about it, on one line.
    pub remedy: String,
}

impl Diagnostic for TrafficError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn place(&self) -> Option<String> {
        Some(format!("{}{}", self.file, self.place))
    }

    fn what(&self) -> String {
        self.what.clone()
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(self.remedy.as_str().into())
    }
}
