//! Which triangles of two bodies intersect: all pairs, the sets of triangles, or whether any do;
//! when those of a body that moves first touch another one; and whether one body holds the other.
//!
//! ```text
//! triangles of A --Tree::build--> tree ─┐               ┌─▶ touches: yes or no, at the first hit
//! triangles of B --Tree::build--> tree ─┼─▶ Workspace ──┼─▶ sets: ids of all triangles hit
//! where B stands in A's frame ──────────┘               └─▶ pairs, for_each_pair: who hits whom
//! ```
//!
//! A query takes a [`Tree`], a [`body::Body`] or a [`BodyView`]. Ids are indices of triangles in
//! the order given to [`Tree::build`], or the source ids of a body.
//!
//! # Exactness
//!
//! A triangle is closed, and two intersect if they share a point: touching counts, and so does
//! overlap in one plane; a degenerate triangle is tested as the segment or point it is. Everything
//! is computed in A's frame. There, a corner of B is at [`RelativePose::point`], in f64: on these
//! coordinates every answer is exact, and thus the same for every build, leaf size, walk and vector
//! width. If A and B are swapped, these coordinates are rounded differently, and triangles that
//! barely touch may come apart.
//!
//! Coordinates are in metres and poses are rigid, but nothing depends on it: any single unit works,
//! and any matrix as a rotation; the boxes are merely looser then.
//!
//! # Example
//!
//! ```
//! use trolley_bvh::query::{BuildOptions, Pose, RelativePose, Tree, Workspace};
//! use trolley_bvh::query::{for_each_pair, pairs, sets, touches};
//! use std::ops::ControlFlow;
//!
//! // Two steps of a stair, and a pole that stands on the floor.
//! let stair = [
//!     [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
//!     [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [0.0, 1.0, 2.0]],
//! ];
//! let pole = [[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 3.0]]];
//! let options = BuildOptions::default();
//! let (stair, pole) = (Tree::build(&stair, &options)?, Tree::build(&pole, &options)?);
//!
//! // Where each stands in the world; the test takes place in the frame of the stair.
//! let pole_at = |x| Pose::from_degrees(0.0, 0.0, 0.0, [x, 0.2, 0.0]);
//! let pose = RelativePose::between(&Pose::IDENTITY, &pole_at(0.3));
//!
//! let mut workspace = Workspace::new();
//! assert!(touches(&stair, &pole, &pose, &mut workspace)?);
//! assert_eq!(pairs(&stair, &pole, &pose, &mut workspace)?, [(0, 0), (1, 0)]);
//! assert_eq!(sets(&stair, &pole, &pose, &mut workspace)?.of_a, [0, 1]);
//!
//! // One pair is enough.
//! let found = |a, b| ControlFlow::Break((a, b));
//! let first = for_each_pair(&stair, &pole, &pose, &mut workspace, found)?;
//! assert!(matches!(first, ControlFlow::Break((0 | 1, 0))));
//!
//! let beside = RelativePose::between(&Pose::IDENTITY, &pole_at(1.5));
//! assert!(!touches(&stair, &pole, &beside, &mut workspace)?);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod containment;
mod curve;
mod first;
mod folds;
mod near;
mod turning;

use crate::kernel::BEAT_TESTS;
use crate::{End, Kernel, NodePair, Question, Side, Sink, Task};
use body::BodyView;
use containment::Columns;
use diagnostic::{Diagnostic, FailureKind};
use std::borrow::Cow;
use std::convert::Infallible;
use std::fmt;
use std::ops::ControlFlow;

// All names that a query takes: callers need no other crate.
pub use crate::kernel::QueryWatch;
pub use crate::kernel::sweep::Witness;
pub use crate::{Build, BuildError, BuildOptions, Tree, Walk};
pub use body::{ShellKind, Shells};
pub use containment::{Containment, containment};
pub use curve::{PairContact, contacts};
pub use first::{SweepEffort, SweepWorkspace, earliest_pairs, first_contact};
pub use folds::self_pairs;
pub use geometry::motion::{MotionPath, Orientation, PathError, RelativeMotion, State};
pub use geometry::simd::Level;
pub use geometry::sweep::SweepError;
pub use geometry::triangle::ContactPoints;
pub use geometry::{Corners, Pose, RelativePose, Sweep};
pub use near::near_pairs;
pub use turning::{MotionContact, MotionEffort, MotionLimits, MotionWorkspace};
pub use turning::{RESOLUTION_MIN, ResolutionError};
pub use turning::{first_contact_in_motion, first_contact_in_motion_watched};

/// Greatest magnitude of a number in a pose: beyond it, points of B might not have finite
/// coordinates.
pub const POSE_MAX: f64 = 1e100;

/// Levels of a tree for which a workspace initially has capacity: those of a million triangles,
/// with some to spare. It grows on demand. The kernel uses at most this many; what it leaves open
/// then becomes separate jobs.
const LEVELS: u32 = 32;

/// Buffers for queries, reusable for any sequence of bodies. They grow to the size of the largest
/// query, about 60 kB plus two bits per triangle; after that only results are allocated.
///
/// Each thread has its own; trees are shared.
#[derive(Clone, Debug)]
pub struct Workspace {
    kernel: Kernel,
    /// Jobs to do, the next one last.
    open: Vec<NodePair>,
    /// The tree depth for which the kernel has capacity, in either tree.
    levels: u32,
    columns: Columns,
}

impl Workspace {
    /// Creates an initial workspace. The walk is the wide one, with the widest vectors of this
    /// processor.
    #[must_use]
    pub fn new() -> Self {
        Self {
            kernel: Kernel::with_room(LEVELS, LEVELS, 0, 0),
            open: Vec::new(),
            levels: LEVELS,
            columns: Columns::default(),
        }
    }

    /// Sets the walk of later queries; the answers do not change.
    pub fn set_walk(&mut self, walk: Walk) {
        self.kernel.set_walk(walk);
    }

    /// Sets the vector instructions of later queries; the answers do not change.
    pub fn set_level(&mut self, level: Level) {
        self.kernel.set_level(level);
    }

    /// Runs jobs until all of both bodies is done or `sink` stops it.
    fn run(&mut self, task: &Task<'_>, sink: &mut dyn Sink) -> Result<End, PoseError> {
        let numbers = task.pose.rotation.as_flattened().iter().chain(&task.pose.translation);
        if !numbers.copied().all(|x| x.abs() <= POSE_MAX) {
            return Err(PoseError);
        }
        if task.a.nodes.is_empty() || task.b.nodes.is_empty() {
            return Ok(End::Complete);
        }
        let triangles = [task.a.corners.len(), task.b.corners.len()];
        self.make_room(triangles);
        self.open.clear();
        self.open.push(NodePair::ROOTS);
        while let Some(start) = self.open.pop() {
            let outcome = self.kernel.run(task, start, u64::MAX, sink);
            match outcome.end {
                // Other jobs remain open if the stack had no capacity for one job over everything.
                End::Complete if task.question == Question::Touches && outcome.pairs > 0 => break,
                End::Complete => {}
                End::Stopped => return Ok(End::Stopped),
                End::OutOfBudget => {
                    self.open.extend_from_slice(self.kernel.remaining());
                    self.levels = self.levels.saturating_mul(2);
                    self.make_room(triangles);
                }
            }
        }
        Ok(End::Complete)
    }

    fn make_room(&mut self, triangles: [usize; 2]) {
        self.kernel.ensure_room(self.levels, self.levels, triangles[0], triangles[1]);
    }
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

/// Ids of the triangles that are hit, ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HitSets {
    /// Triangles of A that intersect any triangle of B.
    pub of_a: Vec<u32>,
    /// Triangles of B that intersect any triangle of A.
    pub of_b: Vec<u32>,
}

/// A number of a pose is NaN, infinite, or beyond [`POSE_MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseError;

impl Diagnostic for PoseError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn what(&self) -> String {
        format!("the pose has a number that is not finite, or beyond {POSE_MAX:e}")
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some("check the values from which the pose is computed".into())
    }
}

impl fmt::Display for PoseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what())
    }
}

impl std::error::Error for PoseError {}

/// Whether any triangle of `a` intersects any of `b`, whose pose in A's frame is `pose`. Stops at
/// the first pair found.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
///
/// # Panics
///
/// Like all queries, if a view is of a damaged tree; [`Tree::build`] and verified model files never
/// produce one.
pub fn touches<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    workspace: &mut Workspace,
) -> Result<bool, PoseError> {
    let task = task(a.into(), b.into(), pose, Question::Touches);
    let mut first = First(false);
    workspace.run(&task, &mut first)?;
    Ok(first.0)
}

/// Returns which triangles of `a` and of `b`, whose pose in A's frame is `pose`, intersect any of
/// the other body. Faster than [`pairs`] where many intersect: not all pairs need to be tested.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
pub fn sets<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    workspace: &mut Workspace,
) -> Result<HitSets, PoseError> {
    let task = task(a.into(), b.into(), pose, Question::Sets);
    let mut gathered = Gathered { task: &task, hits: HitSets::default() };
    workspace.run(&task, &mut gathered)?;
    let mut hits = gathered.hits;
    for ids in [&mut hits.of_a, &mut hits.of_b] {
        ids.sort_unstable();
        // Several jobs may have hit the same triangle.
        ids.dedup();
    }
    Ok(hits)
}

/// Returns all intersecting pairs of a triangle of `a` and one of `b`, whose pose in A's frame is
/// `pose`: ids of A and of B, each pair once, ascending.
///
/// Sorting makes results comparable; [`for_each_pair`] needs neither the order nor the memory.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
pub fn pairs<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    workspace: &mut Workspace,
) -> Result<Vec<(u32, u32)>, PoseError> {
    let mut pairs = Vec::new();
    let ended = for_each_pair::<Infallible>(a, b, pose, workspace, |a, b| {
        pairs.push((a, b));
        ControlFlow::Continue(())
    })?;
    let ControlFlow::Continue(()) = ended;
    pairs.sort_unstable();
    Ok(pairs)
}

/// Calls `each` with the ids of every intersecting pair of a triangle of `a` and one of `b`, whose
/// pose in A's frame is `pose`: each pair once, in no particular order, until it returns `Break`.
/// That value is returned; `each` is not called again.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
pub fn for_each_pair<'t, B>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    workspace: &mut Workspace,
    each: impl FnMut(u32, u32) -> ControlFlow<B>,
) -> Result<ControlFlow<B>, PoseError> {
    let task = task(a.into(), b.into(), pose, Question::Pairs);
    let mut listed = Listed { ids: [task.a.source_ids, task.b.source_ids], each, broken: None };
    workspace.run(&task, &mut listed)?;
    Ok(listed.broken.map_or(ControlFlow::Continue(()), ControlFlow::Break))
}

/// Returns the least pair of [`pairs`] without listing them, or `Break` if that takes more than
/// about `budget` tests of boxes and triangles. A pair of triangles that intersect counts as one
/// more.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
pub fn least_pair<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    budget: u64,
    workspace: &mut Workspace,
) -> Result<ControlFlow<(), Option<[u32; 2]>>, PoseError> {
    least_pair_watched(a, b, pose, (budget, &mut |_| ControlFlow::Continue(())), workspace)
}

/// [`least_pair`], which `watch` may end.
///
/// # Errors
///
/// As [`least_pair`].
pub fn least_pair_watched<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    (budget, watch): (u64, QueryWatch<'_>),
    workspace: &mut Workspace,
) -> Result<ControlFlow<(), Option<[u32; 2]>>, PoseError> {
    let task = task(a.into(), b.into(), pose, Question::Pairs);
    let ids = [task.a.source_ids, task.b.source_ids];
    let mut sink = Least { ids, least: None, budget, watch };
    Ok(match workspace.run(&task, &mut sink)? {
        End::Complete => ControlFlow::Continue(sink.least),
        End::Stopped | End::OutOfBudget => ControlFlow::Break(()),
    })
}

fn task<'t>(a: BodyView<'t>, b: BodyView<'t>, pose: &RelativePose, question: Question) -> Task<'t> {
    Task { a, b, pose: *pose, question, directions: None }
}

/// Whether there was a hit, which ends the query.
struct First(bool);

impl Sink for First {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        self.0 = true;
        ControlFlow::Break(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Ids of triangles that were hit.
struct Gathered<'g> {
    task: &'g Task<'g>,
    hits: HitSets,
}

impl Sink for Gathered<'_> {
    fn hit(&mut self, side: Side, triangle: u32) -> ControlFlow<()> {
        let (ids, hits) = match side {
            Side::A => (self.task.a.source_ids, &mut self.hits.of_a),
            Side::B => (self.task.b.source_ids, &mut self.hits.of_b),
        };
        hits.push(ids[triangle as usize]);
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Reports pairs by their ids.
struct Listed<'l, F, B> {
    ids: [&'l [u32]; 2],
    each: F,
    broken: Option<B>,
}

impl<B, F: FnMut(u32, u32) -> ControlFlow<B>> Sink for Listed<'_, F, B> {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn pairs(&mut self, a: &[u32], b: &[u32]) -> ControlFlow<()> {
        for (&a, &b) in a.iter().zip(b) {
            let each = (self.each)(self.ids[0][a as usize], self.ids[1][b as usize]);
            if let ControlFlow::Break(with) = each {
                self.broken = Some(with);
                return ControlFlow::Break(());
            }
        }
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Keeps the pair of the least ids, within a budget.
struct Least<'l, 'w> {
    ids: [&'l [u32]; 2],
    least: Option<[u32; 2]>,
    /// What is left of it.
    budget: u64,
    watch: QueryWatch<'w>,
}

impl Least<'_, '_> {
    fn spend(&mut self, tests: u64) -> ControlFlow<()> {
        match self.budget.checked_sub(tests) {
            Some(left) => {
                self.budget = left;
                ControlFlow::Continue(())
            }
            None => ControlFlow::Break(()),
        }
    }
}

impl Sink for Least<'_, '_> {
    fn hit(&mut self, _: Side, _: u32) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn pairs(&mut self, a: &[u32], b: &[u32]) -> ControlFlow<()> {
        let pairs = a.iter().zip(b);
        let least = pairs.map(|(&a, &b)| [self.ids[0][a as usize], self.ids[1][b as usize]]).min();
        self.least = [self.least, least].into_iter().flatten().min();
        self.spend(a.len() as u64)
    }

    fn seeks_least(&self) -> bool {
        true
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        (self.watch)(BEAT_TESTS)?;
        self.spend(BEAT_TESTS)
    }
}

#[cfg(test)]
mod tests;
