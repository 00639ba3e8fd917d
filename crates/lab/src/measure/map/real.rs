//! Points of the map run by real workers that copy, beside what the virtual cores predict.

use super::super::bench::{Bench, Way};
use super::fitted::kernel;
use super::grid::BUFFER;
use super::run::matching;
use super::table::Subject;
use dispatch::{Cache, Queues};
use scenario::Scheme;
use serde::{Deserialize, Serialize};
use simulate::{Costs, Home, Prepared, Setup};
use trolley::Failure;
use trolley::dispatch_options::TransferMode;

/// A point to run: workers, scheme, depth, and memory (percent of both bodies; beyond it sections
/// are evicted).
type Planned = (u8, Scheme, u32, u32);

/// At every depth band, memory band, and with every scheme.
const POINTS: [Planned; 12] = [
    (1, Scheme::BestMatchLoad, 2, 200),
    (1, Scheme::BestMatchLoad, 6, 40),
    (1, Scheme::RandomMatch, 4, 60),
    (1, Scheme::LowestMatch, 8, 200),
    (1, Scheme::BestMatch, 3, 80),
    (1, Scheme::BestMatchLoad, 10, 10),
    (1, Scheme::BestMatchLoad, 8, 5),
    (2, Scheme::BestMatchLoad, 3, 200),
    (2, Scheme::BestMatch, 6, 60),
    (2, Scheme::RandomMatch, 4, 200),
    (2, Scheme::LowestMatch, 8, 40),
    (2, Scheme::BestMatchLoad, 6, 20),
];

/// A prediction and what was measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Checked {
    pub(crate) size: u32,
    pub(crate) contact: String,
    pub(crate) workers: u8,
    pub(crate) scheme: String,
    pub(crate) depth: u32,
    pub(crate) memory_percent: u32,
    pub(crate) predicted_ms: f64,
    pub(crate) measured_ms: f64,
    pub(crate) predicted_bytes: u64,
    pub(crate) measured_bytes: u64,
}

impl Checked {
    /// Relative errors of time and of bytes: 0.1 is 10 %.
    pub(crate) fn errors(&self) -> [f64; 2] {
        let bytes = self.predicted_bytes as f64 / self.measured_bytes.max(1) as f64;
        [self.predicted_ms / self.measured_ms - 1.0, bytes - 1.0]
    }
}

/// The median and the greatest size of an error.
pub(crate) fn errors(checked: &[Checked], which: usize) -> Option<[f64; 2]> {
    let mut sizes: Vec<f64> = checked.iter().map(|check| check.errors()[which].abs()).collect();
    sizes.sort_by(f64::total_cmp);
    Some([*sizes.get(sizes.len() / 2)?, *sizes.last()?])
}

/// Runs all points of one subject.
pub(crate) fn check(
    bench: &Bench<'_>,
    subject: Subject,
    (costs, slower): (&Costs, f64),
    told: &dyn Fn(),
) -> Result<Vec<Checked>, Failure> {
    let mut checked = Vec::new();
    let cores = runtime::affinity::allowed_cores().len();
    for (workers, scheme, depth, memory_percent) in POINTS {
        let cache = Cache::Recent(bench.model_bytes() * u64::from(memory_percent) / 100);
        let queues = Queues { capacity: BUFFER, batch: BUFFER / 4, linger_ns: 0 };
        let way = Way {
            workers,
            depth,
            scheme,
            matching: matching(scheme, 0),
            queues,
            transfer: TransferMode::Copy,
            cache,
        };
        // In one process first: the kernel's costs are those of these jobs, at this time.
        let alone = bench.alone(depth)?;
        // The quicker of two rounds: other load only adds time.
        let rounds = [bench.worker_pool(&way)?, bench.worker_pool(&way)?];
        let Some(ran) = rounds.into_iter().min_by_key(|ran| ran.report.duty.run_ns) else {
            continue;
        };
        let costs = kernel(&alone, costs, slower);
        let setup = Setup {
            workers,
            home: if usize::from(workers) < cores { Home::Own } else { Home::Shared },
            matching: way.matching,
            queues,
            cache,
            copies: true,
            paging: None,
        };
        let predicted = Prepared::new(&alone.trace).run(&costs, &setup);
        checked.push(Checked {
            size: subject.size,
            contact: subject.contact().to_owned(),
            workers,
            scheme: scheme.name().to_owned(),
            depth,
            memory_percent,
            predicted_ms: predicted.time_ns / 1e6,
            measured_ms: ran.report.duty.run_ns as f64 / 1e6,
            predicted_bytes: predicted.transfer.section_bytes,
            measured_bytes: ran.report.transfer.section_bytes,
        });
        told();
    }
    Ok(checked)
}

/// Number of points of a subject.
pub(crate) const COUNT: usize = POINTS.len();
