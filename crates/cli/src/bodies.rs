//! The bodies of a scenario, as model files in memory.

use crate::args::Output;
use crate::progress::Progress;
use body::{BodyView, Fit, Kind, Mesh, Meta, Shape, defaults, file, zones};
use bvh::BuildOptions;
use diagnostic::{Failure, chain};
use runtime::FileMap;
use scenario::{Engine, FileRef, Scenario, Source};
use shapes::{call, generate};
use std::path::{Path, PathBuf};

/// A body on its way into the model store.
pub(crate) struct Loaded {
    pub(crate) kind: Kind,
    /// A model file, aligned as one.
    pub(crate) bytes: file::Aligned,
    /// Content hash of the model file that it was opened from.
    pub(crate) source_hash: Option<String>,
}

/// Loads or generates every party's body, with the tree that the engine asks for.
///
/// `file` is the scenario's name in errors; `find` says where the model file of a party is.
pub(crate) fn load(
    scenario: &Scenario,
    engine: &Engine,
    file: &str,
    find: &dyn Fn(usize, &FileRef) -> PathBuf,
    output: &Output,
) -> Result<Vec<Loaded>, Failure> {
    let generated = scenario.parties.iter().map(|party| match party.source {
        Source::Generate { triangles, .. } => u64::from(triangles),
        Source::File(_) => 0,
    });
    let progress = Progress::new("building bodies: triangles", generated.sum(), output);
    let options = BuildOptions {
        build: engine.build,
        leaf_size: engine.leaf_size,
        threads: runtime::affinity::allowed_cores().len(),
    };
    let mut loaded = Vec::new();
    for (number, party) in scenario.parties.iter().enumerate() {
        let body = match &party.source {
            Source::Generate { shape, triangles, seed } => {
                let mut body = generate_body(*shape, *triangles, *seed, &options, &|_| {})?;
                if let Some(size) = party.size {
                    body = stretched(&body.meta, &body.view(), size, &options)?;
                }
                progress.add(u64::from(*triangles));
                encoded(&body)?
            }
            Source::File(reference) => {
                let place = || format!("{file}:{}: party \"{}\"", reference.place, party.name);
                open(&find(number, reference), party.size, &options)
                    .map_err(|failure| failure.at(place()))?
            }
        };
        loaded.push(body);
    }
    let kinds: Vec<Kind> = loaded.iter().map(|body| body.kind).collect();
    scenario.check_kinds(file, &kinds)?;
    Ok(loaded)
}

/// Opens a model file; its tree is built again if the engine asks for another one.
pub(crate) fn open(
    path: &Path,
    size: Option<Fit>,
    options: &BuildOptions,
) -> Result<Loaded, Failure> {
    let map = FileMap::open(path).map_err(|error| {
        Failure::input(chain(&error)).with_remedy("paths are relative to the scenario's folder")
    })?;
    let bad = |error: file::FileError| Failure::from(error).at(path.display());
    let (meta, view) = file::view(map.bytes()).map_err(bad)?;
    let source_hash = Some(file::content_hash(map.bytes()).map_err(bad)?);
    if let Some(size) = size {
        let body = stretched(&meta, &view, size, options)?;
        return Ok(Loaded { source_hash, ..encoded(&body)? });
    }
    if meta.build == options.build && meta.leaf_size == options.leaf_size {
        let bytes = file::Aligned::copy_of(map.bytes());
        return Ok(Loaded { kind: meta.kind, bytes, source_hash });
    }
    let body = bvh::rebuild(view, &meta, options, &|_| {})
        .map_err(|error| Failure::input(format!("{}: {error}", path.display())))?;
    Ok(Loaded { source_hash, ..encoded(&body)? })
}

/// A body stretched to a size. What follows from the size is worked out again; a mass that somebody
/// stated stays.
fn stretched(
    meta: &Meta,
    view: &BodyView<'_>,
    size: Fit,
    options: &BuildOptions,
) -> Result<body::Body, Failure> {
    let mesh = body::fit::fitted(body::fit::mesh_of(meta, view), size);
    let origin = defaults::Origin {
        name: &meta.name,
        kind: meta.kind,
        origin: &format!("{}, stretched", meta.origin),
        hash: &meta.origin_hash,
    };
    let mut new = defaults::assemble(origin, &mesh);
    if !meta.mass_source.starts_with("default") {
        new.mass_kg = meta.mass_kg;
        new.mass_source.clone_from(&meta.mass_source);
    }
    new.occupants.clone_from(&meta.occupants);
    with_tree(mesh, new, options, &|_| {})
}

/// Generates a body and gives it a tree; `progress` as in [`bvh::build()`].
pub(crate) fn generate_body(
    shape: Shape,
    triangles: u32,
    seed: u64,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<body::Body, Failure> {
    let mesh = generate(shape, triangles, seed)
        .map_err(|error| Failure::input(error.to_string()).with_remedy("change `triangles`"))?;
    let origin = call(shape, triangles, seed);
    let hash = blake3::hash(origin.as_bytes()).to_hex();
    let origin = defaults::Origin {
        name: shape.name(),
        kind: shape.kind(),
        origin: &origin,
        hash: hash.as_str(),
    };
    let meta = defaults::assemble(origin, &mesh);
    with_tree(mesh, meta, options, progress)
}

/// Gives a mesh its zones and its tree.
pub(crate) fn with_tree(
    mesh: Mesh,
    meta: Meta,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<body::Body, Failure> {
    let zones = zones::of_mesh(&mesh, meta.kind);
    bvh::body(mesh, meta, zones, options, progress)
        .map_err(|error| Failure::input(error.to_string()))
}

/// A body as a model file in memory.
pub(crate) fn encoded(body: &body::Body) -> Result<Loaded, Failure> {
    let bytes = file::encode(body)?;
    Ok(Loaded { kind: body.meta.kind, bytes: file::Aligned::copy_of(&bytes), source_hash: None })
}
