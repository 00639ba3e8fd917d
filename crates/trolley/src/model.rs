//! Model files: made of others' meshes or of generated shapes, looked at, checked, given away.
//!
//! ```text
//! Import, check --starts--> mesh::reader (limits itself, reads the mesh, builds the tree)
//!       ^                       | progress, then a report and the model file, through a pipe
//!       '-- verify, write <-----'
//! info, Export, check --> open: a model file, verified      Generate --> bodies --> write
//! ```
//!
//! Whatever a mesh file does to its reader happens in a child of this program, which the program
//! plays in [`play_worker`](crate::play_worker). A file is replaced only by a finished and verified
//! one, so a failure leaves nothing behind and nothing damaged.

mod check;
mod export;
pub mod facts;
mod generate;
mod import;
mod info;
pub mod open;

pub use body::{BodyKind, Build, LEAF_SIZE_MAX, Seat, Shape};
pub use bvh::BuildOptions;
pub use check::{CheckReport, FileCheck, check};
pub use export::{Export, Exported};
pub use facts::Facts;
pub use generate::{Generate, Generated};
pub use import::{Import, ImportedModel};
pub use info::{BodyInfo, Info, MeshInfo, info};
pub use mesh::export::ExportFormat;
pub use mesh::import::{Axis, LengthUnit, Reading};
pub use mesh::reader::{MeshOptions, OnProgress, ReadLimits, Report};
pub use shapes::{TRIANGLES_MAX, TRIANGLES_MIN};

/// A tree with at most `leaf_size` triangles in a leaf, built by as many threads as pay.
#[must_use]
pub fn tree(build: Build, leaf_size: u32) -> BuildOptions {
    // More than eight gain nothing, but each takes address space.
    let threads = runtime::affinity::allowed_cores().len().clamp(1, 8);
    BuildOptions { build, leaf_size, threads }
}
