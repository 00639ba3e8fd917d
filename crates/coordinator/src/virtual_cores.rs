//! A ranking on virtual cores: how long it would take with more cores than there are.
//!
//! ```text
//! the coordinator's work, here ──▶ timed ──▶ its virtual clock ──┐
//! looks and jobs, here ──────────▶ timed ──▶ those of workers ───┴▶ when each result arrives
//! ```
//!
//! All work is done in this process, one piece after the other, and every piece takes as long on
//! its virtual core as it took here; what messages cost is given. The order of events is that of
//! the virtual clocks, so what a look shows is learnt, and asks for the next one, when its result
//! would arrive. A worker pauses while a thread that helps the coordinator is on its core. The
//! answer does not depend on any of this.
//!
//! Looks and jobs go to whoever has the fewest: no sections are counted. Results of surveys are
//! folded as soon as they are found, though their time counts when they arrive. Caches, memory
//! bandwidth and other programs are as they are here, where one piece runs at a time.

use crate::idle_cores::{IdleCores, VirtualHelp};
use crate::in_process::InProcessExecutor;
use crate::looks::{LookEffort, LookSource, LookTimes, Seen};
use crate::work::TaskSource;
use core::ops::ControlFlow;
use dispatch::{Closed, Job};
use runtime::clock;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// What messages cost (ns).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MessageCosts {
    /// Coordinator: per job handed out.
    pub hand_out_ns: u64,
    /// From there to the worker, and from the worker to the coordinator.
    pub flight_ns: u64,
    /// Worker: per result.
    pub send_ns: u64,
    /// Coordinator: per result.
    pub take_ns: u64,
    /// From the start of a thread that helps to its first work.
    pub thread_ns: u64,
}

/// The cores of a ranking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VirtualSetup {
    /// Workers, each on a core of its own; 0 counts as 1.
    pub workers: usize,
    /// Whether the coordinator runs on the core of the first worker, which pauses while it is busy;
    /// otherwise it has a core of its own.
    pub is_shared: bool,
    /// What messages cost.
    pub costs: MessageCosts,
}

/// How long a ranking took on virtual cores (ns).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct VirtualTime {
    /// From its acceptance to its answer.
    pub total_ns: u64,
    /// All of it by one core, without messages: what it took here.
    pub alone_ns: u64,
    /// What the coordinator was busy for, by itself.
    pub coordinator_ns: u64,
    /// What each worker was.
    pub busy_ns: Vec<u64>,
}

/// Jobs of a survey that a worker has at once.
const OUT_OF_SURVEY: usize = 32;

/// Runs requests in this process as if by a coordinator and workers.
#[derive(Debug)]
pub struct VirtualCores {
    setup: VirtualSetup,
    executor: InProcessExecutor,
    /// The coordinator's virtual time.
    now_ns: u64,
    /// Up to when the clock is accounted for.
    counted_ns: u64,
    time: VirtualTime,
    workers: Vec<VirtualWorker>,
    /// What helpers have done since then.
    helped: Arc<Mutex<VirtualHelp>>,
}

/// A worker: it does what it has in order.
#[derive(Clone, Debug, Default)]
struct VirtualWorker {
    /// When it has done all that it has.
    free_ns: u64,
    /// When it sends the results that were not taken yet.
    sent_ns: VecDeque<u64>,
}

impl VirtualCores {
    /// Cores that do the work of this executor.
    #[must_use]
    pub fn new(setup: VirtualSetup, executor: InProcessExecutor) -> Self {
        let mut cores = Self {
            setup,
            executor,
            now_ns: 0,
            counted_ns: 0,
            time: VirtualTime::default(),
            workers: Vec::new(),
            helped: Arc::default(),
        };
        // What begins no request, as a search for every policy, has workers all the same.
        cores.begin(clock::now_ns());
        cores
    }

    /// Begins a request that was accepted at this time (monotonic).
    pub(crate) fn begin(&mut self, accepted_ns: u64) {
        let workers = self.setup.workers.max(1);
        self.now_ns = 0;
        self.counted_ns = accepted_ns;
        self.take_help();
        self.workers = vec![VirtualWorker::default(); workers];
        self.time = VirtualTime { busy_ns: vec![0; workers], ..VirtualTime::default() };
    }

    /// Ends it.
    pub(crate) fn end(&mut self) {
        self.count();
        self.time.total_ns = self.now_ns;
    }

    /// How long the last request took.
    #[must_use]
    pub fn time(&self) -> &VirtualTime {
        &self.time
    }

    /// The cores that share what the coordinator does while workers wait.
    pub(crate) fn idle_cores(&self) -> IdleCores {
        let workers = (self.workers.len(), self.setup.is_shared);
        IdleCores::virtual_ones(workers, self.setup.costs.thread_ns, Arc::clone(&self.helped))
    }

    fn take_help(&self) -> VirtualHelp {
        core::mem::take(&mut *self.helped.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Looks, as workers would.
    pub(crate) fn look<S: LookSource>(&mut self, source: &mut S) -> LookEffort {
        let (mut effort, mut times) = (LookEffort::default(), LookTimes::default());
        let mut out: Vec<VecDeque<(S::Id, Seen)>> = Vec::new();
        out.resize_with(self.workers.len(), VecDeque::new);
        loop {
            let most_out = times.out_per_worker() * self.workers.len();
            while out.iter().map(VecDeque::len).sum::<usize>() < most_out {
                let Some(id) = source.next() else { break };
                self.hand_out();
                let begun_ns = clock::now_ns();
                let seen = source.look(id, &mut |_| ControlFlow::Continue(()));
                let took_ns = clock::now_ns() - begun_ns;
                times.add(took_ns);
                let worker = self.give(took_ns);
                out[worker].push_back((id, seen));
                effort.jobs += 1;
            }
            self.count();
            let Some((arrives_ns, worker)) = self.first_result() else { return effort };
            if arrives_ns > self.now_ns && source.use_spare_time() {
                continue;
            }
            self.take(worker);
            if let Some((id, seen)) = out[worker].pop_front() {
                effort.learn(source, id, seen);
            }
        }
    }

    /// Works off a request as workers would. Returns the number of jobs.
    pub(crate) fn work_off<W: TaskSource>(&mut self, work: &mut W) -> u64 {
        work.accept(clock::now_ns());
        let (mut jobs, mut count) = (Vec::new(), 0);
        // How long each result takes to be folded, by worker.
        let mut folds = vec![VecDeque::new(); self.workers.len()];
        loop {
            jobs.clear();
            work.more(&mut jobs);
            if jobs.is_empty() {
                break;
            }
            for job in &jobs {
                count += 1;
                if work.is_obsolete(job) {
                    work.close(job, Closed::Cut);
                    continue;
                }
                if folds.iter().map(VecDeque::len).sum::<usize>() >= OUT_OF_SURVEY * folds.len() {
                    self.take_first(&mut folds);
                }
                self.hand_out();
                let (job_ns, fold_ns) = run(&mut self.executor, work, job);
                let worker = self.give(job_ns);
                folds[worker].push_back(fold_ns);
                self.counted_ns = clock::now_ns();
            }
        }
        while self.take_first(&mut folds) {}
        count
    }

    /// Takes the result that arrives first, and folds it; `false` if there is none.
    fn take_first(&mut self, folds: &mut [VecDeque<u64>]) -> bool {
        self.count();
        let Some((_, worker)) = self.first_result() else { return false };
        self.take(worker);
        let fold_ns = folds[worker].pop_front().unwrap_or(0);
        self.time.alone_ns += fold_ns;
        self.work(fold_ns);
        true
    }

    /// When the next result arrives, and from which worker.
    fn first_result(&self) -> Option<(u64, usize)> {
        let first = |(number, worker): (usize, &VirtualWorker)| {
            worker.sent_ns.front().map(|sent_ns| (sent_ns + self.setup.costs.flight_ns, number))
        };
        self.workers.iter().enumerate().filter_map(first).min()
    }

    /// Takes the next result of a worker, as soon as it is there.
    fn take(&mut self, worker: usize) {
        let sent_ns = self.workers[worker].sent_ns.pop_front().unwrap_or(0);
        self.now_ns = self.now_ns.max(sent_ns + self.setup.costs.flight_ns);
        self.work(self.setup.costs.take_ns);
    }

    fn hand_out(&mut self) {
        self.count();
        self.work(self.setup.costs.hand_out_ns);
    }

    /// Gives whoever has the fewest a job that takes so long. Returns whom.
    fn give(&mut self, job_ns: u64) -> usize {
        let load = |number: &usize| {
            let worker = &self.workers[*number];
            (worker.sent_ns.len(), worker.free_ns)
        };
        let number = (0..self.workers.len()).min_by_key(load).unwrap_or(0);
        let MessageCosts { flight_ns, send_ns, .. } = self.setup.costs;
        let worker = &mut self.workers[number];
        worker.free_ns = worker.free_ns.max(self.now_ns + flight_ns) + job_ns + send_ns;
        worker.sent_ns.push_back(worker.free_ns);
        self.time.busy_ns[number] += job_ns + send_ns;
        self.time.alone_ns += job_ns;
        self.counted_ns = clock::now_ns();
        number
    }

    /// Counts what was done here since the last time as the coordinator's.
    fn count(&mut self) {
        let now_ns = clock::now_ns();
        let here_ns = now_ns.saturating_sub(self.counted_ns);
        self.counted_ns = now_ns;
        self.time.alone_ns += here_ns;
        let VirtualHelp { spared_ns, done_ns } = self.take_help();
        let begun_ns = self.now_ns;
        self.work(here_ns.saturating_sub(spared_ns));
        // The first worker has the coordinator's core, if they share one. Of the others those help
        // first that have nothing to do.
        let mut idle: Vec<&mut VirtualWorker> =
            self.workers.iter_mut().skip(usize::from(self.setup.is_shared)).collect();
        idle.sort_by_key(|worker| worker.free_ns);
        for (worker, done_ns) in idle.into_iter().zip(done_ns) {
            worker.pause(begun_ns, done_ns);
        }
    }

    /// The coordinator works.
    fn work(&mut self, ns: u64) {
        let begun_ns = self.now_ns;
        self.now_ns += ns;
        self.time.coordinator_ns += ns;
        if let (true, Some(worker)) = (self.setup.is_shared, self.workers.first_mut()) {
            worker.pause(begun_ns, ns);
        }
    }
}

impl VirtualWorker {
    /// Does nothing for so long, from a time on, if it has anything to do then.
    fn pause(&mut self, from_ns: u64, ns: u64) {
        if self.free_ns > from_ns {
            self.free_ns += ns;
        }
        for sent_ns in self.sent_ns.iter_mut().filter(|sent_ns| **sent_ns > from_ns) {
            *sent_ns += ns;
        }
    }
}

/// Runs a job. Returns how long it took, and how long its result took to be folded.
fn run<W: TaskSource>(executor: &mut InProcessExecutor, work: &mut W, job: &Job) -> (u64, u64) {
    let begun_ns = clock::now_ns();
    let mut done_ns = None;
    executor.run(work, job, &mut |_, _| done_ns = Some(clock::now_ns()));
    let end_ns = clock::now_ns();
    let done_ns = done_ns.unwrap_or(end_ns);
    (done_ns - begun_ns, end_ns - done_ns)
}

#[cfg(test)]
mod tests;
