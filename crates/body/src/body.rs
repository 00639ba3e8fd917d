//! The data of a body: a mesh in source order, and a body in leaf order with its tree.

use crate::meta::Meta;
use crate::wide::{Wide, WideNode};
use bytemuck::{Pod, Zeroable};
use geometry::{Aabb, Corners};

/// A node of the binary tree, 32 bytes, stored in depth-first preorder.
///
/// The left child of the interior node `i` is `i + 1`, the right one is `link`; so the nodes of a
/// subtree are one contiguous range, and so are its triangles, which are stored in leaf order.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Exact bounding box of all triangles below, body frame.
    pub bounds: Aabb,
    /// Leaf: number of its first triangle. Interior: number of its right child.
    pub link: u32,
    /// Leaf: number of triangles, at least 1. Interior: 0.
    pub count: u32,
}

const _: () = assert!(size_of::<Node>() == 32);

impl Node {
    /// Whether this node is a leaf.
    #[must_use]
    pub fn is_leaf(&self) -> bool {
        self.count > 0
    }
}

/// The zones of a body to which a triangle belongs, as a bit set.
///
/// Bits 0 to 6: front, middle, rear third; left, right side; upper, lower half. Bits 8 to 15:
/// beside the seat whose [`crate::Seat`] number is the bit minus 8.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Zones(pub u16);

/// A triangulated body in source order, before it has a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Triangles, metres, x forward, y left, z up; every coordinate is finite.
    pub corners: Vec<Corners>,
    /// Per triangle: its number in the source file after triangulation.
    pub source_ids: Vec<u32>,
    /// Per triangle: index into `parts`.
    pub part_of: Vec<u16>,
    /// Names of parts, groups or materials.
    pub parts: Vec<String>,
    /// Duplicates that were dropped, as (source id dropped, source id kept), ascending.
    pub dropped: Vec<(u32, u32)>,
    /// Number of triangles with zero area. They are kept, and treated as the segment or point they
    /// are.
    pub degenerate: u32,
}

impl Mesh {
    /// The bounding box of all triangles; empty if there are none.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.corners.iter().fold(Aabb::EMPTY, |sum, corners| sum.union(&Aabb::of(corners)))
    }

    /// Length, width and height in metres.
    #[must_use]
    pub fn size_m(&self) -> [f64; 3] {
        let bounds = self.bounds();
        [0, 1, 2].map(|axis| f64::from(bounds.max[axis]) - f64::from(bounds.min[axis]))
    }
}

/// Whether a triangle has zero area: two edges are parallel or zero.
///
/// Exact where the coordinates of a triangle differ in magnitude by less than 2^28, as differences
/// and products of f32 are then exact in f64.
#[must_use]
pub fn is_degenerate(corners: &Corners) -> bool {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    let (u, v) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    (0..3).all(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        u[j] * v[k] == u[k] * v[j]
    })
}

/// A body with its tree, owned. All arrays are in leaf order.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// The metadata.
    pub meta: Meta,
    /// The tree, preorder; the root is node 0.
    pub nodes: Vec<Node>,
    /// The same tree as wide nodes of eight boxes.
    pub wide: Wide,
    /// Triangles in leaf order.
    pub corners: Vec<Corners>,
    /// Per triangle: source id.
    pub source_ids: Vec<u32>,
    /// Per triangle: part.
    pub part_of: Vec<u16>,
    /// Per triangle: zones.
    pub zones: Vec<Zones>,
    /// Duplicates dropped on import, as (source id dropped, source id kept).
    pub dropped: Vec<[u32; 2]>,
}

/// A body in a model file or in the sealed model store: borrowed, nothing copied.
///
/// For plain triangles, `part_of` and `dropped` are empty, and all zones are 0.
#[derive(Clone, Copy, Debug)]
pub struct BodyView<'a> {
    /// The tree, preorder; the root is node 0.
    pub nodes: &'a [Node],
    /// The same tree as wide nodes of eight boxes; the first corresponds to the root.
    pub wide: &'a [WideNode],
    /// Per node of the tree: the wide node that contains it ([`Wide::of`]).
    pub wide_of: &'a [u32],
    /// Triangles in leaf order.
    pub corners: &'a [Corners],
    /// Per triangle: source id.
    pub source_ids: &'a [u32],
    /// Per triangle: part.
    pub part_of: &'a [u16],
    /// Per triangle: zones.
    pub zones: &'a [Zones],
    /// Duplicates dropped on import, as (source id dropped, source id kept).
    pub dropped: &'a [[u32; 2]],
}

impl Body {
    /// Borrows the body.
    #[must_use]
    pub fn view(&self) -> BodyView<'_> {
        BodyView {
            nodes: &self.nodes,
            wide: &self.wide.nodes,
            wide_of: &self.wide.of,
            corners: &self.corners,
            source_ids: &self.source_ids,
            part_of: &self.part_of,
            zones: &self.zones,
            dropped: &self.dropped,
        }
    }
}

impl<'a> From<&'a Body> for BodyView<'a> {
    fn from(body: &'a Body) -> Self {
        body.view()
    }
}

impl BodyView<'_> {
    /// The bounding box of the whole body, body frame.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |root| root.bounds)
    }
}

#[cfg(test)]
mod tests {
    //! Zero area is detected exactly.

    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Three points on a line with integer steps have zero area; with one moved off it, they do
        /// not.
        #[test]
        fn area_is_zero_exactly_on_a_line(
            start in prop::array::uniform3(-1000_i32..1000),
            step in prop::array::uniform3(-1000_i32..1000),
            (m, n) in (-50_i32..50, -50_i32..50),
            axis in 0_usize..3,
        ) {
            let point_at =
                |times: i32| [0, 1, 2].map(|i| (start[i] + times * step[i]) as f32 / 64.0);
            let mut corners = [point_at(0), point_at(m), point_at(n)];
            prop_assert!(is_degenerate(&corners));
            // The neighbour of zero is so close to it that the test is no longer exact.
            prop_assume!(corners[2][axis] != 0.0);
            corners[2][axis] = f32::from_bits(corners[2][axis].to_bits() + 1);
            let along = step[(axis + 1) % 3] == 0 && step[(axis + 2) % 3] == 0;
            prop_assert_eq!(is_degenerate(&corners), along || m == 0 || step == [0; 3]);
        }
    }
}
