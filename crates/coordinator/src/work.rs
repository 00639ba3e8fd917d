//! The work of one request: tasks become jobs, results become evidence, evidence becomes an answer.

use crate::answer::Answer;
use crate::case::{Aim, Case};
use crate::gather::{Gathered, Part};
use crate::ledger::Ledger;
use crate::request::{Request, RequestError};
use bvh::{Counters, front, section};
use damage::{Basis, CandidateHarm, Encounter, Ranking, assess};
use dispatch::{Closed, Spec};
use model::{BodyView, Meta};
use protocol::{Question, Section, Task, TaskId};
use std::collections::VecDeque;

mod keep;

/// Work that workers can do: its tasks travel, and its results come as parts of messages.
pub trait Errands: for<'p> dispatch::Work<Part<'p> = PartOf<'p>> {
    /// The task as it travels; `None` if there is no such task.
    fn task(&self, task: TaskId) -> Option<&Task>;
    /// The body of this number.
    fn body(&self, model: u32) -> Option<BodyView<'_>>;
}

/// One question about one pose of one candidate.
#[derive(Clone, Debug)]
pub(crate) struct Errand {
    pub(crate) case: usize,
    pub(crate) aim: Aim,
    pub(crate) travel_m: f64,
    wire: Task,
    open: u32,
    is_moot: bool,
    is_unknown: bool,
    /// Made when its jobs are made, taken when the last one is closed.
    found: Option<Gathered>,
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

/// A request at work. Whoever runs the jobs drives it through [`dispatch::Work`].
#[derive(Debug)]
pub struct Work<'w> {
    request: &'w Request,
    bodies: &'w [(Meta, BodyView<'w>)],
    depth: u32,
    cases: Vec<Case>,
    errands: Vec<Errand>,
    waiting: VecDeque<u32>,
    pairs: Vec<bvh::NodePair>,
    aims: Vec<(Aim, f64, Question)>,
    effort: Effort,
    ledger: Option<Ledger>,
}

impl<'w> Work<'w> {
    /// Nothing done yet. `bodies` are those of the scenario's parties, in their order.
    #[must_use]
    pub fn new(request: &'w Request, bodies: &'w [(Meta, BodyView<'w>)], depth: u32) -> Self {
        let cases = request.candidates.iter().map(Case::new).collect();
        let mut work = Self {
            request,
            bodies,
            depth,
            cases,
            errands: Vec::new(),
            waiting: VecDeque::new(),
            pairs: Vec::new(),
            aims: Vec::new(),
            effort: Effort::default(),
            ledger: None,
        };
        for case in 0..work.cases.len() {
            work.advance(case);
        }
        work
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

    /// The answer that follows from what is known by now.
    ///
    /// # Errors
    ///
    /// If a candidate cannot be assessed or ranked at all: then the request is refused.
    pub fn answer(&self) -> Result<Answer, RequestError> {
        let (harms, ranking) = self.judge()?;
        Ok(Answer::new(self.request, &ranking, &harms, &self.cases, self.bodies))
    }

    /// Harm of every candidate, and their order.
    fn judge(&self) -> Result<(Vec<CandidateHarm>, Ranking), RequestError> {
        let request = self.request;
        let basis = Basis {
            curves: &request.curves,
            level: request.policy.outcome,
            parameters: &request.parameters,
        };
        let mut harms = Vec::new();
        for (candidate, case) in request.candidates.iter().zip(&self.cases) {
            let encounter = Encounter {
                approach: &candidate.approach,
                meeting: &candidate.meeting,
                a: &candidate.a,
                b: &candidate.b,
                probability: candidate.probability,
            };
            let harm = assess(&encounter, &case.evidence(), &basis)
                .map_err(|source| RequestError::Assess { name: candidate.name.clone(), source })?;
            harms.push(harm);
        }
        let stakes: Vec<_> = request.persons.iter().map(|person| person.stake).collect();
        let ranking = damage::rank(&request.policy, &stakes, &harms)?;
        Ok((harms, ranking))
    }

    /// Asks for whatever a candidate needs next.
    fn advance(&mut self, case: usize) {
        let candidate = &self.request.candidates[case];
        self.cases[case].advance(candidate, &mut self.aims);
        for (aim, travel_m, question) in std::mem::take(&mut self.aims) {
            let u = candidate.approach.directions.d[0];
            let z = candidate.approach.directions.d[damage::approach::UP];
            let pose = candidate.pose.moved(-u * travel_m);
            let task = self.errands.len() as u32;
            let wire = Task {
                model_a: candidate.model_a,
                model_b: candidate.model_b,
                question: question as u32,
                task,
                rotation: pose.rotation,
                translation: pose.translation,
                u: u.to_array(),
                z: z.to_array(),
            };
            self.errands.push(Errand {
                case,
                aim,
                travel_m,
                wire,
                open: 0,
                is_moot: false,
                is_unknown: false,
                found: None,
            });
            self.effort.tasks += 1;
            self.waiting.push_back(task);
        }
    }

    fn views(&self, task: &Task) -> (&'w BodyView<'w>, &'w BodyView<'w>) {
        (&self.bodies[task.model_a as usize].1, &self.bodies[task.model_b as usize].1)
    }

    /// Descends for one task; its jobs are put into `jobs`, which may be none.
    fn descend(&mut self, number: u32, jobs: &mut Vec<Spec>) {
        let wire = self.errands[number as usize].wire;
        let (a, b) = self.views(&wire);
        let pose =
            geometry::RelativePose { rotation: wire.rotation, translation: wire.translation };
        self.pairs.clear();
        front(a, b, &pose, self.depth, &mut self.pairs, &mut self.effort.descent);
        let errand = &mut self.errands[number as usize];
        errand.found = Some(Gathered::with_room(a.corners.len(), b.corners.len()));
        errand.open = self.pairs.len() as u32;
        let section = |model, node| Section { model, node };
        jobs.extend(self.pairs.iter().map(|pair| Spec {
            task: TaskId(number),
            a: section(wire.model_a, pair.a),
            b: section(wire.model_b, pair.b),
        }));
        if self.pairs.is_empty() {
            self.finish(number);
        }
    }

    /// All jobs of a task are closed: draws the conclusion, and asks for what follows.
    fn finish(&mut self, number: u32) {
        let errand = &mut self.errands[number as usize];
        let Some(found) = errand.found.take() else { return };
        let (case, aim) = (errand.case, errand.aim);
        let is_unknown = errand.is_unknown && !errand.is_moot;
        let wire = errand.wire;
        match aim {
            Aim::Probe { .. } if errand.is_moot => {}
            Aim::Probe { .. } | Aim::Survey { .. } if is_unknown => {
                // Nothing more is asked for this candidate: it stays as wide as it is.
                self.cases[case].is_unknown = true;
            }
            Aim::Probe { travel_m } => self.learn(case, travel_m, false),
            Aim::Survey { stop } => {
                let views = self.views(&wire);
                self.cases[case].surveyed(stop, &found, views);
                if self.cases[case].is_done() {
                    self.note();
                }
            }
        }
    }

    fn learn(&mut self, case: usize, travel_m: f64, touches: bool) {
        self.cases[case].learn(travel_m, touches);
        self.advance(case);
        for errand in self.errands.iter_mut().filter(|errand| errand.case == case) {
            errand.is_moot = errand.is_moot || !self.cases[case].needs(errand.aim);
        }
    }
}

impl Errands for Work<'_> {
    fn task(&self, task: TaskId) -> Option<&Task> {
        self.errands.get(task.0 as usize).map(|errand| &errand.wire)
    }

    fn body(&self, model: u32) -> Option<BodyView<'_>> {
        self.bodies.get(model as usize).map(|(_, body)| *body)
    }
}

impl dispatch::Work for Work<'_> {
    type Part<'p> = PartOf<'p>;

    fn more(&mut self, jobs: &mut Vec<Spec>) {
        while jobs.is_empty() {
            let Some(number) = self.waiting.pop_front() else { return };
            if !self.errands[number as usize].is_moot {
                self.descend(number, jobs);
            }
        }
    }

    fn is_moot(&self, task: TaskId) -> bool {
        self.errands[task.0 as usize].is_moot
    }

    fn fold(&mut self, job: &Spec, part: PartOf<'_>) {
        let Some(errand) = self.errands.get_mut(job.task.0 as usize) else { return };
        let Some(found) = &mut errand.found else { return };
        let sound = found.fold(part.0, &mut self.effort.jobs);
        let is_whole = part.is_whole();
        let touched = found.touched;
        errand.is_unknown |= !sound || !is_whole;
        if let Aim::Probe { travel_m } = errand.aim
            && touched
            && !errand.is_moot
        {
            // One hit answers it: the rest of the task is moot.
            let case = errand.case;
            errand.is_moot = true;
            self.learn(case, travel_m, true);
        }
    }

    fn close(&mut self, job: &Spec, how: Closed) {
        let Some(errand) = self.errands.get_mut(job.task.0 as usize) else { return };
        errand.is_unknown |= how == Closed::Abandoned;
        errand.open -= 1;
        let is_last = errand.open == 0;
        if let Some(ledger) = &mut self.ledger {
            ledger.close(errand, job, how);
        }
        if is_last {
            self.finish(job.task.0);
        }
    }

    fn weight(&self, section: Section) -> u64 {
        let body = self.bodies.get(section.model as usize);
        body.map_or(0, |(_, body)| section::bytes(body.nodes, section.node))
    }
}

/// One part of a result, taken apart.
#[derive(Clone, Copy, Debug)]
pub struct PartOf<'p>(pub(crate) Part<'p>);

impl PartOf<'_> {
    /// Whether its job did all that was asked for, as far as this part says.
    pub(crate) fn is_whole(&self) -> bool {
        let complete = protocol::result::End::Complete as u32;
        self.0.last.is_none_or(|last| last.summary.end == complete)
    }
}
