//! Room for the work of requests, kept from one to the next, so that none is taken from the heap.
//!
//! Lists are emptied and not dropped, and what a list held that has room of its own is laid aside
//! until the next one of its kind is wanted. Nothing that was found goes from one request to the
//! next: only capacity, and what depends on the bodies alone.

use super::{Outlook, TaskState};
use crate::bound;
use crate::brief::Judged;
use crate::case::{Aim, Case};
use crate::gather::Gathered;
use crate::request::Request;
use crate::strategy::Prospect;
use body::{BodyView, Meta};
use bvh::NodePair;
use protocol::{WireQuestion, WireTask};
use std::collections::VecDeque;

/// What [`super::RankingRun::into_room`] gives and [`super::RankingRun::in_room`] takes.
///
/// It must not be kept for other bodies: it holds their zones.
#[derive(Debug, Default)]
pub struct Room {
    pub(super) zones: Vec<u16>,
    pub(super) cases: Vec<Case>,
    pub(super) errands: Vec<TaskState>,
    pub(super) waiting: VecDeque<u32>,
    pub(super) pairs: Vec<NodePair>,
    pub(super) aims: Vec<(Aim, f64, WireQuestion)>,
    pub(super) outlook: Outlook,
    pub(super) spare: Spare,
}

/// What is laid aside.
#[derive(Debug, Default)]
pub(super) struct Spare {
    cases: Vec<Case>,
    errands: Vec<TaskState>,
    pub(super) gathered: Vec<Gathered>,
    pub(super) rests: Vec<Vec<NodePair>>,
    pub(super) prospects: Vec<Prospect>,
    pub(super) judged: Judged,
}

impl Room {
    /// Cleared for a request.
    pub(super) fn for_request(
        mut self,
        request: &Request,
        bodies: &[(Meta, BodyView<'_>)],
    ) -> Self {
        if self.zones.is_empty() {
            self.zones.extend(bodies.iter().map(|(_, body)| bound::zones(body)));
        }
        self.waiting.clear();
        self.aims.clear();
        let spare = &mut self.spare;
        for errand in &mut self.errands {
            spare.gathered.extend(errand.found.take());
            spare.rests.extend(errand.rests.drain(..).map(|(_, rest)| rest));
        }
        // The last is taken first: a request like the last one finds each in its old place.
        spare.errands.extend(self.errands.drain(..).rev());
        spare.cases.extend(self.cases.drain(..).rev());
        for candidate in &request.candidates {
            let case = spare.cases.pop();
            let case = case.map_or_else(|| Case::new(candidate), |case| case.anew(candidate));
            self.cases.push(case);
        }
        Self { outlook: self.outlook.anew(request), ..self }
    }
}

impl Spare {
    /// A task that nothing was done for.
    pub(super) fn errand(
        &mut self,
        case: usize,
        (aim, travel_m): (Aim, f64),
        wire: WireTask,
    ) -> TaskState {
        let [mut todo, mut lost] = [Vec::new(), Vec::new()];
        let (mut out, mut rests) = (VecDeque::new(), Vec::new());
        if let Some(used) = self.errands.pop() {
            (todo, out, lost, rests) = (used.todo, used.out, used.lost, used.rests);
            todo.clear();
            out.clear();
            lost.clear();
        }
        TaskState {
            case,
            aim,
            travel_m,
            wire,
            is_descended: false,
            todo,
            out,
            lost,
            rests,
            done: 0,
            is_obsolete: false,
            found: None,
            reach: None,
        }
    }

    /// Nothing found between bodies of so many triangles.
    pub(super) fn gathered(&mut self, triangles_a: usize, triangles_b: usize) -> Gathered {
        match self.gathered.pop() {
            Some(used) => used.anew(triangles_a, triangles_b),
            None => Gathered::with_room(triangles_a, triangles_b),
        }
    }
}
