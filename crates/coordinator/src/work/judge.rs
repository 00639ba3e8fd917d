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
        self.harms_by(|k| self.evidence(k), |_| {})
    }

    /// [`SurveyRun::judge`] with other evidence, and with harm changed before it is ranked.
    #[cfg(test)]
    pub(crate) fn judge_by(
        &self,
        evidence: impl Fn(usize) -> Evidence,
        change: impl Fn(&mut CandidateHarm),
    ) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
        let harms = self.harms_by(evidence, change)?;
        let ranking = rank(&self.request.criteria.policy, self.outlook.stakes(), &harms)?;
        Ok((harms, ranking))
    }

    fn harms_by(
        &self,
        evidence: impl Fn(usize) -> Evidence,
        change: impl Fn(&mut CandidateHarm),
    ) -> Result<Vec<CandidateHarm>, RequestError> {
        let request = self.request;
        let basis = self.basis();
        let mut harms = Vec::with_capacity(request.candidates.len());
        for (k, candidate) in request.candidates.iter().enumerate() {
            self.lay_plane(k);
            let mut harm =
                assess(&candidate.encounter(), &evidence(k), &basis).map_err(|source| {
                    RequestError::Assess { name: candidate.name.to_string(), source }
                })?;
            change(&mut harm);
            harms.push(harm);
        }
        Ok(harms)
    }

    /// The curves, severity level and parameters that harm is computed with.
    pub(crate) fn basis(&self) -> Basis<'w> {
        let damage::Criteria { curves, policy, parameters } = &self.request.criteria;
        Basis { curves, level: policy.outcome, parameters }
    }
}
