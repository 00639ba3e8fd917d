//! The search for first contact of one candidate: jobs in the order in which they may find it, the
//! earliest pair of triangles so far, and the bracket that both leave.
//!
//! Only what the coordinator has computed itself from two triangles is the best so far: workers
//! name a pair, so that none can end the search too early by a wrong travel.

use super::{RankingRun, SLOTS_MAX};
use crate::candidate_state::FirstContact;
use crate::gather::Part;
use body::Zones;
use bvh::query::{SweepWorkspace, first_contact};
use bvh::{Counters, NodePair, SweepBounds, SweepTask, Witness};
use damage::Meeting;
use dispatch::Job;
use geometry::Supports;
use protocol::result::read_hit;
use protocol::{Section, TaskId, WireSide, WireTask};
use record::RecordedFirst;

/// Maximum number of jobs of one search that are handed out at once. More would mostly be in vain,
/// as the first of them find the contact.
const STRIDE: usize = 4;

impl RankingRun<'_> {
    /// Whether the result of a job cannot change anything any more.
    pub(super) fn is_job_obsolete(&self, job: &Job) -> bool {
        let state = &self.tasks[job.task.0 as usize];
        let pair = NodePair { a: job.a.node, b: job.b.node };
        state.is_obsolete
            || (state.best.is_some() && f64::from(state.handed(pair).from_m) > state.limit_m())
    }

    /// Hands out the jobs of a search that may find contact first.
    pub(super) fn hand_out_first(&mut self, number: u32, stride: usize, jobs: &mut Vec<Job>) {
        let wire = self.tasks[number as usize].wire;
        let views = self.views(&wire);
        let state = &mut self.tasks[number as usize];
        let limit_m = state.limit_m();
        let bounds = state.sweep_task(views).map(|task| SweepBounds::new(&task));
        let section = |model, node| Section { model, node };
        let before = jobs.len();
        for _ in 0..stride.min(STRIDE) {
            let Some(bounds) = &bounds else { break };
            let descent = &mut self.effort.descent;
            let Some(open) = state.front.next(bounds, self.depth, limit_m, descent) else { break };
            self.slots += 1;
            if self.slots > SLOTS_MAX {
                state.lost.push(open);
                continue;
            }
            state.out.push_back(open);
            jobs.push(Job {
                task: TaskId(number),
                a: section(wire.model_a, open.pair.a),
                b: section(wire.model_b, open.pair.b),
            });
        }
        let candidate = state.candidate;
        let is_empty = state.front.is_empty();
        self.outlook.handed_out(candidate, jobs.len() - before);
        // The others take turns with it: meanwhile these jobs find how far it has to look.
        self.waiting.retain(|waiting| *waiting != number);
        if !is_empty {
            self.waiting.push_back(number);
        }
        self.finish_if_closed(number);
    }

    /// Takes a part of the result of a job that seeks first contact; `false` if it does not hold.
    pub(super) fn fold_first(&mut self, number: u32, part: &Part<'_>) -> bool {
        if let Some(last) = &part.last {
            self.effort.jobs.add(&Counters { nb: last.summary.nb, np: last.summary.np });
        }
        let triangles = match *part.hits {
            [] => return true,
            [first, second] => [read_hit(first), read_hit(second)],
            _ => return false,
        };
        let [(WireSide::A, a), (WireSide::B, b)] = triangles else { return false };
        let state = &self.tasks[number as usize];
        let views = self.views(&state.wire);
        let exist = (a as usize) < views.0.corners.len() && (b as usize) < views.1.corners.len();
        // On the whole way: a job that was sent before an earlier contact was found may name a
        // later one, but none that is not.
        let Some(task) = self.whole_way(number).filter(|_| exist) else { return false };
        let Some(witness) = Witness::of(&task, [a, b]) else { return false };
        let state = &mut self.tasks[number as usize];
        if state.improve(witness) {
            state.front.drop_after(witness.travel_m);
            let candidate = state.candidate;
            self.narrow(number);
            self.outlook.touch(candidate, true);
        }
        true
    }

    /// The question of a search as it was asked first.
    fn whole_way(&self, number: u32) -> Option<SweepTask<'_>> {
        let state = &self.tasks[number as usize];
        let candidate = &self.request.candidates[state.candidate];
        let Meeting::Path(path) = &candidate.meeting else { return None };
        let wire = WireTask { travels_m: [path.from_m, path.to_m], ..state.wire };
        let (a, b) = self.views(&wire);
        let sweep = executor::sweep(&wire)?;
        Some(SweepTask { a: *a, b: *b, pose: super::pose_of(&wire), sweep })
    }

    /// Passes on what the jobs of a search have shown so far.
    fn narrow(&mut self, number: u32) {
        let state = &self.tasks[number as usize];
        let limit_m = state.limit_m();
        let from_m = state.open_from_m().unwrap_or(limit_m);
        let touching_m = state.best.map(|best| best.travel_m);
        let first = RecordedFirst {
            from_m: from_m.min(limit_m),
            triangles: state.best.map(|best| best.triangles),
            is_settled: false,
        };
        self.candidate_states[state.candidate].narrow(from_m, touching_m);
        if let Some(job_history) = &mut self.job_history {
            job_history.narrow(TaskId(number), first);
        }
    }

    /// If nothing is open that could touch first, settles the search and asks for the survey.
    pub(super) fn finish_first_if_closed(&mut self, number: u32) {
        let state = &mut self.tasks[number as usize];
        if !state.is_descended || state.is_obsolete {
            return;
        }
        let limit_m = state.limit_m();
        state.front.drop_after(limit_m);
        // What was lost does not matter if it could only touch later.
        state.lost.retain(|lost| f64::from(lost.from_m) <= limit_m);
        if state.front.is_empty() {
            self.waiting.retain(|waiting| *waiting != number);
        }
        self.narrow(number);
        let state = &self.tasks[number as usize];
        let is_open = !state.front.is_empty() || !state.out.is_empty() || !state.lost.is_empty();
        if !is_open {
            self.settle(number);
        }
    }

    /// Takes the best so far as the first contact, or that there is none.
    pub(super) fn settle(&mut self, number: u32) {
        let state = &mut self.tasks[number as usize];
        // Nothing of it counts any more.
        state.is_obsolete = true;
        let (k, best, wire) = (state.candidate, state.best, state.wire);
        if let Some(job_history) = &mut self.job_history {
            let first = RecordedFirst {
                from_m: best.map_or(wire.travels_m[1], |best| best.travel_m),
                triangles: best.map(|best| best.triangles),
                is_settled: true,
            };
            job_history.narrow(TaskId(number), first);
        }
        let candidate = &self.request.candidates[k];
        let (a, b) = self.views(&wire);
        let first = best.map(|witness| {
            let [of_a, of_b] = witness.triangles.map(|triangle| triangle as usize);
            let zones = [a.zones.get(of_a), b.zones.get(of_b)]
                .map(|zones| zones.copied().unwrap_or(Zones(0)));
            let mut supports = Supports::EMPTY;
            supports.add(&candidate.approach.directions, witness.point);
            // Which of two zeros is the greater depends on the machine, so all become +0.
            let supports = Supports(supports.0.map(|s| s + 0.0));
            FirstContact { witness, zones, supports }
        });
        let task = self.tasks.len() as u32;
        self.candidate_states[k].settle(candidate, first.as_ref(), task, &mut self.purposes);
        self.ask(k);
        self.outlook.touch(k, true);
        if first.is_none() {
            self.note();
        }
    }

    /// The searches that are open, by task.
    pub(crate) fn searches(&self) -> Vec<u32> {
        let is_search = |task: &u32| self.tasks[*task as usize].is_first_contact();
        self.waiting.iter().copied().filter(is_search).collect()
    }

    /// Seeks the first contact of a search again, and if what was recorded of it holds, takes that;
    /// else what was found now.
    pub(crate) fn recall(
        &mut self,
        number: u32,
        recorded: Option<RecordedFirst>,
        workspace: &mut SweepWorkspace,
    ) {
        self.waiting.retain(|waiting| *waiting != number);
        let state = &mut self.tasks[number as usize];
        state.is_descended = true;
        if let Some(job_history) = &mut self.job_history {
            job_history.ask(TaskId(number), state);
        }
        let state = &self.tasks[number as usize];
        let Some(task) = state.sweep_task(self.views(&state.wire)) else { return };
        let Some(recorded) = recorded else { return };
        // A pose that cannot be used was refused before.
        let Ok(found) = first_contact(task.a, task.b, &task.pose, &task.sweep, workspace) else {
            return;
        };
        let named = recorded.triangles.and_then(|[a, b]| {
            let exist = (a as usize) < task.a.corners.len() && (b as usize) < task.b.corners.len();
            exist.then(|| Witness::of(&task, [a, b])).flatten()
        });
        let first_m = found.map_or(task.sweep.to_m(), |found| found.travel_m);
        let holds = named.is_some() == recorded.triangles.is_some()
            && recorded.from_m <= first_m
            && named.is_none_or(|named| named.travel_m >= first_m)
            && (!recorded.is_settled || named == found);
        let (best, is_settled) = if holds { (named, recorded.is_settled) } else { (found, true) };
        let state = &mut self.tasks[number as usize];
        best.map(|best| state.improve(best));
        if is_settled {
            self.settle(number);
        } else {
            let candidate = state.candidate;
            let touching_m = best.map(|best| best.travel_m);
            self.candidate_states[candidate].narrow(recorded.from_m, touching_m);
            if let Some(job_history) = &mut self.job_history {
                job_history.narrow(TaskId(number), recorded);
            }
        }
    }
}
