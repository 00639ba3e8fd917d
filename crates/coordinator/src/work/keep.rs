//! What is kept of the work for those who ask afterwards: the ledger, and the explanation.

use super::{RankingRun, TaskState};
use crate::explain::Explanation;
use crate::ledger::{Asked, JobHistory};
use crate::request::RequestError;
use protocol::TaskId;

impl RankingRun<'_> {
    /// The same, keeping a ledger of its jobs.
    #[must_use]
    pub fn with_ledger(mut self) -> Self {
        self.ledger = Some(JobHistory::new());
        self
    }

    /// Asks nothing but this: what a recorded run had asked when it was answered.
    pub(crate) fn ask_only(&mut self, asked: Asked) {
        let errands = &self.errands;
        self.waiting.retain(|task| asked.has(&errands[*task as usize]));
        self.asked = Some(asked);
    }

    /// The ledger, if one is kept.
    #[must_use]
    pub fn ledger(&self) -> Option<&JobHistory> {
        self.ledger.as_ref()
    }

    /// The errand of a task.
    pub(crate) fn errand(&self, task: TaskId) -> Option<&TaskState> {
        self.errands.get(task.0 as usize)
    }

    /// Notes in the ledger what is known by now.
    pub(super) fn note(&mut self) {
        if self.ledger.is_none() {
            return;
        }
        // A request that cannot be judged is refused when it is answered.
        let Ok((_, ranking)) = self.judge() else { return };
        let mut work = vec![[0.0; 2]; self.cases.len()];
        for place in &ranking.places {
            work[place.candidate] = place.work.into();
        }
        if let Some(ledger) = &mut self.ledger {
            ledger.note(ranking.state.name().to_owned(), work);
        }
    }

    /// The answer's chain of figures, from contact to policy, and what would flip the winner.
    ///
    /// # Errors
    ///
    /// As [`RankingRun::answer`].
    pub fn explanation(&self) -> Result<Explanation, RequestError> {
        let (harms, ranking) = self.judge()?;
        Ok(Explanation::new(self.request, &ranking, &harms, &self.cases)?)
    }
}
