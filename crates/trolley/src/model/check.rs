//! Checks whether files are valid.

use super::facts::{Facts, surface, thousands, triangles};
use super::open;
use crate::files::InputKind;
use crate::{Failure, FailureKind};
use mesh::reader::{MeshOptions, ReadLimits, ReadMesh, ReadRequest};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The result of [`check`].
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-report-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let report = model::check(
///     &[out, "no-such-file.trolley".into()],
///     &model::MeshOptions::default(),
///     model::ReadLimits::default(),
///     &mut |_| Ok(()),
/// )?;
/// assert_eq!((report.files.len(), report.refused), (2, 1));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    schema: &'static str,
    /// How many are not valid.
    pub refused: usize,
    /// The files, in the order given.
    pub files: Vec<FileCheck>,
}

/// What a check of one file found.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-file-check-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let report = model::check(
///     &[out, "no-such-file.trolley".into()],
///     &model::MeshOptions::default(),
///     model::ReadLimits::default(),
///     &mut |_| Ok(()),
/// )?;
/// assert!(report.files[0].ok && report.files[0].fault.is_none());
/// assert!(!report.files[1].ok && report.files[1].fault.is_some());
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Debug, Serialize)]
pub struct FileCheck {
    /// Its name.
    pub file: String,
    /// Whether it is valid.
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
    /// What to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub help: Option<String>,
}

/// Verifies model files, and tries whether meshes can be imported; writes nothing. `tell` is called
/// for each file in turn, and can stop the check with an error. If `options` name no kind, any size
/// is accepted.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-check-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// let report = model::check(
///     &[out],
///     &model::MeshOptions::default(),
///     model::ReadLimits::default(),
///     &mut |file| {
///         println!("{}: {}", file.file, file.ok);
///         Ok(())
///     },
/// )?;
/// assert_eq!(report.refused, 0);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If a file could not be checked, through no fault of its own, or the error that `tell` returns.
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
            // Not the fault of the file: the others would fail as well.
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
        let map = open::bytes(path, InputKind::Model)?;
        let (meta, view) = open::view(path, map.bytes())?;
        let facts = Facts::new(meta, &view, map.bytes())?;
        let [x, y, z] = facts.size_m;
        let count = triangles(facts.triangles);
        let surface = surface(facts.shells, facts.open_edges);
        let what =
            format!("model file, {}, {x:.2} × {y:.2} × {z:.2} m, {count}, {surface}", facts.kind);
        return Ok((what, Vec::new()));
    }
    // A trial builds no tree, so there is no progress to report.
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
    what += &format!(", {}", surface(report.shells, report.open_edges));
    let doubts = [report.notes, report.doubts].concat();
    Ok((what, doubts))
}
