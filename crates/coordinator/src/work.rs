//! The work of one request: tasks become jobs, results become evidence, evidence becomes an answer.

use crate::candidate_state::{CandidateState, Purpose};
use crate::job_history::{Asked, JobHistory};
use crate::request::Request;
use crate::request_limits::RequestLimits;
use crate::strategy::Strategy;
use body::{BodyView, Meta};
use buffers::BufferPool;
use bvh::{Counters, NodePair, OpenPair, SweepBounds, front, section};
use dispatch::{Closed, Job};
use geometry::RelativePose;
use geometry::hash::splitmix64;
use outlook::Outlook;
use protocol::{Section, TaskId, WireQuestion, WireTask};
use std::collections::VecDeque;

mod buffers;
mod choose;
mod first;
mod judge;
mod outlook;
mod recording;
mod task;
#[cfg(test)]
mod tests;

pub use buffers::RunBuffers;
pub use outlook::Certainty;
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
    /// Maximum number of box and triangle tests per job.
    fn budget(&self) -> u64 {
        u64::MAX
    }
    /// The travel (m) at which a job that seeks first contact gives back what it has left, as
    /// another one is more urgent from there on.
    fn yield_after_m(&self, _job: &Job) -> f32 {
        f32::INFINITY
    }
}

/// The effort of a request, as the cost model counts it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Tasks: questions about ways and poses.
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
pub struct RankingRun<'w> {
    request: &'w Request,
    bodies: &'w [(Meta, BodyView<'w>)],
    /// Per body, the zones that its triangles belong to.
    zones: Vec<u16>,
    depth: u32,
    candidate_states: Vec<CandidateState>,
    tasks: Vec<TaskState>,
    /// Tasks with jobs to hand out, in the order in which they were asked for.
    waiting: VecDeque<u32>,
    pairs: Vec<NodePair>,
    purposes: Vec<(Purpose, f64, WireQuestion)>,
    /// Number of jobs, including those that were never handed out.
    slots: usize,
    effort: Effort,
    limits: RequestLimits,
    strategy: Box<dyn Strategy>,
    outlook: Outlook,
    spare: BufferPool,
    deadline_ns: Option<u64>,
    job_history: Option<JobHistory>,
    /// If this is a replay: what was asked in time.
    asked: Option<Asked>,
}

impl<'w> RankingRun<'w> {
    /// A run with nothing done yet. `bodies` are those of the scenario's parties, in their order.
    #[must_use]
    pub fn new(request: &'w Request, bodies: &'w [(Meta, BodyView<'w>)], depth: u32) -> Self {
        Self::with_buffers(request, bodies, depth, RunBuffers::default())
    }

    /// [`RankingRun::new`] in the buffers of an earlier request of the same bodies at the same
    /// depth: then nothing is allocated.
    #[must_use]
    pub fn with_buffers(
        request: &'w Request,
        bodies: &'w [(Meta, BodyView<'w>)],
        depth: u32,
        buffers: RunBuffers,
    ) -> Self {
        let buffers = buffers.for_request(request, bodies);
        let RunBuffers { zones, candidate_states, tasks, waiting, .. } = buffers;
        let RunBuffers { pairs, purposes, outlook, spare, .. } = buffers;
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
            purposes,
            slots: 0,
            effort: Effort::default(),
            limits,
            strategy: limits.search_order.strategy(),
            outlook,
            spare,
            deadline_ns: None,
            job_history: None,
            asked: None,
        };
        for (k, candidate) in request.candidates.iter().enumerate() {
            let task = work.tasks.len() as u32;
            work.candidate_states[k].begin(candidate, task, &mut work.purposes);
            work.ask(k);
        }
        work
    }

    /// The buffers, for the next request.
    #[must_use]
    pub fn into_buffers(self) -> RunBuffers {
        let Self {
            zones, candidate_states, tasks, waiting, pairs, purposes, outlook, spare, ..
        } = self;
        RunBuffers { zones, candidate_states, tasks, waiting, pairs, purposes, outlook, spare }
    }

    /// This run with other limits.
    #[must_use]
    pub fn with_limits(self, limits: RequestLimits) -> Self {
        Self { limits, strategy: limits.search_order.strategy(), ..self }
    }

    pub(crate) fn request(&self) -> &'w Request {
        self.request
    }

    pub(crate) fn candidate_states(&self) -> &[CandidateState] {
        &self.candidate_states
    }

    /// The effort so far.
    #[must_use]
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Asks for what a candidate needs next: one task for each purpose.
    fn ask(&mut self, k: usize) {
        let candidate = &self.request.candidates[k];
        let mut purposes = std::mem::take(&mut self.purposes);
        for (purpose, travel_m, question) in purposes.drain(..) {
            let u = candidate.approach.directions.d[0];
            let z = candidate.approach.directions.d[damage::approach::UP];
            // A search begins at the given pose, whatever travel that is: it states travels itself.
            let (pose, travels_m) = match (purpose, &candidate.meeting) {
                (Purpose::FirstContact, damage::Meeting::Path(path)) => {
                    (candidate.pose, [path.from_m, path.to_m])
                }
                _ => (candidate.pose.moved(-u * travel_m), [0.0; 2]),
            };
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
                travels_m,
            };
            let state = self.spare.state(k, (purpose, travel_m), wire);
            self.effort.tasks += 1;
            if self.asked.as_ref().is_none_or(|asked| asked.has(&state)) {
                self.waiting.push_back(task);
            }
            self.tasks.push(state);
        }
        self.purposes = purposes;
    }

    /// A body of the request, by its number.
    pub(crate) fn body_of(&self, model: u32) -> &'w (Meta, BodyView<'w>) {
        &self.bodies[model as usize]
    }

    fn views(&self, task: &WireTask) -> (&'w BodyView<'w>, &'w BodyView<'w>) {
        (&self.bodies[task.model_a as usize].1, &self.bodies[task.model_b as usize].1)
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
        if state.is_first_contact() {
            // Opened bit by bit, as its jobs are handed out.
            match state.sweep_task((a, b)) {
                Some(task) => state.front.begin(&SweepBounds::new(&task), descent),
                // A way too long to be searched: all of it stays open, so it is never "no contact".
                None => {
                    state.lost.push(OpenPair { pair: NodePair::ROOTS, from_m: f32::NEG_INFINITY });
                }
            }
            return;
        }
        self.pairs.clear();
        front(a, b, &pose_of(&wire), self.depth, &mut self.pairs, descent);
        self.slots += self.pairs.len();
        let state = &mut self.tasks[number as usize];
        state.found = Some(self.spare.gathered(a.corners.len(), b.corners.len()));
        state.todo.extend(self.pairs.iter().rev());
    }

    /// Hands out jobs of a task, as many as the strategy allows at once.
    fn hand_out(&mut self, number: u32, jobs: &mut Vec<Job>) {
        if !self.tasks[number as usize].is_descended {
            self.descend(number);
        }
        let stride = self.strategy.stride();
        if self.tasks[number as usize].is_first_contact() {
            return self.hand_out_first(number, stride, jobs);
        }
        let state = &mut self.tasks[number as usize];
        let section = |model, node| Section { model, node };
        let keep = state.todo.len().saturating_sub(stride);
        for pair in state.todo.drain(keep..).rev() {
            state.out.push_back(OpenPair { pair, from_m: f32::NEG_INFINITY });
            jobs.push(Job {
                task: TaskId(number),
                a: section(state.wire.model_a, pair.a),
                b: section(state.wire.model_b, pair.b),
            });
        }
        self.outlook.handed_out(state.candidate, jobs.len());
        if state.todo.is_empty() {
            self.waiting.retain(|waiting| *waiting != number);
            self.finish_if_closed(number);
        }
    }

    /// If all jobs of a task are closed, draws the conclusion and asks for what follows.
    fn finish_if_closed(&mut self, number: u32) {
        let state = &mut self.tasks[number as usize];
        if state.is_first_contact() {
            return self.finish_first_if_closed(number);
        }
        if !state.todo.is_empty() || !state.out.is_empty() || !state.is_descended {
            return;
        }
        let (k, purpose) = (state.candidate, state.purpose);
        self.outlook.touch(k, true);
        if state.is_obsolete {
            self.spare.gathered.extend(state.found.take());
            return;
        }
        if !state.lost.is_empty() {
            // Its bound stays as wide as it is: of a stop, what was found.
            return;
        }
        let Some(found) = state.found.take() else { return };
        let wire = state.wire;
        if let Purpose::Survey { stop } = purpose {
            let views = self.views(&wire);
            self.candidate_states[k].surveyed(stop, &found, views);
            if self.candidate_states[k].is_done() {
                self.note();
            }
        }
        self.spare.gathered.push(found);
    }

    /// Notes a job as lost: its result stays unknown.
    fn lose(&mut self, number: u32, open: OpenPair) {
        let state = &mut self.tasks[number as usize];
        if !state.lost.iter().any(|lost| lost.pair == open.pair) {
            state.lost.push(open);
        }
    }

    /// Turns what a job left open into jobs of the same task, which go out first, or in a search
    /// for first contact in their turn.
    fn divide(&mut self, number: u32, job: OpenPair, rest: &[NodePair]) {
        let state = &self.tasks[number as usize];
        let views = self.views(&state.wire);
        let is_first_contact = state.is_first_contact();
        let state = &mut self.tasks[number as usize];
        if self.slots + rest.len() > SLOTS_MAX {
            state.lost.extend(rest.iter().map(|pair| OpenPair { pair: *pair, ..job }));
            return;
        }
        self.slots += rest.len();
        if is_first_contact {
            let bounds = state.sweep_task(views).map(|task| SweepBounds::new(&task));
            for pair in rest {
                let Some(bounds) = &bounds else {
                    state.lost.push(OpenPair { pair: *pair, ..job });
                    continue;
                };
                let Some(from_m) = bounds.first_m(*pair) else { continue };
                // Bounds only narrow on the way down.
                state.front.push(OpenPair { pair: *pair, from_m: from_m.max(job.from_m) });
            }
        } else {
            state.todo.extend(rest);
        }
        let has_more = !state.todo.is_empty() || !state.front.is_empty();
        if has_more && !self.waiting.contains(&number) {
            self.waiting.push_front(number);
        }
    }
}

/// Maximum number of jobs of a request: what exceeds it stays open.
const SLOTS_MAX: usize = 4 * bvh::front::PAIRS_MAX;

fn pose_of(wire: &WireTask) -> RelativePose {
    RelativePose { rotation: wire.rotation, translation: wire.translation }
}

impl TaskSource for RankingRun<'_> {
    fn task(&self, task: TaskId) -> Option<&WireTask> {
        self.tasks.get(task.0 as usize).map(|state| &state.wire)
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).map(|(_, body)| *body)
    }

    fn accept(&mut self, now_ns: u64) {
        self.outlook.begin(now_ns);
        self.deadline_ns = self.limits.deadline_ns.map(|length_ns| now_ns + length_ns);
    }

    fn deadline_ns(&self) -> Option<u64> {
        self.deadline_ns
    }

    fn is_over(&self, now_ns: u64) -> bool {
        self.outlook.is_decided() || self.deadline_ns.is_some_and(|due_ns| due_ns <= now_ns)
    }

    fn budget(&self) -> u64 {
        self.limits.budget
    }

    fn yield_after_m(&self, job: &Job) -> f32 {
        let state = self.tasks.get(job.task.0 as usize);
        state.and_then(|state| state.front.first_m()).unwrap_or(f32::INFINITY)
    }
}

impl dispatch::JobSource for RankingRun<'_> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Job>) {
        while jobs.is_empty() && !self.outlook.is_decided() {
            let Some(number) = self.choose() else { return };
            self.hand_out(number, jobs);
        }
    }

    fn is_obsolete(&self, job: &Job) -> bool {
        self.outlook.is_decided() || self.is_job_obsolete(job)
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let Some(state) = self.tasks.get_mut(job.task.0 as usize) else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        let sound = if state.is_first_contact() {
            self.fold_first(job.task.0, &part.0)
        } else if let Some(found) = &mut state.found {
            found.fold(part.0, &mut self.effort.jobs)
        } else {
            return;
        };
        let state = &mut self.tasks[job.task.0 as usize];
        state.store_rest(pair, &part.0, &mut self.spare.rests);
        if !sound || !state.is_whole(pair, &part.0) {
            let open = state.handed(pair);
            self.lose(job.task.0, open);
        }
    }

    fn close(&mut self, job: &Job, how: Closed) {
        let is_obsolete =
            self.tasks.get(job.task.0 as usize).is_some() && self.is_job_obsolete(job);
        let Some(state) = self.tasks.get_mut(job.task.0 as usize) else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        let open = state.handed(pair);
        // Jobs end roughly in the order in which they went out.
        if let Some(at) = state.out.iter().position(|out| out.pair == pair) {
            state.out.remove(at);
        }
        state.done += u64::from(how == Closed::Done);
        let rest = state.rests.iter().position(|(of, _)| *of == pair);
        let rest = rest.map(|at| state.rests.swap_remove(at).1);
        // Cut because the winner is certain: it is as open as one that never went out.
        let is_open = how == Closed::Cut && !is_obsolete;
        if let Some(job_history) = self.job_history.as_mut().filter(|_| !is_open) {
            job_history.close(job, how);
        }
        if matches!(how, Closed::Abandoned | Closed::Late) || is_open {
            self.lose(job.task.0, open);
        } else if let Some(rest) = rest.as_ref().filter(|_| how == Closed::Done && !is_obsolete) {
            self.divide(job.task.0, open, rest);
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
