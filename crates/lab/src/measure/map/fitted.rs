//! The costs with which virtual cores take as long as one real worker did, without copying and
//! with.
//!
//! Each cost is fitted where it shows: the kernel's to jobs timed one by one in this process, what
//! it takes longer in a worker to that worker's busy time, a result message to runs that do not
//! copy, and copying to runs that do. Points that are validated are others: other depths, schemes,
//! memories and numbers of workers.

use super::super::bench::{Alone, Bench, Way};
use super::super::calibrate::QUEUES;
use dispatch::{Cache, Matching};
use scenario::{EngineSettings, Scheme};
use simulate::{Costs, Home, Prepared, Setup, fit, fit_copies};
use trolley::Failure;
use trolley::dispatch_options::TransferMode;

/// Depths with few large and with many small sections; none of them is validated.
const DEPTHS: [u32; 4] = [1, 5, 9, 12];

/// One depth as it ran.
struct Measured {
    alone: Alone,
    /// Without copying, and with (ns).
    run_ns: [f64; 2],
}

/// The kernel's costs of these jobs: those that this process timed.
pub(crate) fn kernel(alone: &Alone, costs: &Costs, slower: f64) -> Costs {
    let [job_ns, box_ns, triangle_ns, hit_ns] = fit(&alone.samples).map(|cost| cost * slower);
    Costs { job_ns, box_ns, triangle_ns, hit_ns, ..*costs }
}

/// Fits the costs of messages and of copies, starting with those of a calibration. The second
/// value is how much longer the kernel takes in a worker than in this process (1.1: a tenth).
pub(crate) fn fitted(bench: &Bench<'_>, costs: &Costs) -> Result<(Costs, f64), Failure> {
    let (mut measured, mut ship, mut slower) = (Vec::new(), Vec::new(), 0.0);
    for depth in DEPTHS {
        let way = Way {
            workers: 1,
            depth,
            scheme: Scheme::BestMatchLoad,
            matching: Matching::BestMatchLoad(EngineSettings::DEFAULT.alpha),
            queues: QUEUES,
            transfer: TransferMode::ZeroCopy,
            cache: Cache::Unlimited,
        };
        let alone = bench.alone(depth)?;
        let shared = bench.worker_pool(&way)?;
        // As good as unlimited.
        let cache = Cache::Fixed(2 * bench.model_bytes());
        let copied = bench.worker_pool(&Way { transfer: TransferMode::Copy, cache, ..way })?;
        let moved = copied.report.transfer;
        let (copied, shared) = (copied.report.duty, shared.report);
        let ship_ns = copied.send_ns.saturating_sub(shared.duty.send_ns) as f64;
        ship.push([moved.section_bytes as f64, moved.missed as f64, ship_ns]);
        let busy_ns: u64 = shared.workers.iter().map(|worker| worker.busy_ns).sum();
        let timed_ns: f64 = alone.samples.iter().map(|sample| sample.ns).sum();
        slower += (busy_ns as f64 / timed_ns).ln() / DEPTHS.len() as f64;
        let run_ns = [shared.duty.run_ns as f64, copied.run_ns as f64];
        measured.push(Measured { alone, run_ns });
    }
    let slower = slower.exp();
    let [ship_byte_ns, ship_section_ns] = fit_copies(&ship);
    let costs = Costs { ship_byte_ns, ship_section_ns, ..*costs };
    let error = |costs: &Costs, copies: bool| -> f64 {
        let off = |measured: &Measured| {
            let run = simulated(&measured.alone, &kernel(&measured.alone, costs, slower), copies);
            (run / measured.run_ns[usize::from(copies)]).ln().powi(2)
        };
        measured.iter().map(off).sum()
    };
    let least = |candidates: Vec<Costs>, copies: bool| {
        let rated = candidates.into_iter().map(|costs| (error(&costs, copies), costs));
        rated.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(costs, |(_, costs)| costs)
    };
    let sent = steps(50.0, 30_000.0, 60).into_iter();
    let costs = least(sent.map(|send_ns| Costs { send_ns, ..costs }).collect(), false);
    let mut copies = Vec::new();
    for section_byte_ns in steps(0.02, 8.0, 20) {
        let per_section = steps(50.0, 40_000.0, 20).into_iter();
        copies.extend(per_section.map(|section_ns| Costs { section_byte_ns, section_ns, ..costs }));
    }
    Ok((least(copies, true), slower))
}

/// Zero, and values from `low` to `high` in equal ratios.
fn steps(low: f64, high: f64, count: u32) -> Vec<f64> {
    let ratio = (high / low).ln() / f64::from(count - 1);
    let step = |number| low * (ratio * f64::from(number)).exp();
    std::iter::once(0.0).chain((0..count).map(step)).collect()
}

/// The time of one virtual worker, with a coordinator on a core of its own (ns).
fn simulated(alone: &Alone, costs: &Costs, copies: bool) -> f64 {
    let setup = Setup {
        workers: 1,
        home: if runtime::affinity::allowed_cores().len() > 1 { Home::Own } else { Home::Shared },
        matching: Matching::BestMatchLoad(EngineSettings::DEFAULT.alpha),
        queues: QUEUES,
        cache: Cache::Unlimited,
        copies,
        paging: None,
    };
    Prepared::new(&alone.trace).run(costs, &setup).time_ns
}
