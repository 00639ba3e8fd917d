//! Importing meshes.

use super::{Facts, open};
use crate::{Failure, FailureKind, files};
use bvh::BuildOptions;
use mesh::reader::{MeshOptions, OnProgress, ReadLimits, ReadMesh, ReadRequest, Report};
use serde::Serialize;
use std::path::PathBuf;

/// Imports a mesh as a model file: OBJ, STL, PLY, glTF, GLB, COLLADA or LS-DYNA.
///
/// Mass, centre of mass, inertia and seats come from a TOML file beside the mesh, else from
/// defaults by kind; [`Facts::mass_source`] says which.
///
/// ```
/// use trolley::model::{Build, Import, MeshOptions, ReadLimits, tree};
///
/// let import = Import {
///     mesh: "car.obj".into(),
///     options: MeshOptions::default(),
///     name: Some("car".to_owned()),
///     tree: tree(Build::Paper, 4),
///     limits: ReadLimits::default(),
///     out: "car.trolley".into(),
/// };
/// ```
#[derive(Clone, Debug)]
pub struct Import {
    /// The mesh.
    pub mesh: PathBuf,
    /// How to read it.
    pub options: MeshOptions,
    /// Name of the body; `None`: from the TOML file, else from the name of the mesh.
    pub name: Option<String>,
    /// How its tree is built.
    pub tree: BuildOptions,
    /// Limits for reading it.
    pub limits: ReadLimits,
    /// The model file to write.
    pub out: PathBuf,
}

/// The result of [`Import::run`].
///
/// ```no_run
/// # use trolley::model::{Build, Import, MeshOptions, ReadLimits, tree};
/// # let import = Import {
/// #     mesh: "car.obj".into(),
/// #     options: MeshOptions::default(),
/// #     name: Some("car".to_owned()),
/// #     tree: tree(Build::Paper, 4),
/// #     limits: ReadLimits::default(),
/// #     out: "car.trolley".into(),
/// # };
/// let imported = import.run(&|_, _| {})?;
/// println!("{}: {}", imported.file, imported.body.sentence);
/// for note in &imported.import.notes {
///     println!("note: {note}");
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
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
    /// Reads the mesh in a child process, and writes the model file.
    ///
    /// ```no_run
    /// # use trolley::model::{Build, Import, MeshOptions, ReadLimits, tree};
    /// # let import = Import {
    /// #     mesh: "car.obj".into(),
    /// #     options: MeshOptions::default(),
    /// #     name: Some("car".to_owned()),
    /// #     tree: tree(Build::Paper, 4),
    /// #     limits: ReadLimits::default(),
    /// #     out: "car.trolley".into(),
    /// # };
    /// trolley::play_worker(); // the mesh is read in a child process
    /// let imported = import.run(&|done, total| eprintln!("{done} of {total} triangles"))?;
    /// assert_eq!(imported.file, "car.trolley");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the mesh is not valid, reading it exceeds the limits, or the model file cannot be
    /// written; an existing file is then left as it was.
    pub fn run(&self, progress: OnProgress<'_>) -> Result<ImportedModel, Failure> {
        files::check(&self.out, Some(&self.mesh))?;
        let name = self.name.as_deref();
        let request =
            ReadRequest::new(&self.mesh, &self.options, name, Some(&self.tree), self.limits)?;
        let ReadMesh { report, bytes, .. } = request.run(progress)?;
        // Never write what a damaged child sent.
        let (meta, view) = open::view(&self.mesh, bytes.bytes())
            .map_err(|failure| failure.of_kind(FailureKind::Internal))?;
        let body = Facts::new(meta, &view, bytes.bytes())?;
        files::replace(&self.out, bytes.bytes())?;
        let file = self.out.display().to_string();
        Ok(ImportedModel { schema: "trolley.model-import/1", file, body, import: report })
    }
}
