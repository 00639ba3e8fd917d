//! Readers and writers of others' files: meshes in, glTF out.
//!
//! ```text
//! bytes of a mesh file --import--> Mesh, with guesses of unit and axes
//! BodyView --export--> OBJ, STL
//! ```
//!
//! Importers take bytes and a resolver for side files. Lengths that leave this crate are metres, x
//! forward, y left, z up.

pub mod export;
pub mod import;
pub mod side;
