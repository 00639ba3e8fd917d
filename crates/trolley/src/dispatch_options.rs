//! How jobs reach the workers: buffers, how workers get the bodies, and what a core may hold by the
//! transfer ledger. For measurements; none of it changes an answer.
//!
//! ```
//! use trolley::Engine;
//! use trolley::dispatch_options::{DispatchOptions, TransferMode};
//!
//! let options = DispatchOptions { transfer: TransferMode::Copy, ..DispatchOptions::default() };
//! let engine = Engine::builder().workers(2).dispatch_options(options).build()?;
//! # Ok::<(), trolley::Failure>(())
//! ```

use crate::Failure;
use body::{BodyView, Meta};
use bvh::section;
pub use coordinator::{MessageCosts, VirtualSetup, VirtualTime};
use dispatch::{Cache, LogEntry, Matching, Queues};
use scenario::{EngineSettings, Scheme};
use serde::Serialize;
use std::fmt::Write as _;

/// Longest that a batch may wait (µs): a worker without jobs must not seem silent.
const LINGER_MAX_US: u64 = 10_000;

/// Share of all bodies that a copying worker can hold by default, in percent.
///
/// ```
/// assert!(trolley::dispatch_options::BUDGET_PERCENT < 100);
/// ```
pub const BUDGET_PERCENT: u64 = 60;

/// How workers get the bodies.
///
/// ```
/// use trolley::dispatch_options::TransferMode;
///
/// assert_eq!(TransferMode::default(), TransferMode::ZeroCopy);
/// assert_eq!(TransferMode::Copy.name(), "copy");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TransferMode {
    /// Workers read the one sealed store in place.
    #[default]
    ZeroCopy,
    /// Sections are copied into each worker's own memory and never evicted, for comparison: the
    /// first that does not fit ends the run.
    Copy,
}

impl TransferMode {
    /// Both modes, the default first.
    ///
    /// ```
    /// # use trolley::dispatch_options::TransferMode;
    /// assert_eq!(TransferMode::ALL.map(TransferMode::name), ["zero-copy", "copy"]);
    /// ```
    pub const ALL: [Self; 2] = [Self::ZeroCopy, Self::Copy];

    /// Returns the name used in files and on the command line.
    ///
    /// ```
    /// # use trolley::dispatch_options::TransferMode;
    /// assert_eq!(TransferMode::ZeroCopy.name(), "zero-copy");
    /// ```
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::ZeroCopy => "zero-copy",
            Self::Copy => "copy",
        }
    }
}

/// How jobs reach the workers, besides the scenario's settings.
///
/// ```
/// use trolley::dispatch_options::DispatchOptions;
///
/// let options = DispatchOptions { linger_us: 50, log: true, ..DispatchOptions::default() };
/// assert!(!options.copies());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DispatchOptions {
    /// How long a batch that is not full waits for more jobs (µs).
    pub linger_us: u64,
    /// Bytes of sections that a core may hold by the transfer ledger; the least recently used are
    /// evicted. `None` means no limit.
    pub cache_bytes: Option<u64>,
    /// How workers get the bodies.
    pub transfer: TransferMode,
    /// With [`TransferMode::Copy`]: bytes of sections that a worker may hold. `None` means
    /// [`BUDGET_PERCENT`] of all bodies.
    pub memory_budget: Option<u64>,
    /// Whether to log which worker got which job.
    pub log: bool,
    /// With [`in_process`](crate::EngineBuilder::in_process): to work as if by workers on cores
    /// that there are not; see [`Engine::virtual_time`](crate::Engine::virtual_time).
    pub virtual_cores: Option<VirtualSetup>,
}

impl DispatchOptions {
    /// Returns the sizes of queues and batches.
    ///
    /// ```
    /// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
    /// # use trolley::dispatch_options::DispatchOptions;
    /// let engine = &scenario.parsed().engine;
    /// let options = DispatchOptions { linger_us: 50, ..DispatchOptions::default() };
    /// assert_eq!(options.queues(engine)?.linger_ns, 50_000);
    ///
    /// let too_long = DispatchOptions { linger_us: 1_000_000, ..options };
    /// assert!(too_long.queues(engine).is_err());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If [`linger_us`](Self::linger_us) is too long.
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

    /// Returns what a core may hold by the ledger: at least the largest section at this depth.
    ///
    /// ```
    /// # use trolley::bodies::{Bodies, ModelFile};
    /// # use trolley::model::{BuildOptions, Shape};
    /// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
    /// # let bodies = Bodies::seal(vec![pole])?;
    /// use trolley::dispatch_options::DispatchOptions;
    ///
    /// let options = DispatchOptions { cache_bytes: Some(1 << 20), ..DispatchOptions::default() };
    /// assert!(options.cache(4, &bodies.views()?).is_ok());
    ///
    /// let too_small = DispatchOptions { cache_bytes: Some(1), ..options };
    /// assert!(too_small.cache(4, &bodies.views()?).is_err());
    /// # Ok::<(), trolley::Failure>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If the options contradict each other, or a section is larger than allowed.
    pub fn cache(&self, depth: u32, bodies: &[(Meta, BodyView<'_>)]) -> Result<Cache, Failure> {
        let largest = || bodies.iter().map(|(_, body)| largest_section(body, depth)).max();
        match (self.transfer, self.cache_bytes, self.memory_budget) {
            (TransferMode::Copy, Some(_), _) => {
                Err(Failure::setting("--cache-bytes is for zero-copy alone")
                    .with_remedy("--memory-budget bounds what a worker that copies can hold"))
            }
            (TransferMode::ZeroCopy, _, Some(_)) => {
                Err(Failure::setting("--memory-budget is for workers that copy")
                    .with_remedy("add --transfer copy, or use --cache-bytes"))
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

    /// Returns whether sections are copied.
    ///
    /// ```
    /// use trolley::dispatch_options::{DispatchOptions, TransferMode};
    ///
    /// let transfer = TransferMode::Copy;
    /// let options = DispatchOptions { transfer, ..DispatchOptions::default() };
    /// assert!(options.copies());
    /// ```
    #[must_use]
    pub fn copies(&self) -> bool {
        self.transfer == TransferMode::Copy
    }
}

/// Returns how jobs are matched to workers with these settings.
///
/// ```
/// # let scenario = trolley::Scenario::open("../../config/scenarios/small.toml")?;
/// let matching = trolley::dispatch_options::matching(&scenario.parsed().engine);
/// println!("{matching:?}");
/// # assert_eq!(matching, dispatch::Matching::BestMatchLoad(0.5));
/// # Ok::<(), trolley::Failure>(())
/// ```
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

/// Returns the size of the largest section of a body at a distribution depth (bytes).
///
/// ```
/// # use trolley::bodies::{Bodies, ModelFile};
/// # use trolley::model::{BuildOptions, Shape};
/// # let pole = ModelFile::generate(Shape::Pole, 600, 0, &BuildOptions::default())?;
/// # let bodies = Bodies::seal(vec![pole])?;
/// use trolley::dispatch_options::largest_section;
///
/// let views = bodies.views()?;
/// let (_, pole) = &views[0];
/// assert!(largest_section(pole, 4) < largest_section(pole, 0), "deeper sections are smaller");
/// # Ok::<(), trolley::Failure>(())
/// ```
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

/// Refuses a limit that is smaller than the largest section.
fn fits(option: &str, bytes: u64, depth: u32, largest: u64) -> Result<(), Failure> {
    if bytes >= largest {
        return Ok(());
    }
    let what = format!("{option} {bytes} is less than the largest section at depth {depth}");
    Err(Failure::setting(what)
        .with_remedy(format!("{largest} bytes are the least; a deeper cut needs less")))
}

/// Writes a job log as CSV: which worker got which job, with the sections that it needs and their
/// bytes. The transfer ledger can be recomputed from it.
///
/// ```
/// let csv = trolley::dispatch_options::log_csv(&[]);
/// assert!(csv.starts_with("event,job,attempt,worker,"));
/// ```
#[must_use]
pub fn log_csv(log: &[LogEntry]) -> String {
    let mut text = String::from(
        "event,job,attempt,worker,incarnation,model_a,node_a,bytes_a,model_b,node_b,bytes_b\n",
    );
    for entry in log {
        // Writing to a String cannot fail.
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
