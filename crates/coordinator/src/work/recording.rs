//! What is kept of the work for a replay: the job history.

use super::{SurveyRun, TaskState};
use crate::job_history::{Asked, JobHistory};
use protocol::TaskId;

impl SurveyRun<'_> {
    /// This run, keeping a job history.
    pub(crate) fn with_job_history(mut self) -> Self {
        self.job_history = Some(JobHistory::default());
        self
    }

    /// Restricts the questions to those that a recorded run had asked when it was answered.
    pub(crate) fn ask_only(&mut self, asked: &Asked) {
        let tasks = &self.tasks;
        self.waiting.retain(|task| asked.has(&tasks[*task as usize]));
    }

    /// The job history, if one is kept.
    pub(crate) fn job_history(&self) -> Option<&JobHistory> {
        self.job_history.as_ref()
    }

    /// The state of a task.
    pub(crate) fn state(&self, task: TaskId) -> Option<&TaskState> {
        self.tasks.get(task.0 as usize)
    }
}
