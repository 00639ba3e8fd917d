//! One request, from the bytes of a client to its answer: checked, ranked, encoded.
//!
//! The service and its in-process counterpart share this path.

use crate::answer::lay_out;
use crate::ask::{self, Checked, Lists, Refusal};
use crate::deployment::Deployment;
use body::{BodyView, Meta};
use bvh::support::Extremes;
use coordinator::{
    Backend, BodySet, RankingRequest, RankingWorkspace, RequestLimits, RunError, WorkerPoolError,
};
use damage::{Curves, Policy};
use diagnostic::chain;
use protocol::public::{Ask, Reason, WireAnswer};
use runtime::clock;
use std::sync::Arc;

/// Ranks requests about the bodies of a deployment. It is reused between requests, and allocates
/// nothing once it is warm.
#[derive(Debug)]
pub(crate) struct Ranker<'s> {
    deployment: &'s Deployment,
    bodies: &'s [(Meta, BodyView<'s>)],
    /// Extreme points of each body.
    extremes: Vec<Extremes>,
    rules: (Arc<Policy>, Arc<Curves>),
    depth: u32,
    lists: Lists,
    workspace: RankingWorkspace,
}

/// An answered request, and when its stages ended (ns).
pub(crate) struct Ranked {
    pub(crate) answer: WireAnswer,
    pub(crate) planned_ns: u64,
    pub(crate) worked_ns: u64,
    pub(crate) done_ns: u64,
}

/// Why a checked request has no answer.
pub(crate) enum Unranked {
    Refused(Refusal),
    WorkerPool(WorkerPoolError),
}

impl<'s> Ranker<'s> {
    pub(crate) fn new(
        deployment: &'s Deployment,
        bodies: &'s [(Meta, BodyView<'s>)],
        rules: (Arc<Policy>, Arc<Curves>),
        depth: u32,
    ) -> Self {
        let extremes = bodies.iter().map(|(_, body)| Extremes::of(body)).collect();
        let (lists, workspace) = (Lists::default(), RankingWorkspace::default());
        Self { deployment, bodies, extremes, rules, depth, lists, workspace }
    }

    /// Checks every value of a request.
    pub(crate) fn check(&mut self, ask: &Ask) -> Result<Checked, Refusal> {
        let lists = core::mem::take(&mut self.lists);
        ask::check(ask, self.deployment, self.bodies, lists)
    }

    /// Ranks a checked request; `limits` gives its limits once it is planned.
    pub(crate) fn rank(
        &mut self,
        sequence: u64,
        checked: Checked,
        limits: impl FnOnce() -> RequestLimits,
        backend: &mut Backend,
    ) -> Result<Ranked, Unranked> {
        let stage =
            BodySet { bodies: self.bodies, extremes: Some(&self.extremes), depth: self.depth };
        let inquiry = RankingRequest {
            scenario: &checked.scenario,
            models: &checked.models,
            rules: self.rules.clone(),
            job_history: false,
        };
        let told = self.workspace.rank(&stage, inquiry, limits, backend, |work, course| {
            (work.view(|view| lay_out(sequence, view)), course)
        });
        let has_unknown = checked.has_unknown;
        self.lists = checked.into_room();
        let (answer, course) = told.map_err(|error| match error {
            RunError::Request(error) => unassessable(&error),
            RunError::WorkerPool(error) => Unranked::WorkerPool(error),
        })?;
        let mut answer = answer.map_err(|error| unassessable(&error))?;
        if has_unknown && answer.verdict().has_ranking() {
            answer.say("parties of unknown kind were taken as fixed, with nobody in them");
        }
        let done_ns = clock::now_ns();
        let (planned_ns, worked_ns) = (course.planned_ns, course.worked_ns);
        Ok(Ranked { answer, planned_ns, worked_ns, done_ns })
    }
}

fn unassessable(error: &coordinator::RequestError) -> Unranked {
    Unranked::Refused(Refusal { reason: Reason::Unassessable, text: chain(error) })
}
