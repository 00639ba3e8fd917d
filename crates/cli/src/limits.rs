//! How far and by when a request is worked on, as a person asks for it.

use crate::args::AnswerArgs;
use clap::Args as ClapArgs;
use trolley::{Failure, Limits, Until};

/// When to stop.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct LimitArgs {
    /// Stop when all work is done, when the order is certain, or when the winner is.
    #[arg(long, value_name = "WHEN", default_value = "complete")]
    until: UntilName,
    /// Answer after so many milliseconds at the latest, with bounds on what is not done; overrides
    /// the scenario's `deadline_ms`. The clock starts when bodies are sealed and workers ready.
    #[arg(long, value_name = "N")]
    deadline_ms: Option<f64>,
    /// Most tests of boxes and triangles that one job may take; what it leaves becomes new jobs
    /// [default: no limit, or 262144 under a deadline].
    #[arg(long, value_name = "TESTS", conflicts_with = "record")]
    budget: Option<u64>,
}

/// [`Until`] by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum UntilName {
    /// All work is done.
    #[default]
    Complete,
    /// No open work can change the order.
    Ordered,
    /// No open work can change the winner.
    Certified,
}

impl LimitArgs {
    /// The limits, and what is kept beside the answer.
    pub(crate) fn limits(&self, asked: &AnswerArgs) -> Result<Limits, Failure> {
        let is_recorded = asked.record.is_some();
        let mut limits = Limits {
            until: match self.until {
                UntilName::Complete => Until::Complete,
                UntilName::Ordered => Until::Ordered,
                UntilName::Certified => Until::Certified,
            },
            explanation: asked.explain || is_recorded,
            ledger: is_recorded,
            ..Limits::default()
        };
        if let Some(ms) = self.deadline_ms {
            limits = limits.with_deadline_ms(ms)?;
        }
        match self.budget {
            Some(tests) => limits.with_budget(tests),
            None => Ok(limits),
        }
    }
}
