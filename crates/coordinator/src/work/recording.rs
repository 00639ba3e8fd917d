//! What is kept of the work for later inspection: the job history and the explanation.

use super::{RankingRun, TaskState};
use crate::explain::Explanation;
use crate::job_history::{Asked, JobHistory};
use crate::request::RequestError;
use protocol::TaskId;

impl RankingRun<'_> {
    /// This run, keeping a job history.
    #[must_use]
    pub fn with_job_history(mut self) -> Self {
        self.job_history = Some(JobHistory::new());
        self
    }

    /// Restricts the questions to those that a recorded run had asked when it was answered.
    pub(crate) fn ask_only(&mut self, asked: Asked) {
        let tasks = &self.tasks;
        self.waiting.retain(|task| asked.has(&tasks[*task as usize]));
        self.asked = Some(asked);
    }

    /// The job history, if one is kept.
    #[must_use]
    pub fn job_history(&self) -> Option<&JobHistory> {
        self.job_history.as_ref()
    }

    /// The state of a task.
    pub(crate) fn state(&self, task: TaskId) -> Option<&TaskState> {
        self.tasks.get(task.0 as usize)
    }

    /// Notes in the job history what is known so far.
    pub(super) fn note(&mut self) {
        if self.job_history.is_none() {
            return;
        }
        // A request that cannot be judged is refused when it is answered.
        let Ok((_, ranking)) = self.judge() else { return };
        let mut work = vec![[0.0; 2]; self.candidate_states.len()];
        for place in &ranking.places {
            work[place.candidate] = place.work.into();
        }
        if let Some(job_history) = &mut self.job_history {
            job_history.note(ranking.state.name().to_owned(), work);
        }
    }

    /// The answer's chain of figures, from contact to policy, and what would change the winner.
    ///
    /// # Errors
    ///
    /// As [`RankingRun::answer`].
    pub fn explanation(&self) -> Result<Explanation, RequestError> {
        let (harms, ranking) = self.judge()?;
        Ok(Explanation::new(self.request, &ranking, &harms, &self.candidate_states)?)
    }
}
