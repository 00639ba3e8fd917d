//! Runs the sheets of one subject on all cores, and keeps those that are finished.

use super::grid::Grid;
use super::machine::{Machine, SCHEMES, with_byte};
use super::table::{Beyond, Place, Point, Sheet, SheetKey, Spread};
use crate::progress::Progress;
use dispatch::{Cache, Matching, Queues};
use scenario::{EngineSettings, Scheme};
use simulate::{Costs, Home, Paging, Prepared, Setup, SimulatedRun, Trace};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use trolley::{Failure, files};

/// The traces of one subject at every depth of the grid.
pub(crate) struct Traces {
    /// Of the plain walk, for the paper's machine.
    pub(crate) plain: Vec<(u32, Trace)>,
    /// Of our walk.
    pub(crate) wide: Vec<(u32, Trace)>,
    /// Bytes of both bodies.
    pub(crate) model_bytes: u64,
    /// The costs of the paper's machine.
    pub(crate) paper: Costs,
    /// This machine's costs.
    pub(crate) here: Costs,
    /// Cost of a byte beyond memory (ns).
    pub(crate) swap_byte_ns: f64,
}

impl Traces {
    fn of_machine(&self, machine: Machine) -> (&[(u32, Trace)], &Costs) {
        match machine {
            Machine::Paper => (&self.plain, &self.paper),
            Machine::Copying | Machine::Sealed => (&self.wide, &self.here),
        }
    }
}

/// Runs all sheets that `folder` does not have yet, and returns all, in the order of the keys.
/// Without a folder nothing is kept.
pub(crate) fn sheets(
    keys: &[SheetKey],
    traces: &Traces,
    grid: &Grid,
    folder: Option<&Path>,
    bar: &Progress<'_>,
) -> Result<Vec<Sheet>, Failure> {
    let next = AtomicUsize::new(0);
    let done: Vec<Mutex<Option<Result<Sheet, Failure>>>> =
        keys.iter().map(|_| Mutex::new(None)).collect();
    // Those that take longest come first.
    let mut order: Vec<usize> = (0..keys.len()).collect();
    order.sort_by_key(|number| grid.is_light(&keys[*number]));
    let threads = runtime::affinity::allowed_cores().len().clamp(1, keys.len().max(1));
    std::thread::scope(|scope| {
        for _thread in 0..threads {
            scope.spawn(|| {
                while let Some(number) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let key = &keys[*number];
                    let sheet = match folder {
                        Some(folder) => kept(key, traces, grid, folder),
                        None => Ok(sheet(key, traces, grid)),
                    };
                    if let Ok(mut slot) = done[*number].lock() {
                        *slot = Some(sheet);
                    }
                    bar.add(1);
                }
            });
        }
    });
    let lost = || Failure::internal("a sheet of the map was lost");
    let taken = |slot: Mutex<Option<Result<Sheet, Failure>>>| {
        slot.into_inner().ok().flatten().ok_or_else(lost)?
    };
    done.into_iter().map(taken).collect()
}

/// A sheet from its file, or run and written there.
fn kept(key: &SheetKey, traces: &Traces, grid: &Grid, folder: &Path) -> Result<Sheet, Failure> {
    let (_, costs) = traces.of_machine(key.machine);
    let jobs: usize = traces.of_machine(key.machine).0.iter().map(|(_, t)| t.jobs().count()).sum();
    let made_from = format!(
        "trolley.map/1 orders {ORDERS} {FEW_ORDERS} {FEW_SEEDS} {MANY_JOBS} {} {} swap {} jobs \
        {jobs} {costs:?}",
        key.name(),
        grid.made_from(),
        traces.swap_byte_ns
    );
    let path = folder.join(format!("{}.csv", key.name()));
    // What is missing or made from something else is made anew.
    let known = std::fs::read_to_string(&path).ok();
    if let Some(sheet) = known.and_then(|text| Sheet::parse(&text, &made_from)) {
        return Ok(sheet);
    }
    let text = sheet(key, traces, grid).text(&made_from);
    files::replace(&path, text.as_bytes())?;
    // As it is read, so that a map in one go and one in parts are the same.
    Sheet::parse(&text, &made_from).ok_or_else(|| Failure::internal("a sheet cannot be read back"))
}

/// Runs one sheet.
pub(crate) fn sheet(key: &SheetKey, traces: &Traces, grid: &Grid) -> Sheet {
    let (by_depth, costs) = traces.of_machine(key.machine);
    let mut sheet = Sheet::default();
    if let Some((_, whole)) = by_depth.first() {
        sheet.alone_us = alone_ns(whole, costs) / 1e3;
    }
    for (depth, trace) in by_depth {
        let orders: Vec<Vec<Trace>> = if key.is_single {
            vec![trace.tasks.iter().map(|task| Trace { tasks: vec![task.clone()] }).collect()]
        } else {
            (0..ORDERS).map(|order| vec![turned(trace, order)]).collect()
        };
        let orders: Vec<Vec<Prepared<'_>>> =
            orders.iter().map(|parts| parts.iter().map(Prepared::new).collect()).collect();
        for (number, scheme) in SCHEMES.into_iter().enumerate() {
            if grid.is_light(key) && scheme != Scheme::BestMatchLoad {
                continue;
            }
            let bytes = if key.machine.copies() { grid.bytes.len() } else { 1 };
            for byte in 0..bytes {
                let byte_ns = if key.machine.copies() { grid.bytes[byte] } else { 0.0 };
                let costs = with_byte(costs, byte_ns);
                let place = Place { byte, short: None, depth: *depth, scheme: number };
                let cell = Cell { key, traces, grid, orders: &orders, costs: &costs };
                cell.points(scheme, place, &mut sheet);
            }
        }
    }
    sheet
}

/// Orders of the contacts over which schemes without a seed are averaged: which contact comes first
/// decides who is free when, and a scheme that looks at that may be lucky with one order.
const ORDERS: usize = 8;
/// The same for requests with so many jobs that luck evens out.
const FEW_ORDERS: usize = 1;
/// Seeds of random match for such requests.
const FEW_SEEDS: usize = 4;
/// That many.
const MANY_JOBS: usize = 3_000;

/// The same contacts, beginning with another one.
fn turned(trace: &Trace, order: usize) -> Trace {
    let mut tasks = trace.tasks.clone();
    let first = order * tasks.len() / ORDERS;
    tasks.rotate_left(first);
    Trace { tasks }
}

/// The work in one process: descents, kernel, folding (ns).
fn alone_ns(trace: &Trace, costs: &Costs) -> f64 {
    let tasks =
        trace.tasks.iter().map(|task| costs.task_ns + costs.descent_ns * task.descent_nb as f64);
    let jobs = trace
        .jobs()
        .map(|job| costs.kernel_ns(job.nb, job.np, job.hits) + costs.fold_hit_ns * job.hits as f64);
    tasks.sum::<f64>() + jobs.sum::<f64>()
}

struct Cell<'c> {
    key: &'c SheetKey,
    traces: &'c Traces,
    grid: &'c Grid,
    /// By order of the contacts: one request, or one for each contact.
    orders: &'c [Vec<Prepared<'c>>],
    costs: &'c Costs,
}

/// The runs of one seed, one for each request.
type Runs = Vec<SimulatedRun>;

impl Cell<'_> {
    /// Adds the points of one scheme at one depth and cost of a byte, over all seeds and memories.
    fn points(&self, scheme: Scheme, place: Place, sheet: &mut Sheet) {
        let jobs: usize = self.orders[0].iter().map(Prepared::len).sum();
        let orders = self.orders.len();
        let count = match scheme {
            Scheme::RandomMatch if jobs > MANY_JOBS => (self.grid.seeds as usize).min(FEW_SEEDS),
            Scheme::RandomMatch => self.grid.seeds as usize,
            _ if jobs > MANY_JOBS => orders.min(FEW_ORDERS),
            _ => orders,
        };
        // The first few orders are far apart.
        let chosen = |number: usize| &self.orders[number * orders / count.min(orders) % orders];
        let seeds: Vec<(Matching, &Vec<Prepared<'_>>)> =
            (0..count).map(|number| (matching(scheme, number as u64), chosen(number))).collect();
        let ample: Vec<Runs> = seeds
            .iter()
            .map(|(matching, parts)| {
                parts.iter().map(|part| self.run(part, *matching, None)).collect()
            })
            .collect();
        sheet.points.insert(place, self.point(&ample, &ample, u64::MAX));
        if !self.key.machine.copies() {
            return;
        }
        for (number, percent) in self.grid.memories.iter().enumerate() {
            let memory = self.traces.model_bytes * u64::from(*percent) / 100;
            if ample.iter().flatten().all(|run| most(run) <= memory) {
                continue;
            }
            for beyond in Beyond::ALL {
                let again = |((matching, parts), runs): (&(Matching, &Vec<_>), &Runs)| -> Runs {
                    let parts = parts.iter().zip(runs);
                    let run = |(part, run): (&Prepared<'_>, &SimulatedRun)| {
                        // What suffices changes nothing: `simulate/src/machine/tests.rs`.
                        if most(run) <= memory {
                            return run.clone();
                        }
                        self.run(part, *matching, Some((beyond, memory)))
                    };
                    parts.map(run).collect()
                };
                let short: Vec<Runs> = seeds.iter().zip(&ample).map(again).collect();
                let place = Place { short: Some((beyond, number)), ..place };
                sheet.points.insert(place, self.point(&short, &ample, memory));
            }
        }
    }

    fn run(
        &self,
        part: &Prepared<'_>,
        matching: Matching,
        short: Option<(Beyond, u64)>,
    ) -> SimulatedRun {
        let SheetKey { machine, cores, buffer, .. } = *self.key;
        let (cache, paging) = match short {
            None => (Cache::Unlimited, None),
            Some((Beyond::Evict, bytes)) => (Cache::Recent(bytes), None),
            Some((Beyond::Swap, memory_bytes)) => {
                let byte_ns = self.traces.swap_byte_ns;
                (Cache::Unlimited, Some(Paging { memory_bytes, byte_ns }))
            }
        };
        let setup = Setup {
            workers: cores,
            home: Home::Shared,
            matching,
            queues: Queues { capacity: buffer, batch: (buffer / 4).max(1), linger_ns: 0 },
            cache,
            copies: machine.copies(),
            paging,
        };
        part.run(self.costs, &setup)
    }

    /// The point of these runs; `ample` are the same with memory that suffices.
    fn point(&self, runs: &[Runs], ample: &[Runs], memory: u64) -> Point {
        let bytes = self.traces.model_bytes.max(1) as f64;
        let requests = self.orders[0].len() as f64;
        let sum = |value: fn(&SimulatedRun) -> f64| -> Vec<f64> {
            runs.iter().map(|runs| runs.iter().map(value).sum::<f64>()).collect()
        };
        let times: Vec<f64> = sum(|run| run.time_ns / 1e3);
        let moved = sum(|run| run.transfer.section_bytes as f64);
        let moved: Vec<f64> = moved.into_iter().map(|sum| sum / bytes / requests).collect();
        let swapped = sum(|run| run.swapped_bytes as f64);
        let all = ample.iter().flatten().count().max(1) as f64;
        let out = ample.iter().flatten().filter(|run| most(run) > memory).count() as f64;
        let peak: f64 = ample.iter().flatten().map(|run| most(run) as f64).sum();
        Point {
            time_us: Spread::over(&times),
            moved: Spread::over(&moved),
            swapped: swapped.iter().sum::<f64>() / swapped.len().max(1) as f64 / bytes / requests,
            out: out / all,
            peak: peak / all / bytes,
        }
    }
}

/// The most that came to one core.
fn most(run: &SimulatedRun) -> u64 {
    run.received.iter().copied().max().unwrap_or(0)
}

pub(crate) fn matching(scheme: Scheme, seed: u64) -> Matching {
    match scheme {
        Scheme::BestMatchLoad => Matching::BestMatchLoad(EngineSettings::DEFAULT.alpha),
        Scheme::BestMatch => Matching::BestMatch,
        Scheme::RandomMatch => Matching::RandomMatch(seed),
        Scheme::LowestMatch => Matching::LowestMatch,
        Scheme::RoundRobin => Matching::RoundRobin,
    }
}
