//! A trace of a real run: its tasks and their jobs, in the order of their traversals.

use dispatch::{Closed, Job, JobSource};
use protocol::{Section, TaskId};
use std::collections::BTreeMap;

/// One job as it ran.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JobTrace {
    /// Section of A, and its bytes.
    pub a: (Section, u64),
    /// Section of B, and its bytes.
    pub b: (Section, u64),
    /// Tests of boxes.
    pub nb: u64,
    /// Tests of triangles.
    pub np: u64,
    /// Hits that it returned.
    pub hits: u64,
}

/// One task as it ran.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TaskTrace {
    /// Box tests of its traversal.
    pub descent_nb: u64,
    /// Its jobs, in the order of the traversal.
    pub jobs: Vec<JobTrace>,
}

/// All tasks of a request. None of them waits for another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// The tasks, in order.
    pub tasks: Vec<TaskTrace>,
}

impl Trace {
    /// All jobs, in the order in which a dispatcher numbers them.
    pub fn jobs(&self) -> impl Iterator<Item = &JobTrace> {
        self.tasks.iter().flat_map(|task| &task.jobs)
    }
}

/// A trace as work for a dispatcher.
pub(crate) struct Replay<'t> {
    trace: &'t Trace,
    weights: BTreeMap<Section, u64>,
    next: usize,
    /// Traversals since the last look: tasks, and tests of boxes.
    pub(crate) descents: (u64, u64),
}

impl<'t> Replay<'t> {
    pub(crate) fn new(trace: &'t Trace) -> Self {
        let weights = trace.jobs().flat_map(|job| [job.a, job.b]).collect();
        Self { trace, weights, next: 0, descents: (0, 0) }
    }
}

impl JobSource for Replay<'_> {
    type Part<'p> = ();

    fn more(&mut self, jobs: &mut Vec<Job>) {
        while jobs.is_empty()
            && let Some(task) = self.trace.tasks.get(self.next)
        {
            let number = TaskId(self.next as u32);
            jobs.extend(task.jobs.iter().map(|job| Job { task: number, a: job.a.0, b: job.b.0 }));
            self.next += 1;
            self.descents = (self.descents.0 + 1, self.descents.1 + task.descent_nb);
        }
    }

    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }

    fn fold(&mut self, _: &Job, (): ()) {}

    fn close(&mut self, _: &Job, _: Closed) {}

    fn weight(&self, section: Section) -> u64 {
        self.weights.get(&section).copied().unwrap_or(0)
    }
}
