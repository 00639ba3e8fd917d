//! Which body represents which type: a data file.

use body::Shape;
use keys::Twice;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Name and version of the form.
const SCHEMA: &str = "trolley.bodies/1";

/// The library that comes with the program.
pub const DEFAULT_LIBRARY: &str = include_str!("../config/bodies/default.toml");

/// Bodies by type.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    bodies: BTreeMap<String, Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    schema: String,
    bodies: BTreeMap<String, Entry>,
}

/// A body of the library, as it is written.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    pub(crate) shape: Option<String>,
    pub(crate) triangles: Option<u32>,
    #[serde(default)]
    pub(crate) seed: u32,
    pub(crate) file: Option<String>,
    #[serde(default)]
    pub(crate) nobody: bool,
    #[serde(default)]
    pub(crate) unknown: bool,
}

impl Library {
    /// Reads a library.
    ///
    /// # Errors
    ///
    /// What is wrong, and where, on one line.
    pub fn parse(file: &str, text: &str) -> Result<Self, String> {
        let read: File = toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = text.get(..start).unwrap_or(text).matches('\n').count() + 1;
            match Twice::in_toml(text, &error) {
                Some(twice) => format!("{file}:{line}: {}; {}", twice.what(), Twice::REMEDY),
                None => format!("{file}:{line}: {}", error.message()),
            }
        })?;
        if read.schema != SCHEMA {
            let known = format!("this version reads schema = {SCHEMA:?}");
            return Err(format!("{file}: schema {:?} is not known; {known}", read.schema));
        }
        for (name, entry) in &read.bodies {
            let wrong = |fault: &str| Err(format!("{file}: body \"{name}\": {fault}"));
            match (&entry.shape, &entry.file) {
                (Some(shape), None) => {
                    if !Shape::ALL.iter().any(|known| known.name() == shape) {
                        let known: Vec<&str> = Shape::ALL.iter().map(|s| s.name()).collect();
                        let known = known.join(", ");
                        return wrong(&format!("shape \"{shape}\" is none of {known}"));
                    }
                }
                (None, Some(_)) if entry.triangles.is_none() => {}
                _ => return wrong("write shape and triangles, or file"),
            }
            if entry.unknown && entry.nobody {
                return wrong("an unknown body has no occupants anyway: leave out \"nobody\"");
            }
        }
        Ok(Self { bodies: read.bodies })
    }

    pub(crate) fn get(&self, kind: &str) -> Option<&Entry> {
        self.bodies.get(kind)
    }

    /// The types that it has bodies for.
    pub(crate) fn types(&self) -> String {
        self.bodies.keys().map(String::as_str).collect::<Vec<_>>().join(", ")
    }

    /// The model files that it names, so that the caller can check them first.
    #[must_use]
    pub fn files(&self) -> Vec<&str> {
        self.bodies.values().filter_map(|entry| entry.file.as_deref()).collect()
    }

    /// This library with every file name mapped.
    #[must_use]
    pub fn with_files(mut self, mut change: impl FnMut(&str) -> String) -> Self {
        for entry in self.bodies.values_mut() {
            entry.file = entry.file.as_deref().map(&mut change);
        }
        self
    }
}
