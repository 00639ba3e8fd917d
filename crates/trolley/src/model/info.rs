//! What a model file holds, or how a mesh might be meant.

use super::{Facts, open};
use crate::{Failure, FailureKind};
use body::Mesh;
use bvh::BuildOptions;
use mesh::import::{Format, Reading, readings};
use mesh::reader::{OnProgress, ReadLimits, ReadMesh, ReadRequest};
use serde::Serialize;
use std::path::Path;

/// Offers that are made.
const READINGS_MAX: usize = 4;

const SCHEMA: &str = "trolley.model-info/1";

/// What is known of a file.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Info {
    /// It is a model file.
    Body(Box<BodyInfo>),
    /// It is a mesh.
    Mesh(MeshInfo),
}

/// What a model file holds.
#[derive(Clone, Debug, Serialize)]
pub struct BodyInfo {
    schema: &'static str,
    /// Its name.
    pub file: String,
    /// What is in it.
    pub body: Facts,
}

/// What a mesh holds.
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
    /// Offers, likeliest first; nothing is applied.
    pub readings: Vec<Reading>,
}

/// Says what a model file holds, or how a mesh might be meant, which is read in a child.
///
/// # Errors
///
/// If the file is at fault, or reading it took more than `limits`.
pub fn info(path: &Path, limits: ReadLimits, progress: OnProgress<'_>) -> Result<Info, Failure> {
    let file = path.display().to_string();
    if open::is_model(path) {
        let map = open::bytes(path)?;
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
    let whole = Mesh { corners: view.corners.to_vec(), ..Mesh::default() };
    Ok(Info::Mesh(MeshInfo {
        schema: SCHEMA,
        file,
        format: report.format,
        triangles: report.triangles,
        extent: report.size_m,
        parts: meta.parts,
        notes: report.notes,
        readings: readings(&whole, format, READINGS_MAX),
    }))
}
