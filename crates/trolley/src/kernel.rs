//! The intersection kernel for your own triangles: which triangles of two bodies intersect, and
//! when those of a body that moves first touch another one.
//!
//! ```
//! use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace, pairs};
//!
//! let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
//! let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
//! let options = BuildOptions::default();
//! let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
//! let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
//! assert_eq!(pairs(&floor, &blade, &pose, &mut Workspace::new())?, [(0, 0)]);
//! # Ok::<(), trolley::Failure>(())
//! ```
//!
//! No mass, seat or file is needed. The crate `bvh` documents what is exact, in `bvh::query`.

use crate::Failure;
use crate::files::{self, InputKind};
use mesh::import::{self, Format, ImportOptions};
use std::path::Path;

/// A body with its tree: one of your own is a [`Tree`].
///
/// ```
/// use trolley::kernel::{Body, BuildOptions};
/// use trolley::model::Shape;
///
/// let options = BuildOptions::default();
/// let pole: Body = trolley::bodies::generate(Shape::Pole, 600, 0, &options, &|_| {})?;
/// assert_eq!(pole.corners.len(), 600);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use body::Body;

/// A borrowed [`Body`] or [`Tree`], which every query takes.
///
/// ```
/// # use trolley::kernel::BuildOptions;
/// # use trolley::model::Shape;
/// # let body = trolley::bodies::generate(Shape::Pole, 600, 0, &BuildOptions::default(), &|_| {})?;
/// use trolley::kernel::BodyView;
///
/// let view: BodyView<'_> = body.view();
/// assert_eq!(view.corners.len(), view.source_ids.len());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use body::BodyView;

/// How a tree is built, in [`BuildOptions`].
///
/// ```
/// use trolley::kernel::{Build, BuildOptions};
///
/// let options = BuildOptions { build: Build::Sah, ..BuildOptions::default() };
/// assert_eq!(options.build.name(), "sah");
/// ```
pub use body::Build;

/// The error of [`Tree::build`].
///
/// ```
/// use trolley::kernel::{BuildError, BuildOptions, Tree};
///
/// let nothing = Tree::build(&[], &BuildOptions::default());
/// assert!(matches!(nothing, Err(BuildError::Empty)));
/// ```
pub use bvh::BuildError;

/// The options of [`Tree::build`].
///
/// ```
/// use trolley::kernel::BuildOptions;
///
/// let options = BuildOptions { leaf_size: 8, threads: 2, ..BuildOptions::default() };
/// ```
pub use bvh::BuildOptions;

/// A tree over your own triangles.
///
/// ```
/// use trolley::kernel::{BuildOptions, Tree};
///
/// let triangles = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// let tree = Tree::build(&triangles, &BuildOptions::default())?;
/// assert_eq!(tree.corners(), triangles);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::Tree;

/// How a [`Workspace`] walks trees.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// let mut workspace = Workspace::new();
/// workspace.set_walk(trolley::kernel::Walk::Plain); // the answers are the same
/// assert!(trolley::kernel::touches(&floor, &blade, &pose, &mut workspace)?);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::Walk;

/// The triangles that [`sets`] finds.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// let hits = trolley::kernel::sets(&floor, &blade, &pose, &mut Workspace::new())?;
/// assert_eq!((hits.of_a, hits.of_b), (vec![0], vec![0]));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::HitSets;

/// The vector instructions of a [`Workspace`].
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// let mut workspace = Workspace::new();
/// workspace.set_level(trolley::kernel::Level::new()); // the widest of this processor
/// assert!(trolley::kernel::touches(&floor, &blade, &pose, &mut workspace)?);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::Level;

/// The error of a query.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::{PoseError, touches};
///
/// let nowhere = RelativePose { translation: [f64::NAN; 3], ..pose };
/// assert_eq!(touches(&floor, &blade, &nowhere, &mut Workspace::new()), Err(PoseError));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::PoseError;

/// The memory of queries.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// let mut workspace = Workspace::new(); // for any number of queries
/// for height in [0.0, 0.5, 2.0] {
///     let pose = RelativePose { translation: [0.0, 0.0, height], ..pose };
///     let is_hit = trolley::kernel::touches(&floor, &blade, &pose, &mut workspace)?;
///     assert_eq!(is_hit, height < 1.0);
/// }
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::Workspace;

/// Calls a function for each pair of intersecting triangles.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use std::ops::ControlFlow;
/// use trolley::kernel::for_each_pair;
///
/// let found = |a, b| ControlFlow::Break((a, b)); // one pair is enough
/// let first = for_each_pair(&floor, &blade, &pose, &mut Workspace::new(), found)?;
/// assert_eq!(first, ControlFlow::Break((0, 0)));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::for_each_pair;

/// Returns all pairs of intersecting triangles.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::pairs;
///
/// assert_eq!(pairs(&floor, &blade, &pose, &mut Workspace::new())?, [(0, 0)]);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::pairs;

/// Returns the triangles of each body that intersect the other body.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::sets;
///
/// assert_eq!(sets(&floor, &blade, &pose, &mut Workspace::new())?.of_a, [0]);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::sets;

/// Returns all pairs of intersecting triangles, each with the points of its contact.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::contacts;
///
/// let found = contacts(&floor, &blade, &pose, &mut Workspace::new())?;
/// assert_eq!(found[0].points.points().len(), 2, "the ends of a segment");
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::contacts;

/// Two triangles that intersect, and where: of [`contacts`].
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::{PairContact, contacts};
///
/// let found: Vec<PairContact> = contacts(&floor, &blade, &pose, &mut Workspace::new())?;
/// assert_eq!(found[0].ids, [0, 0]);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::PairContact;

/// Returns the pairs of triangles of one body that have more in common than corners and edges.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::self_pairs;
///
/// let both = [floor.corners()[0], blade.corners()[0]];
/// let both = Tree::build(&both, &options)?;
/// assert_eq!(self_pairs(&both, &mut Workspace::new())?, [(0, 1)]);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::self_pairs;

/// Returns which of many bodies are near enough to each other to be worth a query.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::near_pairs;
///
/// let far = Pose { translation: [9.0, 0.0, 0.0], ..Pose::IDENTITY };
/// let near = Pose::IDENTITY;
/// let bodies = [(floor.view(), near), (blade.view(), near), (blade.view(), far)];
/// assert_eq!(near_pairs(&bodies), [(0, 1)]);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::near_pairs;

/// Returns whether two bodies intersect.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Tree, Workspace};
/// # let options = BuildOptions::default();
/// # let floor = [[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]];
/// # let blade = [[[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 2.0, 0.0]]];
/// # let (floor, blade) = (Tree::build(&floor, &options)?, Tree::build(&blade, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// use trolley::kernel::touches;
///
/// assert!(touches(&floor, &blade, &pose, &mut Workspace::new())?);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::touches;

/// Returns when a body that moves along a straight line first touches another one, and which
/// triangles touch then; `None` if they never do on that way.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// # let options = BuildOptions::default();
/// # let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// # let ball = [[[3.0, 0.25, 0.25], [3.1, 0.3, 0.25], [3.1, 0.25, 0.3]]];
/// # let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// # let mut workspace = SweepWorkspace::new();
/// use trolley::kernel::first_contact;
///
/// // The ball starts 3 m ahead of the wall, and comes towards it for up to 10 m.
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// let first = first_contact(&wall, &ball, &pose, &sweep, &mut workspace)?;
/// assert_eq!(first.map(|first| (first.travel_m, first.ids)), Some((3.0, [0, 0])));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::first_contact;

/// Returns the pairs of triangles that touch first, ascending by travel and ids.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// # let options = BuildOptions::default();
/// # let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// # let ball = [[[3.0, 0.25, 0.25], [3.1, 0.3, 0.25], [3.1, 0.25, 0.3]]];
/// # let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// # let mut workspace = SweepWorkspace::new();
/// use trolley::kernel::earliest_pairs;
///
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// let pairs = earliest_pairs(&wall, &ball, &pose, &sweep, 16, &mut workspace)?;
/// assert_eq!(pairs.len(), 1, "there is one pair only");
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::earliest_pairs;

/// A motion along a straight line, in A's frame.
///
/// ```
/// use trolley::kernel::Sweep;
///
/// // Of any length but 0, from 1 m before the pose to 10 m after it.
/// let sweep = Sweep::new([-2.0, 0.5, 0.0].into(), -1.0, 10.0)?;
/// assert_eq!((sweep.from_m(), sweep.to_m()), (-1.0, 10.0));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::Sweep;

/// The error of [`Sweep::new`].
///
/// ```
/// use trolley::kernel::{Sweep, SweepError};
///
/// assert_eq!(Sweep::new([0.0; 3].into(), 0.0, 10.0), Err(SweepError::Direction));
/// ```
pub use bvh::query::SweepError;

/// Buffers for [`first_contact`] and [`earliest_pairs`].
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// # let options = BuildOptions::default();
/// # let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// # let ball = [[[3.0, 0.25, 0.25], [3.1, 0.3, 0.25], [3.1, 0.25, 0.3]]];
/// # let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// let mut workspace = SweepWorkspace::new();
/// workspace.set_walk(trolley::kernel::Walk::Plain); // the answers are the same
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// assert!(trolley::kernel::first_contact(&wall, &ball, &pose, &sweep, &mut workspace)?.is_some());
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::SweepWorkspace;

/// What the last query of a [`SweepWorkspace`] took.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// # let options = BuildOptions::default();
/// # let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// # let ball = [[[3.0, 0.25, 0.25], [3.1, 0.3, 0.25], [3.1, 0.25, 0.3]]];
/// # let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// # let mut workspace = SweepWorkspace::new();
/// use trolley::kernel::{SweepEffort, first_contact};
///
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// first_contact(&wall, &ball, &pose, &sweep, &mut workspace)?;
/// let SweepEffort { counters, exact_tests } = workspace.effort();
/// println!("{} box tests, {exact_tests} pairs decided one by one", counters.nb);
/// # assert_eq!(exact_tests, 1);
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::SweepEffort;

/// Two triangles, and the first travel at which they touch.
///
/// ```
/// # use trolley::kernel::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// # let options = BuildOptions::default();
/// # let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// # let ball = [[[3.0, 0.25, 0.25], [3.1, 0.3, 0.25], [3.1, 0.25, 0.3]]];
/// # let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
/// # let pose = RelativePose::between(&Pose::IDENTITY, &Pose::IDENTITY);
/// # let mut workspace = SweepWorkspace::new();
/// use trolley::kernel::{Witness, first_contact};
///
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// let first: Option<Witness> = first_contact(&wall, &ball, &pose, &sweep, &mut workspace)?;
/// assert_eq!(first.map(|first| first.point.to_array()), Some([0.0, 0.25, 0.25]));
/// # Ok::<(), trolley::Failure>(())
/// ```
pub use bvh::query::Witness;

/// A triangle: three corners of three coordinates.
///
/// ```
/// use trolley::kernel::Corners;
///
/// let triangle: Corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
/// ```
pub use geometry::Corners;

/// The pose of a body in the world.
///
/// ```
/// use trolley::kernel::Pose;
///
/// let ahead = Pose { translation: [2.5, 0.0, 0.0], ..Pose::IDENTITY };
/// assert_eq!(ahead, Pose::from_degrees(0.0, 0.0, 0.0, [2.5, 0.0, 0.0]));
/// ```
pub use geometry::Pose;

/// The pose of B in the frame of A.
///
/// ```
/// use trolley::kernel::{Pose, RelativePose};
///
/// let b = Pose::from_degrees(0.0, 0.0, 0.0, [2.5, 0.0, 0.0]);
/// assert_eq!(RelativePose::between(&Pose::IDENTITY, &b).translation, [2.5, 0.0, 0.0]);
/// ```
pub use geometry::RelativePose;

/// Reads the triangles of a mesh file, in its order and unit: STL, OBJ, PLY, glTF and more.
///
/// The file is read in this process without limits of memory or time, so it must be trusted.
/// Files beside it, such as buffers of glTF, are not read.
///
/// ```
/// let triangles = trolley::kernel::read_mesh("examples/data/pole.stl")?;
/// assert_eq!(triangles.len(), 12);
/// # Ok::<(), trolley::Failure>(())
/// ```
///
/// # Errors
///
/// If the file cannot be read, is longer than [`InputKind::Mesh`] may be, or is no mesh.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<Vec<Corners>, Failure> {
    let path = path.as_ref();
    let bytes = files::bytes(path, InputKind::Mesh)?;
    let file = path.display().to_string();
    let format = Format::detect(&file, &bytes)?;
    let options = ImportOptions { file, ..ImportOptions::as_it_stands() };
    let mut refuse_beside = |name: &str| Err(format!("{name}: files beside it are not read"));
    Ok(import::read(format, &bytes, &mut refuse_beside, &options)?.mesh.corners)
}
