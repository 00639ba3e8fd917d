//! One question about one pose of one candidate, and where each of its jobs is: to be handed out,
//! out, done, or lost. What the parts of their results say of that; not what they found.

use crate::candidate_state::Purpose;
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
    pub(crate) purpose: Purpose,
    pub(crate) travel_m: f64,
    pub(super) wire: WireTask,
    /// The descent was made: jobs exist.
    pub(super) is_descended: bool,
    /// Jobs not handed out yet; the last goes first.
    pub(super) todo: Vec<NodePair>,
    /// Jobs handed out and not closed, the oldest first.
    pub(super) out: VecDeque<NodePair>,
    /// Jobs that will not be done: what they would have found is not known.
    pub(super) lost: Vec<NodePair>,
    /// What jobs whose budget was spent have left open, by the job.
    pub(super) rests: Vec<(NodePair, Vec<NodePair>)>,
    /// Jobs that were done.
    pub(super) done: u64,
    pub(super) is_obsolete: bool,
    /// Made when its jobs are made, taken when all of them are done.
    pub(super) found: Option<Gathered>,
    /// What its open jobs could still reach when so many were open.
    pub(super) reach: Option<(usize, Supports)>,
}

impl TaskState {
    /// Keeps what a part says was left open; it may come again.
    pub(super) fn keep_rest(
        &mut self,
        job: NodePair,
        part: &Part<'_>,
        spare: &mut Vec<Vec<NodePair>>,
    ) {
        match part.rest {
            Rest::Pairs([]) => {}
            Rest::Pairs(pairs) => self.keep(job, 0, pairs.iter().copied(), spare),
            Rest::Words(words) => {
                let count = words.len().saturating_sub(1) as u32;
                let Some((first, pairs)) = read_rest(words, count) else { return };
                self.keep(job, first, pairs.map(|(a, b)| NodePair { a, b }), spare);
            }
        }
    }

    /// Keeps pairs that a job left open, from number `first` on.
    fn keep(
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
        // Parts come in order: this one goes on where the last one ended, or was seen before.
        rest.truncate(first as usize);
        if rest.len() as u64 == first {
            rest.extend(pairs);
        }
    }

    /// Whether a job did all that was asked for, or left behind all that it did not, as far as this
    /// part says.
    pub(super) fn is_whole(&self, job: NodePair, part: &Part<'_>) -> bool {
        let Some(last) = part.last else { return true };
        let kept = self.rests.iter().find(|(of, _)| *of == job).map_or(0, |(_, rest)| rest.len());
        let is_complete = last.summary.end == protocol::result::WireEnd::Complete as u32;
        kept as u64 == last.summary.rest && (is_complete || kept > 0)
    }
}

/// One part of a result, taken apart.
#[derive(Clone, Copy, Debug)]
pub struct PartOf<'p>(pub(crate) Part<'p>);

impl PartOf<'_> {
    /// Whether its job did all that was asked for, as far as this part says.
    pub(crate) fn is_whole(&self) -> bool {
        let complete = protocol::result::WireEnd::Complete as u32;
        self.0.last.is_none_or(|last| last.summary.end == complete)
    }
}
