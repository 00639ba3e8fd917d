//! What a scenario names: bodies, files, parties.

use crate::document::TextPosition;
use crate::limit;
use body::Shape;

/// How many candidates a scenario has at most.
pub const CANDIDATES_MAX: usize = limit::CANDIDATES.most;

/// A name; copies of it take nothing from the heap.
pub type Name = smol_str::SmolStr;

/// Number of a party in [`crate::HorizonScenario::parties`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PartyIndex(pub usize);

/// A path as written, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileRef {
    /// The path, relative to the scenario's file unless it is absolute. Whoever opens it makes sure
    /// that it does not lead out of the scenario's folder, unless the user allows that.
    pub path: String,
    /// Where it was written, for the error if it cannot be opened.
    pub place: TextPosition,
}

/// Where a body's triangles come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A model file.
    File(FileRef),
    /// The built-in generator.
    Generate {
        /// What it is.
        shape: Shape,
        /// How many triangles, 500 to 1,000,000.
        triangles: u32,
        /// Seed of its small variations.
        seed: u64,
    },
}
