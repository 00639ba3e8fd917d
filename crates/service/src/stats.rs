//! Counts of answers, times per stage, page faults, allocations and messages. Of fixed size.

use coordinator::WorkerPoolReport;
use hdrhistogram::Histogram;
use protocol::public::{Health, LatencyStage, VERSION, WireState, WorkerHealth};
use runtime::clock;

/// The longest time that a histogram resolves (ns): a minute.
const LONGEST_NS: u64 = 60_000_000_000;
/// Significant decimal digits of a time.
const DIGITS: u8 = 3;
/// Requests before page faults are counted: the first ones touch fresh memory.
const WARM: u64 = 100;

/// Counts since the service started.
#[derive(Debug)]
pub(crate) struct Stats {
    since_ns: u64,
    answers: [u64; 5],
    pub(crate) withdrawn: u64,
    pub(crate) lost: u64,
    worked: u64,
    faults: u64,
    allocations: u64,
    messages: u64,
    message_bytes: u64,
    times: [Histogram<u64>; 5],
    each: [WorkerHealth; protocol::WORKERS_MAX],
}

/// Times of one request (ns).
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times(pub(crate) [u64; 5]);

impl Stats {
    /// Empty counts. `None` if memory runs out.
    pub(crate) fn new() -> Option<Self> {
        let empty = || Histogram::new_with_max(LONGEST_NS, DIGITS).ok();
        Some(Self {
            since_ns: clock::now_ns(),
            answers: [0; 5],
            withdrawn: 0,
            lost: 0,
            worked: 0,
            faults: 0,
            allocations: 0,
            messages: 0,
            message_bytes: 0,
            times: [empty()?, empty()?, empty()?, empty()?, empty()?],
            each: [WorkerHealth::default(); protocol::WORKERS_MAX],
        })
    }

    pub(crate) fn answered(&mut self, verdict: WireState) {
        self.answers[verdict as usize - 1] += 1;
    }

    /// Counts an executed request.
    pub(crate) fn worked(&mut self, times: Times, faults: u64, allocations: u64) {
        for (histogram, time) in self.times.iter_mut().zip(times.0) {
            histogram.saturating_record(time);
        }
        self.worked += 1;
        if self.worked > WARM {
            self.faults += faults;
        }
        self.allocations = allocations;
    }

    /// Counts what the workers did for one request, in each of its rounds.
    pub(crate) fn shared(&mut self, rounds: &[WorkerPoolReport]) {
        for worker in rounds.iter().flat_map(|round| &round.workers) {
            self.messages += worker.batches + worker.results;
            self.message_bytes += worker.batch_bytes + worker.result_bytes;
            let Some(row) = self.each.get_mut(usize::from(worker.worker)) else { continue };
            row.pid = worker.pid;
            row.core = worker.core.map_or(0, |core| core as u32 + 1);
            row.jobs += worker.jobs;
            row.busy_ns += worker.busy_ns;
        }
    }

    /// Counts these workers as replaced.
    pub(crate) fn replaced(&mut self, pids: &[u32], first: bool) {
        for (row, pid) in self.each.iter_mut().zip(pids) {
            row.replaced += u64::from(!first && row.pid != *pid);
            row.pid = *pid;
        }
    }

    pub(crate) fn health(&self) -> Health {
        let zero: Health = bytemuck::Zeroable::zeroed();
        let mut latency_ns = [[0; 4]; 5];
        for (row, histogram) in latency_ns.iter_mut().zip(&self.times) {
            let quantile = |share| histogram.value_at_quantile(share);
            *row = [quantile(0.5), quantile(0.99), quantile(0.999), histogram.max()];
        }
        Health {
            version: VERSION,
            pid: std::process::id(),
            at_ns: clock::now_ns(),
            since_ns: self.since_ns,
            answers: self.answers,
            withdrawn: self.withdrawn,
            lost: self.lost,
            faults: self.faults,
            allocations: self.allocations,
            messages: self.messages,
            message_bytes: self.message_bytes,
            latency_ns,
            each: self.each,
            ..zero
        }
    }
}

impl Times {
    pub(crate) fn set(&mut self, stage: LatencyStage, ns: u64) {
        self.0[stage as usize] = ns;
    }
}
