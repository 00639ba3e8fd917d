//! A worker's own bodies, into which sections are copied: for comparison with reading the store.
//!
//! Everything lies at its place in the store, so that numbers of nodes and triangles are the same.
//! What was not sent is empty; no job refers to it, because a section is sent before its first job.

use body::{BodyView, Node, WideNode, Zones};
use geometry::{Aabb, Corners};
use protocol::chunk::read_piece;
use protocol::{Array, Piece};

/// The sections of a body that were sent.
struct Copy {
    nodes: Vec<Node>,
    wide: Vec<WideNode>,
    wide_of: Vec<u32>,
    corners: Vec<Corners>,
    source_ids: Vec<u32>,
    zones: Vec<Zones>,
}

/// The sections of all bodies that were sent.
pub(crate) struct Copies(Vec<Copy>);

impl Copies {
    /// Empty copies with the sizes of these bodies.
    pub(crate) fn like<'v>(bodies: impl Iterator<Item = &'v BodyView<'v>>) -> Self {
        let empty = Node { bounds: Aabb::EMPTY, link: 0, count: 0 };
        let copy = |body: &BodyView<'_>| Copy {
            nodes: vec![empty; body.nodes.len()],
            wide: vec![WideNode::EMPTY; body.wide.len()],
            wide_of: vec![0; body.wide_of.len()],
            corners: vec![Corners::default(); body.corners.len()],
            source_ids: vec![0; body.source_ids.len()],
            zones: vec![Zones(0); body.zones.len()],
        };
        Self(bodies.map(copy).collect())
    }

    /// Copies all pieces of a message to their places; `false` if a piece has none.
    pub(crate) fn store(&mut self, mut words: &[u64]) -> bool {
        while !words.is_empty() {
            let Some((piece, rest)) = read_piece(words) else { return false };
            if self.put(&piece).is_none() {
                return false;
            }
            words = rest;
        }
        true
    }

    fn put(&mut self, piece: &Piece<'_>) -> Option<()> {
        let body = self.0.get_mut(piece.model as usize)?;
        let whole: &mut [u8] = match piece.array {
            Array::Nodes => bytemuck::cast_slice_mut(&mut body.nodes),
            Array::Wide => bytemuck::cast_slice_mut(&mut body.wide),
            Array::WideOf => bytemuck::cast_slice_mut(&mut body.wide_of),
            Array::Corners => bytemuck::cast_slice_mut(&mut body.corners),
            Array::SourceIds => bytemuck::cast_slice_mut(&mut body.source_ids),
            Array::Zones => bytemuck::cast_slice_mut(&mut body.zones),
        };
        let from = (piece.first as usize).checked_mul(piece.array.bytes())?;
        let to = from.checked_add(piece.bytes.len())?;
        whole.get_mut(from..to)?.copy_from_slice(piece.bytes);
        Some(())
    }

    /// The body with this number.
    pub(crate) fn body(&self, number: u32) -> Option<BodyView<'_>> {
        let body = self.0.get(number as usize)?;
        Some(BodyView {
            nodes: &body.nodes,
            wide: &body.wide,
            wide_of: &body.wide_of,
            corners: &body.corners,
            source_ids: &body.source_ids,
            part_of: &[],
            zones: &body.zones,
            dropped: &[],
        })
    }
}
