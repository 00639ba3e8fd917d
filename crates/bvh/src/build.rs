//! Building a tree: options, errors, and the steps from triangles to a tree, and to a body.
//!
//! ```text
//! triangles --hierarchy--> Hierarchy --assemble--> Tree --with all else of a mesh--> Body
//! ```
//!
//! The tree depends only on the triangles, the build and the leaf size. `grow` cuts ranges and lays
//! nodes out; `paper` and `sah` choose the cuts, independently of each other. `thread_pool`
//! distributes work among threads.

mod assemble;
mod error;
mod grow;
mod paper;
mod sah;
mod thread_pool;

pub(crate) use assemble::assembled;
pub use assemble::{body, rebuild};
pub use error::BuildError;
pub use grow::worth_starting;
pub use thread_pool::in_threads;

use body::Node;
use geometry::Corners;
use thread_pool::BuildPool;

pub use body::{Build, LEAF_SIZE_MAX};

/// Maximum number of triangles for [`Build::Literal`]: its tree may be as deep as there are
/// triangles, so its time is quadratic.
pub const LITERAL_MAX: usize = 50_000;

/// Maximum number of triangles of a tree: a hit has 31 bits for its number.
pub const TRIANGLES_MAX: usize = 1 << 31;

/// How to build a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// The split rule.
    pub build: Build,
    /// Maximum number of triangles in a leaf, 1 to [`LEAF_SIZE_MAX`]. The paper uses 1.
    pub leaf_size: u32,
    /// Threads to build with; 0 counts as 1. The tree does not depend on it. With several threads,
    /// a caller inside a rayon pool builds with the threads of that pool, which can thus be started
    /// before there is something to build.
    pub threads: usize,
}

impl Default for BuildOptions {
    /// The paper's split, four triangles per leaf, one thread.
    fn default() -> Self {
        Self { build: Build::Paper, leaf_size: 4, threads: 1 }
    }
}

/// The nodes of a tree and the resulting order of triangles, without the triangles themselves.
#[derive(Clone, Debug, PartialEq)]
pub struct Hierarchy {
    /// Nodes in preorder: the left child of `i` is `i + 1`, the right one its `link`.
    pub nodes: Vec<Node>,
    /// For each place in leaf order, the number of its triangle. Ascending in a leaf.
    pub order: Vec<u32>,
    /// Number of nodes on the longest path from the root: 1 for a single leaf.
    pub depth: u32,
}

/// Builds the nodes of a tree over `corners`; [`crate::Tree::build`] builds a whole tree.
///
/// `progress` is called with the number of triangles placed *since the last call*, from any of the
/// threads, every few thousand triangles; the sum is the number of triangles.
///
/// Time is O(n log n) for `Paper` and `Sah`, O(n · depth) for `Literal`; memory in addition to the
/// result is at most 96 bytes per triangle.
///
/// # Errors
///
/// See [`BuildError`]: no triangles, too many, a leaf size out of range, or a coordinate that is
/// not finite.
pub fn build(
    corners: &[Corners],
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Hierarchy, BuildError> {
    let threads = grow::worth_starting(options.threads, corners.len());
    BuildPool::with(threads, |pool| hierarchy(corners, options, pool, progress))
}

/// Runs [`build`] on this pool.
fn hierarchy(
    corners: &[Corners],
    options: &BuildOptions,
    pool: &BuildPool,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Hierarchy, BuildError> {
    check(corners, options, pool)?;
    let progress = grow::Progress::new(progress);
    let job = grow::Job { leaf_size: options.leaf_size as usize, pool, progress };
    let forest = match options.build {
        Build::Paper => paper::grow(corners, paper::Cuts::Balanced, &job),
        Build::Literal => paper::grow(corners, paper::Cuts::Any, &job),
        Build::Sah => sah::grow(corners, &job),
    };
    Ok(forest.joined(pool))
}

fn check(corners: &[Corners], options: &BuildOptions, pool: &BuildPool) -> Result<(), BuildError> {
    let triangles = corners.len();
    if triangles == 0 {
        return Err(BuildError::Empty);
    }
    if triangles > TRIANGLES_MAX {
        return Err(BuildError::TooMany { triangles });
    }
    if options.build == Build::Literal && triangles > LITERAL_MAX {
        return Err(BuildError::Literal { triangles });
    }
    if !(1..=LEAF_SIZE_MAX).contains(&options.leaf_size) {
        return Err(BuildError::LeafSize { leaf_size: options.leaf_size });
    }
    let share = pool.share(triangles);
    let bad = pool.each(corners.chunks(share).collect(), |part| {
        part.iter().position(|t| !t.iter().flatten().all(|x| x.is_finite()))
    });
    match bad.iter().zip((0..).step_by(share)).find_map(|(bad, first)| Some(first + (*bad)?)) {
        Some(triangle) => Err(BuildError::NotFinite { triangle }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
