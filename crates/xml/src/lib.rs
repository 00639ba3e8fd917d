//! XML of strangers: a document, or a refusal, in time and memory that follow from the limits.
//!
//! ```text
//! text --scan: one pass, no memory--> counts within the limits --roxmltree--> Document
//! ```
//!
//! The parser compares each attribute of an element with all others, and copies the namespaces in
//! scope for each element that declares one: an element with 200,000 attributes takes a minute. It
//! bounds nodes only. So the text is counted first, with the parser's own rules of where a tag, a
//! comment or a value ends, and refused if a count is beyond its limit.
//!
//! # Invariants
//!
//! - What the parser accepts was counted right: `tests.rs`.
//! - Document type declarations are refused, so entities cannot multiply: `tests.rs`.
//!
//! ```
//! let document = trolley_xml::parse("<a b='1'><c/></a>", 100)?;
//! assert_eq!(document.root_element().attribute("b"), Some("1"));
//!
//! let many: String = (0..65).map(|i| format!(" a{i}=''")).collect();
//! let error = trolley_xml::parse(&format!("<a{many}/>"), 100).unwrap_err();
//! assert!(error.to_string().contains("more than 64 attributes"));
//! # Ok::<(), trolley_xml::XmlError>(())
//! ```

mod scan;
#[cfg(test)]
mod tests;

use roxmltree::{Document, ParsingOptions};
use scan::Excess;

/// Maximum number of attributes of an element, declarations of namespaces among them. The formats
/// that are read here have fewer than twenty.
pub const ATTRIBUTES_MAX: usize = 64;
/// Maximum number of elements in each other.
pub const DEPTH_MAX: usize = 512;
/// Maximum number of declarations of namespaces.
pub const NAMESPACES_MAX: usize = 64;

/// A text that was refused. Line and column count from 1.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum XmlError {
    /// A count is beyond its limit.
    #[error("{what}, which is the limit")]
    TooMany {
        /// What there is too much of, and the limit.
        what: String,
        /// Line.
        line: u32,
        /// Column.
        column: u32,
    },
    /// There is a document type declaration.
    #[error("XML with DTD, a document type declaration, is not read")]
    Declaration {
        /// Line.
        line: u32,
    },
    /// It is not XML.
    #[error("{fault}")]
    Syntax {
        /// What the parser says.
        fault: String,
        /// Line.
        line: u32,
        /// Column.
        column: u32,
    },
}

impl XmlError {
    /// Line and column, from 1.
    #[must_use]
    pub fn position(&self) -> (u32, u32) {
        match self {
            Self::TooMany { line, column, .. } | Self::Syntax { line, column, .. } => {
                (*line, *column)
            }
            Self::Declaration { line } => (*line, 1),
        }
    }
}

/// Parses a text of at most `nodes_max` nodes (elements, texts, comments) and as many attributes.
/// Its length is for the caller to bound; time is linear in it.
///
/// # Errors
///
/// [`XmlError`] if it is no XML, has a document type declaration, or a count is beyond
/// [`ATTRIBUTES_MAX`], [`DEPTH_MAX`], [`NAMESPACES_MAX`] or `nodes_max`.
pub fn parse(text: &str, nodes_max: u32) -> Result<Document<'_>, XmlError> {
    scan::scan(text, nodes_max as usize).map_err(|(byte, excess)| {
        let (line, column) = position(text, byte);
        let what = match excess {
            Excess::Attributes => format!("an element has more than {ATTRIBUTES_MAX} attributes"),
            Excess::Depth => format!("more than {DEPTH_MAX} elements are nested in each other"),
            Excess::Namespaces => format!("more than {NAMESPACES_MAX} namespaces are declared"),
            Excess::Elements => format!("there are more than {nodes_max} elements"),
            Excess::AttributesInAll => format!("there are more than {nodes_max} attributes"),
        };
        XmlError::TooMany { what, line, column }
    })?;
    let options =
        ParsingOptions { allow_dtd: false, nodes_limit: nodes_max, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        match error {
            // The parser does not say where the declaration is.
            roxmltree::Error::DtdDetected => {
                let before = text.find("<!DOCTYPE").map_or("", |byte| &text[..byte]);
                XmlError::Declaration { line: 1 + before.matches('\n').count() as u32 }
            }
            roxmltree::Error::NodesLimitReached => {
                let what = format!("there are more than {nodes_max} elements and texts");
                XmlError::TooMany { what, line: at.row, column: at.col }
            }
            other => XmlError::Syntax { fault: other.to_string(), line: at.row, column: at.col },
        }
    })
}

/// Line and column of a byte, from 1; the column in characters.
fn position(text: &str, byte: usize) -> (u32, u32) {
    let before = &text[..byte];
    let line = before.rfind('\n').map_or(0, |feed| feed + 1);
    (1 + before.matches('\n').count() as u32, 1 + before[line..].chars().count() as u32)
}
