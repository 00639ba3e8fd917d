//! What is wanted of an answer, and how far and by when it is worked on, as a person asks for it.

use clap::Args;
use std::path::PathBuf;
use trolley::{Failure, Limits, Until};

/// What is done with an answer, and what may be assumed for it.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct AnswerArgs {
    /// Print the chain from contact to rank, with every source, and what would flip the winner.
    #[arg(long)]
    pub(crate) explain: bool,
    /// Take parties of unknown kind as fixed to the ground, with nobody in them; the answer says
    /// so. Without it a scenario that has any is refused.
    #[arg(long, value_name = "unknown=fixed")]
    pub(crate) assume: Option<Assume>,
    /// Add a decision record to this folder: what was asked, decided, and by what.
    #[arg(long, value_name = "DIR", conflicts_with = "budget")]
    pub(crate) record: Option<PathBuf>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// What may be assumed of what nobody knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Assume {
    /// Unknown things are fixed to the ground.
    #[value(name = "unknown=fixed")]
    UnknownFixed,
}

/// When to stop.
#[derive(Clone, Debug, Default, Args)]
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
    #[arg(long, value_name = "TESTS")]
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
    /// The limits, with nothing kept beside the answer.
    pub(crate) fn limits(&self) -> Result<Limits, Failure> {
        let mut limits = Limits::default().until(match self.until {
            UntilName::Complete => Until::Complete,
            UntilName::Ordered => Until::Ordered,
            UntilName::Certified => Until::Certified,
        });
        if let Some(ms) = self.deadline_ms {
            limits = limits.with_deadline_ms(ms)?;
        }
        match self.budget {
            Some(tests) => limits.with_budget(tests),
            None => Ok(limits),
        }
    }
}

impl AnswerArgs {
    /// The limits, and what is kept beside the answer.
    pub(crate) fn limits(&self) -> Result<Limits, Failure> {
        let limits = self.limits.limits()?;
        Ok(match (&self.record, self.explain) {
            (Some(_), _) => limits.with_record(),
            (None, true) => limits.with_explanation(),
            (None, false) => limits,
        })
    }
}
