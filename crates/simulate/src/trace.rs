//! A trace of a real run: its tasks and their jobs, in the order of their traversals.

use dispatch::{Closed, Job, JobSource};
use protocol::{Section, TaskId};

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

/// The bytes of every section of a trace, by body and node.
#[derive(Debug, Default)]
pub(crate) struct Weights(Vec<Vec<u64>>);

impl Weights {
    pub(crate) fn new(trace: &Trace) -> Self {
        let mut bodies: Vec<Vec<u64>> = Vec::new();
        for (section, bytes) in trace.jobs().flat_map(|job| [job.a, job.b]) {
            let (model, node) = (section.model as usize, section.node as usize);
            if bodies.len() <= model {
                bodies.resize(model + 1, Vec::new());
            }
            let nodes = &mut bodies[model];
            if nodes.len() <= node {
                nodes.resize(node + 1, 0);
            }
            nodes[node] = bytes;
        }
        Self(bodies)
    }

    fn of_section(&self, section: Section) -> u64 {
        let nodes = self.0.get(section.model as usize);
        nodes.and_then(|nodes| nodes.get(section.node as usize)).copied().unwrap_or(0)
    }
}

/// A trace as work for a dispatcher.
pub(crate) struct Replay<'t> {
    trace: &'t Trace,
    weights: &'t Weights,
    next: usize,
    /// Traversals since the last look: tasks, and tests of boxes.
    pub(crate) descents: (u64, u64),
}

impl<'t> Replay<'t> {
    pub(crate) fn new(trace: &'t Trace, weights: &'t Weights) -> Self {
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
        self.weights.of_section(section)
    }
}
