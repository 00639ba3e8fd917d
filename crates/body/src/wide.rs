//! The wide tree: several levels of the binary tree per node, for tests of eight boxes at once.
//!
//! Every wide node corresponds to one node of the binary tree, its *root*. If the root holds more
//! triangles than a wide leaf and is not a leaf, it is opened, then repeatedly the largest of the
//! resulting nodes, until there are eight: these are the lanes. Anything smaller becomes a wide
//! leaf, one or several consecutive nodes, in which each triangle has a lane. So nearly all lanes
//! are in use, however the binary tree was split. (I. Wald, C. Benthin, S. Boulos, *Getting Rid of
//! Packets*, IEEE Symposium on Interactive Ray Tracing 2008, collapse binary trees in this way.)
//!
//! Boxes of triangles are stored as cells of a [`Grid`] over the leaf: a byte per side, so that one
//! instruction compares 32 of them and a leaf takes an eighth of the memory.
//!
//! The triangles of a leaf are a patch of a surface, often a flat one, which a box fits poorly
//! where it is oblique. So a leaf also has a [`Slab`]: the space between two parallel planes.
//!
//! The wide tree follows from nodes and triangles alone, so [`crate::file`] checks it by
//! recomputing it. It is stored nevertheless, so that a mapped file is ready for traversal.

use crate::Node;
use bytemuck::{Pod, Zeroable};
use geometry::{Aabb, Corners};

/// Lanes of a wide node.
pub const LANES: usize = 8;

/// Maximum number of triangles of a wide leaf, unless a leaf of the binary tree has more.
///
/// Each pair of leaves has a high fixed cost, and another triangle costs little, so large leaves
/// are fast. Deep car crashes of 10k, 100k and 1M triangles took 1.20, 1.33 and 1.16 times as long
/// with 32, and 1.05, 1.00 and 1.04 times with 128; larger leaves also increase the time until a
/// job notices its deadline.
pub const LEAF_TRIANGLES: usize = 96;

/// Eight boxes in column layout, 256 bytes; or a [`WideLeaf`].
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WideNode {
    /// Least x, y, z of each lane, body frame (m). An empty lane is inverted and infinite.
    pub min: [[f32; LANES]; 3],
    /// Greatest x, y, z of each lane (m).
    pub max: [[f32; LANES]; 3],
    /// The wide node of each lane; 0 if the lane is empty.
    child: [u32; LANES],
    /// The bounding box of all lanes.
    pub bounds: Aabb,
    /// The corresponding node of the binary tree.
    pub root: u32,
    /// 0; nonzero in a [`WideLeaf`].
    count: u32,
}

const _: () = assert!(size_of::<WideNode>() == 256 && size_of::<WideLeaf>() == 256);

impl WideNode {
    /// A node without used lanes.
    pub const EMPTY: Self = Self {
        min: [[f32::INFINITY; LANES]; 3],
        max: [[f32::NEG_INFINITY; LANES]; 3],
        child: [0; LANES],
        bounds: Aabb::EMPTY,
        root: 0,
        count: 0,
    };

    /// The node as a leaf, if it is one: its lanes are triangles.
    #[must_use]
    #[inline]
    pub fn leaf(&self) -> Option<&WideLeaf> {
        (self.count > 0).then(|| bytemuck::cast_ref(self))
    }

    /// The node as a mutable leaf, if it is one.
    pub fn leaf_mut(&mut self) -> Option<&mut WideLeaf> {
        (self.count > 0).then(|| bytemuck::cast_mut(self))
    }

    /// The number of consecutive nodes of the same leaf, from this one on; 1 for an interior node.
    #[must_use]
    #[inline]
    pub fn run(&self) -> u32 {
        self.count.div_ceil(LEAF_LANES as u32).max(1)
    }

    /// The wide node of a lane, if this is not a leaf.
    #[must_use]
    #[inline]
    pub fn child(&self, lane: usize) -> u32 {
        self.child[lane]
    }

    fn set_box(&mut self, lane: usize, bounds: &Aabb) {
        for axis in 0..3 {
            self.min[axis][lane] = bounds.min[axis];
            self.max[axis][lane] = bounds.max[axis];
        }
    }

    /// Empties a lane, if this is not a leaf.
    pub fn clear(&mut self, lane: usize) {
        self.set_box(lane, &Aabb::EMPTY);
    }

    /// Whether the lane is empty, if this is not a leaf.
    #[must_use]
    pub fn is_empty(&self, lane: usize) -> bool {
        self.min[0][lane] > self.max[0][lane]
    }
}

/// Compares bits: a leaf's may be NaN when read as numbers of a node.
impl PartialEq for WideNode {
    fn eq(&self, other: &Self) -> bool {
        bytemuck::bytes_of(self) == bytemuck::bytes_of(other)
    }
}

/// The wide nodes of a binary tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wide {
    /// The wide nodes. The first one corresponds to the root of the whole tree.
    pub nodes: Vec<WideNode>,
    /// Per node of the binary tree, the wide node that contains it: its own if it is the root of
    /// one, else the one in which it was opened or in whose leaf it lies.
    pub of: Vec<u32>,
}

impl Wide {
    /// Collapses the binary tree over `corners`, both in the layout of a body.
    ///
    /// Time is linear in the number of nodes and triangles.
    ///
    /// # Panics
    ///
    /// The nodes are not a tree over these triangles, as checked by [`crate::file::check_body`].
    #[must_use]
    pub fn of(nodes: &[Node], corners: &[Corners]) -> Self {
        Laid::out(nodes).filled(corners, 1, |shares| shares.into_iter().for_each(LeafRun::fill))
    }
}

/// A wide tree whose leaves are not filled yet.
#[derive(Debug)]
pub struct Laid<'n> {
    nodes: &'n [Node],
    below: Vec<Below>,
    wide: Wide,
    /// The wide node at which each leaf begins, and its root.
    leaves: Vec<(usize, usize)>,
}

impl<'n> Laid<'n> {
    /// Lays out the wide nodes of a binary tree, without using the positions of triangles.
    ///
    /// # Panics
    ///
    /// The nodes are not a tree, as checked by [`crate::file::check_body`].
    #[must_use]
    pub fn out(nodes: &'n [Node]) -> Self {
        let below = below(nodes);
        let mut laid = Self { nodes, below, wide: Wide::default(), leaves: Vec::new() };
        if !nodes.is_empty() {
            laid.lay();
        }
        laid
    }

    /// The number of wide nodes for a node of the binary tree.
    fn blocks(&self, root: usize) -> usize {
        let is_leaf = is_wide_leaf(self.nodes, &self.below, root);
        let whole = if is_leaf { self.below[root].triangles } else { 1 };
        (whole as usize).div_ceil(LEAF_LANES)
    }

    fn lay(&mut self) {
        let nodes = self.nodes;
        let mut wide = vec![WideNode::EMPTY; self.blocks(0)];
        let mut of = vec![0; nodes.len()];
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((root, at)) = open.pop() {
            of[root] = at as u32;
            if is_wide_leaf(nodes, &self.below, root) {
                of[root..root + self.below[root].nodes as usize].fill(at as u32);
                self.leaves.push((at, root));
                continue;
            }
            let lanes = opened(nodes, &self.below, root, |node| of[node] = at as u32);
            let mut node = WideNode { bounds: nodes[root].bounds, ..WideNode::EMPTY };
            node.root = root as u32;
            let mut next = wide.len();
            for (lane, &child) in lanes.as_slice().iter().enumerate() {
                node.set_box(lane, &nodes[child].bounds);
                node.child[lane] = next as u32;
                open.push((child, next));
                next += self.blocks(child);
            }
            wide[at] = node;
            wide.resize(next, WideNode::EMPTY);
        }
        self.leaves.sort_unstable();
        self.wide = Wide { nodes: wide, of };
    }

    /// Fills the leaves in `shares` shares: `run` must fill every one of them, in any order and on
    /// any thread.
    ///
    /// # Panics
    ///
    /// `corners` are not the triangles of the tree, in leaf order.
    #[must_use]
    pub fn filled(
        self,
        corners: &[Corners],
        shares: usize,
        run: impl FnOnce(Vec<LeafRun<'_>>),
    ) -> Wide {
        let Self { nodes, below, mut wide, leaves } = self;
        let (start, below, leaves) = (0, &below, &leaves);
        run(LeafRun { wide: &mut wide.nodes, start, leaves, nodes, below, corners }.cut(shares));
        wide
    }
}

/// Unfilled leaves of a wide tree, and the range of wide nodes that contains them.
#[derive(Debug)]
pub struct LeafRun<'s> {
    wide: &'s mut [WideNode],
    /// Number of the first of these.
    start: usize,
    /// The wide node at which each leaf begins, and its root.
    leaves: &'s [(usize, usize)],
    nodes: &'s [Node],
    below: &'s [Below],
    corners: &'s [Corners],
}

impl<'s> LeafRun<'s> {
    /// Splits the leaves, in order, into `shares` shares of neighbours.
    fn cut(self, shares: usize) -> Vec<LeafRun<'s>> {
        let share = self.leaves.len().div_ceil(shares.max(1)).max(1);
        let mut cut = Vec::new();
        let mut rest = self.wide;
        // From the end: each share takes the nodes from its first leaf on.
        for leaves in self.leaves.chunks(share).rev() {
            let start = leaves[0].0;
            let (before, wide) = rest.split_at_mut(start);
            rest = before;
            cut.push(LeafRun { wide, start, leaves, ..self });
        }
        cut
    }

    /// Fills these leaves.
    pub fn fill(self) {
        for &(at, root) in self.leaves {
            let Below { first, triangles, .. } = self.below[root];
            let corners = &self.corners[first as usize..][..triangles as usize];
            let nodes = &mut self.wide[at - self.start..];
            WideLeaf::fill(nodes, (&self.nodes[root], root), (first, corners));
        }
    }
}

/// Totals below a node of the binary tree, including the node.
#[derive(Clone, Copy, Debug, Default)]
struct Below {
    first: u32,
    triangles: u32,
    nodes: u32,
}

fn below(nodes: &[Node]) -> Vec<Below> {
    let mut below = vec![Below::default(); nodes.len()];
    // Children are stored after their parents.
    for (at, node) in nodes.iter().enumerate().rev() {
        below[at] = if node.is_leaf() {
            Below { first: node.link, triangles: node.count, nodes: 1 }
        } else {
            let (left, right) = (below[at + 1], below[node.link as usize]);
            Below {
                first: left.first,
                triangles: left.triangles + right.triangles,
                nodes: 1 + left.nodes + right.nodes,
            }
        };
    }
    below
}

fn is_wide_leaf(nodes: &[Node], below: &[Below], node: usize) -> bool {
    nodes[node].is_leaf() || below[node].triangles as usize <= LEAF_TRIANGLES
}

/// Up to eight nodes.
struct Lanes {
    nodes: [usize; LANES],
    count: usize,
}

impl Lanes {
    fn as_slice(&self) -> &[usize] {
        &self.nodes[..self.count]
    }

    /// Replaces one node by two, keeping the order of the others.
    fn replace(&mut self, at: usize, [left, right]: [usize; 2]) {
        self.nodes.copy_within(at + 1..self.count, at + 2);
        self.nodes[at] = left;
        self.nodes[at + 1] = right;
        self.count += 1;
    }
}

/// Opens `root`, then the node of largest surface, until there are eight or none can be opened.
fn opened(nodes: &[Node], below: &[Below], root: usize, mut told: impl FnMut(usize)) -> Lanes {
    let mut lanes = Lanes { nodes: [0; LANES], count: 1 };
    lanes.nodes[0] = root;
    while lanes.count < LANES {
        let mut largest = None;
        for (lane, &node) in lanes.as_slice().iter().enumerate() {
            let area = nodes[node].bounds.half_area();
            if !is_wide_leaf(nodes, below, node) && largest.is_none_or(|(most, _)| area > most) {
                largest = Some((area, lane));
            }
        }
        let Some((_, lane)) = largest else { break };
        let node = lanes.nodes[lane];
        told(node);
        lanes.replace(lane, [node + 1, nodes[node].link as usize]);
    }
    lanes
}

mod leaf;
mod slab;
#[cfg(test)]
mod tests;

pub use leaf::{Grid, LEAF_LANES, WideLeaf};
pub use slab::Slab;
