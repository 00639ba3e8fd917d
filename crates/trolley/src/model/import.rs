//! From a mesh to a model file.

use super::{Facts, open};
use crate::{Failure, FailureKind, files};
use bvh::BuildOptions;
use mesh::reader::{MeshOptions, OnProgress, ReadLimits, ReadMesh, ReadRequest, Report};
use serde::Serialize;
use std::path::PathBuf;

/// Makes a model file of a mesh: OBJ, STL, PLY, glTF, GLB, COLLADA or LS-DYNA.
///
/// Mass, centre of mass, inertia and seats come from a TOML file beside the mesh, else from
/// defaults by kind; [`Facts::mass_source`] says which.
#[derive(Clone, Debug)]
pub struct Import {
    /// The mesh.
    pub mesh: PathBuf,
    /// How it is to be understood.
    pub options: MeshOptions,
    /// Name of the body; none: the side file's, else the file's.
    pub name: Option<String>,
    /// The tree that it gets.
    pub tree: BuildOptions,
    /// What reading it may take.
    pub limits: ReadLimits,
    /// The model file to write.
    pub out: PathBuf,
}

/// A model file that was made of a mesh.
#[derive(Clone, Debug, Serialize)]
pub struct ImportedModel {
    schema: &'static str,
    /// The model file.
    pub file: String,
    /// What is in it.
    pub body: Facts,
    /// What was found in the mesh.
    pub import: Report,
}

impl Import {
    /// Reads the mesh in a child, and writes the model file.
    ///
    /// # Errors
    ///
    /// If the mesh is at fault, reading it took more than it was allowed, or the model file cannot
    /// be written; what was in its place is still there.
    pub fn run(&self, progress: OnProgress<'_>) -> Result<ImportedModel, Failure> {
        files::check(&self.out, Some(&self.mesh))?;
        let name = self.name.as_deref();
        let request =
            ReadRequest::new(&self.mesh, &self.options, name, Some(&self.tree), self.limits)?;
        let ReadMesh { report, bytes, .. } = request.run(progress)?;
        // What a damaged child sent is not written.
        let (meta, view) = open::view(&self.mesh, bytes.bytes())
            .map_err(|failure| failure.of_kind(FailureKind::Internal))?;
        let body = Facts::new(meta, &view, bytes.bytes())?;
        files::replace(&self.out, bytes.bytes())?;
        let file = self.out.display().to_string();
        Ok(ImportedModel { schema: "trolley.model-import/1", file, body, import: report })
    }
}
