//! From the bytes of a mesh file to a checked [`Mesh`] in the body frame.
//!
//! ```text
//! bytes --Format::detect--> Format --read--> collect (frame, finite, counted, parts)
//!         --> select (--only) --> drop duplicates --> count zero area --> plausible size --> Mesh
//! ```
//!
//! Source ids are given in file order after triangulation, before anything is left out. The
//! readers are other people's crates; each module says what its crate leaves undone. No file is
//! opened here: side files come from a resolver. What such a crate may still do with hostile
//! bytes (panic, loop, ask for memory) is the caller's to contain, in a child process with
//! limits.

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
pub use frame::{Axis, Frame, LengthUnit, UnknownAxis, UnknownUnit};
pub use guess::{Guess, guess};
pub use suggest::{Reading, readings};

use body::{BodyKind, Mesh, is_degenerate};
use collect::Collector;

/// Greatest length of a mesh file or side file, in bytes.
pub const BYTES_MAX: usize = 1 << 30;

/// Gives the content of a side file by the name written in the mesh file, or says why not.
///
/// Names that are absolute or lead upwards are refused before they come here.
pub type Resolver<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// How a file is to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// Name of the file, for messages.
    pub file: String,
    /// Unit of its coordinates; `None`: the file's where it states one, else a metre.
    pub unit: Option<LengthUnit>,
    /// Its up axis; `None`: the file's where it states one, else the format's.
    pub up: Option<Axis>,
    /// Its forward axis; `None` for the format's.
    pub forward: Option<Axis>,
    /// Names of parts, groups, objects, materials or nodes to keep; empty for all.
    pub only: Vec<String>,
    /// What the body is, for the check of its size.
    pub kind: Option<BodyKind>,
    /// Whether a body may have any size: for a look at a file of which nothing is known yet.
    pub any_size: bool,
    /// Whether triangles with the positions of an earlier one are kept, for whom ids are all there
    /// is.
    pub keep_duplicates: bool,
    /// Name of the body; `None` for the file's name without folder and extension.
    pub name: Option<String>,
}

impl ImportOptions {
    /// Every triangle as it stands in the file, whose coordinates are taken for metres of the
    /// body's own frame: ids count from 0 in file order, nothing is left out, and the size may be
    /// any.
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

/// A mesh and what was found out about it.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedMesh {
    /// The triangles.
    pub mesh: Mesh,
    /// What the file held and what was done with it.
    pub report: ImportReport,
}

/// What a file held and what was done with it.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// Name of the body.
    pub name: String,
    /// Format of the file.
    pub format: Format,
    /// Unit and axes that were used.
    pub frame: Frame,
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
    /// Parts kept, with their triangles.
    pub parts: Vec<(String, usize)>,
    /// What else was seen and left out, in whole sentences.
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
/// If the file is malformed, holds no triangle, names a part that does not exist, or is no
/// plausible body of its kind; see [`MeshDefect`].
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
    let report = ImportReport {
        name: options.name.clone().unwrap_or_else(|| stem(file)),
        format,
        frame,
        triangles_in_file,
        triangles_selected,
        triangles: mesh.corners.len(),
        duplicates: mesh.dropped.len(),
        degenerate: mesh.degenerate,
        parts: mesh.parts.iter().cloned().zip(of_part).collect(),
        notes: all.notes,
        guess,
        hash: all.hasher.finalize().to_hex().to_string(),
        origin: origin(file, &frame, &options.only),
    };
    Ok(ImportedMesh { mesh, report })
}

/// The last part of a path without its extension.
fn stem(file: &str) -> String {
    let name = base(file);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

fn base(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

/// The folder is left out: the same file gives the same model wherever it lies.
fn origin(file: &str, frame: &Frame, only: &[String]) -> String {
    let only = if only.is_empty() { String::new() } else { format!(", only {}", only.join(", ")) };
    format!("{}, {frame}{only}", base(file))
}

#[cfg(test)]
mod tests;
