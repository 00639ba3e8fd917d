//! What a job is to the dispatcher, how it ends, and who hands jobs over and takes what they find.

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

/// How a job ended for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// All its parts were folded.
    Done,
    /// It could not matter any longer, and was not run.
    Cut,
    /// It failed too often; what it would have found is unknown.
    Abandoned,
    /// The time was up before it was done; what it would have found is unknown.
    Late,
}

/// Where jobs come from and results go to.
pub trait JobSource {
    /// One part of a result.
    type Part<'p>: Copy;

    /// Hands over more jobs, if there are any by now.
    fn more(&mut self, jobs: &mut Vec<Job>);
    /// Whether the rest of a task cannot matter any longer.
    fn is_obsolete(&self, task: TaskId) -> bool;
    /// Takes what one part found. May be called again with what a job found before.
    fn fold(&mut self, job: &Job, part: Self::Part<'_>);
    /// Takes note that a job is closed: exactly once per job.
    fn close(&mut self, job: &Job, how: Closed);
    /// Bytes of a section.
    fn weight(&self, section: Section) -> u64;
    /// What names the job in later requests too, so that one that takes workers down is not tried
    /// again at once; `None`: nothing does.
    fn key(&self, _job: &Job) -> Option<u64> {
        None
    }
}
