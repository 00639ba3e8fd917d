//! First contact of a body that moves along a straight line with another one.

use super::{POSE_MAX, PoseError};
use crate::kernel::sweep::{Silent, SweepKernel, SweepLimits, SweepTask, Witness};
use crate::{Counters, End, NodePair, Walk};
use body::BodyView;
use geometry::simd::Level;
use geometry::{RelativePose, Sweep};

/// Buffers for queries of first contact, reusable for any sequence of bodies: some 300 kB.
///
/// Each thread has its own; trees are shared.
#[derive(Clone, Debug)]
pub struct SweepWorkspace {
    kernel: SweepKernel,
    /// Jobs to do, and the travel before which nothing below them touches.
    open: Vec<(NodePair, f32)>,
    found: Vec<Witness>,
    levels: u32,
    effort: SweepEffort,
}

/// What the last query took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SweepEffort {
    /// Tests of boxes, and of triangles that are not apart by their boxes.
    pub counters: Counters,
    /// Pairs of triangles that were decided one by one.
    pub exact_tests: u64,
}

impl SweepWorkspace {
    /// Creates an initial workspace. The walk is the wide one, with the widest vectors of this
    /// processor.
    #[must_use]
    pub fn new() -> Self {
        Self {
            kernel: SweepKernel::with_room(super::LEVELS, super::LEVELS, 1),
            open: Vec::new(),
            found: Vec::new(),
            levels: super::LEVELS,
            effort: SweepEffort::default(),
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

    /// What the last query took.
    #[must_use]
    pub fn effort(&self) -> SweepEffort {
        self.effort
    }

    fn run(&mut self, task: &SweepTask<'_>, nearest: usize) -> Result<(), PoseError> {
        self.effort = SweepEffort::default();
        self.found.clear();
        let numbers = task.pose.rotation.as_flattened().iter().chain(&task.pose.translation);
        if !numbers.copied().all(|x| x.abs() <= POSE_MAX) {
            return Err(PoseError);
        }
        if task.a.nodes.is_empty() || task.b.nodes.is_empty() {
            return Ok(());
        }
        self.kernel.ensure_room(self.levels, self.levels, nearest);
        self.open.clear();
        self.open.push((NodePair::ROOTS, f32::NEG_INFINITY));
        while let Some((start, from_m)) = self.open.pop() {
            let limit_m = match self.found.get(nearest.saturating_sub(1)) {
                Some(last) => last.travel_m,
                None => task.sweep.to_m(),
            };
            if f64::from(from_m) > limit_m {
                continue;
            }
            let task = SweepTask { sweep: task.sweep.until(limit_m), ..*task };
            let limits = SweepLimits::default();
            let outcome = self.kernel.run(&task, start, limits, &mut Silent);
            self.effort.counters.add(&outcome.counters);
            self.effort.exact_tests += outcome.exact_tests;
            self.found.extend_from_slice(self.kernel.nearest());
            self.found.sort_by(Witness::order);
            self.found.truncate(nearest.max(1));
            if outcome.end == End::OutOfBudget {
                // The trees are deeper than there was room for.
                let first = self.open.len();
                self.open.extend(self.kernel.remaining().map(|open| (open.pair, open.from_m)));
                self.open[first..].sort_by(|p, q| q.1.total_cmp(&p.1));
                self.levels = self.levels.saturating_mul(2);
                self.kernel.ensure_room(self.levels, self.levels, nearest);
            }
        }
        Ok(())
    }
}

impl Default for SweepWorkspace {
    fn default() -> Self {
        Self::new()
    }
}

/// When `b`, whose pose in A's frame at travel 0 is `pose`, first touches `a` on its way, and which
/// triangles touch then: of several at the same travel, those with the least ids. `None`: they
/// never touch on that way.
///
/// The motion is continuous: nothing slips between poses. Travel is exact to 1 nm, and so is
/// whether contact at the very ends of the motion counts; everything else about the answer is
/// exact, and the same bits for every build, leaf size, walk, vector width and machine.
///
/// ```
/// use trolley_bvh::query::{BuildOptions, Pose, RelativePose, Sweep, SweepWorkspace, Tree};
/// use trolley_bvh::query::first_contact;
///
/// let wall = [[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
/// let ball = [[[0.0, 0.0, 0.0], [0.1, 0.05, 0.0], [0.1, 0.0, 0.05]]];
/// let options = BuildOptions::default();
/// let (wall, ball) = (Tree::build(&wall, &options)?, Tree::build(&ball, &options)?);
///
/// // The tip of the ball is 3 m ahead of the wall, and comes towards it.
/// let at = Pose::from_degrees(0.0, 0.0, 0.0, [3.0, 0.25, 0.25]);
/// let pose = RelativePose::between(&Pose::IDENTITY, &at);
/// let sweep = Sweep::new([-1.0, 0.0, 0.0].into(), 0.0, 10.0)?;
/// let first = first_contact(&wall, &ball, &pose, &sweep, &mut SweepWorkspace::new())?;
/// assert_eq!(first.map(|witness| (witness.travel_m, witness.ids)), Some((3.0, [0, 0])));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
///
/// # Panics
///
/// A view is of a damaged tree; [`crate::Tree::build`] and verified model files never produce one.
pub fn first_contact<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    sweep: &Sweep,
    workspace: &mut SweepWorkspace,
) -> Result<Option<Witness>, PoseError> {
    let task = SweepTask { a: a.into(), b: b.into(), pose: *pose, sweep: *sweep };
    workspace.run(&task, 1)?;
    Ok(workspace.found.first().copied())
}

/// The `count` pairs of triangles that touch first, as [`first_contact`] finds the first of them:
/// ascending by travel, then by ids; fewer if no more touch on that way.
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`].
pub fn earliest_pairs<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    pose: &RelativePose,
    sweep: &Sweep,
    count: usize,
    workspace: &mut SweepWorkspace,
) -> Result<Vec<Witness>, PoseError> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let task = SweepTask { a: a.into(), b: b.into(), pose: *pose, sweep: *sweep };
    workspace.run(&task, count)?;
    Ok(workspace.found.clone())
}
