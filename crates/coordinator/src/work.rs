//! The work of one request: tasks become jobs, results become evidence, evidence becomes an answer.

use crate::case::{Aim, Case};
use crate::ledger::{Asked, JobHistory};
use crate::request::Request;
use crate::strategy::Strategy;
use crate::terms::RequestLimits;
use body::{BodyView, Meta};
use bvh::{Counters, NodePair, front, section};
use dispatch::{Closed, Job};
use geometry::RelativePose;
use geometry::hash::splitmix64;
use outlook::Outlook;
use protocol::{Section, TaskId, WireQuestion, WireTask};
use room::Spare;
use std::collections::VecDeque;

mod choose;
mod errand;
mod judge;
mod keep;
mod outlook;
mod room;

pub use errand::PartOf;
pub(crate) use errand::TaskState;
pub use outlook::Certainty;
pub use room::Room;

/// Work that workers can do: its tasks travel, and its results come as parts of messages.
pub trait TaskSource: for<'p> dispatch::JobSource<Part<'p> = PartOf<'p>> {
    /// The task as it travels; `None` if there is no such task.
    fn task(&self, task: TaskId) -> Option<&WireTask>;
    /// The body of this number.
    fn body(&self, model: u32) -> Option<BodyView<'_>>;

    /// The workers are ready, and the clock of a deadline starts (ns, monotonic).
    fn accept(&mut self, _now_ns: u64) {}
    /// When the answer is due, if ever (ns, monotonic).
    fn deadline_ns(&self) -> Option<u64> {
        None
    }
    /// Whether what is still open is not waited for any longer.
    fn is_over(&self, _now_ns: u64) -> bool {
        false
    }
    /// Most tests of boxes and triangles that a job may take.
    fn budget(&self) -> u64 {
        u64::MAX
    }
}

/// What it took, in the terms of the cost model and beyond.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Tasks: questions about poses.
    pub tasks: u64,
    /// Tests of the descents to the distribution depth.
    pub descent: Counters,
    /// Tests of the jobs.
    pub jobs: Counters,
}

/// A request at work. Whoever runs the jobs drives it through [`dispatch::JobSource`].
#[derive(Debug)]
pub struct RankingRun<'w> {
    request: &'w Request,
    bodies: &'w [(Meta, BodyView<'w>)],
    /// Per body, the zones that its triangles belong to.
    zones: Vec<u16>,
    depth: u32,
    cases: Vec<Case>,
    errands: Vec<TaskState>,
    /// Tasks with jobs to hand out, in the order in which they were asked for.
    waiting: VecDeque<u32>,
    pairs: Vec<NodePair>,
    aims: Vec<(Aim, f64, WireQuestion)>,
    /// Jobs there are, those included that were never handed out.
    slots: usize,
    effort: Effort,
    terms: RequestLimits,
    strategy: Box<dyn Strategy>,
    outlook: Outlook,
    spare: Spare,
    deadline_ns: Option<u64>,
    ledger: Option<JobHistory>,
    /// If this is a replay: what was asked in time.
    asked: Option<Asked>,
}

impl<'w> RankingRun<'w> {
    /// Nothing done yet. `bodies` are those of the scenario's parties, in their order.
    #[must_use]
    pub fn new(request: &'w Request, bodies: &'w [(Meta, BodyView<'w>)], depth: u32) -> Self {
        Self::in_room(request, bodies, depth, Room::default())
    }

    /// The same in the room of an earlier request of the same bodies at the same depth: then none
    /// is taken from the heap.
    #[must_use]
    pub fn in_room(
        request: &'w Request,
        bodies: &'w [(Meta, BodyView<'w>)],
        depth: u32,
        room: Room,
    ) -> Self {
        let Room { zones, cases, errands, waiting, pairs, aims, outlook, spare } =
            room.for_request(request, bodies);
        let terms = RequestLimits::default();
        let mut work = Self {
            request,
            bodies,
            zones,
            depth,
            cases,
            errands,
            waiting,
            pairs,
            aims,
            slots: 0,
            effort: Effort::default(),
            terms,
            strategy: terms.pursuit.strategy(),
            outlook,
            spare,
            deadline_ns: None,
            ledger: None,
            asked: None,
        };
        for case in 0..work.cases.len() {
            work.advance(case);
        }
        work
    }

    /// The room, for the next request.
    #[must_use]
    pub fn into_room(self) -> Room {
        let Self { zones, cases, errands, waiting, pairs, aims, outlook, spare, .. } = self;
        Room { zones, cases, errands, waiting, pairs, aims, outlook, spare }
    }

    /// The same on other terms.
    #[must_use]
    pub fn with_terms(self, terms: RequestLimits) -> Self {
        Self { terms, strategy: terms.pursuit.strategy(), ..self }
    }

    pub(crate) fn request(&self) -> &'w Request {
        self.request
    }

    pub(crate) fn cases(&self) -> &[Case] {
        &self.cases
    }

    /// What it took so far.
    #[must_use]
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Asks for whatever a candidate needs next.
    fn advance(&mut self, case: usize) {
        let candidate = &self.request.candidates[case];
        let task = self.errands.len() as u32;
        self.cases[case].advance(candidate, task, &mut self.aims);
        let mut aims = std::mem::take(&mut self.aims);
        for (aim, travel_m, question) in aims.drain(..) {
            let u = candidate.approach.directions.d[0];
            let z = candidate.approach.directions.d[damage::approach::UP];
            let pose = candidate.pose.moved(-u * travel_m);
            let task = self.errands.len() as u32;
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
            let errand = self.spare.errand(case, (aim, travel_m), wire);
            self.effort.tasks += 1;
            if self.asked.as_ref().is_none_or(|asked| asked.has(&errand)) {
                self.waiting.push_back(task);
            }
            self.errands.push(errand);
        }
        self.aims = aims;
    }

    fn views(&self, task: &WireTask) -> (&'w BodyView<'w>, &'w BodyView<'w>) {
        (&self.bodies[task.model_a as usize].1, &self.bodies[task.model_b as usize].1)
    }

    /// Descends for one task: its jobs are there to be handed out, which may be none.
    fn descend(&mut self, number: u32) {
        let wire = self.errands[number as usize].wire;
        let (a, b) = self.views(&wire);
        let pose = pose_of(&wire);
        self.pairs.clear();
        let descent = &mut self.effort.descent;
        front(a, b, &pose, self.depth, &mut self.pairs, descent);
        self.slots += self.pairs.len();
        let errand = &mut self.errands[number as usize];
        errand.is_descended = true;
        if let Some(ledger) = &mut self.ledger {
            ledger.ask(TaskId(number), errand);
        }
        errand.found = Some(self.spare.gathered(a.corners.len(), b.corners.len()));
        errand.todo.extend(self.pairs.iter().rev());
    }

    /// Hands out jobs of a task, as many as the strategy gives away at once.
    fn hand_out(&mut self, number: u32, jobs: &mut Vec<Job>) {
        if !self.errands[number as usize].is_descended {
            self.descend(number);
        }
        let stride = self.strategy.stride();
        let errand = &mut self.errands[number as usize];
        let section = |model, node| Section { model, node };
        let keep = errand.todo.len().saturating_sub(stride);
        for pair in errand.todo.drain(keep..).rev() {
            errand.out.push_back(pair);
            jobs.push(Job {
                task: TaskId(number),
                a: section(errand.wire.model_a, pair.a),
                b: section(errand.wire.model_b, pair.b),
            });
        }
        self.outlook.handed_out(errand.case, jobs.len());
        if errand.todo.is_empty() {
            self.waiting.retain(|waiting| *waiting != number);
            self.finish_if_closed(number);
        }
    }

    /// Jobs of a task that cannot matter and were never handed out.
    fn drop_obsolete(&mut self, number: u32) {
        let errand = &mut self.errands[number as usize];
        let mut dropped = std::mem::take(&mut errand.todo);
        if let Some(ledger) = &mut self.ledger {
            let section = |model, node| Section { model, node };
            for pair in dropped.iter().rev() {
                let a = section(errand.wire.model_a, pair.a);
                let b = section(errand.wire.model_b, pair.b);
                ledger.close(&Job { task: TaskId(number), a, b }, Closed::Cut);
            }
        }
        dropped.clear();
        errand.todo = dropped;
        self.finish_if_closed(number);
    }

    /// If all jobs of a task are closed: draws the conclusion, and asks for what follows.
    fn finish_if_closed(&mut self, number: u32) {
        let errand = &mut self.errands[number as usize];
        if !errand.todo.is_empty() || !errand.out.is_empty() || !errand.is_descended {
            return;
        }
        let (case, aim) = (errand.case, errand.aim);
        self.outlook.touch(case, true);
        if errand.is_obsolete {
            self.spare.gathered.extend(errand.found.take());
            return;
        }
        if !errand.lost.is_empty() {
            // It stays as wide as it is: of a probe nothing is known, of a stop what was found.
            return;
        }
        let Some(found) = errand.found.take() else { return };
        let wire = errand.wire;
        match aim {
            Aim::Probe { travel_m } => self.learn(case, travel_m, false),
            Aim::Survey { stop } => {
                let views = self.views(&wire);
                self.cases[case].surveyed(stop, &found, views);
                if self.cases[case].is_done() {
                    self.note();
                }
            }
        }
        self.spare.gathered.push(found);
    }

    fn learn(&mut self, case: usize, travel_m: f64, touches: bool) {
        self.cases[case].learn(travel_m, touches);
        self.advance(case);
        self.outlook.touch(case, true);
        for number in 0..self.errands.len() {
            let errand = &mut self.errands[number];
            if errand.case == case && !errand.is_obsolete && !self.cases[case].needs(errand.aim) {
                errand.is_obsolete = true;
                self.waiting.retain(|waiting| *waiting != number as u32);
                self.drop_obsolete(number as u32);
            }
        }
    }

    /// Notes a job as lost: nothing will be known of it.
    fn lose(&mut self, number: u32, pair: NodePair) {
        let errand = &mut self.errands[number as usize];
        if !errand.lost.contains(&pair) {
            errand.lost.push(pair);
        }
    }

    /// What a job left open becomes jobs of the same task, which go out first.
    fn divide(&mut self, number: u32, rest: &[NodePair]) {
        let errand = &mut self.errands[number as usize];
        if self.slots + rest.len() > SLOTS_MAX {
            errand.lost.extend(rest);
            return;
        }
        self.slots += rest.len();
        errand.todo.extend(rest);
        if !errand.todo.is_empty() && !self.waiting.contains(&number) {
            self.waiting.push_front(number);
        }
    }
}

/// Jobs that a request may have in all: what would be more stays open.
const SLOTS_MAX: usize = 4 * bvh::front::PAIRS_MAX;

fn pose_of(wire: &WireTask) -> RelativePose {
    RelativePose { rotation: wire.rotation, translation: wire.translation }
}

impl TaskSource for RankingRun<'_> {
    fn task(&self, task: TaskId) -> Option<&WireTask> {
        self.errands.get(task.0 as usize).map(|errand| &errand.wire)
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).map(|(_, body)| *body)
    }

    fn accept(&mut self, now_ns: u64) {
        self.outlook.begin(now_ns);
        self.deadline_ns = self.terms.deadline_ns.map(|length_ns| now_ns + length_ns);
    }

    fn deadline_ns(&self) -> Option<u64> {
        self.deadline_ns
    }

    fn is_over(&self, now_ns: u64) -> bool {
        self.outlook.is_decided() || self.deadline_ns.is_some_and(|due_ns| due_ns <= now_ns)
    }

    fn budget(&self) -> u64 {
        self.terms.budget
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

    fn is_obsolete(&self, task: TaskId) -> bool {
        self.outlook.is_decided() || self.errands[task.0 as usize].is_obsolete
    }

    fn fold(&mut self, job: &Job, part: PartOf<'_>) {
        let Some(errand) = self.errands.get_mut(job.task.0 as usize) else { return };
        let Some(found) = &mut errand.found else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        let sound = found.fold(part.0, &mut self.effort.jobs);
        let touched = found.touched;
        errand.keep_rest(pair, &part.0, &mut self.spare.rests);
        if !sound || !errand.is_whole(pair, &part.0) {
            self.lose(job.task.0, pair);
        }
        let errand = &mut self.errands[job.task.0 as usize];
        if let Aim::Probe { travel_m } = errand.aim
            && touched
            && !errand.is_obsolete
        {
            // One hit answers it: the rest of the task is obsolete.
            let case = errand.case;
            errand.is_obsolete = true;
            self.waiting.retain(|waiting| *waiting != job.task.0);
            self.drop_obsolete(job.task.0);
            self.learn(case, travel_m, true);
        }
    }

    fn close(&mut self, job: &Job, how: Closed) {
        let Some(errand) = self.errands.get_mut(job.task.0 as usize) else { return };
        let pair = NodePair { a: job.a.node, b: job.b.node };
        // Jobs end about in the order in which they went out.
        if let Some(at) = errand.out.iter().position(|out| *out == pair) {
            errand.out.remove(at);
        }
        let is_obsolete = errand.is_obsolete;
        errand.done += u64::from(how == Closed::Done);
        let rest = errand.rests.iter().position(|(of, _)| *of == pair);
        let rest = rest.map(|at| errand.rests.swap_remove(at).1);
        // Cut because the winner is certain: it is as open as one that never went out.
        let is_open = how == Closed::Cut && !is_obsolete;
        if let Some(ledger) = self.ledger.as_mut().filter(|_| !is_open) {
            ledger.close(job, how);
        }
        if matches!(how, Closed::Abandoned | Closed::Late) || is_open {
            self.lose(job.task.0, pair);
        } else if let Some(rest) = rest.as_ref().filter(|_| how == Closed::Done && !is_obsolete) {
            self.divide(job.task.0, rest);
        }
        self.spare.rests.extend(rest);
        self.outlook.touch(self.errands[job.task.0 as usize].case, false);
        self.finish_if_closed(job.task.0);
        self.review();
    }

    fn weight(&self, section: Section) -> u64 {
        let body = self.bodies.get(section.model as usize);
        body.map_or(0, |(_, body)| section::bytes(body.nodes, section.node))
    }

    /// Bodies, pose and nodes: what the kernel is asked, whatever the request.
    fn key(&self, job: &Job) -> Option<u64> {
        let WireTask { model_a, model_b, question, rotation, translation, .. } =
            self.errands.get(job.task.0 as usize)?.wire;
        let numbers = [model_a, model_b, question, job.a.node, job.b.node].map(u64::from);
        let pose = rotation.as_flattened().iter().chain(&translation).map(|value| value.to_bits());
        Some(numbers.into_iter().chain(pose).fold(0, |hash, next| splitmix64(hash ^ next)))
    }
}
