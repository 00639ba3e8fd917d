//! Readers and writers of mesh files: meshes in, meshes out.
//!
//! ```text
//! bytes of a mesh file --import--> Mesh, with guesses of unit and axes
//! BodyView --export--> OBJ, STL
//! a mesh file --reader--> a model file, made in a child process with limits
//! ```
//!
//! Importers take bytes and a resolver for side files. Lengths returned by this crate are metres, x
//! forward, y left, z up. Everything except [`reader`] is pure.

pub mod export;
pub mod import;
pub mod reader;
pub mod side;
