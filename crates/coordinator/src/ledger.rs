//! The ledger of a request: which jobs ended how, and what was known when.
//!
//! Questions are named by candidate and travel, never by the number that they happened to get: that
//! depends on the order in which answers came in. So a ledger can be replayed in any order.

use crate::case::Aim;
use crate::work::Errand;
use dispatch::{Closed, Spec};
use record::{End, Job, Moment, Place};
use runtime::clock;
use std::collections::BTreeMap;

/// What was kept of one request.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger {
    /// Questions that had jobs.
    pub places: Vec<Place>,
    /// Jobs, in the order in which they were closed.
    pub jobs: Vec<Job>,
    /// What was known over time.
    pub moments: Vec<Moment>,
    /// Number in `places` of each task that has one.
    of_task: Vec<Option<u32>>,
    begun_ns: u64,
}

impl Ledger {
    pub(crate) fn new() -> Self {
        Self {
            places: Vec::new(),
            jobs: Vec::new(),
            moments: Vec::new(),
            of_task: Vec::new(),
            begun_ns: clock::now_ns(),
        }
    }

    pub(crate) fn close(&mut self, errand: &Errand, job: &Spec, how: Closed) {
        let task = job.task.0 as usize;
        if self.of_task.len() <= task {
            self.of_task.resize(task + 1, None);
        }
        let place = *self.of_task[task].get_or_insert_with(|| {
            self.places.push(errand.place());
            self.places.len() as u32 - 1
        });
        let end = match how {
            Closed::Done => End::Done,
            Closed::Cut => End::Cut,
            Closed::Abandoned | Closed::Late => End::Abandoned,
        };
        self.jobs.push(Job { place, a: job.a.node, b: job.b.node, end });
    }

    pub(crate) fn note(&mut self, state: String, work: Vec<[f64; 2]>) {
        let at_ns = clock::now_ns().saturating_sub(self.begun_ns);
        self.moments.push(Moment { at_ns, jobs: self.jobs.len() as u64, state, work });
    }
}

impl Errand {
    /// What this errand asks, without its number.
    fn place(&self) -> Place {
        let is_survey = matches!(self.aim, Aim::Survey { .. });
        Place { candidate: self.case as u32, is_survey, travel_m: self.travel_m }
    }

    fn key(&self) -> (u32, bool, u64) {
        key(&self.place())
    }
}

fn key(place: &Place) -> (u32, bool, u64) {
    (place.candidate, place.is_survey, place.travel_m.to_bits())
}

/// The ends of a recorded ledger, by what was asked.
#[derive(Clone, Debug)]
pub(crate) struct Ends(BTreeMap<(u32, bool, u64, u32, u32), End>);

impl Ends {
    pub(crate) fn of(places: &[Place], jobs: &[Job]) -> Self {
        let one = |job: &Job| {
            let (candidate, is_survey, travel) = key(places.get(job.place as usize)?);
            Some(((candidate, is_survey, travel, job.a, job.b), job.end))
        };
        Self(jobs.iter().filter_map(one).collect())
    }

    /// How a job ended; `None` if it never did.
    pub(crate) fn end(&self, errand: &Errand, job: &Spec) -> Option<End> {
        let (candidate, is_survey, travel) = errand.key();
        self.0.get(&(candidate, is_survey, travel, job.a.node, job.b.node)).copied()
    }
}
