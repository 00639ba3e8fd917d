//! What each step costs on this machine, for this pair of bodies.
//!
//! The kernel's costs are fitted to jobs that this process timed one by one; the coordinator's are
//! its own counts divided by what it did, with one worker; a worker's cost per result outside its
//! kernel is the remaining time of a run in which that worker is never idle.

use super::bench::{Alone, Bench, Ran, Way};
use coordinator::Options;
use dispatch::{Cache, Matching, Queues};
use scenario::Scheme;
use simulate::{Costs, fit, fit_copies};
use trolley::Failure;
use trolley::dispatch_options::TransferMode;

/// Buffer sizes of all calibrations.
pub(crate) const QUEUES: Queues = Options::QUEUES;

/// From the end of a send to its arrival (ns): iceoryx2 0.10 between two busy processes took 325 to
/// 350 ns on the machines seen so far, and its share in the whole is small.
const FLIGHT_NS: f64 = 340.0;

/// Measures the costs. `fine` is a depth at which a worker always has work.
pub(crate) fn calibrate(bench: &Bench<'_>, fine: u32) -> Result<Costs, Failure> {
    let coarse = bench.alone(0)?;
    let middle = bench.alone(fine / 2)?;
    let split = bench.alone(fine)?;
    let samples: Vec<_> = [&coarse, &middle, &split].iter().flat_map(|a| &a.samples).collect();
    let samples: Vec<_> = samples.into_iter().copied().collect();
    let [job_ns, box_ns, triangle_ns, hit_ns] = fit(&samples);
    let kernel_ns = |alone: &Alone| alone.samples.iter().map(|sample| sample.ns).sum::<f64>();
    let way = usual(fine);
    let ran = bench.worker_pool(&way)?;
    let [ship, load] = copying(bench, fine, &ran)?;
    let (duty, worker) = (ran.report.duty, &ran.report.workers[0]);
    let (jobs, results) = (per(worker.jobs), per(worker.results));
    let tasks = per(split.trace.tasks.len() as u64);
    let tests = |alone: &Alone| per(alone.trace.tasks.iter().map(|t| t.descent_nb).sum());
    let hits = |alone: &Alone| per(alone.trace.jobs().map(|job| job.hits).sum());
    let task_ns = coarse.spent.descent_ns as f64 / tasks;
    let fold_hit_ns = coarse.spent.fold_ns as f64 / hits(&coarse);
    let folded_ns = ran.spent.fold_ns as f64 - fold_hit_ns * hits(&split);
    let decided_ns = duty.step_ns.saturating_sub(ran.spent.descent_ns + ran.spent.fold_ns) as f64;
    Ok(Costs {
        job_ns,
        box_ns,
        triangle_ns,
        hit_ns,
        leaves_ns: kernel_ns(&coarse) / bench.leaf_pairs().max(1.0),
        send_ns: (duty.run_ns.saturating_sub(worker.busy_ns) as f64 / results).min(20_000.0),
        section_byte_ns: load[0],
        section_ns: load[1],
        ship_byte_ns: ship[0],
        ship_section_ns: ship[1],
        task_ns,
        descent_ns: (split.spent.descent_ns as f64 - task_ns * tasks).max(0.0) / tests(&split),
        batch_ns: duty.send_ns as f64 / per(worker.batches),
        place_ns: decided_ns / jobs,
        take_ns: (duty.take_ns as f64 + folded_ns.max(0.0)) / results,
        fold_hit_ns,
        flight_ns: FLIGHT_NS,
    })
}

/// What copying costs the coordinator and the worker, each per logical byte and per section: the
/// additional time of one worker that copies, at depths with few large and with many small
/// sections. `ran` is the run at depth `fine` that does not copy.
fn copying(bench: &Bench<'_>, fine: u32, ran: &Ran) -> Result<[[f64; 2]; 2], Failure> {
    let usual = usual(fine);
    // As good as unlimited.
    let cache = Cache::Fixed(2 * bench.model_bytes());
    let (mut ship, mut load) = (Vec::new(), Vec::new());
    for depth in [fine / 4, fine / 2, fine, fine + 4] {
        let way = Way { depth, ..usual };
        let shared = if depth == fine { None } else { Some(bench.worker_pool(&way)?) };
        let shared = shared.as_ref().unwrap_or(ran);
        let copied = bench.worker_pool(&Way { transfer: TransferMode::Copy, cache, ..way })?;
        let more = |of_duty: fn(&coordinator::Duty) -> u64| {
            of_duty(&copied.report.duty).saturating_sub(of_duty(&shared.report.duty)) as f64
        };
        let (ship_ns, longer_ns) = (more(|duty| duty.send_ns), more(|duty| duty.run_ns));
        let moved = copied.report.transfer;
        let counts = [moved.section_bytes as f64, moved.missed as f64];
        ship.push([counts[0], counts[1], ship_ns]);
        load.push([counts[0], counts[1], (longer_ns - ship_ns).max(0.0)]);
    }
    Ok([fit_copies(&ship), fit_copies(&load)])
}

/// One worker, with the default buffers.
fn usual(depth: u32) -> Way {
    Way {
        workers: 1,
        depth,
        scheme: Scheme::BestMatchLoad,
        matching: Matching::BestMatchLoad(0.5),
        queues: QUEUES,
        transfer: TransferMode::ZeroCopy,
        cache: Cache::Unlimited,
    }
}

/// A count as a divisor: at least 1.
fn per(count: u64) -> f64 {
    count.max(1) as f64
}
