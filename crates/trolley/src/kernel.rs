//! The kernel for anybody's triangles: trees, and which triangles of two bodies intersect.
//!
//! ```
//! use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace, pairs};
//!
//! let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
//! let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
//! let options = BuildOptions::default();
//! let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
//! let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
//! assert_eq!(pairs(&floor, &blade, &pose, &mut Workspace::new())?, [(0, 0)]);
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! No mass, seat or file is needed. [`bvh::query`] has what is exact, and all questions.

use crate::Failure;
use mesh::import::{self, Format, ImportOptions};
use std::path::Path;

pub use body::{Body, BodyView, Build};
pub use bvh::query::{HitSets, Level, PoseError, Workspace, for_each_pair, pairs, sets, touches};
pub use bvh::{BuildError, BuildOptions, Tree, Walk};
pub use geometry::{Corners, Pose, RelativePose};

/// The triangles of a mesh file, in its order and its own unit: STL, OBJ, PLY, glTF and more.
///
/// The file is read in this process, without limits of memory or time: for files that you trust.
/// Side files, such as buffers of glTF, are not looked for.
///
/// # Errors
///
/// If the file cannot be read or is no mesh.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Vec<Corners>, Failure> {
    let path = path.as_ref();
    let wrong = |error: std::io::Error| Failure::input(error.to_string()).at(path.display());
    let bytes = std::fs::read(path).map_err(wrong)?;
    let file = path.display().to_string();
    let format = Format::detect(&file, &bytes)?;
    let options = ImportOptions { file, ..ImportOptions::as_it_stands() };
    let mut nothing_beside = |name: &str| Err(format!("{name}: files beside it are not read"));
    Ok(import::read(format, &bytes, &mut nothing_beside, &options)?.mesh.corners)
}
