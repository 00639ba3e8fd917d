//! Which files are sound.

use super::facts::{Facts, thousands, triangles};
use super::open;
use crate::{Failure, FailureKind};
use mesh::reader::{MeshOptions, ReadLimits, ReadMesh, ReadRequest};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What was found of some files.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    schema: &'static str,
    /// How many are not sound.
    pub refused: usize,
    /// Each of them, in the order in which they were named.
    pub files: Vec<FileCheck>,
}

/// What was found of a file.
#[derive(Clone, Debug, Serialize)]
pub struct FileCheck {
    /// Its name.
    pub file: String,
    /// Whether it is sound.
    pub ok: bool,
    /// What it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub what: Option<String>,
    /// What is odd about it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
    /// What is wrong with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// What to do about that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// Verifies model files, and tries whether meshes could be imported; writes nothing. `tell` hears
/// of each file in turn, and may end it all. Where `options` name no kind, any size is accepted.
///
/// # Errors
///
/// If a file could not be looked at, which is not its fault; or whatever `tell` says.
pub fn check(
    files: &[PathBuf],
    options: &MeshOptions,
    limits: ReadLimits,
    tell: &mut dyn FnMut(&FileCheck) -> Result<(), Failure>,
) -> Result<CheckReport, Failure> {
    let mut verdicts = Vec::new();
    for path in files {
        let file = path.display().to_string();
        let verdict = match look(path, options, limits) {
            Ok((what, doubts)) => {
                FileCheck { file, ok: true, what: Some(what), doubts, fault: None, help: None }
            }
            // Not the file's fault, but the machine's or ours: the others would fare no better.
            Err(failure) if failure.kind() != FailureKind::Input => return Err(failure),
            Err(failure) => FileCheck {
                file,
                ok: false,
                what: None,
                doubts: Vec::new(),
                fault: Some(failure.what().to_owned()),
                help: failure.remedy().map(str::to_owned),
            },
        };
        tell(&verdict)?;
        verdicts.push(verdict);
    }
    let refused = verdicts.iter().filter(|verdict| !verdict.ok).count();
    Ok(CheckReport { schema: "trolley.model-check/1", refused, files: verdicts })
}

/// What a file is, and doubts about it.
fn look(
    path: &Path,
    options: &MeshOptions,
    limits: ReadLimits,
) -> Result<(String, Vec<String>), Failure> {
    if open::is_model(path) {
        let map = open::bytes(path)?;
        let (meta, view) = open::view(path, map.bytes())?;
        let facts = Facts::new(meta, &view, map.bytes())?;
        let [x, y, z] = facts.size_m;
        let count = triangles(facts.triangles);
        let what = format!("model file, {}, {x:.2} × {y:.2} × {z:.2} m, {count}", facts.kind);
        return Ok((what, Vec::new()));
    }
    // A trial builds no tree, so there is no progress to tell.
    let ReadMesh { report, .. } =
        ReadRequest::new(path, options, None, None, limits)?.run(crate::bodies::SILENT)?;
    let mut what =
        format!("{}, {}, {}", report.format, report.sentence, triangles(report.triangles));
    if report.duplicates_dropped > 0 {
        what += &format!(", {} duplicates left out", thousands(report.duplicates_dropped));
    }
    if report.degenerate_kept > 0 {
        what += &format!(", {} of zero area", thousands(report.degenerate_kept as usize));
    }
    let doubts = [report.notes, report.doubts].concat();
    Ok((what, doubts))
}
