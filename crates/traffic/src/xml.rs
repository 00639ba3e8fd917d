//! XML elements that know where they stand and what their file is called.
//!
//! The parser refuses every document type declaration, so entities cannot multiply; attributes and
//! nesting are bounded by it, text and nodes here.

use crate::error::{TrafficError, TrafficPlace};
use ::xml::XmlError;
use roxmltree::Node;

/// Longer texts are refused unread: an hour of a crossing with 100 obstacles has 30 MB.
pub const TEXT_BYTES_MAX: usize = 64 << 20;

/// Nodes of a document, at most: they are what takes memory, 72 bytes each.
const NODES_MAX: u32 = 4_000_000;

/// A parsed text.
pub(crate) struct Document<'t> {
    file: &'t str,
    tree: roxmltree::Document<'t>,
}

impl<'t> Document<'t> {
    pub(crate) fn parse(file: &'t str, text: &'t str) -> Result<Self, TrafficError> {
        let wrong = |line, column, fault: String, help: &str| TrafficError {
            file: file.to_owned(),
            place: TrafficPlace::Line { line, column },
            what: fault,
            remedy: help.to_owned(),
        };
        if text.len() > TEXT_BYTES_MAX {
            let fault = format!("{} bytes are too many for a traffic file", text.len());
            let help = format!("at most {TEXT_BYTES_MAX} bytes are read; is this the right file?");
            return Err(wrong(1, 1, fault, &help));
        }
        let start = text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']);
        if !start.starts_with('<') {
            let first: String = start.chars().take(12).collect();
            let fault = format!("not XML: it begins with {first:?}");
            return Err(wrong(1, 1, fault, "is this the right file? XML begins with <"));
        }
        let tree = ::xml::parse(text, NODES_MAX).map_err(|error| {
            let help = match error {
                XmlError::Declaration { .. } => {
                    "remove <!DOCTYPE …>: entities are not expanded, as they can fill all memory"
                }
                XmlError::TooMany { .. } => "is this the right file? split it",
                XmlError::Syntax { .. } => "the file is damaged, or no XML",
            };
            let (line, column) = error.position();
            wrong(line, column, format!("not readable as XML: {error}"), help)
        })?;
        Ok(Self { file, tree })
    }

    pub(crate) fn root(&self) -> Element<'_> {
        Element { file: self.file, node: self.tree.root_element() }
    }
}

/// An element.
#[derive(Clone, Copy)]
pub(crate) struct Element<'d> {
    file: &'d str,
    node: Node<'d, 'd>,
}

impl<'d> Element<'d> {
    pub(crate) fn name(&self) -> &'d str {
        self.node.tag_name().name()
    }

    /// How it is called in messages: name, and id or name attribute of itself or of the nearest
    /// element around it that has one.
    fn title(&self) -> String {
        let named = self.node.ancestors().find_map(|node| {
            let id = node.attribute("id").or_else(|| node.attribute("name"))?;
            Some((node, id))
        });
        let cut = |text: &str| text.chars().take(40).collect::<String>();
        match named {
            Some((node, id)) if node == self.node => {
                format!("<{} {:?}>", cut(self.name()), cut(id))
            }
            Some((node, id)) => {
                let (outer, id) = (cut(node.tag_name().name()), cut(id));
                format!("<{}> of <{outer} {id:?}>", cut(self.name()))
            }
            None => format!("<{}>", cut(self.name())),
        }
    }

    /// A fault here.
    pub(crate) fn fault(&self, fault: impl AsRef<str>, help: impl Into<String>) -> TrafficError {
        let at = self.node.document().text_pos_at(self.node.range().start);
        TrafficError {
            file: self.file.to_owned(),
            place: TrafficPlace::Line { line: at.row, column: at.col },
            what: format!("{}: {}", self.title(), fault.as_ref()),
            remedy: help.into(),
        }
    }

    /// All elements in it.
    pub(crate) fn children(&self) -> impl Iterator<Item = Element<'d>> + use<'d> {
        let file = self.file;
        self.node.children().filter(Node::is_element).map(move |node| Element { file, node })
    }

    /// All elements in it that have this name.
    pub(crate) fn all<'n>(&self, name: &'n str) -> impl Iterator<Item = Element<'d>> + use<'d, 'n> {
        self.children().filter(move |child| child.name() == name)
    }

    /// The first element in it that has this name.
    pub(crate) fn get(&self, name: &str) -> Option<Element<'d>> {
        self.all(name).next()
    }

    /// The same, where it must be.
    pub(crate) fn need(&self, name: &str) -> Result<Element<'d>, TrafficError> {
        self.get(name).ok_or_else(|| {
            self.fault(format!("<{name}> is missing"), format!("add <{name}>, or leave this out"))
        })
    }

    /// Its text without blank ends.
    pub(crate) fn text(&self) -> &'d str {
        self.node.text().unwrap_or_default().trim()
    }

    /// Its text as a finite number.
    pub(crate) fn number(&self) -> Result<f64, TrafficError> {
        let text = self.text();
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let shown: String = text.chars().take(40).collect();
                Err(self.fault(format!("{shown:?} is not a finite number"), "write a number"))
            }
        }
    }

    pub(crate) fn attribute(&self, name: &str) -> Option<&'d str> {
        self.node.attribute(name)
    }

    /// The value of an attribute, where it must be.
    pub(crate) fn need_attribute(&self, name: &str) -> Result<&'d str, TrafficError> {
        self.attribute(name).ok_or_else(|| {
            self.fault(format!("the attribute {name} is missing"), format!("add {name}=\"…\""))
        })
    }
}
