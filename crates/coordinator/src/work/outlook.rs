//! What is known of the contacts of a round while jobs finish: what a strategy needs that asks for
//! it.
//!
//! Bounds are recomputed for a candidate whose evidence changed, and only when a question of it was
//! answered or a good part of its open jobs was done: so the cost per result stays below that of
//! the job.

use super::SurveyRun;
use crate::bound::{self, Open};
use crate::request::Request;
use damage::{
    Basis, CandidateBounds, Encounter, Evidence, PersonHarm, Risk, Scratch, Stake, Standing,
};
use damage::{bounds_in, needs_high, standing_in};

/// What is known of the order so far.
#[derive(Debug, Default)]
pub(super) struct Outlook {
    /// Per candidate; all are computed at the first review.
    bounds: Vec<CandidateBounds>,
    pub(super) standing: Option<Standing>,
    /// What the persons of the request have at stake.
    stakes: Vec<Stake>,
    /// Buffers for what is computed after every result.
    scratch: OutlookScratch,
    /// Per candidate: closed jobs not yet reflected in its bounds, and whether the bounds are due.
    news: Vec<(usize, bool)>,
    /// Bounds cannot be computed: the request is refused when it is answered.
    is_lost: bool,
}

/// Buffers for what is computed after every result, so that nothing is allocated.
#[derive(Debug, Default)]
struct OutlookScratch {
    scratch: Scratch,
    assessed: Vec<PersonHarm>,
    risks: Vec<Vec<Risk>>,
    standing: Standing,
}

/// Number of closed jobs of an unfinished pose after which its bounds are recomputed.
const NEWS: usize = 32;

impl Outlook {
    /// An outlook with nothing known, in the lists of an earlier request.
    pub(super) fn reset_for(self, request: &Request) -> Self {
        let Self { mut bounds, standing, mut stakes, mut scratch, mut news, .. } = self;
        let candidates = request.candidates.len();
        scratch.risks.extend(bounds.drain(..).map(|bounds| bounds.persons));
        scratch.standing = standing.unwrap_or(scratch.standing);
        stakes.clear();
        stakes.extend(request.persons.iter().map(|person| person.stake));
        news.clear();
        news.resize(candidates, (0, true));
        Self { bounds, stakes, scratch, news, ..Self::default() }
    }

    /// What the persons of the request have at stake, in their order.
    #[cfg(test)]
    pub(super) fn stakes(&self) -> &[Stake] {
        &self.stakes
    }

    /// Recomputes the bounds of a candidate: the first time, those of all candidates in order.
    /// `false` if they cannot be computed: then nothing more is known of the order.
    fn bind(
        &mut self,
        k: usize,
        encounter: &Encounter<'_>,
        evidence: &Evidence,
        basis: &Basis<'_>,
        high: bool,
    ) -> bool {
        let before = self.bounds.get_mut(k).map(|bounds| core::mem::take(&mut bounds.persons));
        let risks = before.or_else(|| self.scratch.risks.pop()).unwrap_or_default();
        match bounds_in(encounter, evidence, basis, high, (&mut self.scratch.assessed, risks)) {
            Ok(made) if k < self.bounds.len() => self.bounds[k] = made,
            Ok(made) => self.bounds.push(made),
            Err(_) => self.is_lost = true,
        }
        !self.is_lost
    }

    /// Notes news of a candidate; `is_due`: a question of it is answered.
    pub(super) fn touch(&mut self, k: usize, is_due: bool) {
        let (jobs, due) = &mut self.news[k];
        *jobs += 1;
        *due |= is_due || *jobs >= NEWS;
    }
}

impl SurveyRun<'_> {
    /// What is certain, as of the last review.
    #[cfg(test)]
    pub(crate) fn standing(&self) -> Option<&Standing> {
        self.outlook.standing.as_ref()
    }

    /// Recomputes bounds where they are due, and updates what is certain.
    pub(super) fn review(&mut self) {
        if !self.outlook.news.iter().any(|(_, due)| *due)
            || self.outlook.is_lost
            || !self.strategy.needs_bounds()
        {
            return;
        }
        let request = self.request;
        let basis = self.basis();
        let high = needs_high(&request.criteria.policy);
        for (k, candidate) in request.candidates.iter().enumerate() {
            if !self.outlook.news[k].1 {
                continue;
            }
            self.outlook.news[k] = (0, false);
            self.update_reach(k);
            self.lay_plane(k);
            let evidence = self.evidence_by(k, true);
            if !self.outlook.bind(k, &candidate.encounter(), &evidence, &basis, high) {
                return;
            }
        }
        let outlook = &mut self.outlook;
        let OutlookScratch { scratch, standing: spare, .. } = &mut outlook.scratch;
        let standing = outlook.standing.as_mut().unwrap_or(spare);
        let (stakes, bounds) = (&outlook.stakes, &outlook.bounds);
        if standing_in(scratch, &request.criteria.policy, stakes, bounds, standing).is_err() {
            outlook.is_lost = true;
            return;
        }
        outlook.standing.get_or_insert_with(|| core::mem::take(&mut outlook.scratch.standing));
    }

    /// What is known of the contact of a candidate.
    pub(crate) fn evidence(&self, k: usize) -> Evidence {
        self.evidence_by(k, false)
    }

    /// [`SurveyRun::evidence`]; `by_cache` takes reaches as last computed, which may be too wide.
    fn evidence_by(&self, k: usize, by_cache: bool) -> Evidence {
        let candidate = &self.request.candidates[k];
        let zones = [candidate.model_a, candidate.model_b]
            .map(|model| self.zones[model as usize].first().map_or(0, |zones| zones.0));
        self.candidate_states[k].evidence(|task, stop| {
            let state = &self.tasks[task as usize];
            let Some(found) = state.found.as_ref().filter(|_| state.done > 0) else {
                return Open::whole(candidate, stop, zones);
            };
            let reach = match (state.reach.as_deref(), by_cache) {
                (Some((_, reach)), true) => *reach,
                _ => self.reach_of(task),
            };
            Open::partly(candidate, stop, (found, &reach), zones)
        })
    }

    /// What the open jobs of a task can reach.
    fn reach_of(&self, task: u32) -> geometry::Supports {
        let state = &self.tasks[task as usize];
        let candidate = &self.request.candidates[state.candidate];
        let handed = state.out.iter().chain(&state.lost).copied();
        let open = state.todo.iter().copied().chain(handed);
        let pose = super::pose_of(&state.wire);
        bound::boxes(candidate, self.views(&state.wire), &pose, state.open(), open)
    }

    /// Recomputes the reaches of a candidate's open poses where half of the jobs that they were
    /// computed from are closed.
    fn update_reach(&mut self, k: usize) {
        for task in 0..self.tasks.len() as u32 {
            let state = &self.tasks[task as usize];
            let is_stop = state.found.is_some();
            let is_stale = state.reach.as_ref().is_none_or(|reach| 2 * state.open() <= reach.0);
            if state.candidate == k && is_stop && state.done > 0 && is_stale {
                let reach = (state.open(), self.reach_of(task));
                self.tasks[task as usize].reach = Some(Box::new(reach));
            }
        }
    }
}

impl super::TaskState {
    /// Number of jobs whose findings are not known.
    fn open(&self) -> usize {
        self.todo.len() + self.out.len() + self.lost.len()
    }
}
