//! The queue to one worker that copies: sections, cut into chunks, and the batches that need them,
//! in order.
//!
//! A section's payload is all that the kernel reads below its root: nodes, wide nodes, triangles
//! with their ids and zones; and the root of the whole tree, whose box bounds the body. That is
//! more than the logical bytes of the transfer account, which are those of a compact format.

use super::WorkerHandle;
use body::BodyView;
use bvh::section;
use protocol::chunk::{Piece, write_piece};
use protocol::launch::CHUNK_WORDS;
use protocol::{Array, Head, Section};
use runtime::StatusMemory;
use std::collections::VecDeque;
use std::ops::Range;
use transport::UseError;

/// Messages that wait for capacity in the channel of one worker.
#[derive(Debug, Default)]
pub(super) struct Outgoing(VecDeque<(Head, Vec<u64>)>);

impl Outgoing {
    pub(super) fn push(&mut self, head: Head, words: Vec<u64>) {
        self.0.push_back((head, words));
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Forgets what waits for a worker.
    pub(super) fn clear(&mut self, worker: &mut WorkerHandle) {
        self.0.clear();
        worker.has_backlog = false;
    }

    /// Sends as much as the channel takes.
    pub(super) fn flush(
        &mut self,
        worker: &mut WorkerHandle,
        status: &StatusMemory,
    ) -> Result<(), UseError> {
        while let Some((head, words)) = self.0.front() {
            match worker.send(status, *head, words) {
                Ok(()) => drop(self.0.pop_front()),
                // The worker is still busy with what it has.
                Err(UseError::Full) => {
                    worker.has_backlog = true;
                    return Ok(());
                }
                Err(error) => return Err(error),
            }
        }
        worker.has_backlog = false;
        Ok(())
    }
}

/// Payloads that hold a section, none larger than a message may be.
pub(super) fn chunks(body: &BodyView<'_>, section: Section) -> Vec<Vec<u64>> {
    let nodes = section::nodes_of(body.nodes, section.node);
    let triangles = section::triangles(body.nodes, section.node);
    let mut chunks = Chunks { model: section.model, done: Vec::new(), open: Vec::new() };
    chunks.add(Array::Nodes, bytemuck::cast_slice(body.nodes), &(0..1));
    chunks.add(Array::Nodes, bytemuck::cast_slice(body.nodes), &nodes);
    chunks.add(Array::WideOf, bytemuck::cast_slice(body.wide_of), &nodes);
    for run in wide_runs(body, &nodes) {
        chunks.add(Array::Wide, bytemuck::cast_slice(body.wide), &run);
    }
    chunks.add(Array::Corners, bytemuck::cast_slice(body.corners), &triangles);
    chunks.add(Array::SourceIds, bytemuck::cast_slice(body.source_ids), &triangles);
    chunks.add(Array::Zones, bytemuck::cast_slice(body.zones), &triangles);
    chunks.close();
    chunks.done
}

struct Chunks {
    model: u32,
    done: Vec<Vec<u64>>,
    open: Vec<u64>,
}

impl Chunks {
    /// Adds elements of an array, all of whose bytes are given.
    fn add(&mut self, array: Array, bytes: &[u8], range: &Range<u32>) {
        let mut first = range.start;
        while first < range.end {
            let (from, to) = (first as usize * array.bytes(), range.end as usize * array.bytes());
            let piece = Piece { model: self.model, array, first, bytes: &bytes[from..to] };
            match write_piece(&mut self.open, CHUNK_WORDS, &piece) {
                0 => self.close(),
                count => first += count as u32,
            }
        }
    }

    fn close(&mut self) {
        if !self.open.is_empty() {
            self.done.push(std::mem::take(&mut self.open));
        }
    }
}

/// The wide nodes in which these nodes are, with all nodes of a leaf, as runs of neighbours.
fn wide_runs(body: &BodyView<'_>, nodes: &Range<u32>) -> Vec<Range<u32>> {
    let mut at: Vec<u32> = body.wide_of[nodes.start as usize..nodes.end as usize].to_vec();
    at.sort_unstable();
    at.dedup();
    let mut runs: Vec<Range<u32>> = Vec::new();
    for first in at {
        let count = body.wide[first as usize].run();
        match runs.last_mut() {
            Some(run) if run.end >= first => run.end = run.end.max(first + count),
            _ => runs.push(first..first + count),
        }
    }
    runs
}
