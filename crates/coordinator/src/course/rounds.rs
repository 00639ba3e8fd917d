//! The work on a request: contacts are searched for in all candidates and members, and surveyed in
//! rounds.

use super::assessed_contact::{assessed, contact, settle};
use super::history::{SearchClock, Surveyor};
use super::member::Members;
use super::persons::People;
use super::plan_scene::ContactScene;
use super::stop::{MayBeClose, Stop};
use super::way::{Begin, NextContact, Scenery};
use super::{Course, CourseEffort, CourseRequest, harm_of};
use crate::explain::contact_chain;
use crate::looks::AskedLook;
use crate::request::{Candidate, Request, RequestError};
use crate::request_limits::Until;
use crate::work::{SurveyBuffers, SurveyRun};
use crate::worker_pool::WorkerPoolReport;
use crate::workspace::{BodySet, RunError};
use body::Outlines;
use bvh::support::{Extremes, support_near};
use damage::approach::STANDSTILL_M_S;
use damage::course::{PASSED_M, Severity};
use damage::{Basis, CandidateHarm, CourseHarm, Criteria, Evidence, assess, expected};
use executor::encounter::{Encounters, LookOutcome};
use geometry::DVec3;
use runtime::clock;
use serde::Serialize;
use std::ops::Range;
use std::rc::Rc;

/// What the search for contacts has taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct EncounterEffort {
    /// Encounters: a candidate's way and a party, each time that it was looked at.
    pub encounters: u64,
    /// Those whose bodies came so near that their trees were looked at.
    pub in_trees: u64,
    /// Those that workers looked at.
    pub jobs: u64,
    /// Tests of boxes there.
    pub nb: u64,
    /// Tests of triangles there.
    pub np: u64,
}

/// The candidates of a request while they are followed.
pub(super) struct Rounds<'r> {
    stage: &'r BodySet<'r>,
    request: &'r CourseRequest<'r>,
    pub(super) scenery: Scenery<'r>,
    pub(super) people: People,
    /// All candidates in the scene as stated, then in each member.
    pub(super) courses: Vec<Course<'r>>,
    pub(super) members: Members<'r>,
    pub(super) encounters: Encounters,
    pub(super) effort: CourseEffort,
    pub(super) reports: Vec<WorkerPoolReport>,
    stop: Stop<'r>,
    /// Whether what is followed now is a part of what was asked for, all of which is wanted.
    pub(super) is_part: bool,
    /// The extremes of each body, as far as they were asked for: for members, of whom each asks
    /// much the same.
    extremes: Vec<Extremes>,
    buffers: SurveyBuffers,
}

/// Contacts that come next in their candidates, worked on together.
pub(super) struct Round {
    /// The number of the course and its contact, in the order of the courses.
    pub(super) meetings: Vec<(usize, NextContact)>,
    /// The same as candidates of a request.
    contacts: Request,
}

impl Round {
    /// The contacts in parts of at most so many, in their order.
    pub(super) fn parts(self, most: usize) -> impl Iterator<Item = Self> {
        let Self { mut meetings, contacts } = self;
        let Request { mut candidates, persons, criteria } = contacts;
        core::iter::from_fn(move || {
            let count = meetings.len().min(most);
            (count > 0).then(|| {
                let contacts = Request {
                    candidates: candidates.drain(..count).collect(),
                    persons: persons.clone(),
                    criteria: criteria.clone(),
                };
                Self { meetings: meetings.drain(..count).collect(), contacts }
            })
        })
    }
}

/// The contacts that come first in the candidates of a request.
#[cfg(test)]
pub(crate) fn first_round(stage: &BodySet<'_>, request: &CourseRequest<'_>) -> Request {
    let mut rounds = Rounds::new(stage, request, Until::Complete);
    let mut surveyor = Surveyor::replay(&[], &[]);
    let time = SearchClock::until(None);
    rounds.search(&mut surveyor, &time).expect("they can be assessed").contacts
}

/// The expected harm of every candidate; `harms[m][k]` is that of candidate k in member m.
pub(super) fn means(harms: &[Vec<CourseHarm>]) -> Vec<CourseHarm> {
    let candidates = harms.first().map_or(0, Vec::len);
    let mean = |k: usize| expected::mean(harms.iter().map(move |member| &member[k]));
    (0..candidates).map(mean).collect()
}

/// Whether a contact is light for the ego, which its plane alone decides.
fn stays_light<'o>(
    contact: &Candidate,
    criteria: &Criteria,
    outlines: &impl Fn(u32) -> &'o Outlines,
) -> Result<bool, RequestError> {
    let Criteria { curves, policy, parameters } = criteria;
    if contact.is_stuck {
        return Ok(false);
    }
    if !contact.may_be_heavy(parameters) {
        return Ok(true);
    }
    contact.lay_plane([contact.model_a, contact.model_b].map(outlines));
    let basis = Basis { curves, level: policy.outcome, parameters };
    let harm = assess(&contact.encounter(), &Evidence::none(), &basis)
        .map_err(|source| RequestError::Assess { name: contact.name.to_string(), source })?;
    Ok(harm.is_settled() && Severity::of(&harm).0 == Severity::Light)
}

impl<'r> Rounds<'r> {
    pub(super) fn new(
        stage: &'r BodySet<'r>,
        request: &'r CourseRequest<'r>,
        until: Until,
    ) -> Self {
        let CourseRequest { scenario, models, shells, criteria, .. } = request;
        let scenery = Scenery { scenario, bodies: stage.bodies, models, shells };
        let people = People::of(scenario, &|party| scenery.body(party));
        let members = Members::nominal(scenery);
        let nominal = &members.list[0];
        let begin = |candidate| Course::new(scenery, Rc::clone(nominal), candidate);
        let courses = (0..scenario.candidates.len()).map(begin).collect();
        Self {
            stage,
            request,
            scenery,
            stop: Stop::new(until, &criteria.policy, people.stakes()),
            is_part: false,
            people,
            courses,
            members,
            encounters: Encounters::default(),
            effort: CourseEffort::default(),
            reports: Vec::new(),
            extremes: Vec::new(),
            buffers: SurveyBuffers::default(),
        }
    }

    /// Draws members until there are so many; the candidates begin in the new ones.
    pub(super) fn draw(&mut self, count: u32) -> Result<(), RequestError> {
        if self.extremes.is_empty() && self.stage.extremes.is_none() {
            let bodies = self.stage.bodies.iter();
            self.extremes = bodies.map(|(_, view)| Extremes::new(view)).collect();
        }
        let known = self.members.list.len();
        self.members.draw(count as usize, &mut self.encounters)?;
        let candidates = self.scenery.scenario.candidates.len();
        for member in &self.members.list[known..] {
            let begin = |k| Course::new(self.scenery, Rc::clone(member), k);
            self.courses.extend((0..candidates).map(begin));
        }
        Ok(())
    }

    /// How many members there are; 0: the candidates are followed in the scene as stated alone.
    fn drawn(&self) -> usize {
        self.members.list.len() - 1
    }

    /// Whether work may end before all of it is done.
    fn is_watched(&self) -> bool {
        self.stop.is_watched() && !self.is_part
    }

    /// Searches for the contact that comes next in every course, as far as that matters, and as far
    /// as there is time.
    pub(super) fn search(
        &mut self,
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<Round, RunError> {
        let begun_ns = clock::now_ns();
        let (mut meetings, mut contacts) = (Vec::new(), Vec::new());
        let mut from = 0;
        while from < self.courses.len() {
            let block = from..(from + self.block()).min(self.courses.len());
            from = block.end;
            let is_open = |k: &usize| self.courses[*k].is_open();
            let mut open: Vec<(usize, Option<_>)> =
                block.clone().filter(is_open).map(|k| (k, None)).collect();
            if open.is_empty() {
                continue;
            }
            // Each look is at a later time than the last one at that party.
            loop {
                self.look(&block, surveyor, time)?;
                for (k, found) in open.iter_mut().filter(|(_, found)| found.is_none()) {
                    *found = self.next(*k, time)?;
                }
                if !self.courses[block.clone()].iter().any(Course::needs_looks) {
                    break;
                }
            }
            let mut is_one_over = false;
            for (k, found) in open {
                match found {
                    Some((meeting, contact)) => {
                        meetings.push((k, meeting));
                        contacts.push(contact);
                    }
                    None => is_one_over |= !self.courses[k].is_open(),
                }
            }
            if is_one_over && self.is_decided(&[])? {
                break;
            }
        }
        self.effort.search_ns += clock::now_ns() - begun_ns;
        // Its candidates are fewer, so their numbers are others.
        let policy = self
            .request
            .criteria
            .policy
            .among(contacts.iter().map(|contact| contact.name.as_str()));
        let criteria = Criteria { policy, ..self.request.criteria.clone() };
        let contacts =
            Request { candidates: contacts, persons: self.people.list.clone(), criteria };
        Ok(Round { meetings, contacts })
    }

    /// How many courses are searched together. Where work may end early, after each candidate there
    /// may be nothing left to do; of members only after all candidates together.
    fn block(&self) -> usize {
        match (self.is_watched(), self.drawn()) {
            (false, _) => self.courses.len(),
            (true, 0) => 1,
            (true, _) => self.scenery.scenario.candidates.len(),
        }
    }

    /// Looks at whomever these courses may meet next.
    fn look(
        &mut self,
        block: &Range<usize>,
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<(), RunError> {
        let is_past = || time.is_past();
        let is_due = time.is_watched().then_some(&is_past as &dyn Fn() -> bool);
        let (scenery, encounters) = (self.scenery, &mut self.encounters);
        let courses = &mut self.courses[block.clone()];
        for course in courses.iter_mut().filter(|course| course.needs_looks()) {
            course.way.prepare(encounters);
        }
        let (mut asked, mut far) = (Vec::new(), Vec::new());
        let (mut of_asked, search) = (Vec::new(), &mut self.effort.search);
        for (k, course) in courses.iter().enumerate().filter(|(_, course)| course.needs_looks()) {
            for (party, look) in course.way.looks() {
                search.encounters += 1;
                if !look.may_touch && look.ways.are_far(&(look.from_s..look.end_s)) {
                    far.push((k, party));
                    continue;
                }
                search.in_trees += 1;
                of_asked.push((k, party));
                asked.push(AskedLook { models: scenery.numbers(party), look });
            }
        }
        if !asked.is_empty() {
            let looked = surveyor.look(&asked, self.stage, encounters, is_due)?;
            drop(asked);
            search.nb += looked.counters.nb;
            search.np += looked.counters.np;
            if looked.by_workers {
                search.jobs += looked.seen.len() as u64;
                self.reports.extend(surveyor.report());
            }
            for ((k, party), seen) in of_asked.into_iter().zip(looked.seen) {
                courses[k].way.learn(party, seen, encounters);
            }
        }
        for (k, party) in far {
            courses[k].way.learn(party, Some(LookOutcome::Never), encounters);
        }
        Ok(())
    }

    /// The next contact of a course that has to be surveyed; `None`, too, if that needs a look, or
    /// there is no time.
    fn next(
        &mut self,
        k: usize,
        time: &SearchClock,
    ) -> Result<Option<(NextContact, Candidate)>, RequestError> {
        let (stage, extremes) = (self.stage, &self.extremes[..]);
        let support_of = |model: usize, direction: DVec3, near: &mut Option<[f32; 3]>| {
            let view = &stage.bodies[model].1;
            match stage.extremes.unwrap_or(extremes).get(model) {
                Some(extremes) => extremes.support(view, direction),
                None => support_near(view, direction, near),
            }
        };
        let outlines = |model: u32| &stage.bodies[model as usize].0.outlines;
        let is_member = k >= self.scenery.scenario.candidates.len();
        let course = &mut self.courses[k];
        if course.stuck.is_some() {
            return Ok(None);
        }
        while let Some(meeting) = course.way.next() {
            // How it comes about, and its plane, take a millisecond where bodies are large.
            if time.has_limit() && time.is_over() {
                course.way.give_up();
                return Ok(None);
            }
            let contact = {
                let (scenery, people) = (&self.scenery, &self.people);
                contact(scenery, people, course, &meeting, &support_of, is_member)?
            };
            let approach = &contact.approach;
            let (closing_m_s, extent_m) = (approach.closing_m_s, approach.extent_up_to(PASSED_M));
            let parts =
                !contact.is_stuck && (closing_m_s < STANDSTILL_M_S || !approach.is_closing());
            match meeting.begin {
                Begin::AtStart if parts => course.way.let_part(&meeting, closing_m_s, extent_m),
                // It was assessed before, and stays as light as it was: no survey changes that.
                Begin::Again if stays_light(&contact, &self.request.criteria, &outlines)? => {
                    course.way.pass(&meeting, closing_m_s, extent_m);
                }
                Begin::AtStart | Begin::Again | Begin::Touched => {
                    if time.has_limit() {
                        // After the deadline nothing may be left to do but to assess what was
                        // found.
                        contact.lay_plane([contact.model_a, contact.model_b].map(outlines));
                    }
                    return Ok(Some((meeting, contact)));
                }
            }
        }
        Ok(None)
    }

    /// Whether no open work can change what was asked for. `found` are contacts that are not
    /// surveyed, and what is known of them.
    fn is_decided(
        &mut self,
        found: &[(usize, NextContact, CandidateHarm)],
    ) -> Result<bool, RequestError> {
        if !self.is_watched() {
            return Ok(false);
        }
        let harms = self.harms(found);
        let candidates = self.scenery.scenario.candidates.len();
        let mut is_open = vec![false; candidates];
        for course in &self.courses {
            is_open[course.candidate] |= course.is_open();
        }
        if self.drawn() == 0 {
            return Ok(self.stop.look(&harms[0], &is_open, None)?);
        }
        let (policy, stakes) = (&self.request.criteria.policy, self.people.stakes());
        let may_be_close = |first| expected::may_be_close(policy, &stakes, &harms[1..], first);
        let is_last = self.drawn() as u32 >= self.request.members.most;
        let may_be_close: Option<MayBeClose<'_>> = if is_last { None } else { Some(&may_be_close) };
        Ok(self.stop.look(&means(&harms[1..]), &is_open, may_be_close)?)
    }

    /// The harm of every candidate in every member, the scene as stated first, as far as it is
    /// known. `found` as in [`Rounds::is_decided`].
    pub(super) fn harms(
        &mut self,
        found: &[(usize, NextContact, CandidateHarm)],
    ) -> Vec<Vec<CourseHarm>> {
        let mut found = found.iter().peekable();
        let mut harms = Vec::with_capacity(self.courses.len());
        for (number, course) in self.courses.iter_mut().enumerate() {
            let next = found.next_if(|(of, ..)| *of == number);
            if course.is_open() {
                let next = next.map(|(_, meeting, harm)| (meeting, harm));
                harms.push(harm_of(&self.people, course, next));
                continue;
            }
            let known = course.harm.take().unwrap_or_else(|| harm_of(&self.people, course, None));
            harms.push(known.clone());
            course.harm = Some(known);
        }
        let candidates = self.scenery.scenario.candidates.len();
        harms.chunks(candidates).map(<[CourseHarm]>::to_vec).collect()
    }

    /// Leaves open what cannot change what was asked for. Returns the contacts that still have to
    /// be surveyed.
    pub(super) fn spare(&mut self, round: Round) -> Result<Round, RequestError> {
        if !self.is_watched() {
            return Ok(round);
        }
        let Round { mut meetings, mut contacts } = round;
        let buffers = core::mem::take(&mut self.buffers);
        let work = SurveyRun::with_buffers(&contacts, self.stage.bodies, self.stage.depth, buffers);
        let harms = work.harms()?;
        let found: Vec<_> =
            meetings.iter().zip(harms).map(|((k, meeting), harm)| (*k, *meeting, harm)).collect();
        self.is_decided(&found)?;
        for (number, (k, meeting, harm)) in found.into_iter().enumerate() {
            if self.stop.may_spare(self.courses[k].candidate) {
                self.settle(k, &work, number, meeting, harm);
            }
        }
        for course in &mut self.courses {
            if course.is_open() && self.stop.may_spare(course.candidate) {
                course.is_spared = true;
                if course.stuck.is_none() {
                    course.way.give_up();
                }
            }
        }
        self.buffers = work.into_buffers();
        let may_spare = |k: usize| self.stop.may_spare(self.courses[k].candidate);
        let is_left: Vec<bool> = meetings.iter().map(|(k, _)| !may_spare(*k)).collect();
        let mut left = is_left.iter();
        meetings.retain(|_| left.next().copied().unwrap_or(true));
        let mut left = is_left.iter();
        contacts.candidates.retain(|_| left.next().copied().unwrap_or(true));
        Ok(Round { meetings, contacts })
    }

    /// Surveys the hit sets of a round, as far as there is time, and lets its candidates go on.
    pub(super) fn survey(
        &mut self,
        round: &Round,
        surveyor: &mut Surveyor<'_>,
    ) -> Result<(), RunError> {
        let Round { meetings, contacts } = round;
        let begun_ns = clock::now_ns();
        let buffers = core::mem::take(&mut self.buffers);
        let work = SurveyRun::with_buffers(contacts, self.stage.bodies, self.stage.depth, buffers);
        let mut work = surveyor.limit(work);
        let effort = &mut self.effort;
        effort.jobs_in_process += surveyor.survey(&mut work, self.stage)?;
        self.reports.extend(surveyor.report());
        effort.surveys_ns += clock::now_ns() - begun_ns;
        effort.rounds += 1;
        effort.surveys.add(&work.effort());
        let harms = work.harms()?;
        for (number, ((k, meeting), harm)) in meetings.iter().zip(harms).enumerate() {
            self.settle(*k, &work, number, *meeting, harm);
        }
        self.buffers = work.into_buffers();
        Ok(())
    }

    /// Lets a candidate go on after its contact, number `number` of the work, or end there.
    fn settle(
        &mut self,
        k: usize,
        work: &SurveyRun<'_>,
        number: usize,
        meeting: NextContact,
        harm: CandidateHarm,
    ) {
        let contacts = work.request();
        let candidate = &contacts.candidates[number];
        let mut assessed = assessed(contacts, work, number, meeting, harm);
        let state = &work.candidate_states()[number];
        // Pictures and chains are of the scene as stated, worlds of members.
        let is_stated = k < self.scenery.scenario.candidates.len();
        if !is_stated {
            assessed.candidate = Some(Box::new(candidate.clone()));
        }
        if self.request.scene && is_stated {
            assessed.scene = Some(Box::new(ContactScene::of(candidate, state)));
        }
        if self.request.explanation && is_stated {
            let chain = contact_chain(contacts, candidate, &assessed.harm, state);
            assessed.chain = Some(Box::new(chain));
        }
        settle(&mut self.courses[k], candidate, assessed);
    }
}
