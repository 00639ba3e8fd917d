//! The data of a triangulated body: its triangles, tree nodes, mass and seats, and the file and the
//! store that hold them.
//!
//! ```text
//! Mesh --(bvh builds a tree)--> Body --file::encode--> model file --store::fill--> model store
//!                               BodyView <-------------- file::view, store::open
//! ```
//!
//! Importing and generating are in `mesh` and `shapes`, building and traversing trees in `bvh`.
//! Lengths are metres, x forward, y left, z up.

mod body;
pub mod codec;
pub mod defaults;
pub mod file;
pub mod fit;
pub mod impact;
pub mod meta;
pub mod outline;
mod shape;
pub mod shells;
pub mod store;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod wide;
pub mod zones;

pub use body::{Body, BodyView, Mesh, Node, Zones, is_degenerate};
pub use fit::Fit;
pub use impact::{OwnParameters, Setting};
pub use meta::{BodyKind, Build, LEAF_SIZE_MAX, Meta, Seat};
pub use outline::{Band, Outlines, Ring};
pub use shape::{Shape, UnknownShape};
pub use shells::{ShellKind, Shells};
pub use wide::{Wide, WideLeaf, WideNode};
