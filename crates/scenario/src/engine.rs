//! Settings of the engine: how the work is cut, handed out and pinned.
//!
//! None of them changes a complete answer; they change how long it takes and what travels. Every
//! default is in [`EngineSettings::DEFAULT`], with its reason. A scenario's `[engine]` table and
//! the command line are both [`Overrides`], so both obey the same rules.

use crate::error::Misfit;
use crate::limit::{self, Limit};
use crate::names;
use body::Build;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How jobs are matched to workers: the schemes of Wiseman and Grinberg, and one that looks at
/// nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// The worker that holds most of a job's sections, weighed against how much it has to do
    /// already.
    BestMatchLoad,
    /// The worker that holds most of a job's sections.
    BestMatch,
    /// Any worker.
    RandomMatch,
    /// The worker that holds fewest of a job's sections.
    LowestMatch,
    /// One after the other.
    RoundRobin,
}

impl Scheme {
    /// All of them, the default first.
    pub const ALL: [Self; 5] = [
        Self::BestMatchLoad,
        Self::BestMatch,
        Self::RandomMatch,
        Self::LowestMatch,
        Self::RoundRobin,
    ];

    /// Its name in a scenario.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BestMatchLoad => "best-match-load",
            Self::BestMatch => "best-match",
            Self::RandomMatch => "random-match",
            Self::LowestMatch => "lowest-match",
            Self::RoundRobin => "round-robin",
        }
    }
}

/// Which cores the workers are pinned to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Cores {
    /// Worker i on the i-th core that the machine grants, around again when there are fewer.
    Granted,
    /// No pinning: the kernel decides.
    Unpinned,
    /// Worker i on the i-th of these; one for each worker, and a core may serve several.
    Listed(Vec<u16>),
}

/// Settings of the engine. Always valid: made by [`EngineSettings::apply`] from
/// [`EngineSettings::DEFAULT`].
#[derive(Clone, Debug, PartialEq)]
pub struct EngineSettings {
    /// Worker processes, 1 to 16.
    pub workers: usize,
    /// Where they run.
    pub cores: Cores,
    /// Where the coordinator runs; `None`: wherever the workers' cores leave room.
    pub coordinator_core: Option<u16>,
    /// Distribution depth: how many levels both trees are descended before pairs become jobs.
    pub depth: u32,
    /// Which worker gets a job.
    pub scheme: Scheme,
    /// Weight of held sections against load in Best Match-Load: 1 looks at sections only, 0 at
    /// load.
    pub alpha: f64,
    /// Jobs per message.
    pub batch: usize,
    /// Jobs on their way to one worker or waiting there, at most; never below `batch`.
    pub queue: usize,
    /// Tree of bodies that are built here.
    pub build: Build,
    /// Triangles per leaf of these trees, at most.
    pub leaf_size: u32,
    /// Seed of every choice that is called random.
    pub seed: u64,
}

impl EngineSettings {
    /// What holds where nothing is written.
    pub const DEFAULT: Self = Self {
        // The target is a quad-core computer: a worker for each core.
        workers: 4,
        // The same file must run on machines with other cores.
        cores: Cores::Granted,
        coordinator_core: None,
        // On four virtual cores the best depth for bodies of 60,000 to 2 million triangles was 3 to
        // 6, and two real workers were the quickest at 3 to 5: `trolley measure`.
        depth: 4,
        // The scheme that the method's authors found best.
        scheme: Scheme::BestMatchLoad,
        // Held sections and load weigh the same until measured otherwise.
        alpha: 0.5,
        // A batch and its results take a few microseconds of both ends, a job tens: four share it.
        batch: 4,
        // Four batches. More and the schemes that look at sections let one worker wait while
        // another has a full queue; with 2 to 16 four virtual cores were the quickest.
        queue: 16,
        build: Build::Paper,
        // 4 to 8 triangles per leaf were the fastest; 4 also suits machines with four lanes.
        leaf_size: 4,
        seed: 0,
    };

    /// These settings with some replaced.
    ///
    /// Fewer workers than listed cores use the first of the cores, when `changes` lists none
    /// itself.
    ///
    /// # Errors
    ///
    /// A [`Misfit`] that names the setting when a value is out of range or contradicts another.
    pub fn apply(&self, changes: &Overrides) -> Result<Self, Misfit> {
        let mut new = self.clone();
        set(&mut new.workers, changes.workers, "workers", limit::WORKERS)?;
        set(&mut new.depth, changes.depth, "depth", limit::DEPTH)?;
        set(&mut new.batch, changes.batch, "batch", limit::BATCH)?;
        set(&mut new.queue, changes.queue, "queue", limit::QUEUE)?;
        set(&mut new.leaf_size, changes.leaf_size, "leaf_size", limit::LEAF_SIZE)?;
        set(&mut new.seed, changes.seed, "seed", limit::SEED)?;
        if let Some(core) = changes.coordinator_core {
            new.coordinator_core = Some(limit::CORE.whole("coordinator_core", core)?);
        }
        if let Some(alpha) = changes.alpha {
            new.alpha = limit::SHARE.check("alpha", alpha)? + 0.0;
        }
        if let Some(word) = &changes.scheme {
            new.scheme = names::meaning("scheme", word)?;
        }
        if let Some(word) = &changes.build {
            new.build = names::meaning("build", word)?;
        }
        match (&changes.cores, &mut new.cores) {
            (Some(cores), new_cores) => *new_cores = listed(cores)?,
            (None, Cores::Listed(cores)) if new.workers < cores.len() => {
                cores.truncate(new.workers);
            }
            (None, _) => {}
        }
        new.check_relations(changes)?;
        Ok(new)
    }

    /// What no range can say: settings that must fit each other.
    fn check_relations(&self, changes: &Overrides) -> Result<(), Misfit> {
        if let Cores::Listed(cores) = &self.cores
            && cores.len() != self.workers
        {
            let setting = if changes.cores.is_some() { "cores" } else { "workers" };
            let fault = format!("cores lists {} of them for {} workers", cores.len(), self.workers);
            let help =
                "list one core for each worker (a core may stand twice), or none: cores = []";
            return Err(Misfit::new(setting, fault, help));
        }
        if self.queue < self.batch {
            let setting = if changes.queue.is_some() { "queue" } else { "batch" };
            let fault = format!("a batch of {} does not fit a queue of {}", self.batch, self.queue);
            let help = "let queue be at least batch; four times as much keeps a worker busy";
            return Err(Misfit::new(setting, fault, help));
        }
        Ok(())
    }
}

impl Default for EngineSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Settings as written, unchecked: the `[engine]` table of a scenario, or the command line. What is
/// `None` stays as it is.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "Engine", description = "How the engine works. No setting here changes a \
    complete answer.", !default)]
pub struct Overrides {
    /// Worker processes. Default 4: one for each core of a quad-core computer.
    #[schemars(range(min = limit::WORKERS.least, max = limit::WORKERS.most))]
    pub workers: Option<i64>,
    /// Worker i is pinned to the i-th of these core numbers; one for each worker. An empty list: no
    /// pinning. Default: the cores that the machine grants, in order.
    #[schemars(length(max = limit::WORKERS.most),
        inner(range(min = limit::CORE.least, max = limit::CORE.most)))]
    pub cores: Option<Vec<i64>>,
    /// Core number of the coordinator. Default: wherever the workers' cores leave room.
    #[schemars(range(min = limit::CORE.least, max = limit::CORE.most))]
    pub coordinator_core: Option<i64>,
    /// Distribution depth: levels of both trees that the coordinator descends itself. Default 4.
    #[schemars(range(min = limit::DEPTH.least, max = limit::DEPTH.most))]
    pub depth: Option<i64>,
    /// How jobs are matched to workers. Default best-match-load.
    #[schemars(extend("enum" = names::all::<Scheme>()))]
    pub scheme: Option<String>,
    /// Weight of held sections against load in best-match-load: 1 looks at sections only, 0 at
    /// load. Default 0.5.
    #[schemars(range(min = limit::SHARE.least, max = limit::SHARE.most))]
    pub alpha: Option<f64>,
    /// Jobs per message. Default 4.
    #[schemars(range(min = limit::BATCH.least, max = limit::BATCH.most))]
    pub batch: Option<i64>,
    /// Jobs on their way to one worker at most; at least batch. Default 16.
    #[schemars(range(min = limit::QUEUE.least, max = limit::QUEUE.most))]
    pub queue: Option<i64>,
    /// How trees are built. Default paper: the split of Wiseman and Grinberg with a balance rule.
    #[schemars(extend("enum" = names::all::<Build>()))]
    pub build: Option<String>,
    /// Triangles per leaf at most. Default 4.
    #[schemars(range(min = limit::LEAF_SIZE.least, max = limit::LEAF_SIZE.most))]
    pub leaf_size: Option<i64>,
    /// Seed of every choice that is called random. Default 0.
    #[schemars(range(min = limit::SEED.least, max = limit::SEED.most))]
    pub seed: Option<i64>,
}

/// Replaces a whole number if another is written and in range.
fn set<T: TryFrom<i64>>(
    old: &mut T,
    written: Option<i64>,
    setting: &'static str,
    limit: Limit<i64>,
) -> Result<(), Misfit> {
    if let Some(value) = written {
        *old = limit.whole(setting, value)?;
    }
    Ok(())
}

/// The cores of a written list.
fn listed(written: &[i64]) -> Result<Cores, Misfit> {
    if written.is_empty() {
        return Ok(Cores::Unpinned);
    }
    let cores: Result<Vec<u16>, Misfit> =
        written.iter().map(|core| limit::CORE.whole("cores", *core)).collect();
    Ok(Cores::Listed(cores?))
}

#[cfg(test)]
mod tests;
