//! Flags for the contents of an answer, and for when to stop.

use crate::named::named;
use clap::Args;
use std::path::PathBuf;
use trolley::{Failure, Limits, Until, Worlds};

/// What to do with an answer, and what to assume for it.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct AnswerArgs {
    /// Print the chain from contact to rank, with every source, and what would flip the winner.
    #[arg(long)]
    pub(crate) explain: bool,
    /// Treat parties of unknown kind as unoccupied and fixed to the ground; the answer says so.
    /// Without this option, a scenario with such parties is refused.
    #[arg(long, value_name = "unknown=fixed")]
    pub(crate) assume: Option<Assume>,
    /// Refuse (exit code 4) a scenario that states what is hardly true: a lorry of 25 kg, 5 m up in
    /// the air, or 2 km away. Without this option the answer says so.
    #[arg(long)]
    pub(crate) strict: bool,
    /// Add a decision record to this folder: the request, the answer, and what produced it.
    #[arg(long, value_name = "DIR", conflicts_with = "budget")]
    pub(crate) record: Option<PathBuf>,
    /// Sign the record with this secret key: Ed25519, PEM, as `openssl genpkey -algorithm ed25519`
    /// writes it. Nobody else may read the file.
    #[arg(long, value_name = "KEY", requires = "record")]
    pub(crate) sign: Option<PathBuf>,
    /// Draw N worlds, 0 to 10000, of what the model does not know [default: 200]; without members
    /// there are none.
    #[arg(long, value_name = "N", conflicts_with = "record")]
    worlds: Option<i64>,
    #[command(flatten)]
    limits: LimitArgs,
}

/// What to assume about the unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Assume {
    /// Parties of unknown kind are fixed to the ground.
    #[value(name = "unknown=fixed")]
    UnknownFixed,
}

/// When to stop.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LimitArgs {
    /// Stop when all work is done, when the order is certain, or when the winner is.
    #[arg(long, value_name = "WHEN", default_value = "complete",
          value_parser = named(Until::ALL, Until::name))]
    until: Until,
    /// Answer within N ms, with bounds on what is not done, or of fewer members, whatever
    /// `deadline_ms` the scenario has. The clock starts when bodies are sealed and workers ready.
    #[arg(long, value_name = "N")]
    deadline_ms: Option<f64>,
    /// Follow the candidates in N draws of what is known only up to errors, and rank by expected
    /// harm; 1: in the scene as stated alone [default: as the scenario says, else 32].
    #[arg(long, value_name = "N")]
    members: Option<i64>,
    /// Draw N members at most, where the best two are too close to call with fewer [default: 128,
    /// or `--members`].
    #[arg(long, value_name = "N", requires = "members")]
    members_max: Option<i64>,
    /// Maximum number of box and triangle tests per job; the remainder becomes new jobs [default:
    /// no limit, or 262144 with a deadline].
    #[arg(long, value_name = "TESTS")]
    budget: Option<u64>,
}

impl LimitArgs {
    /// The limits, without a record or an explanation.
    pub(crate) fn limits(&self) -> Result<Limits, Failure> {
        let mut limits = Limits::default().until(self.until);
        if let Some(ms) = self.deadline_ms {
            limits = limits.with_deadline_ms(ms)?;
        }
        if let Some(count) = self.members {
            limits = limits.with_members(count, self.members_max)?;
        }
        match self.budget {
            Some(tests) => limits.with_budget(tests),
            None => Ok(limits),
        }
    }
}

impl AnswerArgs {
    /// The limits, and whether a record or an explanation is kept.
    pub(crate) fn limits(&self) -> Result<Limits, Failure> {
        let mut limits = self.limits.limits()?;
        if let Some(count) = self.worlds {
            let worlds = Worlds::new(count, 0);
            limits = limits.with_worlds(worlds.map_err(|misfit| {
                Failure::setting(misfit.what).with_remedy(format!("--{}", misfit.remedy))
            })?);
        }
        Ok(match (&self.record, self.explain) {
            (Some(_), _) => limits.with_record(),
            (None, true) => limits.with_explanation(),
            (None, false) => limits,
        })
    }
}
