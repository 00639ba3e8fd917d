//! One request without a service: checked, worked off and laid out in the caller's process.
//!
//! It is what the service does between taking a request and answering it, so it says what an answer
//! must be, and what the service itself costs.

use crate::answer::lay_out;
use crate::ask::{self, Lists, Refusal};
use crate::deployment::Deployment;
use body::{BodyView, Meta};
use bvh::support::Extremes;
use coordinator::{Candidates, InProcessExecutor, Request, Room, Work};
use damage::{Curves, Policy};
use protocol::public::{Answer, Ask, Reason, Verdict};
use std::sync::Arc;

/// Where requests are answered in this process, as a service with these settings would.
#[derive(Debug)]
pub struct Here<'b> {
    deployment: &'b Deployment,
    bodies: &'b [(Meta, BodyView<'b>)],
    extremes: Vec<Extremes>,
    rules: (Arc<Policy>, Arc<Curves>),
    depth: u32,
    lists: Lists,
    candidates: Candidates,
    room: Room,
    executor: InProcessExecutor,
}

impl<'b> Here<'b> {
    /// Made once, as a service is.
    #[must_use]
    pub fn new(
        deployment: &'b Deployment,
        bodies: &'b [(Meta, BodyView<'b>)],
        (policy, curves): (Policy, Curves),
        depth: u32,
    ) -> Self {
        let extremes = bodies.iter().map(|(_, body)| Extremes::of(body)).collect();
        let rules = (Arc::new(policy), Arc::new(curves));
        let (lists, candidates) = (Lists::default(), Candidates::default());
        let (room, executor) = (Room::default(), InProcessExecutor::with_room_for(bodies));
        Self { deployment, bodies, extremes, rules, depth, lists, candidates, room, executor }
    }

    /// Answers a request.
    #[must_use]
    pub fn answer(&mut self, ask: &Ask) -> Answer {
        self.ranked(ask).unwrap_or_else(|Refusal { reason, text }| {
            Answer::without_ranking(ask.sequence, Verdict::Refused, reason, &text)
        })
    }

    fn ranked(&mut self, ask: &Ask) -> Result<Answer, Refusal> {
        let unassessable = |error: coordinator::RequestError| Refusal {
            reason: Reason::Unassessable,
            text: error.to_string(),
        };
        let lists = core::mem::take(&mut self.lists);
        let checked = ask::check(ask, self.deployment, self.bodies, lists)?;
        let candidates = core::mem::take(&mut self.candidates);
        let models = (&checked.models[..], &self.extremes[..]);
        let (scenario, rules) = (&checked.scenario, self.rules.clone());
        let request = Request::with_models(scenario, self.bodies, models, rules, candidates);
        let request = request.map_err(unassessable)?;
        let room = core::mem::take(&mut self.room);
        let mut work = Work::in_room(&request, self.bodies, self.depth, room);
        self.executor.work_off(&mut work);
        let answer = work.brief(|brief| lay_out(ask.sequence, brief));
        self.room = work.into_room();
        (self.candidates, self.lists) = (request.into_room(), checked.into_room());
        answer.map_err(unassessable)
    }
}
