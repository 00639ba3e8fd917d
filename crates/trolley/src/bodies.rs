//! Bodies: loaded or generated, given a tree, sealed into memory that worker processes share.
//!
//! ```text
//! model file --open--+
//! Shape, count ------+--> ModelFile --Bodies::seal--> one sealed memfd --Bodies::views--> BodyView
//! ```
//!
//! Every body that is ranked comes this way.
//!
//! ```
//! use trolley::bodies::{Bodies, ModelFile};
//! use trolley::model::{BuildOptions, Shape};
//!
//! let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
//! let bodies = Bodies::seal(vec![pole])?;
//! let views = bodies.views()?;
//! assert_eq!(views[0].1.corners.len(), 600);
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::Failure;
use crate::deployment::OpenDeployment;
use crate::scenario::Scenario;
use body::{BodyView, Fit, Mesh, Meta, Shape, defaults, file, zones};
use bvh::BuildOptions;
use runtime::SealedMemory;
use scenario::{EngineSettings, FileRef, Party, Source};
use std::path::PathBuf;

mod model_file;

pub use model_file::ModelFile;
use model_file::stretched;

/// A function that is called as trees are built, with [`SILENT`] for none.
///
/// ```
/// use trolley::bodies::OnProgress;
///
/// let progress: OnProgress<'_> = &|done, total| eprintln!("{done} of {total} triangles");
/// ```
pub use mesh::reader::OnProgress;

/// Ignores progress.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// # let mut engine = trolley::Engine::builder().in_process().build()?;
/// let limits = trolley::Limits::default();
/// engine.rank_telling(&scenario, &limits, trolley::bodies::SILENT)?; // as engine.rank
/// # Ok::<(), trolley::Failure>(())
/// ```
pub const SILENT: OnProgress<'static> = &|_, _| {};

/// Returns how trees are built with these settings of a scenario or deployment, on all cores that
/// this process may use.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// let options = trolley::bodies::build_options(&scenario.parsed().engine);
/// assert_eq!(options.leaf_size, scenario.parsed().engine.leaf_size);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[must_use]
pub fn build_options(engine: &EngineSettings) -> BuildOptions {
    BuildOptions {
        build: engine.build,
        leaf_size: engine.leaf_size,
        threads: runtime::affinity::allowed_cores().len(),
    }
}

/// Bodies in sealed memory, which worker processes map read-only.
///
/// ```
/// # use trolley::bodies::{Bodies, ModelFile};
/// # use trolley::model::{BuildOptions, Shape};
/// let options = BuildOptions::default();
/// let pole = ModelFile::generate(Shape::Pole, 600, 0, &options)?;
/// let wall = ModelFile::generate(Shape::Wall, 600, 0, &options)?;
/// let bodies = Bodies::seal(vec![pole, wall])?;
/// assert_eq!(bodies.hashes().len(), 2);
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Debug)]
pub struct Bodies {
    store: SealedMemory,
    largest_bytes: usize,
    hashes: Vec<String>,
    source_hashes: Vec<Option<String>>,
}

/// Where the body of a party comes from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartyBody<'s> {
    pub(crate) name: &'s str,
    pub(crate) source: &'s Source,
    pub(crate) size: Option<Fit>,
}

impl<'s> PartyBody<'s> {
    pub(crate) fn of(party: &'s Party) -> Self {
        Self { name: &party.name, source: &party.source, size: party.size }
    }

    /// Whether another one is the same body.
    /// The bodies without repetition, and the number of each party's own among them.
    pub(crate) fn unique(all: &[Self]) -> (Vec<Self>, Vec<usize>) {
        let mut unique: Vec<Self> = Vec::new();
        let number = |body: &Self| {
            unique.iter().position(|known| known.is_same(body)).unwrap_or_else(|| {
                unique.push(*body);
                unique.len() - 1
            })
        };
        let models = all.iter().map(number).collect();
        (unique, models)
    }

    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.source == other.source && self.size == other.size
    }
}

impl Bodies {
    /// Seals bodies into shared memory.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// let bodies = Bodies::seal(vec![pole])?;
    /// assert_eq!(bodies.views()?.len(), 1);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there is not enough memory.
    pub fn seal(bodies: Vec<ModelFile>) -> Result<Self, Failure> {
        Self::seal_copies(&bodies.iter().collect::<Vec<_>>())
    }

    /// Seals copies of bodies, which their owner keeps.
    pub(crate) fn seal_copies(bodies: &[&ModelFile]) -> Result<Self, Failure> {
        let files: Vec<&[u8]> = bodies.iter().map(|body| body.bytes()).collect();
        let hash = |bytes: &&[u8]| {
            file::content_hash(bytes).map_err(|error| Failure::internal(diagnostic::chain(&error)))
        };
        let hashes = files.iter().map(hash).collect::<Result<_, _>>()?;
        let store = coordinator::seal(&files)?;
        let source_hashes = bodies.iter().map(|body| body.source_hash.clone()).collect();
        let largest_bytes = files.iter().map(|file| file.len()).max().unwrap_or(0);
        Ok(Self { store, largest_bytes, hashes, source_hashes })
    }

    /// Loads or generates the body of every party of a scenario, builds its tree as the scenario
    /// says, and seals them in the order of the parties.
    ///
    /// ```
    /// use trolley::bodies::{Bodies, SILENT};
    ///
    /// let scenario = trolley::Scenario::open("../../config/scenarios/crossing.toml")?;
    /// let bodies = Bodies::of_scenario(&scenario, SILENT)?;
    /// assert_eq!(bodies.views()?.len(), scenario.parsed().parties.len());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a model file cannot be used, or does not suit its party.
    pub fn of_scenario(scenario: &Scenario, progress: OnProgress<'_>) -> Result<Self, Failure> {
        let (parsed, file) = (scenario.parsed(), scenario.file());
        let find = |_: usize, reference: &FileRef| scenario.path_of(reference);
        let parties = scenario.bodies();
        let bodies = Self::of_parties(&parties, &parsed.engine, file, &find, progress)?;
        parsed.check_kinds(file, &bodies.iter().map(ModelFile::kind).collect::<Vec<_>>())?;
        Self::seal(bodies)
    }

    /// The bodies of the parties of a scenario, not sealed yet: see [`Bodies::of_scenario`].
    pub(crate) fn of_parties(
        parties: &[PartyBody<'_>],
        engine: &EngineSettings,
        file: &str,
        find: &dyn Fn(usize, &FileRef) -> PathBuf,
        progress: OnProgress<'_>,
    ) -> Result<Vec<ModelFile>, Failure> {
        let generated = parties.iter().map(|party| match party.source {
            Source::Generate { triangles, .. } => u64::from(*triangles),
            Source::File(_) => 0,
        });
        let (total, mut done) = (generated.sum(), 0);
        let options = build_options(engine);
        let mut bodies = Vec::new();
        for (number, party) in parties.iter().enumerate() {
            let body = match party.source {
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
        Ok(bodies)
    }

    /// Opens or generates every model of a deployment, and seals them in its order.
    ///
    /// ```
    /// use trolley::{OpenDeployment, bodies::Bodies};
    ///
    /// let opened = OpenDeployment::open("../../config/deployments/minimal.toml".as_ref(), None)?;
    /// let bodies = Bodies::of_deployment(&opened)?;
    /// assert_eq!(bodies.views()?.len(), 3);
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If a model cannot be opened or generated, or leads out of the deployment's folder.
    pub fn of_deployment(opened: &OpenDeployment) -> Result<Self, Failure> {
        let options = build_options(&opened.deployment.engine);
        let load = |model: &service::Model| match &model.source {
            service::ModelSource::File(path) => {
                let key = format!("model \"{}\"", model.name);
                let path = opened.checked(&key, path)?;
                ModelFile::open(&path, None, &options).map_err(|failure| failure.at(key))
            }
            service::ModelSource::Generate { shape, triangles, seed } => {
                ModelFile::generate(*shape, *triangles, *seed, &options)
            }
        };
        Self::seal(opened.deployment.models.iter().map(load).collect::<Result<_, _>>()?)
    }

    /// Returns the bodies, read in place.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let bodies = Bodies::seal(vec![pole])?;
    /// for (meta, body) in bodies.views()? {
    ///     println!("{}: {} triangles", meta.name, body.corners.len());
    /// }
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Never for memory that this program sealed.
    pub fn views(&self) -> Result<Vec<(Meta, BodyView<'_>)>, Failure> {
        body::store::open(self.store.bytes())
            .map_err(|error| Failure::internal(diagnostic::chain(&error)))
    }

    /// Returns the sealed memory that worker processes inherit.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let bodies = Bodies::seal(vec![pole])?;
    /// println!("{} bytes", bodies.store().bytes().len());
    /// # assert!(!bodies.store().bytes().is_empty());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn store(&self) -> &SealedMemory {
        &self.store
    }

    /// Bytes of the largest model file in it.
    pub(crate) fn largest_bytes(&self) -> usize {
        self.largest_bytes
    }

    /// The bodies of a scenario's parties as a record names them; party i has body `models[i]`.
    pub(crate) fn recorded(
        &self,
        parties: &[PartyBody<'_>],
        models: &[usize],
    ) -> Vec<record::RecordedBody> {
        let recorded = |(party, model): (&PartyBody<'_>, &usize)| {
            let source = match (party.source, &self.source_hashes[*model]) {
                (Source::File(reference), Some(hash)) => {
                    let (path, hash) = (reference.path.clone(), hash.clone());
                    record::RecordedSource::File { path, hash }
                }
                _ => record::RecordedSource::Generated,
            };
            let hash = self.hashes[*model].clone();
            record::RecordedBody { party: party.name.to_owned(), source, hash }
        };
        parties.iter().zip(models).map(recorded).collect()
    }

    /// Returns the content hash of each body with its tree.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let bodies = Bodies::seal(vec![pole])?;
    /// let [pole] = bodies.hashes() else { unreachable!("one body was sealed") };
    /// println!("{pole}");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn hashes(&self) -> &[String] {
        &self.hashes
    }

    /// Returns the content hash of the file that each body was opened from; `None` if generated.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let bodies = Bodies::seal(vec![pole])?;
    /// assert_eq!(bodies.source_hashes(), [None], "the body was generated");
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    #[must_use]
    pub fn source_hashes(&self) -> &[Option<String>] {
        &self.source_hashes
    }
}

/// Generates a body and builds its tree. `progress` is called with the number of triangles placed
/// since its last call, from several threads.
///
/// ```
/// use trolley::bodies::generate;
/// use trolley::model::{BuildOptions, Shape};
///
/// let pole = generate(Shape::Pole, 600, 0, &BuildOptions::default(), &|_| {})?;
/// assert_eq!(pole.corners.len(), 600);
/// assert!(generate(Shape::Pole, 1, 0, &BuildOptions::default(), &|_| {}).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If `triangles` is out of range for the shape.
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
    bvh::in_threads(options.threads, mesh.corners.len(), || {
        let meta = defaults::assemble(origin, &mesh);
        with_tree(mesh, meta, options, progress)
    })
}

/// Makes a body of a mesh: adds zones, and builds its tree. `progress` as in [`generate`].
///
/// ```
/// # use trolley::bodies::{generate, with_tree};
/// # use trolley::model::{BuildOptions, Shape};
/// # let pole = generate(Shape::Pole, 600, 0, &BuildOptions::default(), &|_| {})?;
/// # let mesh = body::fit::mesh_of(&pole.meta, &pole.view());
/// # let meta = pole.meta.clone();
/// let options = BuildOptions { leaf_size: 8, ..BuildOptions::default() };
/// let body = with_tree(mesh, meta, &options, &|_| {})?;
/// assert_eq!(body.meta.leaf_size, 8);
/// # Ok::<(), trolley::Failure>(())
/// ```
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
