//! What a model file or a mesh contains.

use super::{Facts, open};
use crate::files::InputKind;
use crate::{Failure, FailureKind};
use body::Mesh;
use bvh::BuildOptions;
use mesh::import::{Format, Reading, StatedFrame, readings};
use mesh::reader::{OnProgress, ReadLimits, ReadMesh, ReadRequest};
use serde::Serialize;
use std::path::Path;

/// Most readings that are offered.
const READINGS_MAX: usize = 4;

const SCHEMA: &str = "trolley.model-info/1";

/// What a file contains.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-enum-info-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let info = model::info(&out, model::ReadLimits::default(), trolley::bodies::SILENT)?;
/// match info {
///     model::Info::Body(info) => assert_eq!(info.body.triangles, 600),
///     model::Info::Mesh(mesh) => println!("{} parts", mesh.parts.len()),
/// }
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Info {
    /// It is a model file.
    Body(Box<BodyInfo>),
    /// It is a mesh.
    Mesh(MeshInfo),
}

/// What a model file contains.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-body-info-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let info = model::info(&out, model::ReadLimits::default(), trolley::bodies::SILENT)?;
/// if let model::Info::Body(info) = info {
///     println!("{}: {}", info.file, info.body.sentence);
/// }
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct BodyInfo {
    schema: &'static str,
    /// Its name.
    pub file: String,
    /// What is in it.
    pub body: Facts,
}

/// What a mesh contains.
///
/// ```no_run
/// # use trolley::model::{Info, ReadLimits, info};
/// trolley::play_worker(); // a mesh is read in a child process
/// if let Info::Mesh(mesh) = info("car.obj".as_ref(), ReadLimits::default(), &|_, _| {})? {
///     println!("{}: {} triangles in {} parts", mesh.format, mesh.triangles, mesh.parts.len());
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct MeshInfo {
    schema: &'static str,
    /// Its name.
    pub file: String,
    /// Name of its format.
    pub format: String,
    /// Its triangles.
    pub triangles: usize,
    /// Extent along x, y and z in the file's own numbers.
    pub extent: [f64; 3],
    /// Its parts.
    pub parts: Vec<String>,
    /// What was noticed.
    pub notes: Vec<String>,
    /// How it might be meant, likeliest first; nothing is applied.
    pub readings: Vec<Reading>,
}

/// Returns what a model file contains, or what a mesh contains and how it might be meant. A mesh is
/// read in a child process.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-info-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let info = model::info(&out, model::ReadLimits::default(), trolley::bodies::SILENT)?;
/// assert!(matches!(info, model::Info::Body(_)));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the file is not valid, or reading it exceeds `limits`.
pub fn info(path: &Path, limits: ReadLimits, progress: OnProgress<'_>) -> Result<Info, Failure> {
    let file = path.display().to_string();
    if open::is_model(path) {
        let map = open::bytes(path, InputKind::Model)?;
        let (meta, view) = open::view(path, map.bytes())?;
        let body = Facts::new(meta, &view, map.bytes())?;
        return Ok(Info::Body(Box::new(BodyInfo { schema: SCHEMA, file, body })));
    }
    let request = ReadRequest::as_it_stands(path, &BuildOptions::default(), limits)?;
    let ReadMesh { report, bytes, .. } = request.run(progress)?;
    let (meta, view) = open::view(path, bytes.bytes())
        .map_err(|failure| failure.of_kind(FailureKind::Internal))?;
    let format = Format::ALL.into_iter().find(|format| format.name() == report.format);
    let format = format.unwrap_or(Format::Obj);
    let stated = report.stated.as_ref().and_then(|(metres, up)| {
        Some(StatedFrame { unit: metres.to_string().parse().ok()?, up: up.parse().ok()? })
    });
    let whole = Mesh { corners: view.corners.to_vec(), ..Mesh::default() };
    Ok(Info::Mesh(MeshInfo {
        schema: SCHEMA,
        file,
        format: report.format,
        triangles: report.triangles,
        extent: report.size_m,
        parts: meta.parts,
        notes: report.notes,
        readings: readings(&whole, format, stated, READINGS_MAX),
    }))
}
