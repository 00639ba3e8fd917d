//! A tree over anybody's triangles: all that is needed to intersect them, and nothing else.

use crate::build::{self, BuildError, BuildOptions};
use body::{BodyView, Node, Wide, Zones};
use geometry::{Aabb, Corners};

/// Triangles in a bounding volume hierarchy, ready to be intersected with others: see
/// [`crate::query`].
///
/// It knows of no mass, part or file. The id of a triangle is its number in the slice that the tree
/// was built over, from 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    /// Preorder; the root is node 0.
    pub(crate) nodes: Vec<Node>,
    /// The same tree, eight boxes at a time.
    pub(crate) wide: Wide,
    /// In leaf order, as `ids`.
    pub(crate) corners: Vec<Corners>,
    pub(crate) ids: Vec<u32>,
    /// All 0. The kernel reads those of triangles that are hit; that there may be none would cost
    /// the bodies that have them more than these cost here.
    pub(crate) zones: Vec<Zones>,
    pub(crate) depth: u32,
}

impl Tree {
    /// Builds a tree over triangles: three corners of x, y, z each, in metres (or any one unit),
    /// in a frame of the body's own.
    ///
    /// Any triangles will do: they need not be closed, connected or facing one way. A degenerate
    /// one is the segment or point that it is, and of equal ones each counts. They are copied: with
    /// its boxes a tree takes some 80 bytes per triangle, 125 where each has a leaf of its own.
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
    /// No triangles, more than [`build::TRIANGLES_MAX`] (of [`body::Build::Literal`]:
    /// [`build::LITERAL_MAX`]), a coordinate that is NaN or infinite, a leaf size out of range.
    pub fn build(corners: &[Corners], options: &BuildOptions) -> Result<Self, BuildError> {
        build::assembled(corners, options)
    }

    /// The same tree, as the kernel walks it: without parts, in no zone.
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

    /// The box of all triangles.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.view().bounds()
    }

    /// The triangles in the order of the tree's leaves.
    #[must_use]
    pub fn corners(&self) -> &[Corners] {
        &self.corners
    }

    /// The id of each of [`Tree::corners`].
    #[must_use]
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Nodes on the longest way from the root: 1 for a single leaf.
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
