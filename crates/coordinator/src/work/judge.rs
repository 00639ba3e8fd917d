//! Judges what is known so far: harm of every candidate, their order, the answer.

use super::SurveyRun;
use crate::request::RequestError;
use damage::{Basis, CandidateHarm, Evidence, assess};
#[cfg(test)]
use damage::{RankedCandidates, rank};

impl<'w> SurveyRun<'w> {
    /// Harm of every candidate, and their order.
    #[cfg(test)]
    pub(crate) fn judge(&self) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
        self.judge_by(|k| self.evidence(k), |_| {})
    }

    /// Harm of every candidate, as far as it is known.
    pub(crate) fn harms(&self) -> Result<Vec<CandidateHarm>, RequestError> {
        (0..self.request.candidates.len()).map(|k| self.harm(k)).collect()
    }

    /// Harm of a candidate, as far as it is known.
    pub(crate) fn harm(&self, k: usize) -> Result<CandidateHarm, RequestError> {
        self.harm_by(k, &self.evidence(k))
    }

    /// [`SurveyRun::judge`] with other evidence, and with harm changed before it is ranked.
    #[cfg(test)]
    pub(crate) fn judge_by(
        &self,
        evidence: impl Fn(usize) -> Evidence,
        change: impl Fn(&mut CandidateHarm),
    ) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
        let changed = |k: usize| {
            let mut harm = self.harm_by(k, &evidence(k))?;
            change(&mut harm);
            Ok(harm)
        };
        let harms = (0..self.request.candidates.len()).map(changed);
        let harms = harms.collect::<Result<Vec<_>, RequestError>>()?;
        let ranking = rank(&self.request.criteria.policy, self.outlook.stakes(), &harms)?;
        Ok((harms, ranking))
    }

    fn harm_by(&self, k: usize, evidence: &Evidence) -> Result<CandidateHarm, RequestError> {
        self.lay_plane(k);
        let candidate = &self.request.candidates[k];
        assess(&candidate.encounter(), evidence, &self.basis())
            .map_err(|source| RequestError::Assess { name: candidate.name.to_string(), source })
    }

    /// The curves, severity level and parameters that harm is computed with.
    pub(crate) fn basis(&self) -> Basis<'w> {
        let damage::Criteria { curves, policy, parameters } = &self.request.criteria;
        Basis { curves, level: policy.outcome, parameters }
    }
}
