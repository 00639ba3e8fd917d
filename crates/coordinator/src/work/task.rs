//! One question about one pose, or the way, of one candidate, and the state of each of its jobs: to
//! be handed out, out, done, or lost; not what the jobs found, but for the first contact.

use crate::candidate_state::Purpose;
use crate::gather::{Gathered, Part, Rest};
use body::BodyView;
use bvh::{NodePair, OpenPair, SweepTask, SweptFront, Witness};
use geometry::Supports;
use protocol::WireTask;
use protocol::result::read_rest;
use std::collections::VecDeque;

/// One question about one pose, or the way, of one candidate.
#[derive(Clone, Debug)]
pub(crate) struct TaskState {
    pub(crate) candidate: usize,
    pub(crate) purpose: Purpose,
    pub(crate) travel_m: f64,
    pub(super) wire: WireTask,
    /// The traversal is done: jobs exist.
    pub(super) is_descended: bool,
    /// Jobs about a pose that are not handed out yet; the last goes first.
    pub(super) todo: Vec<NodePair>,
    /// What is not handed out yet of a search for first contact, the earliest first.
    pub(super) front: SweptFront,
    /// Jobs handed out and not closed, the oldest first, and the travel before which nothing of
    /// them touches (m), in a search for first contact.
    pub(super) out: VecDeque<OpenPair>,
    /// Jobs that will not be done: what they would have found is not known.
    pub(super) lost: Vec<OpenPair>,
    /// What jobs that exhausted their budget left open, by job.
    pub(super) rests: Vec<(NodePair, Vec<NodePair>)>,
    /// Jobs that were done.
    pub(super) done: u64,
    pub(super) is_obsolete: bool,
    /// Created with its jobs, taken when all of them are done.
    pub(super) found: Option<Gathered>,
    /// The earliest pair of triangles so far, in a search for first contact.
    pub(super) best: Option<Witness>,
    /// What its open jobs could still reach, and how many were open when that was computed.
    pub(super) reach: Option<(usize, Supports)>,
}

impl TaskState {
    /// Whether this is a search for first contact.
    pub(super) fn is_first_contact(&self) -> bool {
        matches!(self.purpose, Purpose::FirstContact)
    }

    /// A job that was handed out, with its bound.
    pub(super) fn handed(&self, pair: NodePair) -> OpenPair {
        let out = self.out.iter().find(|out| out.pair == pair);
        out.copied().unwrap_or(OpenPair { pair, from_m: f32::NEG_INFINITY })
    }

    /// The travel after which first contact is certainly not (m).
    pub(super) fn limit_m(&self) -> f64 {
        self.best.map_or(self.wire.travels_m[1], |best| best.travel_m)
    }

    /// Takes a pair of triangles that touches; `false` if it is not the earliest so far.
    pub(super) fn improve(&mut self, witness: Witness) -> bool {
        let is_earlier = self.best.is_none_or(|best| witness.order(&best).is_lt());
        if is_earlier {
            self.best = Some(witness);
            // What is sent from now on does not look any further.
            self.wire.travels_m[1] = witness.travel_m;
        }
        is_earlier
    }

    /// The travel before which nothing touches, as far as its jobs show (m).
    pub(super) fn open_from_m(&self) -> Option<f64> {
        let open = self.out.iter().chain(&self.lost).map(|open| open.from_m);
        open.chain(self.front.first_m()).min_by(f32::total_cmp).map(f64::from)
    }

    /// The question as the kernel takes it, up to the earliest contact so far.
    pub(super) fn sweep_task<'b>(
        &self,
        views: (&BodyView<'b>, &BodyView<'b>),
    ) -> Option<SweepTask<'b>> {
        let sweep = executor::sweep(&self.wire)?;
        Some(SweepTask { a: *views.0, b: *views.1, pose: super::pose_of(&self.wire), sweep })
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
