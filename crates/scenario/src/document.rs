//! The text of a scenario as a tree that knows the position of everything.
//!
//! Places are looked up only when something is wrong or names a file, by the path of keys and
//! numbers that leads to it; so the values themselves stay plain. It does not know what any key
//! means.

use keys::Twice;
use serde::de::DeserializeOwned;
use std::fmt;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

/// A place in a text, as editors count: from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TextPosition {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
}

impl TextPosition {
    /// The beginning of a text: the place of whatever is missing from all of it.
    pub const START: Self = Self { line: 1, column: 1 };
}

impl fmt::Display for TextPosition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

/// One step down the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Key(String),
    Index(usize),
}

/// The way from the root of a document to something in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Path(pub(crate) Vec<Step>);

impl Path {
    /// One step further, to the value of a key.
    pub(crate) fn key(&self, key: &str) -> Self {
        self.with(Step::Key(key.to_owned()))
    }

    /// One step further, to an item of a list.
    pub(crate) fn index(&self, index: usize) -> Self {
        self.with(Step::Index(index))
    }

    fn with(&self, step: Step) -> Self {
        Self(self.0.iter().cloned().chain([step]).collect())
    }

    /// The last key on the way.
    pub(crate) fn last_key(&self) -> Option<&str> {
        self.0.iter().rev().find_map(|step| match step {
            Step::Key(key) => Some(key.as_str()),
            Step::Index(_) => None,
        })
    }

    /// Whether the way leads through the value of this key.
    pub(crate) fn passes(&self, name: &str) -> bool {
        self.0.iter().any(|step| matches!(step, Step::Key(key) if key == name))
    }
}

/// As one would say it: `[candidates.other]`, without numbers, long keys and long ways cut.
impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let keys = self.0.iter().filter_map(|step| match step {
            Step::Key(key) => {
                Some(key.chars().take(40).collect::<String>().escape_debug().to_string())
            }
            Step::Index(_) => None,
        });
        let keys: Vec<String> = keys.take(5).collect();
        write!(f, "[{}]", keys.join("."))
    }
}

/// What the TOML reader rejects.
pub(crate) struct Objection {
    pub(crate) place: TextPosition,
    /// The path to what it rejects; `None` if the text is not TOML at all.
    pub(crate) path: Option<Path>,
    pub(crate) message: String,
}

/// A parsed text. Keys and values know their places.
pub(crate) struct Document<'t> {
    lines: Lines<'t>,
    root: Spanned<DeTable<'t>>,
}

impl<'t> Document<'t> {
    /// Parses TOML.
    pub(crate) fn parse(text: &'t str) -> Result<Self, Objection> {
        let lines = Lines::of(text);
        match DeTable::parse(text) {
            Ok(root) => Ok(Self { lines, root }),
            Err(error) => {
                let span = error.span().unwrap_or_default();
                let place = lines.place(span.start);
                let twice = Twice::in_toml(text, &error);
                let message =
                    twice.map_or_else(|| error.message().to_owned(), |twice| twice.what());
                Err(Objection { place, path: None, message })
            }
        }
    }

    /// The value at the end of a path.
    pub(crate) fn value(&self, path: &Path) -> Option<&DeValue<'t>> {
        let mut steps = path.0.iter();
        let mut value = At::Table(self.root.get_ref()).step(steps.next()?)?;
        for step in steps {
            value = At::of(value.get_ref()).step(step)?;
        }
        Some(value.get_ref())
    }

    /// Reads the whole document as one value.
    pub(crate) fn read<T: DeserializeOwned>(&self) -> Result<T, Objection> {
        T::deserialize(Deserializer::from(self.root.clone())).map_err(|error| {
            let span = error.span().unwrap_or_default();
            let path = self.path_at(&span);
            Objection {
                place: self.lines.place(span.start),
                path: Some(path),
                message: error.message().to_owned(),
            }
        })
    }

    /// The position of the value at the end of a path, or of the longest existing prefix.
    pub(crate) fn place(&self, path: &Path) -> TextPosition {
        let mut start = 0;
        let mut at = At::Table(self.root.get_ref());
        for step in &path.0 {
            let Some(value) = at.step(step) else { break };
            // A table that no header or brace opened has no place of its own.
            if !value.span().is_empty() {
                start = value.span().start;
            }
            at = At::of(value.get_ref());
        }
        self.lines.place(start)
    }

    /// The way to the key or value that has this span; the root if there is none.
    fn path_at(&self, span: &Range<usize>) -> Path {
        let mut open = vec![(Path::default(), At::Table(self.root.get_ref()))];
        // Ends: the tree is finite and each node is opened once.
        while let Some((path, at)) = open.pop() {
            for (step, key, value) in at.children() {
                let way = path.with(step);
                if key == *span || value.span() == *span {
                    return way;
                }
                open.push((way, At::of(value.get_ref())));
            }
        }
        Path::default()
    }
}

/// A node of the tree.
#[derive(Clone, Copy)]
enum At<'d, 't> {
    Table(&'d DeTable<'t>),
    List(&'d [Spanned<DeValue<'t>>]),
    Leaf,
}

impl<'d, 't> At<'d, 't> {
    fn of(value: &'d DeValue<'t>) -> Self {
        match value {
            DeValue::Table(table) => Self::Table(table),
            DeValue::Array(items) => Self::List(items),
            _ => Self::Leaf,
        }
    }

    /// What one step leads to.
    fn step(self, step: &Step) -> Option<&'d Spanned<DeValue<'t>>> {
        match (self, step) {
            (Self::Table(table), Step::Key(key)) => table.get(key.as_str()),
            (Self::List(items), Step::Index(index)) => items.get(*index),
            _ => None,
        }
    }

    /// All steps from here, with the span of the key (of the item itself in a list) and the value.
    fn children(self) -> Vec<(Step, Range<usize>, &'d Spanned<DeValue<'t>>)> {
        match self {
            Self::Table(table) => (table.iter())
                .map(|(key, value)| (Step::Key(key.get_ref().to_string()), key.span(), value))
                .collect(),
            Self::List(items) => (items.iter().enumerate())
                .map(|(index, value)| (Step::Index(index), value.span(), value))
                .collect(),
            Self::Leaf => Vec::new(),
        }
    }
}

/// A text and where its lines begin: thousands of places are asked for in a long scenario.
struct Lines<'t> {
    text: &'t str,
    /// The first byte of each line; the first is 0.
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    fn of(text: &'t str) -> Self {
        let starts = [0].into_iter().chain(text.match_indices('\n').map(|(end, _)| end + 1));
        Self { text, starts: starts.collect() }
    }

    /// Line and column of a byte; the end of the text if it is beyond.
    fn place(&self, byte: usize) -> TextPosition {
        let byte = if self.text.is_char_boundary(byte) { byte } else { self.text.len() };
        let line = self.starts.partition_point(|start| *start <= byte);
        let column = self.text[self.starts[line - 1]..byte].chars().count() + 1;
        TextPosition { line, column }
    }
}

#[cfg(test)]
mod tests;
