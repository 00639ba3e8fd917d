//! Bodies from where they are named to where they are read: loaded or generated, given the tree
//! that is asked for, sealed into the model store, opened.
//!
//! ```text
//! model file --open--+
//! Shape, count ------+--> ModelFile --Bodies::seal--> one sealed memfd --Bodies::views--> BodyView
//! ```
//!
//! This is the only way from a name to a body that is worked on, whoever asks.

use crate::Failure;
use crate::deployment::OpenDeployment;
use body::{BodyKind, BodyView, Fit, Mesh, Meta, Shape, defaults, file, zones};
use bvh::BuildOptions;
use runtime::{FileMap, SealedMemory};
use scenario::{EngineSettings, FileRef, Scenario, Source};
use std::path::{Path, PathBuf};

/// A body on its way into the model store.
#[derive(Debug)]
pub struct ModelFile {
    kind: BodyKind,
    bytes: file::Aligned,
    source_hash: Option<String>,
}

pub use mesh::reader::OnProgress;

/// Tells nobody.
pub const SILENT: OnProgress<'static> = &|_, _| {};

/// How trees are built where a scenario or a deployment has these settings: by all cores that are
/// granted.
#[must_use]
pub fn build_options(engine: &EngineSettings) -> BuildOptions {
    BuildOptions {
        build: engine.build,
        leaf_size: engine.leaf_size,
        threads: runtime::affinity::allowed_cores().len(),
    }
}

impl ModelFile {
    /// Opens a model file; its tree is built again if another one is asked for. With a size (m) the
    /// body is stretched to it.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is no sound model file.
    pub fn open(path: &Path, size: Option<Fit>, options: &BuildOptions) -> Result<Self, Failure> {
        let map = FileMap::open(path).map_err(|error| {
            Failure::input(diagnostic::chain(&error))
                .with_remedy("paths are relative to the scenario's folder")
        })?;
        let bad = |error: file::FileError| Failure::from(error).at(path.display());
        let (meta, view) = file::view(map.bytes()).map_err(bad)?;
        let source_hash = Some(file::content_hash(map.bytes()).map_err(bad)?);
        if let Some(size) = size {
            let body = stretched(&meta, &view, size, options)?;
            return Ok(Self { source_hash, ..Self::of(&body)? });
        }
        if meta.build == options.build && meta.leaf_size == options.leaf_size {
            let bytes = file::Aligned::copy_of(map.bytes());
            return Ok(Self { kind: meta.kind, bytes, source_hash });
        }
        let body = bvh::rebuild(view, &meta, options, &|_| {})
            .map_err(|error| Failure::from(error).at(path.display()))?;
        Ok(Self { source_hash, ..Self::of(&body)? })
    }

    /// Opens a model file with the tree that it has.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is no sound model file.
    pub fn as_it_is(path: &Path) -> Result<Self, Failure> {
        let map = FileMap::open(path).map_err(|error| {
            Failure::input(diagnostic::chain(&error))
                .with_remedy("name a model file that can be read")
        })?;
        // What is looked at is the copy: a file may change while it is mapped.
        let bytes = file::Aligned::copy_of(map.bytes());
        let bad = |error: file::FileError| Failure::from(error).at(path.display());
        let (meta, _) = file::view(bytes.bytes()).map_err(bad)?;
        let source_hash = Some(file::content_hash(bytes.bytes()).map_err(bad)?);
        Ok(Self { kind: meta.kind, bytes, source_hash })
    }

    /// Generates a body and gives it a tree.
    ///
    /// # Errors
    ///
    /// If a body of this shape cannot have so many triangles.
    pub fn generate(
        shape: Shape,
        triangles: u32,
        seed: u64,
        options: &BuildOptions,
    ) -> Result<Self, Failure> {
        Self::of(&generate(shape, triangles, seed, options, &|_| {})?)
    }

    /// A body as a model file in memory.
    ///
    /// # Errors
    ///
    /// If its names are too long for one.
    pub fn of(body: &body::Body) -> Result<Self, Failure> {
        let bytes = file::encode(body)?;
        let bytes = file::Aligned::copy_of(&bytes);
        Ok(Self { kind: body.meta.kind, bytes, source_hash: None })
    }

    /// What kind of body it is.
    #[must_use]
    pub fn kind(&self) -> BodyKind {
        self.kind
    }

    /// The model file.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }

    /// Content hash of the file that it was opened from; none of what was generated.
    #[must_use]
    pub fn source_hash(&self) -> Option<&str> {
        self.source_hash.as_deref()
    }
}

/// Bodies in sealed memory, which worker processes map read-only.
#[derive(Debug)]
pub struct Bodies {
    store: SealedMemory,
    hashes: Vec<String>,
    source_hashes: Vec<Option<String>>,
}

impl Bodies {
    /// Seals bodies.
    ///
    /// # Errors
    ///
    /// If there is not enough memory.
    pub fn seal(bodies: Vec<ModelFile>) -> Result<Self, Failure> {
        let files: Vec<&[u8]> = bodies.iter().map(ModelFile::bytes).collect();
        let hash = |bytes: &&[u8]| {
            file::content_hash(bytes).map_err(|error| Failure::internal(diagnostic::chain(&error)))
        };
        let hashes = files.iter().map(hash).collect::<Result<_, _>>()?;
        let store = coordinator::seal(&files)?;
        drop(files);
        let source_hashes = bodies.into_iter().map(|body| body.source_hash).collect();
        Ok(Self { store, hashes, source_hashes })
    }

    /// Loads or generates the body of every party of a scenario, with the tree that the engine asks
    /// for, and seals them in the order of the parties. `file` is the scenario's name in errors;
    /// `find` says where the model file of a party is.
    ///
    /// # Errors
    ///
    /// If a model file cannot be used, or does not fit its party.
    pub fn of_scenario(
        scenario: &Scenario,
        engine: &EngineSettings,
        file: &str,
        find: &dyn Fn(usize, &FileRef) -> PathBuf,
        progress: OnProgress<'_>,
    ) -> Result<Self, Failure> {
        let generated = scenario.parties.iter().map(|party| match party.source {
            Source::Generate { triangles, .. } => u64::from(triangles),
            Source::File(_) => 0,
        });
        let (total, mut done) = (generated.sum(), 0);
        let options = build_options(engine);
        let mut bodies = Vec::new();
        for (number, party) in scenario.parties.iter().enumerate() {
            let body = match &party.source {
                Source::Generate { shape, triangles, seed } => {
                    let mut body = generate(*shape, *triangles, *seed, &options, &|_| {})?;
                    if let Some(size) = party.size {
                        body = stretched(&body.meta, &body.view(), size, &options)?;
                    }
                    done += u64::from(*triangles);
                    progress(done, total);
                    ModelFile::of(&body)?
                }
                Source::File(reference) => {
                    let place = format!("{file}:{}: party \"{}\"", reference.place, party.name);
                    ModelFile::open(&find(number, reference), party.size, &options)
                        .map_err(|failure| failure.at(place))?
                }
            };
            bodies.push(body);
        }
        let kinds: Vec<BodyKind> = bodies.iter().map(ModelFile::kind).collect();
        scenario.check_kinds(file, &kinds)?;
        Self::seal(bodies)
    }

    /// Opens or generates every model of a deployment, in its order.
    ///
    /// # Errors
    ///
    /// If a model cannot be opened or generated.
    pub fn of_deployment(opened: &OpenDeployment) -> Result<Self, Failure> {
        let options = build_options(&opened.deployment.engine);
        let load = |model: &service::Model| match &model.source {
            service::ModelSource::File(path) => ModelFile::open(&opened.path(path), None, &options)
                .map_err(|failure| failure.at(format!("model \"{}\"", model.name))),
            service::ModelSource::Generate { shape, triangles, seed } => {
                ModelFile::generate(*shape, *triangles, *seed, &options)
            }
        };
        Self::seal(opened.deployment.models.iter().map(load).collect::<Result<_, _>>()?)
    }

    /// The bodies, read in place.
    ///
    /// # Errors
    ///
    /// Never for memory that this program sealed.
    pub fn views(&self) -> Result<Vec<(Meta, BodyView<'_>)>, Failure> {
        body::store::open(self.store.bytes())
            .map_err(|error| Failure::internal(diagnostic::chain(&error)))
    }

    /// The sealed memory, as worker processes inherit it.
    #[must_use]
    pub fn store(&self) -> &SealedMemory {
        &self.store
    }

    /// The bodies of a scenario's parties as a record names them.
    pub(crate) fn recorded(&self, scenario: &Scenario) -> Vec<record::RecordedBody> {
        let parties = scenario.parties.iter().zip(&self.hashes).zip(&self.source_hashes);
        let one = |((party, hash), source_hash): ((&scenario::Party, &String), &Option<String>)| {
            let source = match (&party.source, source_hash) {
                (Source::File(reference), Some(hash)) => {
                    let (path, hash) = (reference.path.clone(), hash.clone());
                    record::RecordedSource::File { path, hash }
                }
                _ => record::RecordedSource::Generated,
            };
            record::RecordedBody { party: party.name.to_string(), source, hash: hash.clone() }
        };
        parties.map(one).collect()
    }

    /// Content hash of each body with the tree that it has here.
    #[must_use]
    pub fn hashes(&self) -> &[String] {
        &self.hashes
    }

    /// Content hash of the model file that each was opened from; none of those generated.
    #[must_use]
    pub fn source_hashes(&self) -> &[Option<String>] {
        &self.source_hashes
    }
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
///
/// # Errors
///
/// If a body of this shape cannot have so many triangles.
pub fn generate(
    shape: Shape,
    triangles: u32,
    seed: u64,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<body::Body, Failure> {
    let mesh = shapes::generate(shape, triangles, seed)?;
    let origin = shapes::call(shape, triangles, seed);
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
///
/// # Errors
///
/// If no tree can be built of it.
pub fn with_tree(
    mesh: Mesh,
    meta: Meta,
    options: &BuildOptions,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<body::Body, Failure> {
    let zones = zones::of_mesh(&mesh, meta.kind);
    Ok(bvh::body(mesh, meta, zones, options, progress)?)
}
