//! Which task the next jobs come from.

use super::RankingRun;
use crate::case::{Aim, Case, Stage};
use crate::strategy::Prospect;
use damage::{Interval, needs_high};

impl RankingRun<'_> {
    /// The task whose jobs go out next; `None` if all there are are out.
    pub(super) fn choose(&mut self) -> Option<u32> {
        let first = *self.waiting.front()?;
        if self.strategy.needs_bounds() {
            self.review();
        }
        let mut prospects = std::mem::take(&mut self.spare.prospects);
        self.write_prospects(&mut prospects);
        let chosen = self.chosen(&prospects).unwrap_or(first);
        self.spare.prospects = prospects;
        Some(chosen)
    }

    /// The task that the strategy takes, if it takes one.
    fn chosen(&mut self, prospects: &[Prospect]) -> Option<u32> {
        let incumbent = self.outlook.standing.as_ref().map_or(0, |standing| standing.incumbent);
        let chosen = self.strategy.choose(prospects, incumbent);
        let work = &*self;
        let of_case = |case: usize| {
            let tasks = work.waiting.iter().copied();
            tasks.filter(move |task| work.errands[*task as usize].case == case)
        };
        let chosen = chosen.and_then(|case| {
            if self.strategy.is_eager() {
                of_case(case).min_by_key(|task| self.eagerness(*task))
            } else {
                of_case(case).next()
            }
        });
        // Nobody has work that ranks, or the strategy has no wish.
        let possible = || {
            let is_possible = |task: &u32| prospects[self.errands[*task as usize].case].is_possible;
            self.waiting.iter().copied().find(|task| self.strategy.is_eager() && is_possible(task))
        };
        chosen.or_else(possible)
    }

    fn write_prospects(&self, prospects: &mut Vec<Prospect>) {
        let standing = self.outlook.standing.as_ref();
        let prospect = |case: usize| Prospect {
            has_work: false,
            is_possible: standing.is_none_or(|standing| standing.possible.contains(&case)),
            touch: self.outlook.touch_of(case),
            compared: standing.map_or(Interval::new(0.0, 1.0), |standing| standing.compared[case]),
            jobs: self.outlook.handed(case),
        };
        prospects.clear();
        prospects.extend((0..self.cases.len()).map(prospect));
        let all_rank = !self.strategy.is_eager() || needs_high(&self.request.policy);
        for task in &self.waiting {
            let errand = &self.errands[*task as usize];
            let ranks = match errand.aim {
                Aim::Probe { .. } => true,
                Aim::Survey { stop } => self.cases[errand.case].is_patch(stop),
            };
            prospects[errand.case].has_work |= ranks || all_rank;
        }
    }

    /// Less goes first: the probe that parts the open poses best, then the deepest pose of the
    /// patch, then what only zones and depth need.
    fn eagerness(&self, task: u32) -> (u32, i64) {
        let errand = &self.errands[task as usize];
        let case = &self.cases[errand.case];
        let micrometres = |metres: f64| (metres * 1e6) as i64;
        match errand.aim {
            Aim::Probe { travel_m } => {
                // What was begun is finished first: half a probe tells nothing.
                let begun = u32::from(!errand.is_descended);
                (begun, micrometres((travel_m - case.middle_m()).abs()))
            }
            Aim::Survey { stop } if case.is_patch(stop) => {
                (2 + u32::from(!errand.is_descended), -micrometres(errand.travel_m))
            }
            Aim::Survey { .. } => (4, micrometres(errand.travel_m)),
        }
    }
}

impl Case {
    /// Whether a stop of the survey forms the patch.
    fn is_patch(&self, number: usize) -> bool {
        match &self.stage {
            Stage::Surveying { stops, .. } => stops.get(number).is_some_and(|(stop, _)| stop.patch),
            Stage::Settled | Stage::Searching { .. } => false,
        }
    }

    /// The middle of where first contact may be (m).
    fn middle_m(&self) -> f64 {
        match &self.stage {
            Stage::Searching { search, .. } => {
                let (from, to) = search.bracket();
                f64::midpoint(from, to)
            }
            Stage::Settled | Stage::Surveying { .. } => 0.0,
        }
    }
}
