//! Buffers for the work of requests, kept from one to the next, so that none is allocated again.
//!
//! Lists are cleared rather than dropped, and elements with buffers of their own are kept as spares
//! for the next element of their kind. Only capacity, and what depends on the bodies alone, passes
//! from one request to the next; no finding does.

use super::task::TaskLists;
use super::{Outlook, TaskState};
use crate::candidate_state::CandidateState;
use crate::gather::Gathered;
use crate::request::Request;
use crate::strategy::Prospect;
use body::{BodyView, Meta, Zones};
use bvh::{NodePair, section};
use protocol::{WireQuestion, WireTask};
use std::collections::VecDeque;

/// What [`super::SurveyRun::into_buffers`] returns and [`super::SurveyRun::with_buffers`] takes.
///
/// It must not be used with other bodies: it holds the zones of its own.
#[derive(Debug, Default)]
pub(crate) struct SurveyBuffers {
    pub(super) zones: Vec<Vec<Zones>>,
    pub(super) candidate_states: Vec<CandidateState>,
    pub(super) tasks: Vec<TaskState>,
    pub(super) waiting: VecDeque<u32>,
    pub(super) pairs: Vec<NodePair>,
    pub(super) asked: Vec<(usize, f64, WireQuestion)>,
    pub(super) outlook: Outlook,
    pub(super) spare: BufferPool,
}

/// Spare elements.
#[derive(Debug, Default)]
pub(super) struct BufferPool {
    candidate_states: Vec<CandidateState>,
    tasks: Vec<TaskLists>,
    #[expect(clippy::vec_box, reason = "each goes into a task and comes back as it is")]
    pub(super) gathered: Vec<Box<Gathered>>,
    pub(super) rests: Vec<Vec<NodePair>>,
    pub(super) prospects: Vec<Prospect>,
}

impl SurveyBuffers {
    /// These buffers, cleared for a request.
    pub(super) fn for_request(
        mut self,
        request: &Request,
        bodies: &[(Meta, BodyView<'_>)],
    ) -> Self {
        if self.zones.is_empty() {
            self.zones.extend(bodies.iter().map(|(_, body)| section::zones(body)));
        }
        self.waiting.clear();
        self.asked.clear();
        let spare = &mut self.spare;
        for state in &mut self.tasks {
            spare.gathered.extend(state.found.take());
            spare.rests.extend(state.rests.drain(..).map(|(_, rest)| rest));
        }
        // The last spare is taken first: a request like the last one gets each in its old place.
        spare.tasks.extend(self.tasks.drain(..).rev().map(TaskState::into_lists));
        spare.candidate_states.extend(self.candidate_states.drain(..).rev());
        for candidate in &request.candidates {
            let used = spare.candidate_states.pop();
            let fresh = || CandidateState::new(candidate);
            self.candidate_states.push(used.map_or_else(fresh, |used| used.reset_for(candidate)));
        }
        Self { outlook: self.outlook.reset_for(request), ..self }
    }
}

impl BufferPool {
    /// The state of a new task.
    pub(super) fn state(
        &mut self,
        candidate: usize,
        (stop, travel_m): (usize, f64),
        wire: WireTask,
    ) -> TaskState {
        let TaskLists { todo, out, lost, rests } = self.tasks.pop().unwrap_or_default();
        TaskState {
            candidate,
            stop,
            travel_m,
            wire,
            is_descended: false,
            todo,
            out,
            lost,
            rests,
            done: 0,
            found: None,
            reach: None,
        }
    }

    /// An empty result for bodies of these numbers of triangles.
    pub(super) fn gathered(&mut self, [triangles_a, triangles_b]: [usize; 2]) -> Box<Gathered> {
        match self.gathered.pop() {
            Some(mut used) => {
                used.reset_for(triangles_a, triangles_b);
                used
            }
            None => Box::new(Gathered::with_room(triangles_a, triangles_b)),
        }
    }
}
