//! A machine of virtual cores that runs a trace.

use crate::costs::Costs;
use crate::paging::{Pager, Paging};
use crate::trace::{JobTrace, Replay, Trace, Weights};
use dispatch::{
    Cache, Counts, Dispatcher, Effect, Event, MatchScheme, Matching, Progress, Queues, Thrash,
    Transfer,
};
use protocol::{Incarnation, JobId, RequestId};
use std::collections::VecDeque;

/// Where the coordinator runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Home {
    /// On a core of its own.
    Own,
    /// On the core of worker 0, which pauses while the coordinator is busy.
    Shared,
}

/// There is only one request.
const REQUEST: RequestId = RequestId(1);

/// What is simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Workers, each on a core of its own.
    pub workers: u8,
    /// Where the coordinator runs.
    pub home: Home,
    /// How jobs are matched to workers.
    pub matching: Matching,
    /// Sizes of queues and batches.
    pub queues: Queues,
    /// What a core may hold.
    pub cache: Cache,
    /// Whether sections are copied: then their bytes cost time.
    pub copies: bool,
    /// Memory of a core beyond which what it holds lies in virtual memory; `None`: all is memory.
    /// It changes no placement: a section that was swapped out is held all the same.
    pub paging: Option<Paging>,
}

/// The result of a simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SimulatedRun {
    /// From the start to the last result folded (ns).
    pub time_ns: f64,
    /// Busy time of each worker (ns).
    pub busy_ns: Vec<f64>,
    /// Busy time of the coordinator (ns).
    pub coordinator_ns: f64,
    /// Jobs and batches.
    pub counts: Counts,
    /// Sections that were transferred.
    pub transfer: Transfer,
    /// Bytes that came to each worker. Without eviction, that is what it holds in the end.
    pub received: Vec<u64>,
    /// Bytes that moved between memory and virtual memory, over all workers.
    pub swapped_bytes: u64,
    /// Time that workers waited for them (ns).
    pub swapped_ns: f64,
    /// The section that did not fit: then the run ended there, and its time is meaningless.
    pub thrash: Option<Thrash>,
}

/// A worker: a server that takes its jobs in order.
#[derive(Clone, Debug, Default)]
struct Server {
    /// When it has done all that it has (ns).
    free_ns: f64,
    busy_ns: f64,
    /// Jobs it has, and when their results are sent (ns).
    sent: VecDeque<(f64, JobId, u8)>,
}

/// Runs the trace once. For many runs of one trace, keep a [`Prepared`].
#[must_use]
pub fn run(trace: &Trace, costs: &Costs, setup: &Setup) -> SimulatedRun {
    Prepared::new(trace).run(costs, setup)
}

/// A trace with what every run of it looks up.
#[derive(Debug)]
pub struct Prepared<'t> {
    trace: &'t Trace,
    jobs: Vec<&'t JobTrace>,
    weights: Weights,
}

impl<'t> Prepared<'t> {
    /// Indexes the trace.
    #[must_use]
    pub fn new(trace: &'t Trace) -> Self {
        Self { trace, jobs: trace.jobs().collect(), weights: Weights::new(trace) }
    }

    /// Number of jobs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.jobs.len()
    }

    /// Whether there are no jobs.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty()
    }

    /// Runs the trace.
    #[must_use]
    pub fn run(&self, costs: &Costs, setup: &Setup) -> SimulatedRun {
        run_prepared(self, costs, setup)
    }
}

fn run_prepared(prepared: &Prepared<'_>, costs: &Costs, setup: &Setup) -> SimulatedRun {
    let workers = usize::from(setup.workers);
    let scheme = setup.matching.scheme();
    let mut machine = Machine {
        dispatcher: Dispatcher::new(scheme, setup.queues, setup.cache, workers),
        replay: Replay::new(prepared.trace, &prepared.weights),
        jobs: &prepared.jobs,
        costs,
        home: setup.home,
        copies: setup.copies,
        servers: vec![Server::default(); workers],
        pager: setup.paging.map(|paging| Pager::new(workers, paging)),
        received: vec![0; workers],
        effects: Vec::new(),
        now_ns: 0.0,
        coordinator_ns: 0.0,
    };
    machine.dispatcher.begin(REQUEST);
    for worker in 0..setup.workers {
        machine.dispatcher.admit(Incarnation { worker, inc: 0 });
    }
    let mut progress = machine.step(Event::Poll);
    while progress == Progress::Working {
        progress = machine.next();
    }
    SimulatedRun {
        time_ns: machine.now_ns,
        busy_ns: machine.servers.iter().map(|server| server.busy_ns).collect(),
        coordinator_ns: machine.coordinator_ns,
        counts: machine.dispatcher.counts(),
        transfer: machine.dispatcher.transfer(),
        swapped_bytes: machine.pager.as_ref().map_or(0, Pager::moved_bytes),
        swapped_ns: machine.pager.as_ref().map_or(0.0, Pager::moved_ns),
        received: machine.received,
        thrash: machine.dispatcher.thrash(),
    }
}

struct Machine<'t> {
    dispatcher: Dispatcher<Box<dyn MatchScheme>>,
    replay: Replay<'t>,
    jobs: &'t [&'t JobTrace],
    costs: &'t Costs,
    home: Home,
    copies: bool,
    servers: Vec<Server>,
    pager: Option<Pager>,
    received: Vec<u64>,
    /// Scratch.
    effects: Vec<Effect>,
    /// The coordinator's time.
    now_ns: f64,
    coordinator_ns: f64,
}

impl Machine<'_> {
    /// The next result, or the next batch that has lingered.
    fn next(&mut self) -> Progress {
        let first = |(number, server): (usize, &Server)| {
            server.sent.front().map(|(sent_ns, ..)| (*sent_ns, number))
        };
        let next = self.servers.iter().enumerate().filter_map(first);
        let next = next.min_by(|a, b| a.0.total_cmp(&b.0));
        let due = self.dispatcher.due_ns().map(|due_ns| due_ns as f64);
        match (next, due) {
            (Some((sent_ns, worker)), due) if due.is_none_or(|due| sent_ns <= due) => {
                self.now_ns = self.now_ns.max(sent_ns + self.costs.flight_ns);
                let Some((_, job, attempt)) = self.servers[worker].sent.pop_front() else {
                    return Progress::Stranded;
                };
                let hits = self.jobs[job.0 as usize].hits;
                self.work(self.costs.take_ns + self.costs.fold_hit_ns * hits as f64);
                let from = Incarnation { worker: worker as u8, inc: 0 };
                let (request, part, last, body) = (REQUEST, 0, true, ());
                self.step(Event::Part { from, request, job, attempt, part, last, body })
            }
            (_, Some(due)) => {
                self.now_ns = self.now_ns.max(due);
                self.step(Event::Poll)
            }
            // Jobs are open and no worker has one: the dispatcher's own tests rule this out.
            (_, None) => Progress::Stranded,
        }
    }

    fn step(&mut self, event: Event<()>) -> Progress {
        let mut effects = std::mem::take(&mut self.effects);
        let now_ns = self.now_ns as u64;
        let progress = self.dispatcher.step(now_ns, event, &mut self.replay, &mut effects);
        let (tasks, tests) = std::mem::take(&mut self.replay.descents);
        self.work(self.costs.task_ns * tasks as f64 + self.costs.descent_ns * tests as f64);
        for effect in effects.drain(..) {
            // Nothing goes wrong here, so no worker is killed.
            let Effect::Send { to, jobs, fetch, .. } = effect else { continue };
            let weight = |section: &_| dispatch::JobSource::weight(&self.replay, *section);
            let fetched: u64 = fetch.iter().map(weight).sum();
            self.received[usize::from(to.worker)] += fetched;
            let (loaded, sections) =
                if self.copies { (fetched as f64, fetch.len() as f64) } else { (0.0, 0.0) };
            self.work(
                self.costs.batch_ns
                    + self.costs.place_ns * jobs.len() as f64
                    + self.costs.ship_byte_ns * loaded
                    + self.costs.ship_section_ns * sections,
            );
            let arrives_ns = self.now_ns + self.costs.flight_ns;
            let server = &mut self.servers[usize::from(to.worker)];
            server.free_ns = server.free_ns.max(arrives_ns);
            // The sections of a batch are loaded by its jobs; which of them does not matter here.
            let load_ns = (self.costs.section_byte_ns * loaded + self.costs.section_ns * sections)
                / jobs.len() as f64;
            for &(job, attempt) in &jobs {
                let JobTrace { nb, np, hits, a, b } = *self.jobs[job.0 as usize];
                let swapped_ns = self
                    .pager
                    .as_mut()
                    .map_or(0.0, |pager| pager.need(usize::from(to.worker), [a, b], &fetch));
                let ns =
                    self.costs.kernel_ns(nb, np, hits) + self.costs.send_ns + load_ns + swapped_ns;
                server.free_ns += ns;
                server.busy_ns += ns;
                server.sent.push_back((server.free_ns, job, attempt));
            }
            self.dispatcher.reuse(jobs, fetch);
        }
        self.effects = effects;
        progress
    }

    /// The coordinator works.
    fn work(&mut self, ns: f64) {
        let begun_ns = self.now_ns;
        self.now_ns += ns;
        self.coordinator_ns += ns;
        let (Home::Shared, Some(server)) = (self.home, self.servers.first_mut()) else { return };
        if server.free_ns > begun_ns {
            server.free_ns += ns;
        }
        for (sent_ns, ..) in server.sent.iter_mut().filter(|(sent_ns, ..)| *sent_ns > begun_ns) {
            *sent_ns += ns;
        }
    }
}

#[cfg(test)]
mod tests;
