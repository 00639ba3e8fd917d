//! From the bytes of a mesh file to a checked [`Mesh`] in the body frame.
//!
//! ```text
//! bytes --Format::detect--> Format --read--> collect (frame, finite, counted, parts)
//!         --> select (--only) --> drop duplicates --> count zero area --> plausible size --> Mesh
//! ```
//!
//! Source ids are assigned in file order after triangulation, before anything is dropped. The
//! parsers are third-party crates; each module documents what its crate does not check. No file is
//! opened here: side files come from a resolver. What such a crate may still do with hostile bytes
//! (panic, loop, exhaust memory) must be contained by the caller, in a child process with limits.

mod check;
mod collada;
mod collect;
mod error;
mod format;
mod frame;
mod gltf;
mod guess;
mod lsdyna;
mod obj;
mod ply;
mod polygon;
mod stl;
mod suggest;

pub use collect::TRIANGLES_MAX;
pub use error::{FilePosition, ImportError, MeshDefect};
pub use format::Format;
pub use frame::{Axis, Frame, LengthUnit, StatedFrame, UnknownAxis, UnknownUnit};
pub use guess::{Guess, guess};
pub use suggest::{Reading, likely_kind, readings};

use body::{BodyKind, Mesh, Shells, is_degenerate};
use collect::Collector;

/// Maximum length of a mesh file or side file, in bytes.
pub const BYTES_MAX: usize = 1 << 30;

/// Returns the content of a side file by the name written in the mesh file, or the reason of the
/// failure.
///
/// Absolute names and names that lead upwards are rejected before.
pub type Resolver<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// Options for reading a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Name of the file, for messages.
    pub file: String,
    /// Unit of its coordinates; `None` for the file's own unit if stated, else a metre.
    pub unit: Option<LengthUnit>,
    /// Its up axis; `None` for the file's own if stated, else the format's.
    pub up: Option<Axis>,
    /// Its forward axis; `None` for the format's.
    pub forward: Option<Axis>,
    /// Names of parts, groups, objects, materials or nodes to keep; empty for all.
    pub only: Vec<String>,
    /// The kind of body, for the size check.
    pub kind: Option<BodyKind>,
    /// Whether any size is accepted: for a preview of a file of which nothing is known yet.
    pub any_size: bool,
    /// Whether triangles with the positions of an earlier one are kept, so that ids match the file.
    pub keep_duplicates: bool,
    /// Name of the body; `None` for the file name without folder and extension.
    pub name: Option<String>,
}

impl ImportOptions {
    /// Options to take every triangle as stored, with coordinates in metres of the body's own
    /// frame: ids count from 0 in file order, nothing is dropped, and any size is accepted.
    #[must_use]
    pub fn as_it_stands() -> Self {
        Self {
            unit: Some(LengthUnit::METRE),
            up: Some(Axis::Z),
            forward: Some(Axis::X),
            any_size: true,
            keep_duplicates: true,
            ..Self::default()
        }
    }
}

/// A mesh and the report of its import.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// The content of the file and how it was processed.
    pub report: ImportReport,
}

/// The content of a file and how it was processed.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// Name of the body.
    pub name: String,
    /// Format of the file.
    pub format: Format,
    /// Unit and axes that were used.
    pub frame: Frame,
    /// What the file states of them, used or not.
    pub stated: Option<StatedFrame>,
    /// Triangles in the file, polygons triangulated.
    pub triangles_in_file: usize,
    /// Triangles in selected parts.
    pub triangles_selected: usize,
    /// Triangles kept: selected ones without duplicates.
    pub triangles: usize,
    /// Duplicates dropped.
    pub duplicates: usize,
    /// Triangles of zero area, kept.
    pub degenerate: u32,
    /// Pieces that hang together by edges.
    pub shells: usize,
    /// Edges of an odd number of triangles; 0 if the body is watertight.
    pub open_edges: usize,
    /// Parts kept, with their triangles.
    pub parts: Vec<(String, usize)>,
    /// What else was noticed and skipped, in whole sentences.
    pub notes: Vec<String>,
    /// What the body looks like.
    pub guess: Guess,
    /// BLAKE3 of the file and its side files, in the order in which they are named; hexadecimal.
    pub hash: String,
    /// File, unit and axes in words, as metadata keep it.
    pub origin: String,
}

/// Reads a mesh file.
///
/// # Errors
///
/// The file is malformed, holds no triangle, lacks a selected part, or is not a plausible body of
/// its kind; see [`MeshDefect`].
pub fn read(
    format: Format,
    bytes: &[u8],
    resolve: Resolver<'_>,
    options: &ImportOptions,
) -> Result<ImportedMesh, ImportError> {
    let file = options.file.as_str();
    let whole = |fault| ImportError::new(file, FilePosition::Whole, fault);
    let collada = match format {
        Format::Collada if bytes.len() <= BYTES_MAX => Some(collada::parse(file, bytes)?),
        _ => None,
    };
    let stated = collada.as_ref().map(|collada| collada.asset(file)).transpose()?;
    if format == Format::LsDyna && options.unit.is_none() {
        return Err(whole(MeshDefect::NoUnit));
    }
    let unit = options.unit.or(stated.map(|asset| asset.unit)).unwrap_or_default();
    let up = options.up.or(stated.map(|asset| asset.up));
    let frame = Frame::new(format, unit, up, options.forward).map_err(whole)?;
    if bytes.len() > BYTES_MAX {
        let (count, max) = (bytes.len() as u64, BYTES_MAX as u64);
        return Err(whole(MeshDefect::TooMany { what: "bytes", count, max }));
    }
    if format.has_cr_line_ends(bytes) {
        return Err(whole(MeshDefect::LineEnds));
    }
    let mut all = Collector::new(file, frame);
    all.hasher.update(bytes);
    match format {
        Format::Obj => obj::read(bytes, &mut all)?,
        Format::Stl => stl::read(bytes, &mut all)?,
        Format::Ply => ply::read(bytes, &mut all)?,
        Format::Gltf | Format::Glb => gltf::read(bytes, resolve, &mut all)?,
        Format::Collada => {
            if let Some((collada, stated)) = collada.as_ref().zip(stated) {
                let (unit, up) = (stated.unit, stated.up);
                all.notes.push(format!("the file states unit {unit} and up {up}"));
                collada::read(collada, &mut all)?;
            }
        }
        Format::LsDyna => lsdyna::read(bytes, resolve, &mut all)?,
    }
    let triangles_in_file = all.corners.len();
    let mut mesh = Mesh {
        source_ids: (0..triangles_in_file as u32).collect(),
        corners: all.corners,
        part_of: all.part_of,
        parts: all.parts.iter().map(|part| part.name.clone()).collect(),
        dropped: Vec::new(),
        degenerate: 0,
    };
    check::select(&mut mesh, &all.parts, &options.only).map_err(whole)?;
    if mesh.corners.is_empty() {
        return Err(whole(MeshDefect::Empty(String::new())));
    }
    let triangles_selected = mesh.corners.len();
    if !options.keep_duplicates {
        check::drop_duplicates(&mut mesh);
    }
    check::compact_parts(&mut mesh);
    mesh.degenerate = mesh.corners.iter().filter(|corners| is_degenerate(corners)).count() as u32;
    let guess = guess(&mesh);
    if !options.any_size {
        check::check_size(guess.size_m, options.kind, unit).map_err(whole)?;
    }
    let mut of_part = vec![0_usize; mesh.parts.len()];
    for part in &mesh.part_of {
        of_part[usize::from(*part)] += 1;
    }
    let shells = Shells::of(&mesh.corners);
    let report = ImportReport {
        name: options.name.clone().unwrap_or_else(|| stem(file)),
        format,
        frame,
        stated,
        triangles_in_file,
        triangles_selected,
        triangles: mesh.corners.len(),
        duplicates: mesh.dropped.len(),
        degenerate: mesh.degenerate,
        shells: shells.kinds().len(),
        open_edges: shells.open_edges(),
        parts: mesh.parts.iter().cloned().zip(of_part).collect(),
        notes: all.notes,
        guess,
        hash: all.hasher.finalize().to_hex().to_string(),
        origin: origin(file, &frame, &options.only),
    };
    Ok(ImportedMesh { mesh, report })
}

/// The last component of a path without its extension.
fn stem(file: &str) -> String {
    let name = base(file);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

fn base(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

/// The folder is omitted: the same file gives the same model wherever it is stored.
fn origin(file: &str, frame: &Frame, only: &[String]) -> String {
    let only = if only.is_empty() { String::new() } else { format!(", only {}", only.join(", ")) };
    format!("{}, {frame}{only}", base(file))
}

#[cfg(test)]
mod tests;
