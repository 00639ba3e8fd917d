//! One request without a service: checked, executed and encoded in the caller's process.
//!
//! It does what the service does between receiving a request and answering it, so it shows what an
//! answer must be, and what the service itself costs.

use crate::ask::Refusal;
use crate::deployment::Deployment;
use crate::ranker::{Ranker, Unranked};
use body::{BodyView, Meta};
use coordinator::{Backend, InProcessExecutor, RequestLimits};
use damage::Criteria;
use protocol::public::{Ask, Reason, WireAnswer, WireState};

/// Answers requests in this process, as a service with these settings would.
#[derive(Debug)]
pub struct InProcess<'b> {
    ranker: Ranker<'b>,
    backend: Backend,
}

impl<'b> InProcess<'b> {
    /// Sets up everything once, like a service.
    #[must_use]
    pub fn new(
        deployment: &'b Deployment,
        bodies: &'b [(Meta, BodyView<'b>)],
        criteria: Criteria,
        depth: u32,
    ) -> Self {
        let executor = InProcessExecutor::with_room_for(bodies);
        let backend = Backend::InProcess(Box::new(executor));
        Self { ranker: Ranker::new(deployment, bodies, criteria, depth), backend }
    }

    /// Answers a request.
    ///
    /// Nothing lies between the caller and here, so its checksum does not count.
    #[must_use]
    pub fn answer(&mut self, ask: &Ask) -> WireAnswer {
        let answer = self.ranked(ask).unwrap_or_else(|Refusal { reason, text }| {
            WireAnswer::without_ranking(ask.sequence, WireState::Refused, reason, &text)
        });
        answer.sealed()
    }

    fn ranked(&mut self, ask: &Ask) -> Result<WireAnswer, Refusal> {
        let checked = self.ranker.check(ask)?;
        let limits = RequestLimits::default();
        let ranked = self.ranker.rank(ask.sequence, &checked, limits, &mut self.backend);
        match ranked {
            Ok(ranked) => Ok(ranked.answer),
            Err(Unranked::Refused(refusal)) => Err(refusal),
            // Without workers none can be lost.
            Err(Unranked::WorkerPool(error)) => {
                Err(Refusal { reason: Reason::Internal, text: error.to_string() })
            }
        }
    }
}
