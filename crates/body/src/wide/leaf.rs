//! A leaf of the wide tree: boxes of triangles in bytes.

use super::{Slab, WideNode};
use crate::Node;
use bytemuck::{Pod, Zeroable};
use geometry::{Aabb, Corners};

/// Lanes of a node of a wide leaf.
pub const LEAF_LANES: usize = 32;

/// The triangles of a wide leaf, or 32 of them, in 256 bytes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WideLeaf {
    /// Least x, y, z of each triangle, in cells of the grid. An empty lane has 255, which
    /// no grid has.
    pub min: [[u8; LEAF_LANES]; 3],
    /// Greatest x, y, z of each triangle. An empty lane has 0.
    pub max: [[u8; LEAF_LANES]; 3],
    /// The triangle of the first lane; the others are consecutive.
    pub first: u32,
    /// The planes between which all triangles of the leaf lie.
    pub slab: Slab,
    unused: [u32; 2],
    /// The bounding box of all triangles of the leaf, body frame (m), which defines the grid.
    pub bounds: Aabb,
    /// The corresponding node of the binary tree.
    pub root: u32,
    /// Number of triangles in this node and the following ones of the same leaf, at least 1: if
    /// more than 32, the leaf continues in the next node.
    pub count: u32,
}

const _: () = assert!(size_of::<WideLeaf>() == size_of::<WideNode>());

impl WideLeaf {
    /// The nodes of a leaf, as leaves.
    #[must_use]
    #[inline]
    pub fn all(nodes: &[WideNode]) -> &[Self] {
        bytemuck::cast_slice(nodes)
    }

    /// The box of one triangle, in cells: least and greatest x, y, z.
    fn set_box(&mut self, lane: usize, [min, max]: [[u8; 3]; 2]) {
        for axis in 0..3 {
            self.min[axis][lane] = min[axis];
            self.max[axis][lane] = max[axis];
        }
    }

    /// Empties a lane.
    pub fn clear(&mut self, lane: usize) {
        self.set_box(lane, [[u8::MAX; 3], [0; 3]]);
    }

    /// Whether the lane is empty.
    #[must_use]
    pub fn is_empty(&self, lane: usize) -> bool {
        self.min[0][lane] > self.max[0][lane]
    }

    /// Fills as many of `nodes` as needed with `triangles`, which are all those of `node`, number
    /// `root` of the binary tree, numbered from `first` on.
    pub(super) fn fill(
        nodes: &mut [WideNode],
        (node, root): (&Node, usize),
        (first, triangles): (u32, &[Corners]),
    ) {
        let grid = Grid::over(&node.bounds);
        let mut leaf = Self {
            min: [[0; LEAF_LANES]; 3],
            max: [[0; LEAF_LANES]; 3],
            first,
            slab: Slab::around(triangles),
            unused: [0; 2],
            bounds: node.bounds,
            root: root as u32,
            count: triangles.len() as u32,
        };
        for (place, some) in nodes.iter_mut().zip(triangles.chunks(LEAF_LANES)) {
            (0..LEAF_LANES).for_each(|lane| leaf.clear(lane));
            for (lane, corners) in some.iter().enumerate() {
                leaf.set_box(lane, grid.cells(&Aabb::of(corners)));
            }
            *place = bytemuck::cast(leaf);
            leaf.first += LEAF_LANES as u32;
            leaf.count = leaf.count.saturating_sub(LEAF_LANES as u32);
        }
    }
}

/// A division of a box into 254 cells along each axis, plus one for coordinates at its end.
///
/// The cell number is monotonic in the coordinate, rounding included. So boxes that overlap also
/// overlap in cells; boxes that do not, may.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    low: [f32; 3],
    /// Cells per metre.
    scale: [f32; 3],
}

impl Grid {
    /// The number of the last cell: one less than the value of an empty lane.
    pub const LAST: f32 = (u8::MAX - 1) as f32;

    /// The grid over a box.
    #[must_use]
    #[inline(always)]
    pub fn over(bounds: &Aabb) -> Self {
        let scale = |axis| (Self::LAST / bounds.extent(axis)).min(f32::MAX);
        Self { low: bounds.min, scale: [scale(0), scale(1), scale(2)] }
    }

    /// The cells of the corners of a box: of the least and of the greatest x, y, z.
    #[must_use]
    #[inline(always)]
    pub fn cells(&self, of: &Aabb) -> [[u8; 3]; 2] {
        [self.cell(of.min), self.cell(of.max)]
    }

    #[inline(always)]
    fn cell(&self, point: [f32; 3]) -> [u8; 3] {
        let along = |axis: usize| (point[axis] - self.low[axis]) * self.scale[axis];
        // The conversion saturates, so everything below the box is in its first cell.
        let cell = |axis: usize| along(axis).min(Self::LAST) as u8;
        [cell(0), cell(1), cell(2)]
    }
}
