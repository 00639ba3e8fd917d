//! The work of one request: tasks become jobs, results become evidence, evidence becomes an answer.

use crate::candidate_state::CandidateState;
use crate::job_history::JobHistory;
use crate::request::{Candidate, Request, Wanted};
use crate::request_limits::RequestLimits;
use crate::strategy::Strategy;
use body::{BodyView, Meta, Zones};
use buffers::BufferPool;
use bvh::{Counters, NodePair, front, front_where, section};
use dispatch::{Closed, Job};
use geometry::RelativePose;
use geometry::hash::splitmix64;
use outlook::Outlook;
use protocol::{Section, TaskId, WireQuestion, WireTask};
use std::collections::VecDeque;

mod buffers;
mod choose;
mod judge;
mod outlook;
mod recording;
mod task;

pub(crate) use buffers::SurveyBuffers;
pub use task::PartOf;
pub(crate) use task::TaskState;

/// Work that workers can do: its tasks are sent as messages, and its results arrive in parts.
pub trait TaskSource: for<'p> dispatch::JobSource<Part<'p> = PartOf<'p>> {
    /// The task as encoded for workers; `None` if there is no such task.
    fn task(&self, task: TaskId) -> Option<&WireTask>;
    /// The body with this number.
    fn body(&self, model: u32) -> Option<BodyView<'_>>;

    /// Called when the workers are ready: the deadline counts from `_now_ns` (ns, monotonic).
    fn accept(&mut self, _now_ns: u64) {}
    /// When the answer is due, if ever (ns, monotonic).
    fn deadline_ns(&self) -> Option<u64> {
        None
    }
    /// Whether open work is no longer waited for.
    fn is_over(&self, _now_ns: u64) -> bool {
        false
    }
    /// Called while workers work and nothing of them is there to take: does a little of what has to
    /// be done besides; `false` if there is nothing.
    fn use_spare_time(&mut self) -> bool {
        false
    }
    /// Maximum number of box and triangle tests per job.
    fn budget(&self) -> u64 {
        u64::MAX
    }
}

/// The effort of a request, as the cost model counts it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Tasks: questions about poses.
    pub tasks: u64,
    /// Tests of the traversals to the distribution depth.
    pub descent: Counters,
    /// Tests of the jobs.
    pub jobs: Counters,
}

impl Effort {
    /// Adds the effort of another request.
    pub fn add(&mut self, other: &Self) {
        self.tasks += other.tasks;
        self.descent.add(&other.descent);
        self.jobs.add(&other.jobs);
    }
}

/// The work of one request. The backend that runs its jobs drives it through
/// [`dispatch::JobSource`].
#[derive(Debug)]
pub(crate) struct SurveyRun<'w> {
    request: &'w Request,
    bodies: &'w [(Meta, BodyView<'w>)],
    /// Per body and node, the zones that triangles below belong to.
    zones: Vec<Vec<Zones>>,
    depth: u32,
    candidate_states: Vec<CandidateState>,
    tasks: Vec<TaskState>,
    /// Tasks with jobs to hand out, in the order in which they were asked for.
    waiting: VecDeque<u32>,
    pairs: Vec<NodePair>,
    asked: Vec<(usize, f64, WireQuestion)>,
    /// Number of jobs, including those that were never handed out.
    slots: usize,
    /// Contacts whose planes are laid.
    laid: usize,
    effort: Effort,
    limits: RequestLimits,
    strategy: Box<dyn Strategy>,
    outlook: Outlook,
    spare: BufferPool,
    deadline_ns: Option<u64>,
    job_history: Option<JobHistory>,
}

impl<'w> SurveyRun<'w> {
    /// A run with nothing done yet. `bodies` are those of the scenario's parties, in their order.
    #[cfg(test)]
    pub(crate) fn new(
        request: &'w Request,
        bodies: &'w [(Meta, BodyView<'w>)],
        depth: u32,
    ) -> Self {
        Self::with_buffers(request, bodies, depth, SurveyBuffers::default())
    }

    /// [`SurveyRun::new`] in the buffers of an earlier request of the same bodies at the same
    /// depth: then nothing is allocated.
    pub(crate) fn with_buffers(
        request: &'w Request,
        bodies: &'w [(Meta, BodyView<'w>)],
        depth: u32,
        buffers: SurveyBuffers,
    ) -> Self {
        let buffers = buffers.for_request(request, bodies);
        let SurveyBuffers { zones, candidate_states, tasks, waiting, .. } = buffers;
        let SurveyBuffers { pairs, asked, outlook, spare, .. } = buffers;
        let limits = RequestLimits::default();
        let mut work = Self {
            request,
            bodies,
            zones,
            depth,
            candidate_states,
            tasks,
            waiting,
            pairs,
            asked,
            slots: 0,
            laid: 0,
            effort: Effort::default(),
            limits,
            strategy: limits.search_order.strategy(),
            outlook,
            spare,
            deadline_ns: None,
            job_history: None,
        };
        for (k, candidate) in request.candidates.iter().enumerate() {
            let task = work.tasks.len() as u32;
            work.candidate_states[k].begin(task, &mut work.asked);
            work.ask(k, candidate);
        }
        work
    }

    /// The buffers, for the next request.
    pub(crate) fn into_buffers(self) -> SurveyBuffers {
        let Self { zones, candidate_states, tasks, waiting, .. } = self;
        let Self { pairs, asked, outlook, spare, .. } = self;
        SurveyBuffers { zones, candidate_states, tasks, waiting, pairs, asked, outlook, spare }
    }

    /// This run with other limits.
    pub(crate) fn with_limits(self, limits: RequestLimits) -> Self {
        Self { limits, strategy: limits.search_order.strategy(), ..self }
    }

    pub(crate) fn request(&self) -> &'w Request {
        self.request
    }

    pub(crate) fn candidate_states(&self) -> &[CandidateState] {
        &self.candidate_states
    }

    /// The effort so far.
    pub(crate) fn effort(&self) -> Effort {
        self.effort
    }

    /// Asks for the poses of a candidate: one task for each.
    fn ask(&mut self, k: usize, candidate: &Candidate) {
        let mut asked = std::mem::take(&mut self.asked);
        for (stop, travel_m, question) in asked.drain(..) {
            let u = candidate.approach.directions.d[0];
            let z = candidate.approach.directions.d[damage::approach::UP];
            let pose = candidate.pose.moved(-u * travel_m);
            let task = self.tasks.len() as u32;
            let wire = WireTask {
                model_a: candidate.model_a,
                model_b: candidate.model_b,
                question: question as u32,
                task,
                rotation: pose.rotation,
                translation: pose.translation,
                u: u.to_array(),
                z: z.to_array(),
            };
            let state = self.spare.state(k, (stop, travel_m), wire);
            self.effort.tasks += 1;
            self.waiting.push_back(task);
            self.tasks.push(state);
        }
        self.asked = asked;
    }

    /// A body of the request, by its number.
    pub(crate) fn body_of(&self, model: u32) -> &'w (Meta, BodyView<'w>) {
        &self.bodies[model as usize]
    }

    fn views(&self, task: &WireTask) -> (&'w BodyView<'w>, &'w BodyView<'w>) {
        (&self.bodies[task.model_a as usize].1, &self.bodies[task.model_b as usize].1)
    }

    /// Lays the plane of a contact: nothing of it is assessed before. Returns whether it was not.
    pub(crate) fn lay_plane(&self, k: usize) -> bool {
        let candidate = &self.request.candidates[k];
        let outlines = [candidate.model_a, candidate.model_b]
            .map(|model| &self.bodies[model as usize].0.outlines);
        candidate.lay_plane(outlines)
    }

    /// Traverses for one task: afterwards its jobs, if any, can be handed out.
    fn descend(&mut self, number: u32) {
        let wire = self.tasks[number as usize].wire;
        let (a, b) = self.views(&wire);
        let descent = &mut self.effort.descent;
        let state = &mut self.tasks[number as usize];
        state.is_descended = true;
        if let Some(job_history) = &mut self.job_history {
            job_history.ask(TaskId(number), state);
        }
        self.pairs.clear();
        match self.request.candidates[state.candidate].wanted {
            Wanted::Everything => {
                front(a, b, &pose_of(&wire), self.depth, &mut self.pairs, descent);
            }
            Wanted::Zones(wanted) => {
                let zones = [wire.model_a, wire.model_b].map(|model| &self.zones[model as usize]);
                let has =
                    |side: usize, node: u32| zones[side][node as usize].0 & wanted[side].0 != 0;
                let mut counts = |pair: NodePair| has(0, pair.a) || has(1, pair.b);
                let (depth, pairs) = (self.depth + ZONES_DEEPER, &mut self.pairs);
                front_where((a, b), &pose_of(&wire), depth, &mut counts, pairs, descent);
            }
        }
        self.slots += self.pairs.len();
        let state = &mut self.tasks[number as usize];
        // At most stops of a member nothing meets that counts, and then there is nothing to gather.
        let hit =
            if self.pairs.is_empty() { [0; 2] } else { [a, b].map(|body| body.corners.len()) };
        state.found = Some(self.spare.gathered(hit));
        state.todo.extend(self.pairs.iter().rev());
    }

    /// Hands out jobs of a task, as many as the strategy allows at once.
    fn hand_out(&mut self, number: u32, jobs: &mut Vec<Job>) {
        if self.candidate_states[self.tasks[number as usize].candidate].is_obsolete() {
            // Whatever is left of it is not needed.
            self.tasks[number as usize].todo.clear();
            self.stop_waiting(number);
            return;
        }
        if !self.tasks[number as usize].is_descended {
            self.descend(number);
        }
        let stride = self.strategy.stride();
        let state = &mut self.tasks[number as usize];
        let section = |model, node| Section { model, node };
        let keep = state.todo.len().saturating_sub(stride);
        for pair in state.todo.drain(keep..).rev() {
            state.out.push_back(pair);
            jobs.push(Job {
                task: TaskId(number),
                a: section(state.wire.model_a, pair.a),
                b: section(state.wire.model_b, pair.b),
            });
        }
        if state.todo.is_empty() {
            self.stop_waiting(number);
            self.finish_if_closed(number);
        }
    }

    /// Nothing of this task is left to be handed out.
    fn stop_waiting(&mut self, number: u32) {
        if self.waiting.front() == Some(&number) {
            self.waiting.pop_front();
        } else {
            self.waiting.retain(|waiting| *waiting != number);
        }
    }

    /// If all jobs of a task are closed, draws the conclusion and asks for what follows.
    fn finish_if_closed(&mut self, number: u32) {
        let state = &mut self.tasks[number as usize];
        if !state.todo.is_empty() || !state.out.is_empty() || !state.is_descended {
            return;
        }
        let (k, stop) = (state.candidate, state.stop);
        self.outlook.touch(k, true);
        if !state.lost.is_empty() {
            // Its bound stays as wide as it is: of a stop, what was found.
            return;
        }
        let Some(found) = state.found.take() else { return };
        let wire = state.wire;
        let views = self.views(&wire);
        self.candidate_states[k].surveyed(stop, &found, views);
        self.spare.gathered.push(found);
    }

    /// Notes a job as lost: its result stays unknown.
    fn lose(&mut self, number: u32, open: NodePair) {
        let state = &mut self.tasks[number as usize];
        if !state.lost.contains(&open) {
            state.lost.push(open);
        }
    }

    /// Turns what a job left open into jobs of the same task, which go out first.
    fn divide(&mut self, number: u32, job: NodePair, rest: &[NodePair]) {
        let state = &mut self.tasks[number as usize];
        if self.slots + rest.len() > SLOTS_MAX {
            state.lost.push(job);
            return;
        }
        self.slots += rest.len();
        state.todo.extend(rest);
        if !state.todo.is_empty() && !self.waiting.contains(&number) {
            self.waiting.push_front(number);
        }
    }
}

/// How many levels deeper the trees are cut where only zones are wanted: what does not belong to
/// them is left out at once.
const ZONES_DEEPER: u32 = 3;

/// Maximum number of jobs of a request: what exceeds it stays open.
pub(crate) const SLOTS_MAX: usize = 4 * bvh::front::PAIRS_MAX;

fn pose_of(wire: &WireTask) -> RelativePose {
    RelativePose { rotation: wire.rotation, translation: wire.translation }
}

impl TaskSource for SurveyRun<'_> {
    fn task(&self, task: TaskId) -> Option<&WireTask> {
        self.tasks.get(task.0 as usize).map(|state| &state.wire)
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).map(|(_, body)| *body)
    }

    fn accept(&mut self, now_ns: u64) {
        self.deadline_ns = self.limits.deadline_ns.map(|length_ns| now_ns + length_ns);
    }

    fn deadline_ns(&self) -> Option<u64> {
        self.deadline_ns
    }

    fn is_over(&self, now_ns: u64) -> bool {
        self.deadline_ns.is_some_and(|due_ns| due_ns <= now_ns)
    }

    fn use_spare_time(&mut self) -> bool {
        while self.laid < self.request.candidates.len() {
            self.laid += 1;
            if self.lay_plane(self.laid - 1) {
                return true;
            }
        }
        false
    }

    fn budget(&self) -> u64 {
        self.limits.budget
    }
}

impl dispatch::JobSource for SurveyRun<'_> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        while jobs.is_empty() {
            let Some(number) = self.choose() else { return };
            self.hand_out(number, jobs);
        }
    }

    fn is_obsolete(&self, job: &Job) -> bool {
        let task = self.tasks.get(job.task.0 as usize);
        task.is_some_and(|task| self.candidate_states[task.candidate].is_obsolete())
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let Some(state) = self.tasks.get_mut(job.task.0 as usize) else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        let Some(found) = &mut state.found else { return };
        let sound = found.fold(part.0, &mut self.effort.jobs);
        self.candidate_states[state.candidate].note([found.zones_a, found.zones_b]);
        state.store_rest(pair, &part.0, &mut self.spare.rests);
        if !sound || !state.is_whole(pair, &part.0) {
            self.lose(job.task.0, pair);
        }
    }

    fn close(&mut self, job: &Job, how: Closed) {
        let Some(state) = self.tasks.get_mut(job.task.0 as usize) else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        // Jobs end roughly in the order in which they went out.
        if let Some(at) = state.out.iter().position(|out| *out == pair) {
            state.out.remove(at);
        }
        state.done += u64::from(how == Closed::Done);
        let rest = state.rests.iter().position(|(of, _)| *of == pair);
        let rest = rest.map(|at| state.rests.swap_remove(at).1);
        // It is as open as one that never went out.
        let is_open = how == Closed::Cut;
        if let Some(job_history) = self.job_history.as_mut().filter(|_| !is_open) {
            job_history.close(job, how);
        }
        if matches!(how, Closed::Abandoned | Closed::Late) || is_open {
            self.lose(job.task.0, pair);
        } else if let Some(rest) = rest.as_ref().filter(|_| how == Closed::Done) {
            self.divide(job.task.0, pair, rest);
        }
        self.spare.rests.extend(rest);
        self.outlook.touch(self.tasks[job.task.0 as usize].candidate, false);
        self.finish_if_closed(job.task.0);
        self.review();
    }

    fn weight(&self, section: Section) -> u64 {
        let body = self.bodies.get(section.model as usize);
        body.map_or(0, |(_, body)| section::bytes(body.nodes, section.node))
    }

    /// A key of bodies, pose and nodes: the input of the kernel, whatever the request.
    fn key(&self, job: &Job) -> Option<u64> {
        let WireTask { model_a, model_b, question, rotation, translation, .. } =
            self.tasks.get(job.task.0 as usize)?.wire;
        let numbers = [model_a, model_b, question, job.a.node, job.b.node].map(u64::from);
        let pose = rotation.as_flattened().iter().chain(&translation).map(|value| value.to_bits());
        Some(numbers.into_iter().chain(pose).fold(0, |hash, next| splitmix64(hash ^ next)))
    }
}

#[cfg(test)]
mod tests;
