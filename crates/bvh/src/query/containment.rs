//! Whether one body lies wholly inside the other, without a triangle that meets another one.
//!
//! Where no triangles meet, each shell of B lies on one side of each shell of A, so one of its
//! corners decides for all of it. A ray straight up from there is counted against the triangles of
//! A under whose boxes the corner lies: [`cross_upward`] is exact, whatever it meets.

use super::{PoseError, Workspace, touches};
use body::{BodyView, Node, ShellKind, Shells};
use geometry::triangle::{RayCrossing, cross_upward};
use geometry::{Bounds, Corners, DVec3, Pose, RelativePose, Triangle};
use std::mem;

/// How two bodies lie to each other: whether they overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// Triangles of the two share a point.
    Touching,
    /// Some shell of B lies inside A, and touches nothing.
    BInA,
    /// Some shell of A lies inside B, and touches nothing.
    AInB,
    /// They are apart.
    Apart,
    /// They do not touch, no closed shell holds a shell of the other body, and one reaches into the
    /// box of a body that is not watertight: whether it lies inside has no answer.
    Undecided {
        /// A is open, and a shell of B reaches into A's box.
        in_a: bool,
        /// B is open, and a shell of A reaches into B's box.
        in_b: bool,
    },
}

/// How `b`, whose pose in A's frame is `pose`, lies to `a`: whether they touch, or one lies inside
/// the other. `shells` are those of both, in the order of the views' triangles:
/// `Shells::of(view.corners)`.
///
/// A point lies inside a body if it lies inside one of its closed shells: of one that is oriented,
/// if its winding number is not 0; of another one, if a ray crosses it an odd number of times. So
/// shells may overlap, and a cavity counts as solid. If several answers hold, the first in the
/// order of [`Containment`] is given. Exact on the coordinates that [`touches`] uses, in A's frame.
///
/// ```
/// use trolley_bvh::query::{BuildOptions, Pose, RelativePose, Shells, Tree, Workspace};
/// use trolley_bvh::query::{Containment, containment};
///
/// let tetrahedron = |size: f32| {
///     let [o, x, y, z] = [[0.0; 3], [size, 0.0, 0.0], [0.0, size, 0.0], [0.0, 0.0, size]];
///     [[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
/// };
/// let [large, small] = [9.0, 1.0].map(tetrahedron);
/// let options = BuildOptions::default();
/// let (a, b) = (Tree::build(&large, &options)?, Tree::build(&small, &options)?);
/// let shells = [Shells::of(a.corners()), Shells::of(b.corners())];
///
/// let moved_to = |x| {
///     let pose = Pose::from_degrees(0.0, 0.0, 0.0, [x, 1.0, 1.0]);
///     RelativePose::between(&Pose::IDENTITY, &pose)
/// };
/// let mut workspace = Workspace::new();
/// let inside = containment(&a, &b, shells.each_ref(), &moved_to(1.0), &mut workspace)?;
/// assert_eq!(inside, Containment::BInA);
/// let beside = containment(&a, &b, shells.each_ref(), &moved_to(-5.0), &mut workspace)?;
/// assert_eq!(beside, Containment::Apart);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// The pose is not finite, or exceeds [`POSE_MAX`](super::POSE_MAX).
///
/// # Panics
///
/// If `shells` are not those of the bodies.
pub fn containment<'t>(
    a: impl Into<BodyView<'t>>,
    b: impl Into<BodyView<'t>>,
    shells: [&Shells; 2],
    pose: &RelativePose,
    workspace: &mut Workspace,
) -> Result<Containment, PoseError> {
    let (a, b) = (a.into(), b.into());
    if touches(a, b, pose, workspace)? {
        return Ok(Containment::Touching);
    }
    const SAME: RelativePose =
        RelativePose { rotation: Pose::IDENTITY.rotation, translation: Pose::IDENTITY.translation };
    let [of_a, of_b] = shells;
    let a = PosedShells { view: a, shells: of_a, pose: &SAME };
    let b = PosedShells { view: b, shells: of_b, pose };
    let columns = &mut workspace.columns;
    let in_a = a.holds(&b, columns);
    if in_a == Holds::Yes {
        return Ok(Containment::BInA);
    }
    let in_b = b.holds(&a, columns);
    if in_b == Holds::Yes {
        return Ok(Containment::AInB);
    }
    Ok(match (in_a == Holds::Unknown, in_b == Holds::Unknown) {
        (false, false) => Containment::Apart,
        (in_a, in_b) => Containment::Undecided { in_a, in_b },
    })
}

/// Whether a body holds another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Holds {
    No,
    Yes,
    Unknown,
}

/// Buffers for rays, reusable.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Nodes still to be visited.
    open: Vec<u32>,
    /// Crossings of the current ray, by shell; between rays there are none.
    crossed: Vec<Crossed>,
    /// The shells that the current ray has crossed, each as often.
    met: Vec<u32>,
}

/// How a ray has crossed a shell.
#[derive(Clone, Copy, Debug, Default)]
struct Crossed {
    count: u32,
    /// How often it left less how often it entered.
    winding: i32,
}

/// A body at its pose in A's frame.
struct PosedShells<'p> {
    view: BodyView<'p>,
    shells: &'p Shells,
    pose: &'p RelativePose,
}

impl PosedShells<'_> {
    /// Whether this body holds a shell of the other, which it does not touch.
    fn holds(&self, other: &PosedShells<'_>, columns: &mut Columns) -> Holds {
        let Some(root) = self.view.nodes.first() else { return Holds::No };
        let box_ = self.bounds(root);
        columns.crossed.clear();
        columns.crossed.resize(self.shells.kinds().len(), Crossed::default());
        let mut holds = Holds::No;
        for triangle in other.shells.first_triangles() {
            let corners: &Corners = &other.view.corners[*triangle as usize];
            let point = other.pose.point(corners[0]);
            let is_near = point.cmpge(box_.min).all() && point.cmple(box_.max).all();
            if !is_near {
                continue;
            }
            if self.is_inside(point, columns) {
                return Holds::Yes;
            }
            if !self.shells.is_watertight() {
                holds = Holds::Unknown;
            }
        }
        holds
    }

    /// Whether a point lies inside a closed shell.
    fn is_inside(&self, point: DVec3, columns: &mut Columns) -> bool {
        let Columns { open, crossed, met } = columns;
        open.clear();
        open.push(0);
        while let Some(index) = open.pop() {
            let node = &self.view.nodes[index as usize];
            let box_ = self.bounds(node);
            let is_below = point.z <= box_.max.z
                && (box_.min.x..=box_.max.x).contains(&point.x)
                && (box_.min.y..=box_.max.y).contains(&point.y);
            if !is_below {
                continue;
            }
            if !node.is_leaf() {
                open.extend([index + 1, node.link]);
                continue;
            }
            let triangles = node.link as usize..(node.link + node.count) as usize;
            for triangle in triangles {
                let posed: Triangle = self.pose.triangle(&self.view.corners[triangle]);
                let winding = match cross_upward(point, &posed) {
                    RayCrossing::Leaves => 1,
                    RayCrossing::Enters => -1,
                    // A corner on the surface would touch it, so none is.
                    RayCrossing::Misses | RayCrossing::Starts => continue,
                };
                let shell = self.shells.of_triangles()[triangle];
                met.push(shell);
                let crossed = &mut crossed[shell as usize];
                crossed.count += 1;
                crossed.winding += winding;
            }
        }
        let kinds = self.shells.kinds();
        met.drain(..).fold(false, |is_inside, shell| {
            let shell = shell as usize;
            // Met again, it has been counted and contributes nothing.
            let Crossed { count, winding } = mem::take(&mut crossed[shell]);
            let holds = match kinds[shell] {
                ShellKind::Open => false,
                ShellKind::Closed => count % 2 == 1,
                ShellKind::Oriented => winding != 0,
            };
            is_inside || holds
        })
    }

    /// The box of a node, rounded outward.
    fn bounds(&self, node: &Node) -> Bounds {
        self.pose.bounds(&node.bounds)
    }
}

#[cfg(test)]
mod tests;
