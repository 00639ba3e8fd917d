//! Why a mesh was refused: which file, where in it, what is wrong, what to do.

use super::Format;
use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// A mesh was refused. Displays as one sentence, `file: place: fault`; [`Diagnostic::remedy`]
/// says what to do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}: {place}{fault}")]
pub struct ImportError {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// Where in the file.
    pub place: FilePosition,
    /// What is wrong.
    pub fault: MeshDefect,
}

/// Where in a file a fault is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilePosition {
    /// The file as a whole.
    Whole,
    /// A line, counted from 1.
    Line(usize),
    /// A named element: "vertex 7", "mesh 2, primitive 0".
    Element(String),
}

impl fmt::Display for FilePosition {
    /// Ends with a colon and a space, unless the place is the whole file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(f, "line {line}: "),
            Self::Element(name) => write!(f, "{name}: "),
        }
    }
}

/// What is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshDefect {
    /// The name's extension is none that can be imported.
    #[error("{what} cannot be imported")]
    Unsupported {
        /// What the file is, as far as can be told.
        what: String,
    },
    /// The content is of another format than the extension says.
    #[error("named {named}, but its content looks like {looks}")]
    Misnamed {
        /// Format that the extension names.
        named: Format,
        /// What the content looks like.
        looks: String,
    },
    /// The file breaks the rules of its format.
    #[error("{0}")]
    Syntax(String),
    /// The file uses a part of its format that is not read.
    #[error("{0} is not supported")]
    Feature(String),
    /// The file ends too early or claims more than it has.
    #[error("{0}")]
    Truncated(String),
    /// A coordinate is not finite.
    #[error("coordinate {value} is not finite")]
    NotFinite {
        /// The value.
        value: f64,
    },
    /// A coordinate is too far away.
    #[error("coordinate {metres} m is beyond {max} m")]
    TooFar {
        /// The coordinate in metres.
        metres: f64,
        /// The limit in metres.
        max: f64,
    },
    /// A face names a vertex that does not exist.
    #[error("index {index} is out of range: {range}")]
    Index {
        /// The index as written.
        index: i64,
        /// What would be in range.
        range: String,
    },
    /// The file holds no triangle.
    #[error("no triangle{0}")]
    Empty(String),
    /// A limit on counts or sizes.
    #[error("{what}: {count} is above the limit of {max}")]
    TooMany {
        /// What is counted.
        what: &'static str,
        /// How many.
        count: u64,
        /// How many at most.
        max: u64,
    },
    /// A side file cannot be had.
    #[error("side file \"{name}\": {reason}")]
    SideFile {
        /// Name as written.
        name: String,
        /// Why not.
        reason: String,
    },
    /// A node's transform flattens what is below it.
    #[error("transform is singular (determinant {0}): it flattens the body")]
    Singular(f64),
    /// No part has a name that was asked for.
    #[error("no part is named {asked}; the names are {names}")]
    NoSuchPart {
        /// The name that was asked for, quoted.
        asked: String,
        /// The names that there are, quoted.
        names: String,
    },
    /// The format states no unit, and nobody else did.
    #[error("an LS-DYNA deck states no unit")]
    NoUnit,
    /// The options contradict each other.
    #[error("{0}")]
    Options(String),
    /// The body is too small or too large to be what it is said to be.
    #[error("{size} is no plausible {kind}: its greatest length should be {least} to {greatest} m")]
    Size {
        /// Size in words, metres.
        size: String,
        /// What it should be.
        kind: String,
        /// Least plausible greatest length in metres.
        least: f64,
        /// Greatest plausible greatest length in metres.
        greatest: f64,
        /// The unit that would make it plausible, if there is one.
        unit: Option<&'static str>,
    },
}

impl ImportError {
    /// A fault at a place.
    #[must_use]
    pub fn new(file: &str, place: FilePosition, fault: MeshDefect) -> Self {
        Self { file: file.to_owned(), place, fault }
    }
}

impl Diagnostic for ImportError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match &self.fault {
            MeshDefect::Unsupported { .. } => {
                "convert it to OBJ, STL, PLY, glTF, GLB or COLLADA (Blender: File, Export)"
            }
            MeshDefect::Misnamed { looks, .. } => {
                match Format::ALL.iter().find(|f| f.name() == looks) {
                    Some(format) => {
                        return Some(format!("rename it to end in .{}", format.extension()).into());
                    }
                    None => "convert it to UTF-8 OBJ, STL, PLY, glTF or GLB",
                }
            }
            MeshDefect::Syntax(_) => "correct this place, or export the mesh again",
            MeshDefect::Feature(_) => "export the mesh without it",
            MeshDefect::Truncated(_) => {
                "the file is incomplete: copy it again, or export the mesh again"
            }
            MeshDefect::NotFinite { .. } => {
                "export the mesh again: NaN and infinity are no \
                                        positions"
            }
            MeshDefect::TooFar { .. } => {
                "state the unit (--unit mm, cm, inch, ...), or move the body \
                                     to the origin"
            }
            MeshDefect::Index { .. } => "correct the face, or export the mesh again",
            MeshDefect::Empty(_) => "export the surface as triangles or polygons",
            MeshDefect::TooMany { .. } => "reduce the mesh, or import parts of it with --only",
            MeshDefect::SideFile { .. } => {
                "put the side file beside the mesh, or export as one .glb \
                                       file"
            }
            MeshDefect::Singular(_) => "apply the transforms when exporting",
            MeshDefect::NoSuchPart { .. } => "give one of these names to --only",
            MeshDefect::NoUnit => {
                "state the length that it was written in: --unit mm, --unit m, ..."
            }
            MeshDefect::Options(_) => "the axes are +x, -x, +y, -y, +z, -z",
            MeshDefect::Size { unit: Some(unit), .. } => {
                return Some(
                    format!("is its unit {unit}? then import it with --unit {unit}").into(),
                );
            }
            MeshDefect::Size { unit: None, .. } => {
                "state its unit or a factor with --unit, and check --kind"
            }
        };
        Some(remedy.into())
    }
}
