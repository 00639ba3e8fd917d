//! The sweep over one pair: schemes, depths, buffers, workers and transfer modes, measured on this
//! machine's cores and simulated with four.

use super::bench::{Alone, Bench, Ran, Way};
use super::calibrate::{QUEUES, calibrate};
use super::row::{Mode, Row};
use super::swept::{Check, Shares, Swept};
use crate::progress::Progress;
use dispatch::{Cache, LogEntry, Matching, Queues, Thrash};
use scenario::{EngineSettings, Scheme};
use simulate::{Costs, Home, Setup};
use trolley::Failure;
use trolley::dispatch_options::{self, BUDGET_PERCENT, DispatchOptions, TransferMode};

/// Workers of the quad-core machine.
pub(crate) const CORES: u8 = 4;
/// Depth at which costs are calibrated.
pub(crate) const FINE: u32 = 8;

/// What to sweep.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) depths: Vec<u32>,
    /// Queue capacities; a batch is a quarter of them.
    pub(crate) buffers: Vec<u32>,
    /// Number of passes over the whole sweep.
    pub(crate) passes: u32,
    pub(crate) schemes: Vec<Scheme>,
    pub(crate) seed: u64,
    pub(crate) alpha: f64,
    /// How jobs reach the workers of measured runs.
    pub(crate) dispatch_options: DispatchOptions,
    /// Whether copying is measured as well.
    pub(crate) copies_too: bool,
}

impl Plan {
    fn matching(&self, scheme: Scheme) -> Matching {
        let (alpha, seed) = (self.alpha, self.seed);
        dispatch_options::matching(&EngineSettings {
            scheme,
            alpha,
            seed,
            ..EngineSettings::DEFAULT
        })
    }
}

/// Number of progress steps of a sweep.
pub(crate) fn steps(plan: &Plan) -> u64 {
    u64::from(plan.passes) * (plan.depths.len() as u64 + 1)
        + (plan.depths.len() + plan.buffers.len()) as u64
}

/// Sweeps a pair in several passes, of which the fastest counts: bursts of other programs last
/// longer than the repeats of one run.
pub(crate) fn sweep(bench: &Bench<'_>, plan: &Plan, bar: &Progress<'_>) -> Result<Swept, Failure> {
    let deepest = plan.depths.iter().copied().max().unwrap_or(0);
    let cache = plan.dispatch_options.cache(deepest, &bench.bodies)?;
    let mut alone: Vec<(u32, Alone)> = Vec::new();
    let mut whole = bench.alone(0)?;
    let mut sweep = Sweep {
        bench,
        plan,
        bar,
        cache,
        log: Vec::new(),
        costs: calibrate(bench, FINE)?,
        alone_ns: f64::INFINITY,
        predicted_ns: 0.0,
        model_bytes: bench.model_bytes(),
        rows: Vec::new(),
        checks: Vec::new(),
        shares: Vec::new(),
    };
    let threads = runtime::affinity::allowed_cores().len().max(1);
    let mut threads_ns = f64::INFINITY;
    for pass in 0..plan.passes {
        if pass > 0 {
            sweep.costs = calmer(sweep.costs, calibrate(bench, FINE)?);
            whole.quicken(bench.alone(0)?);
        }
        bar.add(1);
        for (number, depth) in plan.depths.iter().enumerate() {
            let again = bench.alone(*depth)?;
            match alone.get_mut(number) {
                Some((_, known)) => known.quicken(again),
                None => alone.push((*depth, again)),
            }
            sweep.measure_depth(*depth)?;
            bar.add(1);
        }
        threads_ns = threads_ns.min(bench.threads(threads)?);
    }
    let all = alone.iter().map(|(depth, alone)| (alone, *depth)).chain([(&whole, 0)]);
    let (best, best_depth) = all.min_by(|a, b| a.0.ns.total_cmp(&b.0.ns)).unwrap_or((&whole, 0));
    sweep.alone_ns = best.ns;
    sweep.predicted_ns = predicted(&whole, &sweep.costs);
    for (depth, alone) in &alone {
        sweep.simulate_depth(*depth, alone);
        bar.add(1);
    }
    sweep.buffers(&alone)?;
    sweep.relate();
    let [a, b] = [0, 1].map(|body: usize| bench.bodies[body].1.corners.len());
    Ok(Swept {
        pair: bench.pair.name.clone(),
        triangles: [a, b],
        poses: bench.pair.poses.len(),
        pairs_found: bench.pairs(),
        model_bytes: sweep.model_bytes,
        costs: sweep.costs,
        alone_ms: best.ns / 1e6,
        alone_median_ms: best.median_ns / 1e6,
        alone_depth: best_depth,
        threads,
        threads_ms: threads_ns / 1e6,
        alone_predicted_ms: sweep.predicted_ns / 1e6,
        checks: sweep.checks,
        shares: sweep.shares,
        rows: sweep.rows,
        log: sweep.log,
    })
}

/// Merges two calibrations: the kernel costs of the faster one, and the lower of each other cost.
fn calmer(a: Costs, b: Costs) -> Costs {
    let typical = |costs: &Costs| costs.kernel_ns(1_000, 200, 40);
    let kernel = if typical(&a) <= typical(&b) { a } else { b };
    let copied = |costs: &Costs| {
        1_000.0 * (costs.section_byte_ns + costs.ship_byte_ns)
            + (costs.section_ns + costs.ship_section_ns)
    };
    let copies = if copied(&a) <= copied(&b) { a } else { b };
    Costs {
        leaves_ns: a.leaves_ns.min(b.leaves_ns),
        send_ns: a.send_ns.min(b.send_ns),
        // Those of one fit belong together.
        section_byte_ns: copies.section_byte_ns,
        section_ns: copies.section_ns,
        ship_byte_ns: copies.ship_byte_ns,
        ship_section_ns: copies.ship_section_ns,
        task_ns: a.task_ns.min(b.task_ns),
        descent_ns: a.descent_ns.min(b.descent_ns),
        batch_ns: a.batch_ns.min(b.batch_ns),
        place_ns: a.place_ns.min(b.place_ns),
        take_ns: a.take_ns.min(b.take_ns),
        fold_hit_ns: a.fold_hit_ns.min(b.fold_hit_ns),
        ..kernel
    }
}

/// The in-process kernel by the cost model (ns).
fn predicted(alone: &Alone, costs: &Costs) -> f64 {
    let task =
        |task: &simulate::TaskTrace| costs.task_ns + costs.descent_ns * task.descent_nb as f64;
    let job = |job: &simulate::JobTrace| {
        costs.kernel_ns(job.nb, job.np, job.hits) + costs.fold_hit_ns * job.hits as f64
    };
    alone.trace.tasks.iter().map(task).sum::<f64>() + alone.trace.jobs().map(job).sum::<f64>()
}

struct Sweep<'s> {
    bench: &'s Bench<'s>,
    plan: &'s Plan,
    bar: &'s Progress<'s>,
    /// What a worker of a measured run may hold.
    cache: Cache,
    /// Job log of the last measured run, if it is kept.
    log: Vec<LogEntry>,
    costs: Costs,
    alone_ns: f64,
    predicted_ns: f64,
    model_bytes: u64,
    rows: Vec<Row>,
    checks: Vec<Check>,
    shares: Vec<Shares>,
}

impl Sweep<'_> {
    /// Default dispatch options.
    fn way(&self, scheme: Scheme, workers: u8, depth: u32) -> Way {
        Way {
            workers,
            depth,
            scheme,
            matching: self.plan.matching(scheme),
            queues: QUEUES,
            transfer: TransferMode::ZeroCopy,
            cache: Cache::Unlimited,
        }
    }

    /// Dispatch options that copy sections into memory of this percentage of the bodies.
    fn copying(&self, way: Way) -> Way {
        let cache = Cache::Fixed(self.model_bytes * BUDGET_PERCENT / 100);
        Way { transfer: TransferMode::Copy, cache, ..way }
    }

    /// Dispatch options for real workers.
    fn handed(&self, way: Way) -> Way {
        let linger_ns = 1_000 * self.plan.dispatch_options.linger_us;
        let queues = Queues { linger_ns, ..way.queues };
        Way { queues, transfer: self.plan.dispatch_options.transfer, cache: self.cache, ..way }
    }

    /// Measures every scheme at one depth with two workers, and one scheme with one worker.
    fn measure_depth(&mut self, depth: u32) -> Result<(), Failure> {
        let plan = self.plan;
        for &scheme in &plan.schemes {
            let way = self.handed(self.way(scheme, 2, depth));
            self.measure(way)?;
            if scheme == Scheme::BestMatchLoad {
                self.measure(Way { workers: 1, ..way })?;
                if self.plan.copies_too {
                    self.measure(self.copying(way))?;
                }
            }
        }
        Ok(())
    }

    /// Simulates every scheme at one depth on four virtual cores, and predicts one and two workers.
    fn simulate_depth(&mut self, depth: u32, alone: &Alone) {
        let plan = self.plan;
        for &scheme in &plan.schemes {
            let way = self.way(scheme, CORES, depth);
            for way in [way, self.copying(way)] {
                for home in [Home::Own, Home::Shared] {
                    self.simulate(way, alone, home);
                }
            }
        }
        let usual = self.plan.matching(Scheme::BestMatchLoad);
        for (workers, home) in [(1, Home::Own), (2, Home::Shared)] {
            let setup = Setup {
                workers,
                home,
                matching: usual,
                queues: QUEUES,
                cache: Cache::Unlimited,
                copies: false,
                paging: None,
            };
            let predicted = simulate::run(&alone.trace, &self.costs, &setup);
            let ran = self.shares.iter().find(|s| s.workers == workers && s.depth == depth);
            let Some(measured_ms) = ran.map(|shares| shares.run_ms) else { continue };
            self.checks.push(Check {
                workers,
                depth,
                predicted_ms: predicted.time_ns / 1e6,
                measured_ms,
                predicted_speed_up: self.predicted_ns / predicted.time_ns,
                measured_speed_up: self.alone_ns / 1e6 / measured_ms,
            });
        }
    }

    /// Relates everything measured to the in-process kernel, once its best time is known.
    fn relate(&mut self) {
        let alone_ms = self.alone_ns / 1e6;
        for row in self.rows.iter_mut().filter(|row| row.mode == Mode::Measured) {
            row.speed_up = row.time_ms.map(|ms| alone_ms / ms);
        }
        // The passes have put the fastest runs last.
        self.rows.sort_by_key(|row| (row.workers, row.queue, row.depth));
        self.shares.sort_by_key(|shares| (shares.workers, shares.depth));
        for shares in &mut self.shares {
            shares.speed_up = alone_ms / shares.run_ms;
            shares.kernel_alone_ms = alone_ms;
        }
    }

    /// Measures Best Match-Load with every buffer at its best depth.
    fn buffers(&mut self, alone: &[(u32, Alone)]) -> Result<(), Failure> {
        let scheme = Scheme::BestMatchLoad;
        let best = self.rows.iter().filter(|row| {
            (row.mode, row.transfer, row.scheme)
                == (Mode::SimulatedOwnCore, TransferMode::ZeroCopy, scheme)
        });
        let best =
            best.max_by(|a, b| a.speed_up.unwrap_or(0.0).total_cmp(&b.speed_up.unwrap_or(0.0)));
        let Some(depth) = best.map(|row| row.depth) else { return Ok(()) };
        let Some((_, alone)) = alone.iter().find(|(known, _)| *known == depth) else {
            return Ok(());
        };
        for capacity in &self.plan.buffers {
            let batch = (capacity / 4).max(1);
            let queues = Queues { capacity: *capacity, batch, linger_ns: 0 };
            if queues != QUEUES {
                let way = |workers| Way { queues, ..self.way(scheme, workers, depth) };
                let (measured, simulated) = (self.handed(way(2)), way(CORES));
                for _pass in 0..self.plan.passes {
                    self.measure(measured)?;
                }
                for home in [Home::Own, Home::Shared] {
                    self.simulate(simulated, alone, home);
                }
            }
            self.bar.add(1);
        }
        Ok(())
    }

    /// A run by real workers. Of several passes the fastest stays in the table.
    fn measure(&mut self, way: Way) -> Result<(), Failure> {
        let ran = match self.bench.run(&way)? {
            Ok(ran) => ran,
            // Whether a run thrashes does not depend on time, so every pass agrees.
            Err(_) if self.rows.iter().any(|row| is_of(row, &way) && row.thrashed.is_some()) => {
                return Ok(());
            }
            Err(thrash) => {
                let row = self.lost(Mode::Measured, &way, &thrash);
                self.rows.push(row);
                return Ok(());
            }
        };
        self.log.clone_from(&ran.log);
        let (report, duty) = (&ran.report, ran.report.duty);
        let sum = |of: fn(&coordinator::WorkerReport) -> u64| report.workers.iter().map(of).sum();
        let moved = report.transfer;
        let run_ns = duty.run_ns as f64;
        // Runs that copy in addition do not show where the time usually goes.
        let is_usual = way.queues.capacity == QUEUES.capacity
            && way.scheme == Scheme::BestMatchLoad
            && way.transfer == self.plan.dispatch_options.transfer;
        if let Some(at) = self.rows.iter().position(|row| is_of(row, &way)) {
            if self.rows[at].time_ms.is_some_and(|ms| ms <= run_ns / 1e6) {
                return Ok(());
            }
            self.rows.remove(at);
            if is_usual {
                self.shares
                    .retain(|known| (known.workers, known.depth) != (way.workers, way.depth));
            }
        }
        self.rows.push(Row {
            time_ms: Some(run_ns / 1e6),
            median_ms: Some(ran.median_ns / 1e6),
            speed_up: Some(self.alone_ns / run_ns),
            jobs: report.counts.jobs,
            messages: sum(|w| w.batches + w.results),
            message_bytes: Some(sum(|w| w.batch_bytes + w.result_bytes)),
            cache_lines: Some(sum(|w| w.batch_lines + w.result_lines)),
            section_bytes: Some(moved.section_bytes),
            relative_to_models: Some(ratio(moved.section_bytes, self.model_bytes)),
            relative_to_unshared: Some(ratio(moved.section_bytes, moved.unshared_bytes)),
            ..self.row(Mode::Measured, &way)
        });
        if is_usual {
            self.shares.push(self.shares_of(&way, &ran));
        }
        Ok(())
    }

    /// Where the time of a measured run went.
    fn shares_of(&self, way: &Way, ran: &Ran) -> Shares {
        let duty = ran.report.duty;
        let busy = ran.report.workers.iter().map(|worker| worker.busy_ns);
        let ms = |ns: u64| ns as f64 / 1e6;
        let decided = duty.step_ns.saturating_sub(ran.spent.descent_ns + ran.spent.fold_ns);
        Shares {
            workers: way.workers,
            depth: way.depth,
            run_ms: ms(duty.run_ns),
            speed_up: self.alone_ns / duty.run_ns as f64,
            kernel_ms: ms(busy.clone().sum()),
            kernel_alone_ms: self.alone_ns / 1e6,
            worker_least_ms: ms(busy.clone().min().unwrap_or(0)),
            worker_most_ms: ms(busy.max().unwrap_or(0)),
            descent_ms: ms(ran.spent.descent_ns),
            fold_ms: ms(ran.spent.fold_ns),
            decide_ms: ms(decided),
            send_ms: ms(duty.send_ns),
            take_ms: ms(duty.take_ns),
        }
    }

    /// A run on virtual cores.
    fn simulate(&mut self, way: Way, alone: &Alone, home: Home) {
        let Way { workers, matching, queues, cache, .. } = way;
        let copies = way.transfer == TransferMode::Copy;
        let setup = Setup { workers, home, matching, queues, cache, copies, paging: None };
        let out = simulate::run(&alone.trace, &self.costs, &setup);
        let mode = match home {
            Home::Own => Mode::SimulatedOwnCore,
            Home::Shared => Mode::SimulatedSharedCore,
        };
        let moved = out.transfer.section_bytes;
        if let Some(thrash) = out.thrash {
            let row = self.lost(mode, &way, &thrash);
            self.rows.push(row);
            return;
        }
        self.rows.push(Row {
            time_ms: Some(out.time_ns / 1e6),
            speed_up: Some(self.predicted_ns / out.time_ns),
            jobs: out.counts.jobs,
            messages: out.counts.batches + out.counts.done,
            section_bytes: Some(moved),
            relative_to_models: Some(ratio(moved, self.model_bytes)),
            relative_to_unshared: Some(ratio(moved, out.transfer.unshared_bytes)),
            ..self.row(mode, &way)
        });
    }

    /// A run that ended because a section did not fit: a reason without figures.
    fn lost(&self, mode: Mode, way: &Way, thrash: &Thrash) -> Row {
        let why = format!(
            "worker {} held {} of {} bytes and needed {} more",
            thrash.core, thrash.held, thrash.budget, thrash.bytes
        );
        Row { thrashed: Some(why), ..self.row(mode, way) }
    }

    /// A row without figures.
    fn row(&self, mode: Mode, way: &Way) -> Row {
        Row {
            pair: self.bench.pair.name.clone(),
            mode,
            transfer: way.transfer,
            scheme: way.scheme,
            depth: way.depth,
            workers: way.workers,
            queue: way.queues.capacity,
            batch: way.queues.batch,
            time_ms: None,
            median_ms: None,
            speed_up: None,
            jobs: 0,
            messages: 0,
            message_bytes: None,
            cache_lines: None,
            section_bytes: None,
            relative_to_models: None,
            relative_to_unshared: None,
            thrashed: None,
        }
    }
}

/// Whether a row is of a real run with these options.
fn is_of(row: &Row, way: &Way) -> bool {
    (row.mode, row.transfer, row.scheme) == (Mode::Measured, way.transfer, way.scheme)
        && (row.depth, row.workers, row.queue) == (way.depth, way.workers, way.queues.capacity)
}

fn ratio(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}
