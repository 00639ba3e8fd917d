//! Real runs, in-process and by a worker pool; each repeated, and each checked.

use crate::pair::Pair;
use body::{BodyView, Meta};
use bvh::{Counters, Kernel, Question, Task, front, parallel};
use coordinator::{
    Options, PairWork, PoseFound, Spent, WorkerPool, WorkerPoolError, WorkerPoolReport, run_watched,
};
use dispatch::{Cache, LogEntry, Matching, Queues, Thrash};
use geometry::{DVec3, Directions};
use runtime::{affinity, clock};
use scenario::Scheme;
use simulate::{JobTrace, Sample, TaskTrace, Trace};
use trolley::dispatch_options::TransferMode;
use trolley::{BUILD, Failure};

/// Depths from which the number of leaf pairs is estimated: shallower ones gave four times too
/// many.
const DEPTHS: [u32; 2] = [8, 12];

/// A pair to run.
pub(crate) struct Bench<'p> {
    pub(crate) pair: &'p Pair,
    pub(crate) bodies: Vec<(Meta, BodyView<'p>)>,
    /// The hits at each pose; a run that finds anything else is wrong.
    truth: Vec<PoseFound>,
    repeats: usize,
    /// Whether a job log is kept.
    log: bool,
}

/// Dispatch options of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) workers: u8,
    pub(crate) depth: u32,
    pub(crate) scheme: Scheme,
    pub(crate) matching: Matching,
    pub(crate) queues: Queues,
    pub(crate) transfer: TransferMode,
    pub(crate) cache: Cache,
}

/// The fastest of several runs of a worker pool: other load on the machine only adds time.
pub(crate) struct Ran {
    pub(crate) report: WorkerPoolReport,
    pub(crate) spent: Spent,
    /// Median of all (ns).
    pub(crate) median_ns: f64,
    /// Job log of the last of them, if it is kept.
    pub(crate) log: Vec<LogEntry>,
}

/// The in-process runs at one depth.
pub(crate) struct Alone {
    /// The fastest of the repeats, and their median (ns).
    pub(crate) ns: f64,
    pub(crate) median_ns: f64,
    pub(crate) trace: Trace,
    pub(crate) samples: Vec<Sample>,
    /// Of the fastest run.
    pub(crate) spent: Spent,
}

impl Alone {
    /// Keeps the faster of two measurements of the same run.
    pub(crate) fn quicken(&mut self, other: Self) {
        if other.ns < self.ns {
            *self = other;
        }
    }
}

impl<'p> Bench<'p> {
    pub(crate) fn new(pair: &'p Pair, repeats: usize, log: bool) -> Result<Self, Failure> {
        let bodies = pair.bodies.views()?;
        let mut bench = Self { pair, bodies, truth: Vec::new(), repeats, log };
        let mut work = bench.work(0);
        run_watched(&mut work, &bench.bodies, |_, _| {});
        bench.truth = work.found().ok_or_else(unknown)?;
        Ok(bench)
    }

    /// Intersecting pairs of triangles, over all poses.
    pub(crate) fn pairs(&self) -> u64 {
        self.truth.iter().map(|found| found.pairs).sum()
    }

    /// Bytes of both bodies, as sections weigh them.
    pub(crate) fn model_bytes(&self) -> u64 {
        self.bodies.iter().map(|(_, body)| bvh::section::bytes(body.nodes, 0)).sum()
    }

    /// Pairs of leaves whose boxes overlap, over all poses: estimated from two descents each, since
    /// counting them takes half as long as the work itself.
    pub(crate) fn leaf_pairs(&self) -> f64 {
        let [(_, a), (_, b)] = &self.bodies[..] else { return 0.0 };
        // A binary tree has one node fewer than twice its leaves.
        let levels = |body: &BodyView<'_>| (body.nodes.len().div_ceil(2).max(1) as f64).log2();
        let below = f64::midpoint(levels(a), levels(b)) - f64::from(DEPTHS[1]);
        let leaf_pairs_at = |pose| {
            let [upper, lower] = DEPTHS.map(|depth| {
                let mut pairs = Vec::new();
                front(a, b, pose, depth, &mut pairs, &mut Counters::default());
                pairs.len() as f64
            });
            if upper == 0.0 || below <= 0.0 {
                return lower;
            }
            // A level of both trees makes no more than four pairs out of one.
            let growth = (lower / upper).powf(1.0 / f64::from(DEPTHS[1] - DEPTHS[0]));
            lower * growth.clamp(1.0, 4.0).powf(below)
        };
        self.pair.poses.iter().map(leaf_pairs_at).sum()
    }

    fn work(&self, depth: u32) -> PairWork<'p> {
        PairWork::new([self.bodies[0].1, self.bodies[1].1], &self.pair.poses, depth)
    }

    fn check(&self, work: &PairWork<'_>) -> Result<(), Failure> {
        if work.found().ok_or_else(unknown)? == self.truth {
            return Ok(());
        }
        Err(Failure::internal("two configurations found different triangles"))
    }

    /// The jobs at one depth, from one run in this process.
    pub(crate) fn trace(&self, depth: u32) -> Result<Trace, Failure> {
        Ok(self.repeated(depth, 0)?.trace)
    }

    /// Runs all jobs in this process, each timed: the fastest of the repeats.
    pub(crate) fn alone(&self, depth: u32) -> Result<Alone, Failure> {
        self.repeated(depth, self.repeats)
    }

    fn repeated(&self, depth: u32, repeats: usize) -> Result<Alone, Failure> {
        let mut times: Vec<(u64, Spent)> = Vec::new();
        let mut samples: Vec<Sample> = Vec::new();
        let mut tasks = Vec::new();
        for round in 0..=repeats {
            let mut work = self.work(depth);
            let mut jobs = vec![TaskTrace::default(); self.pair.poses.len()];
            let mut at = 0;
            let begun_ns = clock::now_ns();
            run_watched(&mut work, &self.bodies, |job, said| {
                let sample = Sample {
                    nb: said.nb,
                    np: said.np,
                    hits: u64::from(said.hits),
                    ns: said.wall_ns as f64,
                };
                if round == 0 {
                    samples.push(Sample { ns: f64::INFINITY, ..sample });
                    let weight = |section: protocol::Section| {
                        let body = &self.bodies[section.model as usize].1;
                        (section, bvh::section::bytes(body.nodes, section.node))
                    };
                    jobs[job.task.0 as usize].jobs.push(JobTrace {
                        a: weight(job.a),
                        b: weight(job.b),
                        nb: sample.nb,
                        np: sample.np,
                        hits: sample.hits,
                    });
                } else if let Some(known) = samples.get_mut(at) {
                    known.ns = known.ns.min(sample.ns);
                }
                at += 1;
            });
            let took_ns = clock::now_ns() - begun_ns;
            self.check(&work)?;
            if round == 0 {
                for (task, nb) in jobs.iter_mut().zip(work.descents()) {
                    task.descent_nb = nb;
                }
                tasks = jobs;
            } else {
                times.push((took_ns, work.spent));
            }
        }
        times.sort_by_key(|(ns, _)| *ns);
        let (ns, spent) = times.first().copied().unwrap_or_default();
        let (median_ns, _) = times.get(times.len() / 2).copied().unwrap_or_default();
        let (ns, median_ns) = (ns as f64, median_ns as f64);
        Ok(Alone { ns, median_ns, trace: Trace { tasks }, samples, spent })
    }

    /// Runs with this many threads of this process, which share each pose: the baseline without
    /// processes, messages or depth. The fastest of the repeats (ns).
    pub(crate) fn threads(&self, threads: usize) -> Result<f64, Failure> {
        let around = Directions::around(DVec3::X, DVec3::Z);
        let [(meta_a, a), (meta_b, b)] = &self.bodies[..] else { return Err(unknown()) };
        let kernel =
            || Kernel::with_room(meta_a.depth, meta_b.depth, a.corners.len(), b.corners.len());
        let (mut least_ns, mut pairs) = (u64::MAX, 0);
        parallel::with(threads, kernel, |parallel| {
            for round in 0..=self.repeats {
                let begun_ns = clock::now_ns();
                pairs = 0;
                for pose in &self.pair.poses {
                    let question = Question::Pairs;
                    let directions = Some(&around);
                    let task = Task { a: *a, b: *b, pose: *pose, question, directions };
                    pairs += parallel.run(&task).pairs;
                }
                if round > 0 {
                    least_ns = least_ns.min(clock::now_ns() - begun_ns);
                }
            }
        });
        if pairs == self.pairs() { Ok(least_ns as f64) } else { Err(unknown()) }
    }

    /// Runs a worker pool with unlimited capacity.
    pub(crate) fn worker_pool(&self, way: &Way) -> Result<Ran, Failure> {
        self.run(way)?.map_err(|thrash| WorkerPoolError::Thrashed(thrash).into())
    }

    /// Runs a worker pool; the first run is a warm-up. The inner error: a section did not fit.
    pub(crate) fn run(&self, way: &Way) -> Result<Result<Ran, Thrash>, Failure> {
        let cores = affinity::in_turn(&affinity::allowed_cores(), way.workers.into());
        let options = Options {
            matching: way.matching,
            queues: way.queues,
            cache: way.cache,
            copies: way.transfer == TransferMode::Copy,
            log: self.log,
            ..Options::new(format!("m{}", std::process::id()), BUILD, cores)
        };
        let mut worker_pool = WorkerPool::start(self.pair.bodies.store(), &options)?;
        let mut runs = Vec::new();
        for round in 0..=self.repeats {
            let mut work = self.work(way.depth);
            let report = match worker_pool.run(&mut work) {
                Err(WorkerPoolError::Thrashed(thrash)) => return Ok(Err(thrash)),
                other => other?,
            };
            self.check(&work)?;
            if round > 0 {
                runs.push((report, work.spent));
            }
        }
        runs.sort_by_key(|(report, _)| report.duty.run_ns);
        let median_ns = runs[runs.len() / 2].0.duty.run_ns as f64;
        let (report, spent) = runs.swap_remove(0);
        Ok(Ok(Ran { report, spent, median_ns, log: worker_pool.log().to_vec() }))
    }
}

fn unknown() -> Failure {
    Failure::internal("a job was not done, so nothing can be measured")
}
