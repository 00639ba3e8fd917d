//! Why a mesh was rejected: the file, the place in it, the problem, the remedy.

use super::Format;
use core::fmt;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;

/// A mesh was rejected. Displays as one sentence, `file: place: fault`; [`Diagnostic::remedy`]
/// gives the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{file}: {place}{fault}")]
pub struct ImportError {
    /// Name of the file, as the caller gave it.
    pub file: String,
    /// The place in the file.
    pub place: FilePosition,
    /// The problem.
    pub fault: MeshDefect,
}

/// The place of a fault in a file.
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

/// The problem with a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshDefect {
    /// The extension is not that of a supported format.
    #[error("{what} cannot be imported")]
    Unsupported {
        /// What the file is, as far as it can be determined.
        what: String,
    },
    /// The content is of another format than the extension indicates.
    #[error("named {named}, but its content looks like {looks}")]
    Misnamed {
        /// Format of the extension.
        named: Format,
        /// What the content looks like.
        looks: String,
    },
    /// The file breaks the rules of its format.
    #[error("{0}")]
    Syntax(String),
    /// The file uses an unsupported feature of its format.
    #[error("{0} is not supported")]
    Feature(String),
    /// The file ends too early, or claims more than it contains.
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
    /// A face refers to a vertex that does not exist.
    #[error("index {index} is out of range: {range}")]
    Index {
        /// The index as written.
        index: i64,
        /// The valid range.
        range: String,
    },
    /// The file holds no triangle.
    #[error("no triangle{0}")]
    Empty(String),
    /// A limit on counts or sizes is exceeded.
    #[error("{what}: {count} is above the limit of {max}")]
    TooMany {
        /// What is counted.
        what: &'static str,
        /// The count.
        count: u64,
        /// The limit.
        max: u64,
    },
    /// A side file is not available.
    #[error("side file \"{name}\": {reason}")]
    SideFile {
        /// Name as written.
        name: String,
        /// The reason.
        reason: String,
    },
    /// A node's transform flattens everything below it.
    #[error("transform is singular (determinant {0}): it flattens the body")]
    Singular(f64),
    /// No part has a requested name.
    #[error("no part is named {asked}; the names are {names}")]
    NoSuchPart {
        /// The requested name, quoted.
        asked: String,
        /// The existing names, quoted.
        names: String,
    },
    /// The format states no unit, and none was given.
    #[error("an LS-DYNA deck states no unit")]
    NoUnit,
    /// The options contradict each other.
    #[error("{0}")]
    Options(String),
    /// Its lines end with CR alone.
    #[error("its lines end with CR alone, as on a classic Mac")]
    LineEnds,
    /// The file is of a former version of its format.
    #[error("{0} is not supported")]
    Former(&'static str),
    /// The triangles are compressed by an extension of the format.
    #[error("its triangles are compressed with {0}, which is not supported")]
    Compressed(String),
    /// A deck that another one includes is not available.
    #[error("*INCLUDE of \"{name}\": {reason}")]
    Include {
        /// Name as written.
        name: String,
        /// The reason.
        reason: String,
    },
    /// A deck includes itself, directly or through others.
    #[error("the deck includes itself: {0}")]
    IncludesItself(String),
    /// The size is implausible for the kind of body.
    #[error(
        "{size} is not a plausible {kind}: its greatest length should be {least} to {greatest} m"
    )]
    Size {
        /// Size in words, metres.
        size: String,
        /// The expected kind.
        kind: String,
        /// Least plausible value of the greatest length, in metres.
        least: f64,
        /// Greatest plausible value of the greatest length, in metres.
        greatest: f64,
        /// The unit that would make it plausible, if any.
        unit: Option<&'static str>,
    },
}

impl ImportError {
    /// Creates an error at a place.
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
            MeshDefect::Unsupported { what } | MeshDefect::Misnamed { looks: what, .. }
                if what.contains("Git LFS") =>
            {
                "bring the file itself: git lfs pull"
            }
            // It is an archive, of what is not read either.
            MeshDefect::Unsupported { what } if what.starts_with("a file named .3mf") => {
                "convert it to OBJ, STL, PLY, glTF, GLB or COLLADA"
            }
            MeshDefect::Unsupported { what } | MeshDefect::Misnamed { looks: what, .. }
                if what.contains("gzip") =>
            {
                return Some(format!("unpack it first: gunzip -k {}", self.file).into());
            }
            MeshDefect::Unsupported { what } | MeshDefect::Misnamed { looks: what, .. }
                if what.contains("ZIP") =>
            {
                return Some(format!("unpack it first: unzip {}", self.file).into());
            }
            MeshDefect::LineEnds => {
                let file = &self.file;
                return Some(format!("convert them: tr '\\r' '\\n' < {file} > NEW").into());
            }
            MeshDefect::Former(_) => {
                "export it as glTF 2.0 (Blender: File, Export, glTF 2.0), or as OBJ"
            }
            MeshDefect::Compressed(_) => {
                "export it without compression (Blender: File, Export, glTF 2.0, Compression off)"
            }
            MeshDefect::Include { .. } => {
                "put the included deck into the folder of the mesh or below it, and write its name \
                 as seen from there: *INCLUDE_PATH is not followed"
            }
            MeshDefect::IncludesItself(_) => "remove the *INCLUDE that closes the circle",
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
            MeshDefect::Index { .. } => "correct this number, or export the mesh again",
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
