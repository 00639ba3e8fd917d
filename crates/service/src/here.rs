//! One request without a service: checked, worked off and laid out in the caller's process.
//!
//! It is what the service does between taking a request and answering it, so it says what an answer
//! must be, and what the service itself costs.

use crate::answer::lay_out;
use crate::ask::{self, Refusal};
use crate::deployment::Deployment;
use coordinator::{Request, Work, run_here};
use damage::{Curves, Policy};
use model::{BodyView, Meta};
use protocol::public::{Answer, Ask, Reason, Verdict};

/// Answers a request in this process, as a service with these settings would.
#[must_use]
pub fn answer_here(
    ask: &Ask,
    deployment: &Deployment,
    bodies: &[(Meta, BodyView<'_>)],
    (policy, curves): (&Policy, &Curves),
    depth: u32,
) -> Answer {
    let refused = |reason: Reason, text: &str| {
        Answer::without_ranking(ask.sequence, Verdict::Refused, reason, text)
    };
    let checked = match ask::check(ask, deployment, bodies) {
        Ok(checked) => checked,
        Err(Refusal { reason, text }) => return refused(reason, &text),
    };
    let (policy, curves) = (policy.clone(), curves.clone());
    let models = &checked.models;
    let request = Request::with_models(&checked.scenario, bodies, models, policy, curves);
    let request = match request {
        Ok(request) => request,
        Err(error) => return refused(Reason::Unassessable, &error.to_string()),
    };
    let mut work = Work::new(&request, bodies, depth);
    run_here(&mut work, bodies);
    match work.answer() {
        Ok(answer) => lay_out(ask.sequence, &answer),
        Err(error) => refused(Reason::Unassessable, &error.to_string()),
    }
}
