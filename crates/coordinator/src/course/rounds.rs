//! The work on a request: contacts are searched for in all candidates and members, and surveyed in
//! rounds.

use super::assessed_contact::{AssessedContact, assessed, settle};
use super::contact_facts::ContactFacts;
use super::history::{SearchClock, Surveyor};
use super::judged::Judged;
use super::member::Members;
use super::persons::People;
use super::plan_scene::ContactScene;
use super::selection::CourseOrder;
use super::stages::{CourseOutline, Stage};
use super::stop::{MayBeClose, Stop};
use super::way::{NextContact, Scenery};
use super::{Course, CourseEffort, CourseRequest, PART_MAX, harm_of, names_of};
use crate::explain::contact_chain;
use crate::idle_cores::IdleCores;
use crate::request::{Request, RequestError};
use crate::request_limits::Until;
use crate::work::{SurveyBuffers, SurveyRun};
use crate::worker_pool::WorkerPoolReport;
use crate::workspace::{BodySet, RunError};
use bvh::support::Extremes;
use damage::{CandidateHarm, CourseHarm, RankedCandidates, expected};
use executor::encounter::Encounters;
use runtime::clock;
use scenario::Name;
use serde::Serialize;
use std::sync::Arc;

/// Contacts of a round below which others do not help to assess them: threads take as long to
/// start.
const SHARED_MIN: usize = 16;

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
    pub(super) stage: &'r BodySet<'r>,
    pub(super) request: &'r CourseRequest<'r>,
    pub(super) scenery: Scenery<'r>,
    pub(super) people: People,
    /// All candidates in the scene as stated, then in each member.
    pub(super) courses: Vec<Course<'r>>,
    pub(super) members: Members<'r>,
    pub(super) encounters: Encounters,
    pub(super) effort: CourseEffort,
    pub(super) reports: Vec<WorkerPoolReport>,
    stop: Stop<'r>,
    /// In which order courses of members are followed until the winner is certain.
    pub(super) order: CourseOrder,
    /// Whether contacts keep what other criteria assess.
    pub(super) keeps_facts: bool,
    /// Whether what is followed now is a part of what was asked for: what does not matter in it may
    /// do so in the next one.
    pub(super) is_part: bool,
    /// The extremes of each body, as far as they were asked for: for members, of whom each asks
    /// much the same.
    pub(super) extremes: Vec<Extremes>,
    buffers: SurveyBuffers,
}

/// What is known of all candidates so far.
pub(super) struct Standing {
    /// The harm of every candidate in the scene as stated, then in each member.
    pub(super) harms: Vec<Vec<CourseHarm>>,
    /// Per candidate: what ranks, the mean of members if there are any.
    pub(super) means: Vec<CourseHarm>,
    /// Per candidate: whether anything is open.
    pub(super) is_open: Vec<bool>,
}

/// Contacts that come next in their candidates, worked on together.
pub(super) struct Round {
    /// The number of the course and its contact, in the order of the courses.
    pub(super) meetings: Vec<(usize, NextContact)>,
    /// The same as candidates of a request.
    pub(super) contacts: Request,
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
    let all: Vec<usize> = (0..rounds.courses.len()).collect();
    rounds.search(&all, &mut surveyor, &time).expect("they can be assessed").contacts
}

/// The expected harm of every candidate; `harms[m][k]` is that of candidate k in member m.
pub(super) fn means(harms: &[Vec<CourseHarm>]) -> Vec<CourseHarm> {
    let candidates = harms.first().map_or(0, Vec::len);
    let mean = |k: usize| expected::mean(harms.iter().map(move |member| &member[k]));
    (0..candidates).map(mean).collect()
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
        let begin = |candidate| Course::new(scenery, Arc::clone(nominal), candidate);
        let courses = (0..scenario.candidates.len()).map(begin).collect();
        Self {
            stage,
            request,
            scenery,
            stop: Stop::new(until, &criteria.policy, people.stakes()),
            order: CourseOrder::default(),
            keeps_facts: false,
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
            let begin = |k| Course::new(self.scenery, Arc::clone(member), k);
            self.courses.extend((0..candidates).map(begin));
        }
        Ok(())
    }

    /// How many members there are; 0: the candidates are followed in the scene as stated alone.
    pub(super) fn drawn(&self) -> usize {
        self.members.list.len() - 1
    }

    /// Follows these courses, in ascending order, until no contact is left, as far as that matters,
    /// and as far as there is time.
    pub(super) fn follow_chosen(
        &mut self,
        chosen: &[usize],
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<(), RunError> {
        loop {
            let round = self.search(chosen, surveyor, time)?;
            let begun_ns = clock::now_ns();
            let round = self.spare(round)?;
            self.effort.assess_ns += clock::now_ns() - begun_ns;
            if round.meetings.is_empty() {
                return Ok(());
            }
            for part in round.parts(PART_MAX) {
                self.survey(&part, surveyor)?;
            }
        }
    }

    /// Whether work may end before all of it is done.
    pub(super) fn is_watched(&self) -> bool {
        self.stop.is_watched() && (!self.is_part || self.stop.is_for_winner())
    }

    /// Whether members are followed only as far as they tell who wins.
    pub(super) fn is_for_winner(&self) -> bool {
        self.stop.is_for_winner() && self.drawn() > 0
    }

    /// Whether more members are drawn if the best two are too close to call.
    pub(super) fn may_draw_more(&self) -> bool {
        !self.is_part && 0 < self.drawn() && (self.drawn() as u32) < self.request.members.most
    }

    /// Whether anything is open of a candidate in the members.
    pub(super) fn is_open_in_members(&self, candidate: usize) -> bool {
        let candidates = self.scenery.scenario.candidates.len();
        let mut own = self.courses.iter().skip(candidates + candidate).step_by(candidates);
        own.any(Course::is_open)
    }

    /// The order by the last look at what is known.
    pub(super) fn ranking(&self) -> &RankedCandidates {
        self.stop.ranking()
    }

    /// What is known of all candidates. `found` are contacts that are not surveyed, and what is
    /// known of them.
    pub(super) fn standing(&mut self, found: &[(usize, NextContact, CandidateHarm)]) -> Standing {
        let harms = self.harms(found);
        let candidates = self.scenery.scenario.candidates.len();
        let mut is_open = vec![false; candidates];
        for course in &self.courses {
            is_open[course.candidate] |= course.is_open();
        }
        let means = if self.drawn() == 0 { harms[0].clone() } else { means(&harms[1..]) };
        Standing { harms, means, is_open }
    }

    /// Whether no open work can change what was asked for.
    pub(super) fn is_settled(&mut self, standing: &Standing) -> Result<bool, RequestError> {
        if !self.is_watched() {
            return Ok(false);
        }
        let Standing { harms, means, is_open } = standing;
        let (policy, stakes) = (&self.request.criteria.policy, self.people.stakes());
        let may_be_close = |first| {
            let close = expected::may_be_close(policy, &stakes, &harms[1..], first)?;
            Ok(close.contains(&true))
        };
        let may_be_close: Option<MayBeClose<'_>> =
            if self.may_draw_more() { Some(&may_be_close) } else { None };
        Ok(self.stop.look(means, is_open, may_be_close)?)
    }

    /// The harm of every candidate in every member, the scene as stated first, as far as it is
    /// known. `found` as in [`Rounds::standing`].
    fn harms(&mut self, found: &[(usize, NextContact, CandidateHarm)]) -> Vec<Vec<CourseHarm>> {
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

    /// What is known by so many members; 0: by the scene as stated alone.
    pub(super) fn judged(&mut self, count: u32) -> Result<Judged, RequestError> {
        let mut harms = self.harms(&[]);
        let (stakes, request) = (self.people.stakes(), self.request);
        let policy = &request.criteria.policy;
        if count == 0 {
            return Judged::of(policy, &stakes, harms.swap_remove(0));
        }
        let parties: Vec<Name> = names_of(request.scenario);
        let courses: Vec<CourseOutline> = self.courses.iter().map(CourseOutline::of).collect();
        let (members, replaced) = (request.members, self.members.replaced);
        let (stakes, parties) = (&stakes[..], &parties[..]);
        let (harms, courses) = (&harms[..], &courses[..]);
        let stage = Stage { policy, stakes, parties, members, count, replaced, harms, courses };
        stage.judged()
    }

    /// Leaves open what cannot change what was asked for. Returns the contacts that still have to
    /// be surveyed.
    pub(super) fn spare(&mut self, round: Round) -> Result<Round, RequestError> {
        if !self.is_watched() || self.is_part {
            return Ok(round);
        }
        let Round { mut meetings, mut contacts } = round;
        let buffers = core::mem::take(&mut self.buffers);
        let work = SurveyRun::with_buffers(&contacts, self.stage.bodies, self.stage.depth, buffers);
        let harms = work.harms()?;
        let found: Vec<_> =
            meetings.iter().zip(harms).map(|((k, meeting), harm)| (*k, *meeting, harm)).collect();
        let standing = self.standing(&found);
        self.is_settled(&standing)?;
        for (number, (k, meeting, harm)) in found.into_iter().enumerate() {
            if self.stop.may_spare(self.courses[k].candidate) {
                let assessed = self.keeping().contact((k, meeting), (&work, number), harm);
                settle(&mut self.courses[k], &work.request().candidates[number], assessed);
            }
        }
        self.spare_open();
        self.buffers = work.into_buffers();
        let may_spare = |k: usize| self.stop.may_spare(self.courses[k].candidate);
        let is_left: Vec<bool> = meetings.iter().map(|(k, _)| !may_spare(*k)).collect();
        let mut left = is_left.iter();
        meetings.retain(|_| left.next().copied().unwrap_or(true));
        let mut left = is_left.iter();
        contacts.candidates.retain(|_| left.next().copied().unwrap_or(true));
        Ok(Round { meetings, contacts })
    }

    /// Gives up what is open and, by the last look, cannot change what was asked for: nothing in a
    /// part of it.
    pub(super) fn spare_open(&mut self) {
        if self.is_part {
            return;
        }
        for course in &mut self.courses {
            if course.is_open() && self.stop.may_spare(course.candidate) {
                course.is_spared = true;
                if course.stuck.is_none() {
                    course.way.give_up();
                }
            }
        }
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
        let surveyed_ns = clock::now_ns();
        effort.surveys_ns += surveyed_ns - begun_ns;
        effort.rounds += 1;
        effort.surveys.add(&work.effort());
        let cores = surveyor.idle_cores();
        let cores = if meetings.len() >= SHARED_MIN { cores } else { IdleCores::default() };
        let (keeping, known) = (self.keeping(), &work);
        let assessed = cores.map(&mut (), meetings.len(), |(), number| {
            let (k, meeting) = meetings[number];
            let harm = known.harm(number)?;
            Ok::<_, RequestError>(keeping.contact((k, meeting), (known, number), harm))
        });
        for (number, ((k, _), assessed)) in meetings.iter().zip(assessed).enumerate() {
            settle(&mut self.courses[*k], &contacts.candidates[number], assessed?);
        }
        self.buffers = work.into_buffers();
        self.effort.assess_ns += clock::now_ns() - surveyed_ns;
        Ok(())
    }

    /// What is kept of contacts.
    fn keeping(&self) -> Keeping {
        Keeping {
            stated: self.scenery.scenario.candidates.len(),
            ego: self.scenery.scenario.ego.0,
            facts: self.keeps_facts,
            scene: self.request.scene,
            chain: self.request.explanation,
        }
    }
}

/// What is kept of contacts beside their harm. Pictures and chains are of the scene as stated,
/// worlds of members; other criteria judge both.
#[derive(Clone, Copy, Debug)]
struct Keeping {
    /// How many courses are of the scene as stated: the first ones.
    stated: usize,
    /// The number of the ego.
    ego: usize,
    facts: bool,
    scene: bool,
    chain: bool,
}

impl Keeping {
    /// A contact of course `k`, number `number` of the work, with its harm.
    fn contact(
        &self,
        (k, meeting): (usize, NextContact),
        (work, number): (&SurveyRun<'_>, usize),
        harm: CandidateHarm,
    ) -> AssessedContact {
        let contacts = work.request();
        let candidate = &contacts.candidates[number];
        let mut assessed = assessed(contacts, work, number, meeting, harm);
        let state = &work.candidate_states()[number];
        let is_stated = k < self.stated;
        if self.facts || !is_stated {
            let facts = ContactFacts::of(candidate, [self.ego, meeting.party]);
            assessed.facts = Some(Box::new(facts));
        }
        if self.facts {
            assessed.evidence = Some(Box::new(work.evidence(number)));
        }
        if self.scene && is_stated {
            assessed.scene = Some(Box::new(ContactScene::of(candidate, state)));
        }
        if self.chain && is_stated {
            let chain = contact_chain(contacts, candidate, &assessed.harm, state);
            assessed.chain = Some(Box::new(chain));
        }
        assessed
    }
}
