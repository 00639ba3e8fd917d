//! Which task the next jobs come from.

use super::SurveyRun;
use crate::strategy::Prospect;
use damage::Interval;

impl SurveyRun<'_> {
    /// The task whose jobs go out next; `None` if all jobs are out.
    pub(super) fn choose(&mut self) -> Option<u32> {
        let first = *self.waiting.front()?;
        // Of many members thousands of tasks wait: listing them for each would take longer than
        // their jobs.
        if !self.strategy.has_preference() {
            return Some(first);
        }
        if self.strategy.needs_bounds() {
            self.review();
        }
        let mut prospects = std::mem::take(&mut self.spare.prospects);
        self.write_prospects(&mut prospects);
        let chosen = self.chosen(&prospects).unwrap_or(first);
        self.spare.prospects = prospects;
        Some(chosen)
    }

    /// The task that the strategy chooses, if it chooses one.
    fn chosen(&mut self, prospects: &[Prospect]) -> Option<u32> {
        let incumbent = self.outlook.standing.as_ref().map_or(0, |standing| standing.incumbent);
        let chosen = self.strategy.choose(prospects, incumbent);
        let work = &*self;
        let of_case = |k: usize| {
            let tasks = work.waiting.iter().copied();
            tasks.filter(move |task| work.tasks[*task as usize].candidate == k)
        };
        let chosen = chosen.and_then(|k| {
            if self.strategy.is_eager() {
                of_case(k).min_by_key(|task| self.eagerness(*task))
            } else {
                of_case(k).next()
            }
        });
        // No candidate has work that ranks, or the strategy has no preference.
        let possible = || {
            let is_possible =
                |task: &u32| prospects[self.tasks[*task as usize].candidate].is_possible;
            self.waiting.iter().copied().find(|task| self.strategy.is_eager() && is_possible(task))
        };
        chosen.or_else(possible)
    }

    fn write_prospects(&self, prospects: &mut Vec<Prospect>) {
        let standing = self.outlook.standing.as_ref();
        let prospect = |k: usize| Prospect {
            has_work: false,
            is_possible: standing.is_none_or(|standing| standing.possible.contains(&k)),
            compared: standing.map_or(Interval::new(0.0, 1.0), |standing| standing.compared[k]),
        };
        prospects.clear();
        prospects.extend((0..self.candidate_states.len()).map(prospect));
        for task in &self.waiting {
            prospects[self.tasks[*task as usize].candidate].has_work = true;
        }
    }

    /// Lower goes first: what is begun, then the deepest, where most zones are hit.
    fn eagerness(&self, task: u32) -> (bool, i64) {
        let state = &self.tasks[task as usize];
        let micrometres = |metres: f64| (metres * 1e6) as i64;
        (!state.is_descended, -micrometres(state.travel_m))
    }
}
