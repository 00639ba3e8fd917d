//! The job history of a round of contacts: what was asked, and how each job ended.
//!
//! Questions are identified by candidate and travel, never by task number, which depends on the
//! order in which answers arrived. So a job history can be replayed in any order.

use crate::work::TaskState;
use dispatch::{Closed, Job};
use protocol::TaskId;
use record::{PoseQuestion, RecordedEnd, RecordedJob, RecordedRound};
use std::collections::{BTreeMap, BTreeSet};

/// What was recorded of one round of contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct JobHistory {
    /// Questions and jobs.
    pub(crate) round: RecordedRound,
    /// Number in `round.places` of each task that was asked.
    of_task: Vec<Option<u32>>,
}

impl JobHistory {
    /// Notes that a question was asked: its jobs, if any, exist from now on.
    pub(crate) fn ask(&mut self, task: TaskId, state: &TaskState) {
        let task = task.0 as usize;
        self.of_task.resize(self.of_task.len().max(task + 1), None);
        self.of_task[task] = Some(self.round.places.len() as u32);
        self.round.places.push(state.place());
    }

    /// Notes that a job of a question that was asked has ended.
    pub(crate) fn close(&mut self, job: &Job, how: Closed) {
        let Some(place) = self.of_task.get(job.task.0 as usize).copied().flatten() else { return };
        let end = match how {
            Closed::Done => RecordedEnd::Done,
            Closed::Cut => RecordedEnd::Cut,
            Closed::Abandoned | Closed::Late => RecordedEnd::Abandoned,
        };
        self.round.jobs.push(RecordedJob { place, a: job.a.node, b: job.b.node, end });
    }
}

impl TaskState {
    /// The question of this state, without its task number.
    fn place(&self) -> PoseQuestion {
        PoseQuestion { candidate: self.candidate as u32, travel_m: self.travel_m }
    }

    fn key(&self) -> Key {
        key(&self.place())
    }
}

/// A comparable key of a question: candidate, bits of the travel.
type Key = (u32, u64);

fn key(place: &PoseQuestion) -> Key {
    (place.candidate, place.travel_m.to_bits())
}

/// The questions of a recorded job history. Anything else that a replay would ask was not asked in
/// time.
#[derive(Clone, Debug)]
pub(crate) struct Asked(BTreeSet<Key>);

impl Asked {
    pub(crate) fn of(places: &[PoseQuestion]) -> Self {
        Self(places.iter().map(key).collect())
    }

    /// Whether it was asked.
    pub(crate) fn has(&self, state: &TaskState) -> bool {
        self.0.contains(&state.key())
    }
}

/// How the jobs of a recorded job history ended, by question.
#[derive(Clone, Debug)]
pub(crate) struct Ends(BTreeMap<(Key, (u32, u32)), RecordedEnd>);

impl Ends {
    pub(crate) fn of(places: &[PoseQuestion], jobs: &[RecordedJob]) -> Self {
        let keyed_end = |job: &RecordedJob| {
            let asked = key(places.get(job.place as usize)?);
            Some(((asked, (job.a, job.b)), job.end))
        };
        Self(jobs.iter().filter_map(keyed_end).collect())
    }

    /// How a job ended; `None` if it never did.
    pub(crate) fn end(&self, state: &TaskState, job: &Job) -> Option<RecordedEnd> {
        self.0.get(&(state.key(), (job.a.node, job.b.node))).copied()
    }
}
