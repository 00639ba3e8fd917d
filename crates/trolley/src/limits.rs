//! How far, by when, in which order and in how large pieces a request is worked on.

use crate::{Failure, FailureKind};
use coordinator::{RequestLimits, SearchOrder, Until};
use core::time::Duration;

/// Least budget: two full leaves are tested in one step.
const BUDGET_MIN: u64 = 2 * bvh::kernel::STEP_TESTS;
/// Longest deadline (ms), as in scenarios.
const DEADLINE_MS: f64 = 3_600_000.0;

/// When to stop, and what is kept beside the answer. None of it changes a complete answer.
///
/// ```
/// let limits = trolley::Limits::default().with_deadline_ms(20.0)?;
/// assert!(trolley::Limits::default().with_deadline_ms(f64::NAN).is_err());
/// # Ok::<(), trolley::Failure>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    until: Until,
    search_order: Option<SearchOrder>,
    explanation: bool,
    job_history: bool,
    deadline: Option<Duration>,
    budget: Option<u64>,
}

impl Limits {
    /// The same, stopping as soon as so much is certain.
    #[must_use]
    pub fn until(self, until: Until) -> Self {
        Self { until, ..self }
    }

    /// The same, with jobs in this order, and not in the one that suits deadline and certainty.
    #[must_use]
    pub fn with_search_order(self, search_order: SearchOrder) -> Self {
        Self { search_order: Some(search_order), ..self }
    }

    /// The same, with the chain from contact to rank beside the answer, and every source.
    #[must_use]
    pub fn with_explanation(self) -> Self {
        Self { explanation: true, ..self }
    }

    /// The same, with all that a [`RecordContent`](crate::RecordContent) needs: an explanation, and a job history of
    /// questions and jobs.
    #[must_use]
    pub fn with_record(self) -> Self {
        Self { explanation: true, job_history: true, ..self }
    }

    pub(crate) fn wants_explanation(&self) -> bool {
        self.explanation
    }

    pub(crate) fn wants_job_history(&self) -> bool {
        self.job_history
    }

    /// The same with an answer after so many milliseconds at the latest, and bounds on what is not
    /// done by then; in place of the scenario's deadline. The clock starts when bodies are sealed
    /// and workers ready.
    ///
    /// # Errors
    ///
    /// If it is not 0.001 to 3,600,000 ms.
    pub fn with_deadline_ms(self, ms: f64) -> Result<Self, Failure> {
        if (0.001..=DEADLINE_MS).contains(&ms) {
            return Ok(Self { deadline: Some(Duration::from_secs_f64(ms / 1e3)), ..self });
        }
        Err(Failure::new(FailureKind::Configuration, format!("--deadline-ms is {ms}"))
            .with_remedy(format!("--deadline-ms may be 0.001 to {DEADLINE_MS}")))
    }

    /// The same with at most so many tests of boxes and triangles in one job; what it leaves
    /// becomes new jobs.
    ///
    /// # Errors
    ///
    /// If it is less than what one step of a job may take.
    pub fn with_budget(self, tests: u64) -> Result<Self, Failure> {
        if tests >= BUDGET_MIN {
            return Ok(Self { budget: Some(tests), ..self });
        }
        Err(Failure::new(FailureKind::Configuration, format!("--budget is {tests}")).with_remedy(
            format!("--budget may be {BUDGET_MIN} or more: a step of a job takes half"),
        ))
    }

    /// Refuses what cannot be together.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        match (self.budget, self.job_history) {
            (Some(_), true) => {
                let what = "a record knows of no parts of jobs, so no budget can be replayed";
                Err(Failure::setting(what).with_remedy("leave the budget out, or the record"))
            }
            _ => Ok(()),
        }
    }

    /// When the answer is due after the request was accepted; `scenario`: as the scenario says.
    #[must_use]
    pub fn deadline(&self, scenario: Option<Duration>) -> Option<Duration> {
        self.deadline.or(scenario)
    }

    /// As the coordinator takes them.
    #[must_use]
    pub fn request_limits(&self, scenario: Option<Duration>) -> RequestLimits {
        let deadline = self.deadline(scenario);
        let is_early = self.until != Until::Complete || deadline.is_some();
        let usual = if is_early { SearchOrder::Deciding } else { SearchOrder::AsAsked };
        // A replay makes the jobs of a job history again, and knows of no parts of them.
        let budget = match (self.budget, deadline) {
            (Some(budget), _) => budget,
            (None, Some(_)) if !self.job_history => RequestLimits::BUDGET,
            (None, _) => u64::MAX,
        };
        RequestLimits {
            until: self.until,
            deadline_ns: deadline.map(RequestLimits::guarded),
            search_order: self.search_order.unwrap_or(usual),
            budget,
        }
    }
}
