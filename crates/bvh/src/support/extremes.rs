//! The corners of a body that can be farthest, by direction: computed once, when a direction is
//! first asked for, for many queries.
//!
//! Directions are sorted into the cells of a cube around the origin, like the texels of a cube map.
//! A cell is a cone, spanned by the directions to its four corners. A point that lies behind
//! another one in all four lies behind it in every direction of the cone, which is a sum of the
//! four with non-negative factors; so it is left out of the cell's list. *Behind* means by a margin
//! far above the rounding of a sum of three products, so no omitted point can be the farthest: the
//! maximum over a list is [`super::support`], bit for bit.
//!
//! Level directions, whose z is zero, have cells of their own, as most of those that are asked for
//! are level: between two edges instead of four corners few points are farthest, and of those above
//! each other one will do.
//!
//! A cell with too many candidate points, such as one that faces a flat side, has no list: it uses
//! the tree.

use super::{along, farthest, reach, support_near};
use body::BodyView;
use geometry::DVec3;
use std::sync::OnceLock;

/// Cells along an edge of the cube: about 5° each.
const SIDE: usize = 16;
/// Faces of a cube.
const FACES: usize = 6;
/// Cells of all directions; those of level ones follow.
const CELLS: usize = FACES * SIDE * SIDE;
/// Level cells along a side of the square: about 3° each.
const LEVEL_SIDE: usize = 32;
/// Sides of a square.
const LEVEL_FACES: usize = 4;
/// Maximum number of points of a cell: comparing more takes about as long as searching the tree.
const POINTS_MAX: usize = 256;
/// A corner is in six triangles of a closed mesh: this many are collected before duplicates are
/// removed.
const MET_MAX: usize = 8 * POINTS_MAX;
/// Points behind by less than this fraction of the body's size are kept. Rounding moves a product
/// by less than a millionth of it.
const MARGIN: f64 = 1e-9;

/// The points of a cell; none: the tree is used.
type Cell = Box<[[f32; 3]]>;

/// The candidate points of one body, by direction. Queries must pass the body it was built from.
#[derive(Clone, Debug)]
pub struct Extremes {
    cells: Vec<OnceLock<Cell>>,
    /// Points behind by less than this (m) are kept.
    margin: f64,
}

impl Extremes {
    /// Of a body, with nothing computed yet.
    #[must_use]
    pub fn new(view: &BodyView<'_>) -> Self {
        let size = view.bounds();
        let most =
            size.min.iter().chain(&size.max).fold(0.0, |most: f64, x| most.max(x.abs().into()));
        let cells = vec![OnceLock::new(); CELLS + LEVEL_FACES * LEVEL_SIDE];
        Self { cells, margin: MARGIN * most }
    }

    /// Of a body, with everything computed. The result takes at most five and a half megabytes for
    /// any body.
    #[must_use]
    pub fn of(view: &BodyView<'_>) -> Self {
        let extremes = Self::new(view);
        let mut front = Vec::with_capacity((SIDE + 1) * (SIDE + 1));
        for face in 0..FACES {
            front.clear();
            for at in 0..(SIDE + 1) * (SIDE + 1) {
                let toward = corner(face, at / (SIDE + 1), at % (SIDE + 1));
                front.push((toward, farthest(view, toward)));
            }
            for cell in 0..SIDE * SIDE {
                let from = cell / SIDE * (SIDE + 1) + cell % SIDE;
                let around = [from, from + 1, from + SIDE + 1, from + SIDE + 2].map(|at| front[at]);
                let points = Cone::of(around, extremes.margin).points(view);
                extremes.cells[face * SIDE * SIDE + cell].get_or_init(|| points);
            }
        }
        for number in CELLS..extremes.cells.len() {
            extremes.cell(view, number);
        }
        extremes
    }

    /// The points of a cell.
    fn cell(&self, view: &BodyView<'_>, number: usize) -> &[[f32; 3]] {
        self.cells[number].get_or_init(|| {
            if let Some(number) = number.checked_sub(CELLS) {
                let (face, cell) = (number / LEVEL_SIDE, number % LEVEL_SIDE);
                let around = [cell, cell + 1].map(|step| edge(face, step));
                return self.cone(view, around).points(view);
            }
            let (face, cell) = (number / (SIDE * SIDE), number % (SIDE * SIDE));
            let (row, column) = (cell / SIDE, cell % SIDE);
            let around =
                [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)];
            let around = around.map(|(row, column)| corner(face, row, column));
            self.cone(view, around).points(view)
        })
    }

    fn cone<const N: usize>(&self, view: &BodyView<'_>, around: [DVec3; N]) -> Cone<N> {
        Cone::of(around.map(|toward| (toward, farthest(view, toward))), self.margin)
    }

    /// [`support_near`] of the body from which this was built.
    #[must_use]
    pub fn support_near(
        &self,
        view: &BodyView<'_>,
        direction: DVec3,
        near: &mut Option<[f32; 3]>,
    ) -> f64 {
        let points = cell_of(direction).map_or(&[][..], |cell| self.cell(view, cell));
        if points.is_empty() {
            return support_near(view, direction, near);
        }
        let mut greatest = f64::NEG_INFINITY;
        for point in points {
            let value = along(*point, direction);
            if value > greatest {
                greatest = value;
                *near = Some(*point);
            }
        }
        greatest + 0.0
    }
}

/// A coordinate on the cube after so many of `side` steps.
fn coordinate(step: usize, side: usize) -> f64 {
    (2 * step) as f64 / side as f64 - 1.0
}

/// The direction to a corner of a cell, on the cube: 1 or −1 along the face's axis.
fn corner(face: usize, row: usize, column: usize) -> DVec3 {
    let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
    let mut toward = DVec3::ZERO;
    toward[axis] = sign;
    toward[(axis + 1) % 3] = coordinate(row, SIDE);
    toward[(axis + 2) % 3] = coordinate(column, SIDE);
    toward
}

/// The direction to an edge of a level cell, on the square.
fn edge(face: usize, step: usize) -> DVec3 {
    let (axis, sign) = (face / 2, if face.is_multiple_of(2) { 1.0 } else { -1.0 });
    let mut toward = DVec3::ZERO;
    toward[axis] = sign;
    toward[1 - axis] = coordinate(step, LEVEL_SIDE);
    toward
}

/// The cell that contains a direction; `None` for the zero vector or one that is not finite.
fn cell_of(direction: DVec3) -> Option<usize> {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    let most = size[axis];
    if !(most > 0.0 && most.is_finite()) {
        return None;
    }
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    // A direction that rounding puts beside the cell is within its margin.
    let step =
        |x: f64, side: usize| (((x / most + 1.0) * (side / 2) as f64) as usize).min(side - 1);
    if direction.z == 0.0 {
        return Some(CELLS + face * LEVEL_SIDE + step(direction[1 - axis], LEVEL_SIDE));
    }
    let [row, column] = [1, 2].map(|next| step(direction[(axis + next) % 3], SIDE));
    Some((face * SIDE + row) * SIDE + column)
}

/// The directions of a cell between `N` edges, and the points farthest along these.
struct Cone<const N: usize> {
    edges: [DVec3; N],
    front: [[f32; 3]; N],
    /// The reach of each of these points along each edge, less the margin.
    bars: [[f64; N]; N],
}

impl<const N: usize> Cone<N> {
    fn of(around: [(DVec3, [f32; 3]); N], margin: f64) -> Self {
        let (edges, front) = (around.map(|(edge, _)| edge), around.map(|(_, point)| point));
        let bars = front.map(|point| edges.map(|edge| along(point, edge) - margin));
        Self { edges, front, bars }
    }

    /// Whether a point with these reaches along the edges lies behind one of the points in front.
    fn is_behind(&self, reaches: [f64; N]) -> bool {
        self.bars.iter().any(|bars| bars.iter().zip(&reaches).all(|(bar, reach)| reach < bar))
    }

    /// All corners that are not behind, each once; none if there are too many.
    fn points(&self, view: &BodyView<'_>) -> Cell {
        let mut met = Vec::new();
        self.meet(view, &mut met);
        self.thin_out(&mut met);
        if met.len() > POINTS_MAX {
            met.clear();
        }
        met.into_boxed_slice()
    }

    /// Leaves one of the points that are as far in all directions of the cone.
    fn thin_out(&self, met: &mut Vec<[f32; 3]>) {
        let is_level = self.edges.iter().all(|edge| edge.z == 0.0);
        // As bits: the sort treats +0 and −0 as different points, which is harmless.
        let key = |point: &[f32; 3]| {
            let [x, y, z] = point.map(f32::to_bits);
            [x, y, if is_level { 0 } else { z }]
        };
        met.sort_unstable_by_key(key);
        met.dedup_by_key(|point| key(point));
    }

    /// Collects all corners that are not behind, with duplicates; stops when there are too many.
    fn meet(&self, view: &BodyView<'_>, met: &mut Vec<[f32; 3]>) {
        met.clear();
        if view.nodes.is_empty() {
            return;
        }
        // Points in front come first, so that a body of equal corners is not a special case.
        met.extend_from_slice(&self.front);
        // At most one node waits per level of the tree.
        let mut open = vec![0_u32];
        while let Some(at) = open.pop() {
            let node = &view.nodes[at as usize];
            if self.is_behind(self.edges.map(|edge| reach(&node.bounds, edge))) {
                continue;
            }
            if !node.is_leaf() {
                open.extend([node.link, at + 1]);
                continue;
            }
            let first = node.link as usize;
            for point in view.corners[first..first + node.count as usize].iter().flatten() {
                if !self.is_behind(self.edges.map(|edge| along(*point, edge))) {
                    met.push(*point);
                }
            }
            if met.len() > MET_MAX {
                self.thin_out(met);
                if met.len() > POINTS_MAX {
                    return;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
