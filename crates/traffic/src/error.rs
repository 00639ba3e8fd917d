//! What is wrong with a traffic file: file, line, element, fault and remedy, in that order.

use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// A file that cannot be used.
///
/// ```
/// let text = "<commonRoad commonRoadVersion=\"2017a\"/>";
/// let error = trolley_traffic::read("a.xml", text, &Default::default()).unwrap_err();
/// assert!(error.to_string().starts_with("a.xml:1:1: <commonRoad>: version \"2017a\""));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}:{column}: {what}")]
pub struct TrafficError {
    /// The file, as named by the caller.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
    /// Which element, and what is wrong with it, on one line.
    pub what: String,
    /// What to do about it, on one line.
    pub remedy: String,
}

impl Diagnostic for TrafficError {
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
