//! The wide tree: the binary tree with several levels at a time, for tests of eight boxes at once.
//!
//! Every wide node stands for one node of the binary tree, its *root*. Where that holds more
//! triangles than a wide leaf and is no leaf, it is opened, then the largest of what came out,
//! until there are eight: these are the lanes. Anything smaller is a wide leaf, a node or several,
//! one behind the other, in which each triangle has a lane. So nearly all lanes are in use, however
//! the binary tree was split. (I. Wald, C. Benthin, S. Boulos, *Getting Rid of Packets*, IEEE
//! Symposium on Interactive Ray Tracing 2008, collapse binary trees so.)
//!
//! Boxes of triangles are known as cells of a [`Grid`] over the leaf: a byte per
//! side, so that one instruction compares 32 of them and a leaf takes an eighth of the memory.
//!
//! The triangles of a leaf are a patch of a surface, often a flat one, which a box hardly fits
//! where it lies askew. So a leaf has a [`Slab`] besides: the space between two parallel planes.
//!
//! It follows from nodes and triangles alone, so [`crate::file`] checks it by making it anew. It is
//! stored all the same: a mapped file is ready to be walked.

use crate::Node;
use bytemuck::{Pod, Zeroable};
use geometry::{Aabb, Corners};

/// Lanes of a wide node.
pub const LANES: usize = 8;

/// Most triangles of a wide leaf, unless a leaf of the binary tree has more.
///
/// Where two leaves meet costs much and another triangle little, so large leaves are quick. Deep
/// car crashes of 10k, 100k and 1M triangles took 1.20, 1.33 and 1.16 times as long with 32, and
/// 1.05, 1.00 and 1.04 times with 128; those would also be tested for longer before a job hears of
/// its deadline.
pub const LEAF_TRIANGLES: usize = 96;

/// Eight boxes side by side, 256 bytes; or a [`WideLeaf`].
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WideNode {
    /// Least x, y, z of each lane, body frame (m). An empty lane is inverted and infinite.
    pub min: [[f32; LANES]; 3],
    /// Greatest x, y, z of each lane (m).
    pub max: [[f32; LANES]; 3],
    /// The lane's wide node; 0 where it is empty.
    child: [u32; LANES],
    /// The box of all lanes.
    pub bounds: Aabb,
    /// The node of the binary tree that this one stands for.
    pub root: u32,
    /// 0; in a [`WideLeaf`] it is not.
    count: u32,
}

const _: () = assert!(size_of::<WideNode>() == 256 && size_of::<WideLeaf>() == 256);

impl WideNode {
    /// No lane is in use.
    pub const EMPTY: Self = Self {
        min: [[f32::INFINITY; LANES]; 3],
        max: [[f32::NEG_INFINITY; LANES]; 3],
        child: [0; LANES],
        bounds: Aabb::EMPTY,
        root: 0,
        count: 0,
    };

    /// It as a leaf, if it is one: its lanes are triangles.
    #[must_use]
    #[inline]
    pub fn leaf(&self) -> Option<&WideLeaf> {
        (self.count > 0).then(|| bytemuck::cast_ref(self))
    }

    /// It as a leaf, if it is one.
    pub fn leaf_mut(&mut self) -> Option<&mut WideLeaf> {
        (self.count > 0).then(|| bytemuck::cast_mut(self))
    }

    /// How many nodes it is, with those that follow of the same leaf; an interior node is alone.
    #[must_use]
    #[inline]
    pub fn run(&self) -> u32 {
        self.count.div_ceil(LEAF_LANES as u32).max(1)
    }

    /// The wide node of a lane, if this is no leaf.
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

    /// Makes a lane empty, if this is no leaf.
    pub fn clear(&mut self, lane: usize) {
        self.set_box(lane, &Aabb::EMPTY);
    }

    /// Whether nothing is in the lane, if this is no leaf.
    #[must_use]
    pub fn is_empty(&self, lane: usize) -> bool {
        self.min[0][lane] > self.max[0][lane]
    }
}

/// The bits are compared: those of a leaf may be NaN as numbers of a node.
impl PartialEq for WideNode {
    fn eq(&self, other: &Self) -> bool {
        bytemuck::bytes_of(self) == bytemuck::bytes_of(other)
    }
}

/// The wide nodes of a binary tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wide {
    /// The wide nodes. The first one stands for the root of the whole tree.
    pub nodes: Vec<WideNode>,
    /// Per node of the binary tree: the wide node in which it is. That is its own if it is the
    /// root of one, else that of which it is an opened node or below whose leaf it lies.
    pub of: Vec<u32>,
}

impl Wide {
    /// Collapses the binary tree over `corners`, both as a body has them.
    ///
    /// Time is linear in the number of nodes and triangles.
    ///
    /// # Panics
    ///
    /// If the nodes are not a tree over these triangles, as [`crate::file::check_body`] holds.
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
    /// Lays out the wide nodes of a binary tree. Where its triangles lie does not matter yet.
    ///
    /// # Panics
    ///
    /// If the nodes are not a tree, as [`crate::file::check_body`] holds.
    #[must_use]
    pub fn out(nodes: &'n [Node]) -> Self {
        let below = below(nodes);
        let mut laid = Self { nodes, below, wide: Wide::default(), leaves: Vec::new() };
        if !nodes.is_empty() {
            laid.lay();
        }
        laid
    }

    /// How many wide nodes stand for a node of the binary tree.
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

    /// Fills the leaves: `run` has every one of so many shares of them filled, in any order and by
    /// any thread.
    ///
    /// # Panics
    ///
    /// If `corners` are not the triangles of the tree, in leaf order.
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

/// Some leaves of a wide tree that wait to be filled, and the wide nodes among which they lie.
#[derive(Debug)]
pub struct LeafRun<'s> {
    wide: &'s mut [WideNode],
    /// Number of the first of these.
    start: usize,
    /// The wide node at which each begins, and its root.
    leaves: &'s [(usize, usize)],
    nodes: &'s [Node],
    below: &'s [Below],
    corners: &'s [Corners],
}

impl<'s> LeafRun<'s> {
    /// Cuts the leaves, in order, into so many shares of neighbours.
    fn cut(self, shares: usize) -> Vec<LeafRun<'s>> {
        let share = self.leaves.len().div_ceil(shares.max(1)).max(1);
        let mut cut = Vec::new();
        let mut rest = self.wide;
        // From behind: each share has the nodes from its first leaf on.
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

/// What lies below a node of the binary tree, itself included.
#[derive(Clone, Copy, Debug, Default)]
struct Below {
    first: u32,
    triangles: u32,
    nodes: u32,
}

fn below(nodes: &[Node]) -> Vec<Below> {
    let mut below = vec![Below::default(); nodes.len()];
    // Children stand behind their parents.
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

    /// Puts two nodes where one was, the others in order as they are.
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
