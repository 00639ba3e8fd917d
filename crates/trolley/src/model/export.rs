//! The triangles of a model file as a mesh for other programs.

use super::open;
use crate::{Failure, files};
use mesh::export::{self, ExportFormat};
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Writes the triangles of a model file in the order of their source ids, with their exact
/// coordinates, in metres, x forward, y left, z up.
#[derive(Clone, Debug)]
pub struct Export {
    /// The model file.
    pub file: PathBuf,
    /// The format; none: what the output's name ends in.
    pub format: Option<ExportFormat>,
    /// The mesh file to write.
    pub out: PathBuf,
}

/// A mesh that was written.
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
    /// Its length.
    pub bytes: usize,
}

impl Export {
    /// Writes the mesh.
    ///
    /// # Errors
    ///
    /// If nothing says which format, the model file is not sound, or the mesh cannot be written;
    /// what was in its place is still there.
    pub fn run(&self) -> Result<Exported, Failure> {
        let format = self.format()?;
        files::check(&self.out, Some(&self.file))?;
        let map = open::bytes(&self.file)?;
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
