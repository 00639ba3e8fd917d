//! The work on a request: contacts are searched for in all candidates, and surveyed in rounds.

use super::assessed_contact::{assessed, contact, settle};
use super::encounter::EncounterSearch;
use super::history::Surveyor;
use super::persons::People;
use super::plan_scene::ContactScene;
use super::stop::Stop;
use super::way::{Begin, NextContact, Scenery, Way};
use super::{Course, CourseEffort, CourseRequest, harm_of};
use crate::explain::contact_chain;
use crate::request::{Candidate, Request, RequestError};
use crate::request_limits::Until;
use crate::work::{SurveyBuffers, SurveyRun};
use crate::worker_pool::WorkerPoolReport;
use crate::workspace::{BodySet, RunError};
use bvh::support::support;
use damage::approach::STANDSTILL_M_S;
use damage::course::PASSED_M;
use damage::{CandidateHarm, CourseHarm, Criteria};
use geometry::DVec3;
use runtime::clock;

/// The candidates of a request while they are followed.
pub(super) struct Rounds<'r> {
    stage: &'r BodySet<'r>,
    request: &'r CourseRequest<'r>,
    pub(super) scenery: Scenery<'r>,
    pub(super) people: People,
    pub(super) courses: Vec<Course<'r>>,
    pub(super) search: EncounterSearch,
    pub(super) effort: CourseEffort,
    pub(super) reports: Vec<WorkerPoolReport>,
    stop: Stop<'r>,
    buffers: SurveyBuffers,
}

/// Contacts that come next in their candidates, worked on together.
pub(super) struct Round {
    /// The candidate and its contact, in the order of the candidates.
    pub(super) meetings: Vec<(usize, NextContact)>,
    /// The same as candidates of a request.
    contacts: Request,
}

/// The contacts that come first in the candidates of a request.
#[cfg(test)]
pub(crate) fn first_round(stage: &BodySet<'_>, request: &CourseRequest<'_>) -> Request {
    let mut rounds = Rounds::new(stage, request, Until::Complete);
    rounds.search(None).expect("they can be assessed").contacts
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
        let begin = |candidate| Course::new(Way::new(scenery, candidate));
        Self {
            stage,
            request,
            scenery,
            stop: Stop::new(until, &criteria.policy, people.stakes()),
            people,
            courses: scenario.candidates.iter().map(begin).collect(),
            search: EncounterSearch::default(),
            effort: CourseEffort::default(),
            reports: Vec::new(),
            buffers: SurveyBuffers::default(),
        }
    }

    /// Searches for the contact that comes next in every candidate, as far as that matters.
    pub(super) fn search(
        &mut self,
        is_due: Option<&dyn Fn() -> bool>,
    ) -> Result<Round, RequestError> {
        let begun_ns = clock::now_ns();
        let (mut meetings, mut contacts) = (Vec::new(), Vec::new());
        for k in 0..self.courses.len() {
            if !self.courses[k].is_open() {
                continue;
            }
            if let Some((meeting, contact)) = self.next(k, is_due)? {
                meetings.push((k, meeting));
                contacts.push(contact);
            } else if !self.courses[k].is_open() && self.is_decided(&[])? {
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

    /// The next contact of a candidate that has to be surveyed.
    fn next(
        &mut self,
        k: usize,
        is_due: Option<&dyn Fn() -> bool>,
    ) -> Result<Option<(NextContact, Candidate)>, RequestError> {
        let stage = self.stage;
        let support_of = |model: usize, direction: DVec3| match stage.extremes {
            Some(extremes) => extremes[model].support(&stage.bodies[model].1, direction),
            None => support(&stage.bodies[model].1, direction),
        };
        let course = &mut self.courses[k];
        if course.stuck.is_some() {
            return Ok(None);
        }
        while let Some(meeting) = course.way.next(&mut self.search, is_due) {
            let mut contact =
                contact(&self.scenery, &self.people, course, k, &meeting, &support_of)?;
            let approach = &contact.approach;
            let (closing_m_s, extent_m) = (approach.closing_m_s, approach.extent_up_to(PASSED_M));
            let parts =
                !contact.is_stuck && (closing_m_s < STANDSTILL_M_S || !approach.is_closing());
            match meeting.begin {
                Begin::AtStart if parts => course.way.let_part(&meeting, closing_m_s, extent_m),
                // It was assessed before, and stays as light as it was.
                Begin::Again if !contact.may_be_heavy(&self.request.criteria.parameters) => {
                    course.way.pass(&meeting, closing_m_s, extent_m);
                }
                Begin::AtStart | Begin::Again | Begin::Touched => {
                    let parties = [self.scenery.scenario.ego.0, meeting.party];
                    let outlines = parties.map(|party| &self.scenery.body(party).0.outlines);
                    contact.lay_plane(outlines, meeting.touching.point);
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
        if !self.stop.is_watched() {
            return Ok(false);
        }
        let harm = |(k, course): (usize, &Course<'_>)| {
            let next = found.iter().find(|(of, ..)| *of == k);
            harm_of(&self.people, course, next.map(|(_, meeting, harm)| (meeting, harm)))
        };
        let harms: Vec<CourseHarm> = self.courses.iter().enumerate().map(harm).collect();
        let is_open: Vec<bool> = self.courses.iter().map(Course::is_open).collect();
        self.stop.look(&harms, &is_open).map_err(RequestError::from)
    }

    /// Leaves open what cannot change what was asked for. Returns the contacts that still have to
    /// be surveyed.
    pub(super) fn spare(&mut self, round: Round) -> Result<Round, RequestError> {
        if !self.stop.is_watched() {
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
            if self.stop.may_spare(k) {
                self.settle(k, &work, number, meeting, harm);
            }
        }
        for (k, course) in self.courses.iter_mut().enumerate() {
            if course.is_open() && self.stop.may_spare(k) {
                course.is_spared = true;
                if course.stuck.is_none() {
                    course.way.give_up();
                }
            }
        }
        self.buffers = work.into_buffers();
        let is_left: Vec<bool> = meetings.iter().map(|(k, _)| !self.stop.may_spare(*k)).collect();
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
        if self.request.scene {
            assessed.scene = Some(Box::new(ContactScene::of(candidate, state)));
        }
        if self.request.explanation {
            let chain = contact_chain(contacts, candidate, &assessed.harm, state);
            assessed.chain = Some(Box::new(chain));
        }
        settle(&mut self.courses[k], candidate, assessed);
    }
}
