//! How far, by when and in which order a request is worked on, as a person asks for it.

use crate::run::milliseconds;
use clap::Args as ClapArgs;
use coordinator::{Certainty, Pursuit, Terms, Until, Work};
use diagnostic::Failure;
use serde::Serialize;
use std::time::Duration;

/// Least budget: two full leaves are tested in one step.
const BUDGET_MIN: u64 = 2 * bvh::kernel::STEP_TESTS;
/// Longest deadline (ms), as in scenarios.
const DEADLINE_MS: f64 = 3_600_000.0;

/// When to stop, and what goes out next.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct TermsArgs {
    /// Stop when all work is done, when the order is certain, or when the winner is.
    #[arg(long, value_name = "WHEN", default_value = "complete")]
    pub(crate) until: UntilName,
    /// Answer after so many milliseconds at the latest, with bounds on what is not done; overrides
    /// the scenario's `deadline_ms`. The clock starts when bodies are sealed and workers ready.
    #[arg(long, value_name = "N")]
    pub(crate) deadline_ms: Option<f64>,
    /// Whose job goes out next [default: as-asked, or deciding where the answer may come early].
    #[arg(long, value_name = "HOW")]
    pub(crate) pursuit: Option<PursuitName>,
    /// Most tests of boxes and triangles that one job may take; what it leaves becomes new jobs
    /// [default: no limit, or 262144 under a deadline].
    #[arg(long, value_name = "TESTS", conflicts_with = "record")]
    pub(crate) budget: Option<u64>,
}

/// [`Until`] by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum UntilName {
    /// All work is done.
    #[default]
    Complete,
    /// No open work can change the order.
    Ordered,
    /// No open work can change the winner.
    Certified,
}

/// [`Pursuit`] by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PursuitName {
    /// In the order in which questions come up.
    AsAsked,
    /// One candidate after the other.
    Sequential,
    /// Each candidate in turn.
    RoundRobin,
    /// Incumbent and challenger in turn.
    Alternating,
    /// Contact first, then incumbent or challenger, whichever is less known.
    Deciding,
}

/// How a deadline was kept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Kept {
    /// When the answer was due, after the request was accepted.
    pub(crate) due_ms: f64,
    /// When it was made.
    pub(crate) answered_ms: f64,
    /// How much later than due that was; 0 if it was not.
    pub(crate) late_ms: f64,
}

/// When something became certain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct Certain {
    /// Tests of boxes and triangles by then, in units of all that were done.
    pub(crate) share: f64,
    /// Jobs done by then.
    pub(crate) jobs: u64,
    /// Time since the request was accepted.
    pub(crate) ms: f64,
}

impl TermsArgs {
    /// The terms, with the scenario's deadline where none is asked for.
    pub(crate) fn terms(
        &self,
        scenario: Option<Duration>,
        is_recorded: bool,
    ) -> Result<Terms, Failure> {
        let deadline = match self.deadline_ms {
            Some(ms) if (0.001..=DEADLINE_MS).contains(&ms) => {
                Some(Duration::from_secs_f64(ms / 1e3))
            }
            Some(ms) => {
                let fault = format!("--deadline-ms is {ms}");
                let help = format!("--deadline-ms may be 0.001 to {DEADLINE_MS}");
                return Err(Failure::setting(fault).with_remedy(help));
            }
            None => scenario,
        };
        if let Some(budget) = self.budget.filter(|budget| *budget < BUDGET_MIN) {
            let fault = format!("--budget is {budget}");
            let help = format!("--budget may be {BUDGET_MIN} or more: a step of a job takes half");
            return Err(Failure::setting(fault).with_remedy(help));
        }
        let until = match self.until {
            UntilName::Complete => Until::Complete,
            UntilName::Ordered => Until::Ordered,
            UntilName::Certified => Until::Certified,
        };
        let is_early = until != Until::Complete || deadline.is_some();
        let pursuit = match self.pursuit {
            Some(PursuitName::AsAsked) => Pursuit::AsAsked,
            Some(PursuitName::Sequential) => Pursuit::Sequential,
            Some(PursuitName::RoundRobin) => Pursuit::RoundRobin,
            Some(PursuitName::Alternating) => Pursuit::Alternating,
            Some(PursuitName::Deciding) => Pursuit::Deciding,
            None if is_early => Pursuit::Deciding,
            None => Pursuit::AsAsked,
        };
        // A replay makes the jobs of a ledger again, and knows of no parts of them.
        let budget = match (self.budget, deadline) {
            (Some(budget), _) => budget,
            (None, Some(_)) if !is_recorded => Terms::BUDGET,
            (None, _) => u64::MAX,
        };
        let deadline_ns = deadline.map(Terms::guarded);
        Ok(Terms { until, deadline_ns, pursuit, budget })
    }

    /// When an answer is due after the request was accepted.
    pub(crate) fn deadline(&self, scenario: Option<Duration>) -> Option<Duration> {
        self.deadline_ms.map(|ms| Duration::from_secs_f64(ms / 1e3)).or(scenario)
    }
}

impl Kept {
    /// Of an answer that took so long (ns).
    pub(crate) fn of(due: Duration, answered_ns: u64) -> Self {
        let (due_ms, answered_ms) = (due.as_secs_f64() * 1e3, milliseconds(answered_ns));
        Self { due_ms, answered_ms, late_ms: (answered_ms - due_ms).max(0.0) }
    }
}

/// When winner and order were certain.
pub(crate) fn certain(work: &Work<'_>) -> [Option<Certain>; 2] {
    let effort = work.effort();
    let all = (effort.descent.tests() + effort.jobs.tests()).max(1) as f64;
    let one = |certainty: Certainty| Certain {
        share: certainty.tests as f64 / all,
        jobs: certainty.jobs,
        ms: milliseconds(certainty.ns),
    };
    work.certainties().map(|certainty| certainty.map(one))
}
