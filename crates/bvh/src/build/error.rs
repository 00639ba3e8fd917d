//! Why a tree could not be built, and the remedy.

use super::{LEAF_SIZE_MAX, LITERAL_MAX, TRIANGLES_MAX};
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::fmt;

/// The error of a tree build. As text: the problem and, after a colon, the remedy, if any.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BuildError {
    /// There are no triangles.
    Empty,
    /// There are more triangles than numbers for them.
    TooMany {
        /// Number of triangles.
        triangles: usize,
    },
    /// The literal build would take too long.
    Literal {
        /// Number of triangles.
        triangles: usize,
    },
    /// The leaf size is out of range.
    LeafSize {
        /// The requested leaf size.
        leaf_size: u32,
    },
    /// A coordinate is NaN or infinite.
    NotFinite {
        /// Its number, in the given order.
        triangle: usize,
    },
    /// The arrays of a mesh differ in length.
    Lengths {
        /// Number of triangles.
        triangles: usize,
        /// The array that differs.
        array: &'static str,
        /// Its number of entries.
        entries: usize,
    },
}

impl Diagnostic for BuildError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn what(&self) -> String {
        match self {
            Self::Empty => "the body has no triangles".into(),
            Self::TooMany { triangles } => {
                format!("the body has {triangles} triangles, at most {TRIANGLES_MAX} are possible")
            }
            Self::Literal { triangles } => format!(
                "the literal build takes at most {LITERAL_MAX} triangles, the body has {triangles}"
            ),
            Self::LeafSize { leaf_size } => {
                format!("a leaf size of {leaf_size} is not possible")
            }
            Self::NotFinite { triangle } => {
                format!("triangle {triangle} has a coordinate that is not finite")
            }
            Self::Lengths { triangles, array, entries } => format!(
                "the mesh has {triangles} triangles but {entries} {array}: both must be equal"
            ),
        }
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        let remedy = match self {
            Self::Empty => "import a mesh with faces, or select another group",
            Self::TooMany { .. } => "simplify it",
            Self::Literal { .. } => {
                "use the build 'paper', which is the same split with a balance rule"
            }
            Self::LeafSize { .. } => return Some(format!("use 1 to {LEAF_SIZE_MAX}").into()),
            Self::NotFinite { .. } => "repair the mesh",
            Self::Lengths { .. } => return None,
        };
        Some(remedy.into())
    }
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what())?;
        self.remedy().map_or(Ok(()), |remedy| write!(f, ": {remedy}"))
    }
}

impl std::error::Error for BuildError {}
