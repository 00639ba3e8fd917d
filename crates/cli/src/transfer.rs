//! How work is handed to workers: scheme, buffers, and what the transfer ledger lets a core hold.
//!
//! None of it changes an answer. What a person wrote is checked here, against the bodies at hand.

use crate::failure::{Code, Failure};
use body::{BodyView, Meta};
use bvh::section;
use clap::{Args as ClapArgs, ValueEnum};
use dispatch::{Cache, Entry, Matching, Queues};
use scenario::{Engine, Scheme};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Longest that a batch may wait (µs): a worker that gets nothing must not look silent.
const LINGER_MAX_US: u64 = 10_000;

/// Share of all bodies that a copying worker can hold, in percent.
pub(crate) const BUDGET_PERCENT: u64 = 60;

/// How workers come by the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Mode {
    /// They read the one sealed store in place.
    #[default]
    ZeroCopy,
    /// Sections are shipped into memory of their own, without eviction, for comparison: the first
    /// that does not fit ends the run.
    Copy,
}

/// What a person may say about transfer, beside the scenario's settings.
#[derive(Clone, Debug, Default, ClapArgs)]
pub(crate) struct TransferArgs {
    /// How long a batch that is not full waits for more jobs (µs) [default: 0].
    #[arg(long, value_name = "US")]
    linger: Option<u64>,
    /// Bytes of sections that the transfer ledger lets a core hold; the least recently needed make
    /// room [default: no limit].
    #[arg(long, value_name = "BYTES")]
    cache_bytes: Option<u64>,
    /// How workers come by the bodies.
    #[arg(long, value_name = "MODE", default_value = "zero-copy")]
    transfer: Mode,
    /// With --transfer copy: bytes of sections that a worker may hold [default: 60 % of bodies].
    #[arg(long, value_name = "BYTES")]
    memory_budget: Option<u64>,
    /// Write down who got which job: a CSV file from which the transfer ledger can be recomputed.
    #[arg(long, value_name = "FILE")]
    pub(crate) job_log: Option<PathBuf>,
}

impl TransferArgs {
    /// Sizes of queues and batches.
    pub(crate) fn queues(&self, engine: &Engine) -> Result<Queues, Failure> {
        let linger_us = self.linger.unwrap_or(0);
        if linger_us > LINGER_MAX_US {
            let help = format!("--linger may be 0 to {LINGER_MAX_US} µs");
            return Err(setting(format!("--linger is {linger_us}")).help(help));
        }
        Ok(Queues {
            capacity: engine.queue as u32,
            batch: engine.batch as u32,
            linger_ns: 1_000 * linger_us,
        })
    }

    /// What a core may hold, by the ledger: at least every section there is at this depth.
    pub(crate) fn cache(
        &self,
        depth: u32,
        bodies: &[(Meta, BodyView<'_>)],
    ) -> Result<Cache, Failure> {
        let largest = || bodies.iter().map(|(_, body)| largest_section(body, depth)).max();
        match (self.transfer, self.cache_bytes, self.memory_budget) {
            (Mode::Copy, Some(_), _) => {
                let help = "--memory-budget bounds what a worker that copies can hold";
                Err(setting("--cache-bytes is for zero-copy alone".to_owned()).help(help))
            }
            (Mode::ZeroCopy, _, Some(_)) => {
                let help = "give --transfer copy besides, or --cache-bytes";
                Err(setting("--memory-budget is for workers that copy".to_owned()).help(help))
            }
            (Mode::Copy, None, Some(budget)) => {
                fits("--memory-budget", budget, depth, largest().unwrap_or(0))?;
                Ok(Cache::Fixed(budget))
            }
            (Mode::Copy, None, None) => {
                let all: u64 = bodies.iter().map(|(_, body)| section::bytes(body.nodes, 0)).sum();
                Ok(Cache::Fixed(all * BUDGET_PERCENT / 100))
            }
            (Mode::ZeroCopy, Some(bytes), None) => {
                fits("--cache-bytes", bytes, depth, largest().unwrap_or(0))?;
                Ok(Cache::Recent(bytes))
            }
            (Mode::ZeroCopy, None, None) => Ok(Cache::Unlimited),
        }
    }

    /// Whether workers read the one store in place, and the ledger has no limit.
    pub(crate) fn is_plain(&self) -> bool {
        self.transfer == Mode::ZeroCopy
            && self.cache_bytes.is_none()
            && self.memory_budget.is_none()
    }

    /// Whether sections are copied.
    pub(crate) fn copies(&self) -> bool {
        self.transfer == Mode::Copy
    }
}

/// The scheme that the engine names.
pub(crate) fn matching(scheme: Scheme, alpha: f64, seed: u64) -> Result<Matching, Failure> {
    Ok(match scheme {
        Scheme::BestMatchLoad => Matching::BestMatchLoad(alpha),
        Scheme::BestMatch => Matching::BestMatch,
        Scheme::RandomMatch => Matching::RandomMatch(seed),
        Scheme::LowestMatch => Matching::LowestMatch,
        Scheme::RoundRobin => Matching::RoundRobin,
        other => {
            let fault = format!("{} is read, but not carried out", other.name());
            return Err(Failure::new(Code::Internal, fault));
        }
    })
}

/// The largest section of a body at a distribution depth (bytes).
pub(crate) fn largest_section(body: &BodyView<'_>, depth: u32) -> u64 {
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
pub(crate) fn fits(option: &str, bytes: u64, depth: u32, largest: u64) -> Result<(), Failure> {
    if bytes >= largest {
        return Ok(());
    }
    let fault = format!("{option} {bytes} is less than the largest section at depth {depth}");
    Err(setting(fault).help(format!("{largest} bytes are the least; a deeper cut needs less")))
}

fn setting(fault: String) -> Failure {
    Failure::new(Code::Configuration, fault)
}

/// Writes the job log.
pub(crate) fn write_log(path: &Path, log: &[Entry]) -> Result<(), Failure> {
    let mut text = String::from(
        "event,job,attempt,worker,incarnation,model_a,node_a,bytes_a,model_b,node_b,bytes_b\n",
    );
    for entry in log {
        // A String takes whatever it is given.
        let _written = match entry {
            Entry::Assigned { job, attempt, who, sections: [(a, bytes_a), (b, bytes_b)] } => {
                writeln!(
                    text,
                    "assigned,{},{attempt},{},{},{},{},{bytes_a},{},{},{bytes_b}",
                    job.0, who.worker, who.inc, a.model, a.node, b.model, b.node
                )
            }
            Entry::Lost { who } => writeln!(text, "lost,,,{},{},,,,,,", who.worker, who.inc),
        };
    }
    write(path, text.as_bytes())
}

/// Writes a file that a person asked for.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, bytes).map_err(|error| unwritable(path, &error))
}

/// Whether a file can be written; what it holds stays.
#[cfg(feature = "lab")]
pub(crate) fn ready(path: &Path) -> Result<(), Failure> {
    let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
    file.map(drop).map_err(|error| unwritable(path, &error))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Code::System, format!("{}: {error}", path.display()))
        .help("name a file in a folder that exists and that you may write to")
}
