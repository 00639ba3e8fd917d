//! Requests with known answers: tasks of jobs, each of which finds bits, a maximum and a sum.
//!
//! As in real requests, bits are unions (hit sets), maxima are maxima (extents), sums are counted
//! once (pairs); a *probe* asks only whether there is anything, and is obsolete after the first
//! hit; tasks come in waves, the next when the last one is closed.

use super::rng_key::RngKey;
use dispatch::{Closed, Job, JobSource};
use protocol::{Section, TaskId};
use std::collections::VecDeque;

/// What one job finds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Found {
    pub(super) bits: u64,
    pub(super) most: u32,
    pub(super) sum: u64,
}

/// The most that a job may find.
const MOST: u32 = 1000;
const SUM: u64 = 1 << 20;

/// One part of a result: sums come with the last.
pub(super) type Part = Found;

#[derive(Clone, Copy, Debug)]
pub(super) struct SimulatedJob {
    task: u32,
    pub(super) found: Found,
    /// Number of messages of its result.
    pub(super) parts: u16,
    /// Its time (ns).
    pub(super) time_ns: u64,
}

impl SimulatedJob {
    /// One of the messages: bits are spread over them, so that a lost message is noticed.
    pub(super) fn part(&self, number: u16) -> Part {
        let share = (0..64).filter(|bit| bit % self.parts == number).fold(0, |m, bit| m | 1 << bit);
        let is_last = number + 1 == self.parts;
        Part {
            bits: self.found.bits & share,
            most: if is_last { self.found.most } else { 0 },
            sum: if is_last { self.found.sum } else { 0 },
        }
    }
}

#[derive(Clone, Debug)]
struct Task {
    is_probe: bool,
    jobs: core::ops::Range<u32>,
    found: Found,
    open: u32,
    /// Jobs that matter and were not done.
    unknown: u32,
}

/// How a request was answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Answer {
    /// All that matters was done.
    Complete,
    /// Something is missing, and bounds say how much.
    Degraded,
    /// Nothing was done.
    Refused,
}

/// A request while it is worked on.
#[derive(Clone, Debug, Default)]
pub(super) struct Request {
    pub(super) jobs: Vec<SimulatedJob>,
    tasks: Vec<Task>,
    waiting: VecDeque<u32>,
    /// Whether the next task waits until the last is closed.
    is_gated: bool,
    open: u32,
    closings: Vec<u8>,
    done: u64,
}

impl Request {
    pub(super) fn random(key: RngKey) -> Self {
        let mut request = Self { is_gated: key.at(1).once_in(3), ..Self::default() };
        let tasks = 1 + key.at(2).below(5);
        for number in 0..tasks {
            let key = key.at(3).at(number);
            let first = request.jobs.len() as u32;
            let is_probe = key.at(0).once_in(4);
            for job in 0..1 + key.at(1).below(12) {
                let key = key.at(2).at(job);
                let is_hit = key.at(0).once_in(2);
                let found = Found {
                    bits: if is_hit { key.at(1).bits() } else { 0 },
                    most: if is_hit { key.at(2).below(MOST.into()) as u32 } else { 0 },
                    sum: if is_hit { 1 + key.at(3).below(SUM - 1) } else { 0 },
                };
                let parts = if key.at(4).once_in(4) { 1 + key.at(5).below(3) as u16 } else { 1 };
                let time_ns = 5_000 + key.at(6).below(300_000);
                request.jobs.push(SimulatedJob { task: number as u32, found, parts, time_ns });
            }
            let jobs = first..request.jobs.len() as u32;
            let open = jobs.len() as u32;
            request.tasks.push(Task { is_probe, jobs, found: Found::default(), open, unknown: 0 });
            request.waiting.push_back(number as u32);
        }
        request.closings = vec![0; request.jobs.len()];
        request
    }

    fn job_of(spec: &Job) -> usize {
        spec.a.node as usize
    }

    /// The job that a slot of the dispatcher's table stands for.
    pub(super) fn job(&self, spec: Option<&Job>) -> Option<&SimulatedJob> {
        self.jobs.get(Self::job_of(spec?))
    }

    pub(super) fn name_of(spec: &Job) -> u64 {
        Self::job_of(spec) as u64
    }

    fn truth(&self, task: &Task) -> Found {
        let jobs = self.jobs[task.jobs.start as usize..task.jobs.end as usize].iter();
        jobs.fold(Found::default(), |sum, job| Found {
            bits: sum.bits | job.found.bits,
            most: sum.most.max(job.found.most),
            sum: sum.sum + job.found.sum,
        })
    }

    /// Checks the laws for an answer, and classifies it.
    pub(super) fn judge(&self, counts: &dispatch::Counts) -> Result<Answer, String> {
        for (job, closings) in self.closings.iter().enumerate() {
            if *closings > 1 {
                return Err(format!("job {job} was closed {closings} times"));
            }
        }
        let closed = self.closings.iter().map(|closings| u64::from(*closings)).sum::<u64>();
        let ends = counts.done + counts.cut + counts.abandoned + counts.late;
        if closed != counts.jobs || ends != counts.jobs {
            return Err(format!("{} jobs, {closed} closed, {ends} ended", counts.jobs));
        }
        let mut is_complete = true;
        for (number, task) in self.tasks.iter().enumerate() {
            let (truth, found) = (self.truth(task), task.found);
            if task.is_probe {
                let is_hit = |found: Found| found.bits != 0 || found.sum != 0;
                if is_hit(found) && !is_hit(truth) {
                    return Err(format!("probe {number} found what is not there"));
                }
                let is_known = is_hit(found) || (task.open == 0 && task.unknown == 0);
                if is_known && is_hit(found) != is_hit(truth) {
                    return Err(format!("probe {number} says {}", is_hit(found)));
                }
                is_complete &= is_known;
                continue;
            }
            let missing = task.open + task.unknown;
            if missing == 0 && found != truth {
                return Err(format!("task {number}: {found:x?}, and {truth:x?} is right"));
            }
            let holds = found.bits & !truth.bits == 0
                && found.most <= truth.most
                && found.sum <= truth.sum
                && truth.sum - found.sum <= u64::from(missing) * SUM;
            if !holds {
                return Err(format!("task {number}: bounds of {found:x?} miss {truth:x?}"));
            }
            is_complete &= missing == 0;
        }
        Ok(match (is_complete, self.done) {
            (true, _) => Answer::Complete,
            (false, 0) => Answer::Refused,
            (false, _) => Answer::Degraded,
        })
    }
}

impl JobSource for Request {
    type Part<'p> = Part;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        while jobs.is_empty() && !(self.is_gated && self.open > 0) {
            let Some(number) = self.waiting.pop_front() else { return };
            let task = &self.tasks[number as usize];
            jobs.extend(task.jobs.clone().map(|job| Job {
                task: TaskId(number),
                a: Section { model: 0, node: job },
                b: Section { model: 1, node: job % 5 },
            }));
            self.open += jobs.len() as u32;
        }
    }

    fn is_obsolete(&self, job: &Job) -> bool {
        let task = &self.tasks[job.task.0 as usize];
        task.is_probe && (task.found.bits != 0 || task.found.sum != 0)
    }

    fn fold(&mut self, spec: &Job, part: Part) {
        let Some(job) = self.jobs.get(Self::job_of(spec)) else { return };
        let found = &mut self.tasks[job.task as usize].found;
        found.bits |= part.bits;
        found.most = found.most.max(part.most);
        found.sum += part.sum;
    }

    fn close(&mut self, spec: &Job, how: Closed) {
        let number = Self::job_of(spec);
        self.closings[number] = self.closings[number].saturating_add(1);
        let task = &mut self.tasks[self.jobs[number].task as usize];
        task.open = task.open.saturating_sub(1);
        self.open = self.open.saturating_sub(1);
        match how {
            Closed::Done => self.done += 1,
            Closed::Cut => {}
            Closed::Abandoned | Closed::Late => task.unknown += 1,
        }
    }

    fn weight(&self, section: Section) -> u64 {
        60 + u64::from(section.node)
    }
}
