//! Exporting the triangles of a model file as a mesh.

use super::open;
use crate::files::InputKind;
use crate::{Failure, files};
use mesh::export::{self, ExportFormat};
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Exports the triangles of a model file as a mesh, in the order of their source ids, with their
/// exact coordinates: in metres, x forward, y left, z up.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-export-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let export = model::Export { file: out, format: None, out: folder.join("pole.stl") };
/// assert_eq!(export.run()?.triangles, 600);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug)]
pub struct Export {
    /// The model file.
    pub file: PathBuf,
    /// The format; `None`: by the ending of `out`.
    pub format: Option<ExportFormat>,
    /// The mesh file to write.
    pub out: PathBuf,
}

/// The result of [`Export::run`].
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-exported-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let export = model::Export { file: out, format: None, out: folder.join("pole.stl") };
/// let exported = export.run()?;
/// println!("{}: {} bytes", exported.file, exported.bytes);
/// # assert_eq!(exported.format, model::ExportFormat::Stl);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct Exported {
    schema: &'static str,
    /// The mesh file.
    pub file: String,
    /// Its format.
    #[serde(serialize_with = "by_name")]
    pub format: ExportFormat,
    /// Its triangles.
    pub triangles: usize,
    /// Its length in bytes.
    pub bytes: usize,
}

impl Export {
    /// Writes the mesh.
    ///
    /// ```
    /// # use trolley::model::{self, Generate, Shape};
    /// # let folder = std::env::temp_dir();
    /// # let folder = folder.join(format!("trolley-export-run-{}", std::process::id()));
    /// # std::fs::create_dir_all(&folder).ok();
    /// # let out = folder.join("pole.trolley");
    /// # let tree = model::tree(model::Build::Paper, 4);
    /// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
    /// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
    /// # let generated = pole.run(&|_, _| {})?;
    /// let export = model::Export { file: out, format: None, out: folder.join("pole.stl") };
    /// export.run()?;
    /// let mesh = trolley::kernel::read_mesh(folder.join("pole.stl"))?;
    /// assert_eq!(mesh.len(), 600);
    /// # std::fs::remove_dir_all(&folder).ok();
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the format is not known, the model file is not valid, or the mesh cannot be written; an
    /// existing file is then left as it was.
    pub fn run(&self) -> Result<Exported, Failure> {
        let format = self.format()?;
        files::check(&self.out, Some(&self.file))?;
        let map = open::bytes(&self.file, InputKind::Model)?;
        let (meta, view) = open::view(&self.file, map.bytes())?;
        let bytes = export::write(format, &meta, &view);
        files::replace(&self.out, &bytes)?;
        Ok(Exported {
            schema: "trolley.model-export/1",
            file: self.out.display().to_string(),
            format,
            triangles: view.corners.len(),
            bytes: bytes.len(),
        })
    }

    fn format(&self) -> Result<ExportFormat, Failure> {
        if let Some(format) = self.format {
            return Ok(format);
        }
        let end = self.out.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        end.parse().map_err(|_unknown| {
            let fault = format!("{}: its name does not say which format", self.out.display());
            Failure::setting(fault).with_remedy("add --format stl, ply or obj")
        })
    }
}

fn by_name<S: Serializer>(format: &ExportFormat, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(format.name())
}
