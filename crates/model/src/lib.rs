//! Triangulated bodies: importing, checking, storing and generating them.
//!
//! ```text
//! bytes of a mesh file --import--> Mesh --(bvh builds a tree)--> Body --file::encode--> model file
//! generate(kind, count) ----------> Mesh                           BodyView <--file::view-- bytes
//! ```
//!
//! This crate takes bytes and a resolver for side files; it never opens a file. It knows nothing of
//! poses, contact or harm. Lengths are metres, x forward, y left, z up.

pub mod body;
pub mod codec;
pub mod defaults;
pub mod export;
pub mod file;
pub mod fit;
pub mod generate;
pub mod import;
pub mod meta;
pub mod side;
pub mod store;
#[cfg(test)]
mod testing;
pub mod wide;
pub mod zones;

pub use body::{Body, BodyView, Mesh, Node, Zones};
pub use fit::Fit;
pub use meta::{Build, Kind, LEAF_SIZE_MAX, Meta, Seat};
pub use wide::{Wide, WideLeaf, WideNode};
