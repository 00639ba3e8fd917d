//! Judges what is known so far: harm of every candidate, their order, the answer.

use super::RankingRun;
use crate::answer::Answer;
use crate::answer_view::{AnswerView, Judged};
use crate::request::{Request, RequestError};
use damage::{Basis, CandidateHarm, Evidence, RankedCandidates, assess_in, rank_in};

impl<'w> RankingRun<'w> {
    /// The answer that follows from what is known so far.
    ///
    /// # Errors
    ///
    /// If a candidate cannot be assessed or ranked at all: then the request is refused.
    pub fn answer(&self) -> Result<Answer, RequestError> {
        let (harms, ranking) = self.judge()?;
        Ok(Answer::new(self.request, &ranking, &harms, &self.candidate_states, self.bodies))
    }

    /// Harm of every candidate, and their order.
    pub(crate) fn judge(&self) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
        self.judge_by(|k| self.evidence(k), |_| {})
    }

    /// [`RankingRun::judge`] with other evidence, and with harm changed before it is ranked.
    pub(crate) fn judge_by(
        &self,
        evidence: impl Fn(usize) -> Evidence,
        change: impl Fn(&mut CandidateHarm),
    ) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
        let mut judged = Judged::default();
        self.judge_in(&mut judged, evidence, change)?;
        Ok((judged.harms, judged.ranking))
    }

    /// [`RankingRun::judge`] in buffers of an earlier call.
    fn judge_in(
        &self,
        judged: &mut Judged,
        evidence: impl Fn(usize) -> Evidence,
        change: impl Fn(&mut CandidateHarm),
    ) -> Result<(), RequestError> {
        let request = self.request;
        let basis = self.basis();
        let Judged { harms, ranking, scratch, persons } = judged;
        persons.extend(harms.drain(..).rev().map(|harm| harm.persons));
        for (k, candidate) in request.candidates.iter().enumerate() {
            let list = persons.pop().unwrap_or_default();
            let mut harm = assess_in(&candidate.encounter(), &evidence(k), &basis, list).map_err(
                |source| RequestError::Assess { name: candidate.name.to_string(), source },
            )?;
            change(&mut harm);
            harms.push(harm);
        }
        rank_in(scratch, &request.policy, self.outlook.stakes(), harms, ranking)?;
        Ok(())
    }

    /// Calls `of` with a view of the answer that follows from what is known so far.
    ///
    /// # Errors
    ///
    /// As [`RankingRun::answer`].
    pub fn view<T>(&mut self, of: impl FnOnce(&AnswerView<'_>) -> T) -> Result<T, RequestError> {
        let mut judged = std::mem::take(&mut self.spare.judged);
        let made = self.judge_in(&mut judged, |k| self.evidence(k), |_| {});
        let told = made.map(|()| of(&AnswerView::new(self.request, &judged)));
        self.spare.judged = judged;
        told
    }

    /// The curves, severity level and parameters that harm is computed with.
    pub(crate) fn basis(&self) -> Basis<'w> {
        let Request { curves, policy, parameters, .. } = self.request;
        Basis { curves, level: policy.outcome, parameters }
    }
}
