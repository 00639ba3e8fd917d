//! A tree over plain triangles: what is needed to intersect them, and nothing else.

use crate::build::{self, BuildError, BuildOptions};
use body::{BodyView, Node, Wide, Zones};
use geometry::{Aabb, Corners};

/// Triangles in a bounding volume hierarchy, ready to be intersected with others: see
/// [`crate::query`].
///
/// It has no mass, parts or file. The id of a triangle is its index in the slice from which the
/// tree was built.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Preorder; the root is node 0.
    pub(crate) nodes: Vec<Node>,
    /// The same tree as wide nodes of eight boxes.
    pub(crate) wide: Wide,
    /// In leaf order, like `ids`.
    pub(crate) corners: Vec<Corners>,
    pub(crate) ids: Vec<u32>,
    /// All 0. The kernel reads the zones of hit triangles; making them optional would cost bodies
    /// with zones more than these zeros cost here.
    pub(crate) zones: Vec<Zones>,
    pub(crate) depth: u32,
}

impl Tree {
    /// Builds a tree over triangles: three corners of x, y, z each, in metres (or any one unit), in
    /// the body's own frame.
    ///
    /// Any triangles are accepted: they need not be closed, connected or consistently oriented. A
    /// degenerate triangle is treated as the segment or point it is, and duplicates count
    /// separately. The triangles are copied: with its boxes a tree takes about 80 bytes per
    /// triangle, or 125 with one triangle per leaf.
    ///
    /// ```
    /// use trolley_bvh::{BuildError, BuildOptions, Tree};
    ///
    /// let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let tree = Tree::build(&[triangle], &BuildOptions::default())?;
    /// assert_eq!(tree.ids(), [0]);
    /// assert_eq!(Tree::build(&[], &BuildOptions::default()), Err(BuildError::Empty));
    /// # Ok::<(), BuildError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// There are no triangles or more than [`build::TRIANGLES_MAX`] (for [`body::Build::Literal`]:
    /// [`build::LITERAL_MAX`]), a coordinate is NaN or infinite, or the leaf size is out of range.
    pub fn build(corners: &[Corners], options: &BuildOptions) -> Result<Self, BuildError> {
        build::assembled(corners, options)
    }

    /// Returns the tree as a kernel input: without parts, in no zone.
    #[must_use]
    pub fn view(&self) -> BodyView<'_> {
        BodyView {
            nodes: &self.nodes,
            wide: &self.wide.nodes,
            wide_of: &self.wide.of,
            corners: &self.corners,
            source_ids: &self.ids,
            part_of: &[],
            zones: &self.zones,
            dropped: &[],
        }
    }

    /// The bounding box of all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.view().bounds()
    }

    /// The triangles in the order of the tree's leaves.
    #[must_use]
    pub fn corners(&self) -> &[Corners] {
        &self.corners
    }

    /// The ids of the triangles, parallel to [`Tree::corners`].
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Number of nodes on the longest path from the root: 1 for a single leaf.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depth
    }
}

impl<'a> From<&'a Tree> for BodyView<'a> {
    fn from(tree: &'a Tree) -> Self {
        tree.view()
    }
}
