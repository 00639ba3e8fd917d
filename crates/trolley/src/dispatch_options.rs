//! How jobs reach the workers: buffers, how workers come by the bodies, and what the transfer
//! ledger lets a core hold. For measurements; none of it changes an answer.

use crate::Failure;
use body::{BodyView, Meta};
use bvh::section;
use dispatch::{Cache, LogEntry, Matching, Queues};
use scenario::{EngineSettings, Scheme};
use serde::Serialize;
use std::fmt::Write as _;

/// Longest that a batch may wait (µs): a worker that gets nothing must not look silent.
const LINGER_MAX_US: u64 = 10_000;

/// Share of all bodies that a copying worker can hold, in percent.
pub const BUDGET_PERCENT: u64 = 60;

/// How workers come by the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TransferMode {
    /// They read the one sealed store in place.
    #[default]
    ZeroCopy,
    /// Sections are shipped into memory of their own, without eviction, for comparison: the first
    /// that does not fit ends the run.
    Copy,
}

impl TransferMode {
    /// Both of them, the default first.
    pub const ALL: [Self; 2] = [Self::ZeroCopy, Self::Copy];

    /// Its name, as files and the command line have it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ZeroCopy => "zero-copy",
            Self::Copy => "copy",
        }
    }
}

/// How jobs reach the workers, beside the scenario's settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DispatchOptions {
    /// How long a batch that is not full waits for more jobs (µs).
    pub linger_us: u64,
    /// Bytes of sections that the transfer ledger lets a core hold; the least recently needed make
    /// room. `None`: no limit.
    pub cache_bytes: Option<u64>,
    /// How workers come by the bodies.
    pub transfer: TransferMode,
    /// With [`TransferMode::Copy`]: bytes of sections that a worker may hold; `None`:
    /// [`BUDGET_PERCENT`] of all bodies.
    pub memory_budget: Option<u64>,
    /// Whether to keep who got which job.
    pub log: bool,
}

impl DispatchOptions {
    /// Sizes of queues and batches.
    ///
    /// # Errors
    ///
    /// If batches would wait too long.
    pub fn queues(&self, engine: &EngineSettings) -> Result<Queues, Failure> {
        if self.linger_us > LINGER_MAX_US {
            return Err(Failure::setting(format!("--linger is {}", self.linger_us))
                .with_remedy(format!("--linger may be 0 to {LINGER_MAX_US} µs")));
        }
        Ok(Queues {
            capacity: engine.queue as u32,
            batch: engine.batch as u32,
            linger_ns: 1_000 * self.linger_us,
        })
    }

    /// What a core may hold, by the ledger: at least every section there is at this depth.
    ///
    /// # Errors
    ///
    /// If the settings contradict one another, or a section is larger than what is allowed.
    pub fn cache(&self, depth: u32, bodies: &[(Meta, BodyView<'_>)]) -> Result<Cache, Failure> {
        let largest = || bodies.iter().map(|(_, body)| largest_section(body, depth)).max();
        match (self.transfer, self.cache_bytes, self.memory_budget) {
            (TransferMode::Copy, Some(_), _) => {
                Err(Failure::setting("--cache-bytes is for zero-copy alone")
                    .with_remedy("--memory-budget bounds what a worker that copies can hold"))
            }
            (TransferMode::ZeroCopy, _, Some(_)) => {
                Err(Failure::setting("--memory-budget is for workers that copy")
                    .with_remedy("give --transfer copy besides, or --cache-bytes"))
            }
            (TransferMode::Copy, None, Some(budget)) => {
                fits("--memory-budget", budget, depth, largest().unwrap_or(0))?;
                Ok(Cache::Fixed(budget))
            }
            (TransferMode::Copy, None, None) => {
                let all: u64 = bodies.iter().map(|(_, body)| section::bytes(body.nodes, 0)).sum();
                Ok(Cache::Fixed(all * BUDGET_PERCENT / 100))
            }
            (TransferMode::ZeroCopy, Some(bytes), None) => {
                fits("--cache-bytes", bytes, depth, largest().unwrap_or(0))?;
                Ok(Cache::Recent(bytes))
            }
            (TransferMode::ZeroCopy, None, None) => Ok(Cache::Unlimited),
        }
    }

    /// Whether sections are copied.
    #[must_use]
    pub fn copies(&self) -> bool {
        self.transfer == TransferMode::Copy
    }
}

/// Who gets which job, as the engine's settings say.
#[must_use]
pub fn matching(engine: &EngineSettings) -> Matching {
    match engine.scheme {
        Scheme::BestMatchLoad => Matching::BestMatchLoad(engine.alpha),
        Scheme::BestMatch => Matching::BestMatch,
        Scheme::RandomMatch => Matching::RandomMatch(engine.seed),
        Scheme::LowestMatch => Matching::LowestMatch,
        Scheme::RoundRobin => Matching::RoundRobin,
    }
}

/// The largest section of a body at a distribution depth (bytes).
#[must_use]
pub fn largest_section(body: &BodyView<'_>, depth: u32) -> u64 {
    let mut largest = 0;
    let mut open = if body.nodes.is_empty() { Vec::new() } else { vec![(0_u32, 0_u32)] };
    while let Some((number, level)) = open.pop() {
        let node = &body.nodes[number as usize];
        if node.is_leaf() || level == depth {
            largest = largest.max(section::bytes(body.nodes, number));
        } else {
            open.extend([(number + 1, level + 1), (node.link, level + 1)]);
        }
    }
    largest
}

/// Refuses a memory that is smaller than the largest section.
fn fits(option: &str, bytes: u64, depth: u32, largest: u64) -> Result<(), Failure> {
    if bytes >= largest {
        return Ok(());
    }
    let what = format!("{option} {bytes} is less than the largest section at depth {depth}");
    Err(Failure::setting(what)
        .with_remedy(format!("{largest} bytes are the least; a deeper cut needs less")))
}

/// A job log as CSV: who got which job, with the sections that it needs and their bytes. The
/// transfer ledger can be recomputed from it.
#[must_use]
pub fn log_csv(log: &[LogEntry]) -> String {
    let mut text = String::from(
        "event,job,attempt,worker,incarnation,model_a,node_a,bytes_a,model_b,node_b,bytes_b\n",
    );
    for entry in log {
        // A String takes whatever it is given.
        let _written = match entry {
            LogEntry::Assigned { job, attempt, who, sections: [(a, bytes_a), (b, bytes_b)] } => {
                writeln!(
                    text,
                    "assigned,{},{attempt},{},{},{},{},{bytes_a},{},{},{bytes_b}",
                    job.0, who.worker, who.inc, a.model, a.node, b.model, b.node
                )
            }
            LogEntry::Lost { who } => writeln!(text, "lost,,,{},{},,,,,,", who.worker, who.inc),
        };
    }
    text
}
