//! First contact of two bodies that both move and turn.

use super::{QueryWatch, Workspace, least_pair_watched};
use crate::kernel::turning::{First, TurningKernel, TurningOutcome, TurningTask};
use crate::{Counters, Walk};
use body::BodyView;
use diagnostic::{Diagnostic, FailureKind};
use geometry::motion::RelativeMotion;
use geometry::simd::Level;
use std::borrow::Cow;
use std::fmt;
use std::ops::ControlFlow;

/// The least distance that possible contact may be resolved to (m).
pub const RESOLUTION_MIN: f64 = 1e-5;

/// Limits of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// Contact that is not certain is possible within this distance (m): at least
    /// [`RESOLUTION_MIN`]. Also how far anything moves between [`MotionContact::Certain`]'s times.
    pub resolution_m: f64,
    /// Maximum number of tests of boxes and triangles, but for those of one step: in the search,
    /// and again at the first pose and at that of contact.
    pub budget: u64,
}

impl Default for MotionLimits {
    /// 1 mm, and no budget.
    fn default() -> Self {
        Self { resolution_m: 1e-3, budget: u64::MAX }
    }
}

/// Whether and when two bodies in motion touch first. Times in seconds, ids those of A's triangle
/// and of B's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionContact {
    /// They never touch: a proof for the whole motion.
    Excluded,
    /// At the pose of the motion at `time_s` they touch, exactly: [`super::touches`] is true for
    /// [`RelativeMotion::pose_at`].
    Certain {
        /// The time of the pose.
        time_s: f64,
        /// Nothing touches before: at most `time_s`.
        excluded_before_s: f64,
        /// The least ids of all triangles that touch at that pose.
        ids: [u32; 2],
    },
    /// Triangles come within the resolution of each other at some time from `time_s` to `to_s`, but
    /// no pose is known at which any touch, neither then nor shortly after.
    Possible {
        /// Nothing touches before.
        time_s: f64,
        /// The end of the interval in doubt.
        to_s: f64,
        /// The least ids of two triangles that come so close.
        ids: [u32; 2],
    },
    /// The budget did not suffice.
    OutOfBudget {
        /// Nothing touches before; from then on everything is open.
        excluded_before_s: f64,
    },
}

/// Buffers for queries of first contact in motion, reusable for any sequence of bodies: at most
/// some 4 MB.
///
/// Each thread has its own; trees are shared.
#[derive(Clone, Debug)]
pub struct MotionWorkspace {
    kernel: TurningKernel,
    poses: Workspace,
    effort: MotionEffort,
}

/// What the last query took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotionEffort {
    /// Tests of boxes, and of triangles whose boxes overlap.
    pub counters: Counters,
    /// Intervals of time that were looked at.
    pub intervals: u64,
}

impl MotionWorkspace {
    /// Creates an initial workspace. The walk is the wide one, with the widest vectors of this
    /// processor.
    #[must_use]
    pub fn new() -> Self {
        Self {
            kernel: TurningKernel::new(),
            poses: Workspace::new(),
            effort: MotionEffort::default(),
        }
    }

    /// Sets the walk of later queries; the answers do not change.
    pub fn set_walk(&mut self, walk: Walk) {
        self.poses.set_walk(walk);
    }

    /// Sets the vector instructions of later queries; the answers do not change.
    pub fn set_level(&mut self, level: Level) {
        self.poses.set_level(level);
    }

    /// What the last query took, but for the tests at the pose where it found contact.
    #[must_use]
    pub fn effort(&self) -> MotionEffort {
        self.effort
    }

    /// The least ids of triangles that touch at the pose at a time, if any do; `Break` if the
    /// budget does not suffice.
    fn touching(
        &mut self,
        task: &TurningTask<'_>,
        time_s: f64,
        limits: (u64, QueryWatch<'_>),
    ) -> ControlFlow<(), Option<[u32; 2]>> {
        let pose = task.motion.pose_at(time_s);
        // A path keeps poses far within what is accepted.
        least_pair_watched(task.a, task.b, &pose, limits, &mut self.poses)
            .unwrap_or(ControlFlow::Continue(None))
    }
}

impl Default for MotionWorkspace {
    fn default() -> Self {
        Self::new()
    }
}

/// The resolution is not a number from [`RESOLUTION_MIN`] up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResolutionError(pub f64);

impl Diagnostic for ResolutionError {
    fn kind(&self) -> FailureKind {
        FailureKind::Input
    }

    fn what(&self) -> String {
        format!("contact cannot be resolved to {} m", self.0)
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        Some(format!("give at least {RESOLUTION_MIN} m").into())
    }
}

impl fmt::Display for ResolutionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what())
    }
}

impl std::error::Error for ResolutionError {}

/// When two bodies that move and turn touch first, and which triangles touch then.
///
/// The motion is continuous: between two states position is linear in time and orientation turns
/// steadily, and nothing slips between poses. The answer is the same bits for every build, leaf
/// size, walk, vector width and machine, unless the budget ends it.
///
/// ```
/// use trolley_bvh::query::{BuildOptions, Tree};
/// use trolley_bvh::query::{MotionContact, MotionLimits, MotionWorkspace, Orientation};
/// use trolley_bvh::query::RelativeMotion;
/// use trolley_bvh::query::{MotionPath, State, first_contact_in_motion};
///
/// // A wall, and a rod of 1 m that turns about its end by 90 degrees in a second.
/// let wall = [[[0.0, 0.5, -1.0], [2.0, 0.5, -1.0], [0.0, 0.5, 1.0]]];
/// let rod = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]];
/// let options = BuildOptions::default();
/// let (wall, rod) = (Tree::build(&wall, &options)?, Tree::build(&rod, &options)?);
///
/// let standing = MotionPath::still([0.0; 3], Orientation::IDENTITY, [0.0, 1.0])?;
/// let state = |time_s, yaw| State {
///     time_s,
///     position_m: [0.0; 3],
///     orientation: Orientation::from_degrees(yaw, 0.0, 0.0),
/// };
/// let turning = MotionPath::new(&[state(0.0, 0.0), state(1.0, 90.0)])?;
/// let motion = RelativeMotion::new(&standing, &turning)?;
///
/// let (limits, mut workspace) = (MotionLimits::default(), MotionWorkspace::new());
/// let first = first_contact_in_motion(&wall, &rod, &motion, &limits, &mut workspace)?;
/// // Its tip is half a metre up when it has turned by 30 degrees.
/// let MotionContact::Certain { time_s, excluded_before_s, ids } = first else { panic!() };
/// assert!((time_s - 1.0 / 3.0).abs() < 1e-6 && excluded_before_s <= 1.0 / 3.0);
/// assert_eq!(ids, [0, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// The resolution is less than [`RESOLUTION_MIN`], or not a number.
///
/// # Panics
///
/// A view is of a damaged tree; [`crate::Tree::build`] and verified model files never produce one.
pub fn first_contact_in_motion<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    motion: &RelativeMotion<'t>,
    limits: &MotionLimits,
    workspace: &mut MotionWorkspace,
) -> Result<MotionContact, ResolutionError> {
    let mut watch = |_| ControlFlow::Continue(());
    first_contact_in_motion_watched(a, b, motion, (limits, &mut watch), workspace)
}

/// [`first_contact_in_motion`], which `watch` may end: then the contact is out of budget.
///
/// # Errors
///
/// As [`first_contact_in_motion`].
///
/// # Panics
///
/// As [`first_contact_in_motion`].
pub fn first_contact_in_motion_watched<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    motion: &RelativeMotion<'t>,
    (limits, watch): (&MotionLimits, QueryWatch<'_>),
    workspace: &mut MotionWorkspace,
) -> Result<MotionContact, ResolutionError> {
    let MotionLimits { resolution_m, budget } = *limits;
    if !(resolution_m >= RESOLUTION_MIN) {
        return Err(ResolutionError(resolution_m));
    }
    let task = TurningTask { a: a.into(), b: b.into(), motion: *motion, resolution_m };
    workspace.effort = MotionEffort::default();
    let time_s = motion.from_s();
    match workspace.touching(&task, time_s, (budget, &mut *watch)) {
        ControlFlow::Break(()) => {
            return Ok(MotionContact::OutOfBudget { excluded_before_s: time_s });
        }
        ControlFlow::Continue(Some(ids)) => {
            return Ok(MotionContact::Certain { time_s, excluded_before_s: time_s, ids });
        }
        ControlFlow::Continue(None) => {}
    }
    let TurningOutcome { first, counters, intervals } =
        workspace.kernel.run(&task, (budget, &mut *watch));
    workspace.effort = MotionEffort { counters, intervals };
    Ok(match first {
        First::Never => MotionContact::Excluded,
        First::Certain { time_s, clear_before_s, ids } => {
            match workspace.touching(&task, time_s, (budget, watch)) {
                ControlFlow::Break(()) => {
                    MotionContact::OutOfBudget { excluded_before_s: clear_before_s }
                }
                ControlFlow::Continue(least) => {
                    let ids = least.unwrap_or(ids);
                    MotionContact::Certain { time_s, excluded_before_s: clear_before_s, ids }
                }
            }
        }
        First::Possible { clear_before_s, to_s, ids } => {
            MotionContact::Possible { time_s: clear_before_s, to_s, ids }
        }
        First::Open { clear_before_s } => {
            MotionContact::OutOfBudget { excluded_before_s: clear_before_s }
        }
    })
}

#[cfg(test)]
mod tests;
