//! What a job is to the dispatcher, how it ends, and the interface that supplies jobs and takes
//! results.

use protocol::{Section, TaskId};

/// A job as the dispatcher knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Job {
    /// The task it belongs to.
    pub task: TaskId,
    /// Section of body A.
    pub a: Section,
    /// Section of body B.
    pub b: Section,
}

/// The final state of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// All its parts were folded.
    Done,
    /// It was obsolete and was not run.
    Cut,
    /// It failed too often; its result is unknown.
    Abandoned,
    /// The time was up before it was done; its result is unknown.
    Late,
}

/// Supplies jobs and takes results.
pub trait JobSource {
    /// One part of a result.
    type Part<'p>: Copy;

    /// Appends more jobs, if there are any by now.
    fn more(&mut self, jobs: &mut Vec<Job>);
    /// Whether a job can no longer matter.
    fn is_obsolete(&self, job: &Job) -> bool;
    /// Folds one part of a result. May be called again with parts that were folded before.
    fn fold(&mut self, job: &Job, part: Self::Part<'_>);
    /// Called when a job is closed: exactly once per job.
    fn close(&mut self, job: &Job, how: Closed);
    /// The size of a section in bytes.
    fn weight(&self, section: Section) -> u64;
    /// A key that identifies the job in later requests, so that a job that kills workers is not
    /// retried at once; `None` if there is none.
    fn key(&self, _job: &Job) -> Option<u64> {
        None
    }
}
