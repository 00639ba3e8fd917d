//! Model files: imported from meshes or generated, inspected, checked, exported.
//!
//! ```text
//! Import, check --starts--> mesh::reader (limits itself, reads the mesh, builds the tree)
//!       ^                       | progress, then a report and the model file, through a pipe
//!       '-- verify, write <-----'
//! info, Export, check --> open: a model file, verified      Generate --> bodies --> write
//! ```
//!
//! A mesh file is read in a child process, which [`play_worker`](crate::play_worker) plays, so a
//! bad mesh cannot harm the caller. A file is replaced only by a finished and verified one, so a
//! failure leaves nothing behind and nothing damaged.
//!
//! ```
//! # let folder = std::env::temp_dir().join(format!("trolley-model-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).ok();
//! use trolley::model::{self, Build, Generate, Info, ReadLimits, Shape};
//!
//! let (tree, out) = (model::tree(Build::Paper, 4), folder.join("suv.trolley"));
//! let suv = Generate { shape: Shape::Suv, triangles: 1500, seed: 0, tree, out: out.clone() };
//! println!("{}", suv.run(&|_, _| {})?.body.sentence);
//!
//! let info = model::info(&out, ReadLimits::default(), trolley::bodies::SILENT)?;
//! assert!(matches!(info, Info::Body(_)));
//! # std::fs::remove_dir_all(&folder).ok();
//! # Ok::<(), trolley::Failure>(())
//! ```

mod check;
mod export;
pub mod facts;
mod generate;
mod import;
mod info;
pub mod open;

/// The kind of a body.
///
/// ```
/// # use trolley::model::{self, Generate, Shape};
/// # let folder = std::env::temp_dir().join(format!("trolley-kind-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).ok();
/// # let out = folder.join("pole.trolley");
/// # let tree = model::tree(model::Build::Paper, 4);
/// # let (shape, triangles, seed) = (Shape::Pole, 600, 0);
/// # let pole = Generate { shape, triangles, seed, tree, out: out.clone() };
/// # let generated = pole.run(&|_, _| {})?;
/// assert_eq!(generated.body.kind, model::BodyKind::Pole);
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use body::BodyKind;

/// How a tree is built.
///
/// ```
/// use trolley::model::{self, Build};
///
/// let trees = Build::ALL.map(|build| model::tree(build, 4));
/// assert_eq!(trees[0].build, Build::Paper);
/// ```
pub use body::Build;

/// The greatest leaf size of a [`tree`].
///
/// ```
/// use trolley::model::{self, Build, LEAF_SIZE_MAX};
///
/// let shallow = model::tree(Build::Sah, LEAF_SIZE_MAX);
/// ```
pub use body::LEAF_SIZE_MAX;

/// What a side file says of a body's impacts, in place of the parameters in force.
///
/// ```
/// use trolley::model::{BodyKind, OwnParameters};
///
/// let own = OwnParameters { mass_share: Some(0.02), ..OwnParameters::default() };
/// assert!(own.check(BodyKind::Sedan).is_ok());
/// assert!(own.check(BodyKind::Wall).is_err()); // it has no mass
/// ```
pub use body::OwnParameters;

/// A seat of an occupant.
///
/// ```
/// # let options = trolley::model::BuildOptions::default();
/// # let shape = trolley::model::Shape::Sedan;
/// # let car = trolley::bodies::generate(shape, 1500, 0, &options, &|_| {})?;
/// use trolley::model::Seat;
///
/// let driver = Some(Seat::FrontLeft); // `None` stands for a person on foot
/// assert!(car.meta.occupants.is_none_or(|all| all.iter().any(|person| person.seat == driver)));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use body::Seat;

/// A built-in shape, for [`Generate`].
///
/// ```
/// use trolley::model::Shape;
///
/// assert_eq!("cyclist".parse(), Ok(Shape::Cyclist));
/// assert_eq!(Shape::ALL.len(), 9);
/// ```
pub use body::Shape;

/// How a tree is built: see [`tree`].
///
/// ```
/// use trolley::model::{self, Build, BuildOptions};
///
/// let options = BuildOptions { threads: 1, ..model::tree(Build::Sah, 8) };
/// assert_eq!(options, BuildOptions { build: Build::Sah, leaf_size: 8, threads: 1 });
/// ```
pub use bvh::BuildOptions;
pub use check::{CheckReport, FileCheck, check};
pub use export::{Export, Exported};
pub use facts::Facts;
pub use generate::{Generate, Generated};
pub use import::{Import, ImportedModel};
pub use info::{BodyInfo, Info, MeshInfo, info};

/// The format of an [`Export`].
///
/// ```
/// use trolley::model::ExportFormat;
///
/// assert!("stl".parse() == Ok(ExportFormat::Stl) && ExportFormat::Obj.name() == "obj");
/// ```
pub use mesh::export::ExportFormat;

/// An axis of a mesh, in [`MeshOptions`].
///
/// ```
/// use trolley::model::{Axis, MeshOptions};
///
/// let (up, forward) = (Some(Axis::Y), Some(Axis::Z));
/// let options = MeshOptions { up, forward, ..MeshOptions::default() };
/// assert!("-x".parse::<Axis>().is_ok());
/// ```
pub use mesh::import::Axis;

/// The unit of a mesh, in [`MeshOptions`].
///
/// ```
/// use trolley::model::{LengthUnit, MeshOptions};
///
/// let unit = "cm".parse::<LengthUnit>()?;
/// let options = MeshOptions { unit: Some(unit), ..MeshOptions::default() };
/// assert_eq!(unit.metres(), 0.01);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use mesh::import::LengthUnit;

/// A way to read a mesh, offered in [`MeshInfo`].
///
/// ```no_run
/// # use trolley::model::{Info, ReadLimits, info};
/// trolley::play_worker(); // a mesh is read in a child process
/// if let Info::Mesh(mesh) = info("car.obj".as_ref(), ReadLimits::default(), &|_, _| {})? {
///     for reading in &mesh.readings {
///         println!("in {}, {} up: {}", reading.unit, reading.up, reading.looks_like);
///     }
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use mesh::import::Reading;

/// How an [`Import`] reads its mesh.
///
/// ```
/// use trolley::model::{Axis, BodyKind, LengthUnit, MeshOptions};
///
/// let options = MeshOptions {
///     unit: Some(LengthUnit::METRE),
///     up: Some(Axis::Z),
///     kind: Some(BodyKind::Sedan),
///     ..MeshOptions::default()
/// };
/// ```
pub use mesh::reader::MeshOptions;

/// A function that is called as trees are built.
///
/// ```
/// use trolley::model::OnProgress;
///
/// let progress: OnProgress<'_> = &|done, total| eprintln!("{done} of {total} triangles");
/// ```
pub use mesh::reader::OnProgress;

/// The limits of the process that reads a mesh.
///
/// ```
/// use trolley::model::ReadLimits;
///
/// let limits = ReadLimits { memory_mb: Some(512), ..ReadLimits::default() };
/// assert_eq!(limits.cpu_s, ReadLimits::CPU_S);
/// ```
pub use mesh::reader::ReadLimits;

/// What an [`Import`] found in its mesh.
///
/// ```no_run
/// # use trolley::model::{Build, Import, MeshOptions, ReadLimits, tree};
/// # let import = Import {
/// #     mesh: "car.obj".into(),
/// #     options: MeshOptions::default(),
/// #     name: None,
/// #     tree: tree(Build::Paper, 4),
/// #     limits: ReadLimits::default(),
/// #     out: "car.trolley".into(),
/// # };
/// let report = import.run(&|_, _| {})?.import;
/// println!("{}: {} triangles", report.sentence, report.triangles);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use mesh::reader::Report;

/// The greatest number of triangles of a generated body.
///
/// ```
/// use trolley::model::{Shape, TRIANGLES_MAX};
///
/// let options = trolley::model::BuildOptions::default();
/// let more = trolley::bodies::generate(Shape::Pole, TRIANGLES_MAX + 1, 0, &options, &|_| {});
/// assert!(more.is_err());
/// ```
pub use shapes::TRIANGLES_MAX;

/// The least number of triangles of a generated body.
///
/// ```
/// use trolley::model::{Shape, TRIANGLES_MIN};
///
/// let options = trolley::model::BuildOptions::default();
/// assert!(trolley::bodies::generate(Shape::Pole, TRIANGLES_MIN, 0, &options, &|_| {}).is_ok());
/// ```
pub use shapes::TRIANGLES_MIN;

/// Returns options for a tree with at most `leaf_size` triangles in a leaf, built by as many
/// threads as are useful.
///
/// ```
/// use trolley::model::{self, Build};
///
/// let options = model::tree(Build::Sah, 8);
/// assert_eq!((options.build, options.leaf_size), (Build::Sah, 8));
/// assert!((1..=8).contains(&options.threads));
/// ```
#[must_use]
pub fn tree(build: Build, leaf_size: u32) -> BuildOptions {
    // More than eight gain nothing, and each takes address space.
    let threads = runtime::affinity::allowed_cores().len().clamp(1, 8);
    BuildOptions { build, leaf_size, threads }
}
