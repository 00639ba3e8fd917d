//! One question about one pose of one candidate, and the state of each of its jobs: to be handed
//! out, out, done, or lost.

use crate::gather::{Gathered, Part, Rest};
use bvh::NodePair;
use geometry::Supports;
use protocol::WireTask;
use protocol::result::read_rest;
use std::collections::VecDeque;

/// One question about one pose of one candidate.
#[derive(Clone, Debug)]
pub(crate) struct TaskState {
    pub(crate) candidate: usize,
    /// Number of the pose in the survey of the candidate.
    pub(crate) stop: usize,
    pub(crate) travel_m: f64,
    pub(super) wire: WireTask,
    /// The traversal is done: jobs exist.
    pub(super) is_descended: bool,
    /// Jobs about a pose that are not handed out yet; the last goes first.
    pub(super) todo: Vec<NodePair>,
    /// Jobs handed out and not closed, the oldest first.
    pub(super) out: VecDeque<NodePair>,
    /// Jobs that will not be done: what they would have found is not known.
    pub(super) lost: Vec<NodePair>,
    /// What jobs that exhausted their budget left open, by job.
    pub(super) rests: Vec<(NodePair, Vec<NodePair>)>,
    /// Jobs that were done.
    pub(super) done: u64,
    /// Created with its jobs, taken when all of them are done.
    pub(super) found: Option<Box<Gathered>>,
    /// What its open jobs could still reach, and how many were open when that was computed.
    pub(super) reach: Option<Box<(usize, Supports)>>,
}

/// The lists of a task that is over, empty, for the next one.
#[derive(Debug, Default)]
pub(super) struct TaskLists {
    pub(super) todo: Vec<NodePair>,
    pub(super) out: VecDeque<NodePair>,
    pub(super) lost: Vec<NodePair>,
    pub(super) rests: Vec<(NodePair, Vec<NodePair>)>,
}

impl TaskState {
    /// Its lists, once nothing is in the last of them.
    pub(super) fn into_lists(self) -> TaskLists {
        let Self { mut todo, mut out, mut lost, rests, .. } = self;
        debug_assert!(rests.is_empty(), "their lists are kept for other tasks");
        todo.clear();
        out.clear();
        lost.clear();
        TaskLists { todo, out, lost, rests }
    }

    /// Keeps what a part reports as left open; the part may be repeated.
    pub(super) fn store_rest(
        &mut self,
        job: NodePair,
        part: &Part<'_>,
        spare: &mut Vec<Vec<NodePair>>,
    ) {
        match part.rest {
            Rest::Pairs([]) => {}
            Rest::Pairs(pairs) => self.store(job, 0, pairs.iter().copied(), spare),
            Rest::Words(words) => {
                let count = words.len().saturating_sub(1) as u32;
                let Some((first, pairs)) = read_rest(words, count) else { return };
                self.store(job, first, pairs.map(|(a, b)| NodePair { a, b }), spare);
            }
        }
    }

    /// Keeps pairs that a job left open, from number `first` on.
    fn store(
        &mut self,
        job: NodePair,
        first: u64,
        pairs: impl Iterator<Item = NodePair>,
        spare: &mut Vec<Vec<NodePair>>,
    ) {
        let at = self.rests.iter().position(|(of, _)| *of == job);
        let at = at.unwrap_or_else(|| {
            let mut room = spare.pop().unwrap_or_default();
            room.clear();
            self.rests.push((job, room));
            self.rests.len() - 1
        });
        let rest = &mut self.rests[at].1;
        // Parts come in order: this one continues the last one, or is a repeat.
        rest.truncate(first as usize);
        if rest.len() as u64 == first {
            rest.extend(pairs);
        }
    }

    /// Whether a job did all that was asked for, or listed all that it left open, as far as this
    /// part shows.
    pub(super) fn is_whole(&self, job: NodePair, part: &Part<'_>) -> bool {
        let Some(last) = part.last else { return true };
        let kept = self.rests.iter().find(|(of, _)| *of == job).map_or(0, |(_, rest)| rest.len());
        let is_complete = last.summary.end == protocol::result::WireEnd::Complete as u32;
        kept as u64 == last.summary.rest && (is_complete || kept > 0)
    }
}

/// One decoded part of a result.
#[derive(Clone, Copy, Debug)]
pub struct PartOf<'p>(pub(crate) Part<'p>);

impl PartOf<'_> {
    /// Whether its job did all that was asked for, as far as this part shows.
    pub(crate) fn is_whole(&self) -> bool {
        let complete = protocol::result::WireEnd::Complete as u32;
        self.0.last.is_none_or(|last| last.summary.end == complete)
    }
}
