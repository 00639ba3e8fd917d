//! The job history of a request: what was asked, how each job ended, and what was known when.
//!
//! Questions are identified by candidate and travel, never by task number, which depends on the
//! order in which answers arrived. So a job history can be replayed in any order.

use crate::candidate_state::Purpose;
use crate::work::TaskState;
use dispatch::{Closed, Job};
use protocol::TaskId;
use record::{PoseQuestion, RecordedEnd, RecordedFirst, RecordedJob, RecordedMoment};
use runtime::clock;
use std::collections::{BTreeMap, BTreeSet};

/// What was recorded of one request.
#[derive(Clone, Debug, PartialEq)]
pub struct JobHistory {
    /// Questions, in the order in which they were asked. One without jobs was answered by its
    /// traversal alone.
    pub places: Vec<PoseQuestion>,
    /// Jobs, in the order in which they were closed.
    pub jobs: Vec<RecordedJob>,
    /// What was known over time.
    pub moments: Vec<RecordedMoment>,
    /// Number in `places` of each task that was asked.
    of_task: Vec<Option<u32>>,
    begun_ns: u64,
}

impl JobHistory {
    pub(crate) fn new() -> Self {
        Self {
            places: Vec::new(),
            jobs: Vec::new(),
            moments: Vec::new(),
            of_task: Vec::new(),
            begun_ns: clock::now_ns(),
        }
    }

    /// Notes that a question was asked: its jobs, if any, exist from now on.
    pub(crate) fn ask(&mut self, task: TaskId, state: &TaskState) {
        let task = task.0 as usize;
        self.of_task.resize(self.of_task.len().max(task + 1), None);
        self.of_task[task] = Some(self.places.len() as u32);
        self.places.push(state.place());
    }

    /// Notes what is known of the first contact that a question asks for.
    pub(crate) fn narrow(&mut self, task: TaskId, first: RecordedFirst) {
        let place = self.of_task.get(task.0 as usize).copied().flatten();
        if let Some(place) = place.and_then(|place| self.places.get_mut(place as usize)) {
            place.first = Some(first);
        }
    }

    /// Notes that a job of a question that was asked has ended.
    pub(crate) fn close(&mut self, job: &Job, how: Closed) {
        let Some(place) = self.of_task.get(job.task.0 as usize).copied().flatten() else { return };
        let end = match how {
            Closed::Done => RecordedEnd::Done,
            Closed::Cut => RecordedEnd::Cut,
            Closed::Abandoned | Closed::Late => RecordedEnd::Abandoned,
        };
        self.jobs.push(RecordedJob { place, a: job.a.node, b: job.b.node, end });
    }

    pub(crate) fn note(&mut self, state: String, work: Vec<[f64; 2]>) {
        let at_ns = clock::now_ns().saturating_sub(self.begun_ns);
        self.moments.push(RecordedMoment { at_ns, jobs: self.jobs.len() as u64, state, work });
    }
}

impl TaskState {
    /// The question of this state, without its task number.
    fn place(&self) -> PoseQuestion {
        let is_survey = matches!(self.purpose, Purpose::Survey { .. });
        let candidate = self.candidate as u32;
        PoseQuestion { candidate, is_survey, travel_m: self.travel_m, first: None }
    }

    fn key(&self) -> Key {
        key(&self.place())
    }
}

/// A comparable key of a question: candidate, whether a survey asked, bits of the travel.
type Key = (u32, bool, u64);

fn key(place: &PoseQuestion) -> Key {
    (place.candidate, place.is_survey, place.travel_m.to_bits())
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

/// What a recorded job history knows of first contacts, by question.
#[derive(Clone, Debug)]
pub(crate) struct Firsts(BTreeMap<Key, RecordedFirst>);

impl Firsts {
    pub(crate) fn of(places: &[PoseQuestion]) -> Self {
        Self(places.iter().filter_map(|place| Some((key(place), place.first?))).collect())
    }

    /// What is known of the one that a question asks for.
    pub(crate) fn of_state(&self, state: &TaskState) -> Option<RecordedFirst> {
        self.0.get(&state.key()).copied()
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
