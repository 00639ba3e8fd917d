//! The search for the contact that comes next in every course.
//!
//! ```text
//! courses --looks--> workers --> whom each meets next --> contacts (here, while workers look)
//!    ^                                                       |
//!    +---- that meets nobody yet: its further looks go first +
//! ```
//!
//! What comes about, and with which plane, takes as long as the looks. Where many courses wait for
//! that and workers wait for looks, threads on their cores help. Nothing waits for planes of
//! members: they are laid when there is nothing else to do, and the last of them by all cores; a
//! coordinator that has a worker's core leaves them to these while few looks are out. A course goes
//! on as soon as its own looks are done, so the order in which courses do depends on
//! workers; what becomes of each does not. What was not done is known by its course and its number
//! there, so a replay leaves the same open.

use super::Course;
use super::assembly::{Assembly, Found, Then};
use super::history::{Cutoff, SearchClock, Surveyor};
use super::rounds::{EncounterEffort, Round, Rounds};
use super::way::NextContact;
use crate::idle_cores::IdleCores;
use crate::looks::{AskedLook, LookSource, OUT_MOST};
use crate::request::{Candidate, Request, RequestError};
use crate::workspace::RunError;
use bvh::Counters;
use bvh::query::QueryWatch;
use damage::Criteria;
use damage::course::PASSED_M;
use executor::encounter::{Encounters, LookOutcome};
use record::OpenStep;
use runtime::clock;
use smallvec::SmallVec;
use std::collections::VecDeque;

/// Planes for each core that are laid without a look at the clock: a few milliseconds.
const PLANES_AT_ONCE: usize = 16;

/// Contacts for each core that are assembled while nobody takes what workers have found: about a
/// millisecond.
const CONTACTS_AT_ONCE: usize = 4;

/// Courses that wait for the coordinator below which others do not help: threads take as long to
/// start as a few contacts do.
const SHARED_MIN: usize = 8;

/// Looks that have to be out before courses wait until there is spare time: a single one would be
/// done by the coordinator.
const OUT_FIRST: usize = 2;

impl Rounds<'_> {
    /// Searches for the contact that comes next in these courses, in ascending order, as far as
    /// that matters, and as far as there is time.
    pub(super) fn search(
        &mut self,
        chosen: &[usize],
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<Round, RunError> {
        let begun_ns = clock::now_ns();
        let (mut meetings, mut contacts) = (Vec::new(), Vec::new());
        // Where work may end early, after each candidate there may be nothing left to do: that is
        // asked here of the scene as stated, and of members by who chooses.
        let is_watched = self.is_watched() && self.drawn() == 0;
        // Of a part nothing is given up: what is open of it does not matter once it is settled.
        let is_settled = is_watched && self.is_part && {
            let standing = self.standing(&[]);
            self.is_settled(&standing)?
        };
        let chosen = if is_settled { &[] } else { chosen };
        for block in chosen.chunks(if is_watched { 1 } else { chosen.len().max(1) }) {
            let is_open = |k: &usize| self.courses[*k].is_open();
            let open: Vec<usize> = block.iter().copied().filter(is_open).collect();
            let found = self.search_together(&open, surveyor, time)?;
            let mut is_one_over = false;
            for (k, found) in open.into_iter().zip(found) {
                match found {
                    Some((meeting, contact)) => {
                        meetings.push((k, meeting));
                        contacts.push(contact);
                    }
                    None => is_one_over |= !self.courses[k].is_open(),
                }
            }
            if is_one_over && is_watched {
                let standing = self.standing(&[]);
                if self.is_settled(&standing)? {
                    break;
                }
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

    /// What comes next in each of these open courses, in ascending order.
    fn search_together(
        &mut self,
        open: &[usize],
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<Vec<Option<Found>>, RunError> {
        let Self { scenery, people, stage, request, courses, encounters, effort, .. } = self;
        let assembly = Assembly {
            scenery,
            people,
            stage,
            criteria: &request.criteria,
            extremes: &self.extremes,
            has_limit: time.has_limit(),
        };
        let mut left = open.iter().peekable();
        let is_open = |(k, _): &(usize, _)| left.next_if(|next| **next == *k).is_some();
        let courses = courses.iter_mut().enumerate().filter(is_open);
        let courses = courses.map(|(k, course)| Searching { k, course, out: 0, found: Ok(None) });
        let mut search = CourseSearch {
            assembly,
            courses: courses.collect(),
            encounters,
            effort: &mut effort.search,
            cutoff: surveyor.cutoff(time),
            cores: surveyor.idle_cores(),
            begun: 0,
            looks: VecDeque::new(),
            out: 0,
            ready: VecDeque::new(),
            bare: VecDeque::new(),
            not_done: Vec::new(),
        };
        let looked = surveyor.look(&mut search, stage, time)?;
        search.lay_planes(time);
        let found = search.courses.into_iter().map(|course| course.found);
        let found = found.collect::<Result<_, _>>()?;
        effort.search.nb += looked.counters.nb;
        effort.search.np += looked.counters.np;
        effort.search.jobs += looked.jobs;
        if looked.jobs > 0 {
            self.reports.extend(surveyor.report());
        }
        Ok(found)
    }
}

/// A course whose next contact is searched for.
struct Searching<'a, 'r> {
    /// Its number.
    k: usize,
    course: &'a mut Course<'r>,
    /// Looks that are not learnt yet.
    out: usize,
    found: Result<Option<Found>, RequestError>,
}

/// A look at a party.
#[derive(Clone, Copy, Debug)]
pub(super) struct CourseLook {
    /// The place of its course in the search.
    at: usize,
    party: usize,
    pub(super) step: OpenStep,
}

/// The search for the next contacts of some courses.
pub(super) struct CourseSearch<'a, 'r> {
    assembly: Assembly<'a, 'r>,
    courses: Vec<Searching<'a, 'r>>,
    encounters: &'a mut Encounters,
    effort: &'a mut EncounterEffort,
    cutoff: Cutoff<'a>,
    /// Who helps where courses wait for the coordinator.
    cores: IdleCores,
    /// How many courses have begun.
    begun: usize,
    /// Looks that nobody has taken yet.
    looks: VecDeque<CourseLook>,
    /// Looks that were taken, and are not learnt yet.
    out: usize,
    /// Courses whose looks are all learnt.
    ready: VecDeque<usize>,
    /// Members' courses with a contact whose plane is not laid.
    bare: VecDeque<usize>,
    /// What was not done, in the order in which that came about.
    pub(super) not_done: Vec<OpenStep>,
}

impl CourseSearch<'_, '_> {
    /// Asks for the looks that a course needs: those of one that has asked before go first, as
    /// nobody else is as far behind.
    fn begin(&mut self, at: usize, is_first: bool) {
        let Self { assembly, courses, encounters, effort, cutoff, looks, ready, not_done, .. } =
            self;
        let Searching { k, course, out, .. } = &mut courses[at];
        if is_first && assembly.has_limit && course.needs_looks() {
            // After the deadline there may be hundreds that have not begun.
            let step = OpenStep { course: *k as u32, number: course.steps };
            course.steps += 1;
            if cutoff.is_over(step) {
                not_done.push(step);
                return course.way.give_up();
            }
        }
        if course.needs_looks() {
            course.way.prepare(encounters);
        }
        if course.needs_looks() {
            let (mut asked, mut far) = (Vec::new(), Vec::new());
            for (party, look) in course.way.looks() {
                effort.encounters += 1;
                if !look.may_touch && look.ways.are_far(&(look.from_s..look.end_s)) {
                    far.push(party);
                    continue;
                }
                effort.in_trees += 1;
                let number = course.steps + asked.len() as u32;
                asked.push(CourseLook { at, party, step: OpenStep { course: *k as u32, number } });
            }
            course.steps += asked.len() as u32;
            for party in far {
                course.way.learn(party, Some(LookOutcome::Never), encounters);
            }
            *out = asked.len();
            if is_first {
                looks.extend(asked);
            } else {
                asked.into_iter().rev().for_each(|look| looks.push_front(look));
            }
        }
        if *out == 0 {
            ready.push_back(at);
        }
    }

    /// Lets courses whose looks are all learnt go on to their next contacts: one of them, or where
    /// many wait for that, several on all cores. `false` if there are none.
    fn assemble(&mut self) -> bool {
        // Each look that is out keeps one worker busy at most.
        let is_shared = self.ready.len() >= SHARED_MIN;
        let cores = if is_shared { self.cores.without(self.out) } else { IdleCores::default() };
        let count = if cores.threads() > 1 { CONTACTS_AT_ONCE * cores.threads() } else { 1 };
        let mut meetings: SmallVec<[(usize, NextContact); 1]> = SmallVec::new();
        let ready: SmallVec<[usize; 1]> = self.ready.drain(..count.min(self.ready.len())).collect();
        for at in &ready {
            match self.next_contact(*at) {
                Some(meeting) => meetings.push((*at, meeting)),
                // Each look is at a later time than the last one at that party.
                None if self.courses[*at].course.needs_looks() => self.begin(*at, false),
                None => {}
            }
        }
        let (assembly, courses) = (&self.assembly, &self.courses);
        let contacts = cores.map(&mut (), meetings.len(), |(), number| {
            let (at, meeting) = &meetings[number];
            let Searching { k, course, .. } = &courses[*at];
            assembly.contact(*k, course, meeting)
        });
        for ((at, meeting), contact) in meetings.into_iter().zip(contacts) {
            self.go_on(at, meeting, contact);
        }
        !ready.is_empty()
    }

    /// The contact that comes next in a course whose looks are all learnt; `None`, too, if that
    /// needs a look, or there is no time.
    fn next_contact(&mut self, at: usize) -> Option<NextContact> {
        let Self { assembly, courses, cutoff, not_done, .. } = self;
        let Searching { k, course, .. } = &mut courses[at];
        if course.stuck.is_some() {
            return None;
        }
        let meeting = course.way.next()?;
        if assembly.has_limit {
            // How it comes about, and its plane, take a millisecond where bodies are large.
            let step = OpenStep { course: *k as u32, number: course.steps };
            course.steps += 1;
            if cutoff.is_over(step) {
                not_done.push(step);
                course.way.give_up();
                return None;
            }
        }
        Some(meeting)
    }

    /// Lets a course go on at its next contact.
    fn go_on(
        &mut self,
        at: usize,
        meeting: NextContact,
        contact: Result<(Box<Candidate>, Then), RequestError>,
    ) {
        let Self { assembly, courses, ready, bare, .. } = self;
        let Searching { k, course, found, .. } = &mut courses[at];
        let (contact, then) = match contact {
            Ok(contact) => contact,
            Err(error) => return *found = Err(error),
        };
        let approach = &contact.approach;
        let (closing_m_s, extent_m) = (approach.closing_m_s, approach.extent_up_to(PASSED_M));
        match then {
            Then::Survey => {
                *found = Ok(Some((meeting, contact)));
                if assembly.is_member(*k) && !assembly.has_limit {
                    bare.push_back(at);
                }
                return;
            }
            Then::Part => course.way.let_part(&meeting, closing_m_s, extent_m),
            Then::Pass => course.way.pass(&meeting, closing_m_s, extent_m),
        }
        // As one that has asked before: nobody else is as far behind.
        ready.push_front(at);
    }

    /// Lays the plane of a member's contact, if one is not laid. Its survey leaves no time for it:
    /// there is often nothing to survey.
    fn lay_plane(&mut self) -> bool {
        let Some(at) = self.bare.pop_front() else { return false };
        if let Ok(Some((_, contact))) = &self.courses[at].found {
            self.assembly.lay_plane(contact);
        }
        true
    }

    /// Lays all planes that are still to be laid, when all workers wait.
    fn lay_planes(&mut self, time: &SearchClock) {
        let cores = &self.cores;
        let bare: Vec<usize> = self.bare.drain(..).collect();
        let contacts = bare.iter().filter_map(|at| self.courses[*at].found.as_ref().ok()?.as_ref());
        let contacts: Vec<_> =
            contacts.map(|(_, contact)| (contact, self.assembly.outlines(contact))).collect();
        for some in contacts.chunks(PLANES_AT_ONCE * cores.threads()) {
            // Whoever has to hear of it does so in time.
            time.is_past();
            cores.map(&mut (), some.len(), |(), number| {
                let (contact, outlines) = some[number];
                contact.lay_plane(outlines)
            });
        }
    }
}

impl LookSource for CourseSearch<'_, '_> {
    type Id = CourseLook;

    fn next(&mut self) -> Option<CourseLook> {
        loop {
            if let Some(look) = self.looks.pop_front() {
                self.out += 1;
                return Some(look);
            }
            if self.begun < self.courses.len() {
                self.begun += 1;
                self.begin(self.begun - 1, true);
            } else if self.out >= OUT_FIRST || !self.assemble() {
                // What workers have found is taken first: so it shows which of them wait.
                return None;
            }
        }
    }

    fn asked(&self, id: CourseLook) -> AskedLook<'_> {
        let models = self.assembly.scenery.numbers(id.party);
        AskedLook { models, look: self.courses[id.at].course.way.look(id.party) }
    }

    fn look(&mut self, id: CourseLook, watch: QueryWatch<'_>) -> Option<(LookOutcome, Counters)> {
        let look = self.courses[id.at].course.way.look(id.party);
        self.encounters.look(&look, watch).ok()
    }

    fn learn(&mut self, id: CourseLook, seen: Option<LookOutcome>) {
        self.out -= 1;
        let Searching { course, out, .. } = &mut self.courses[id.at];
        if seen.is_none() {
            self.not_done.push(id.step);
        }
        course.way.learn(id.party, seen, self.encounters);
        *out -= 1;
        if *out == 0 {
            self.ready.push_back(id.at);
        }
    }

    fn use_spare_time(&mut self) -> bool {
        // Looks of a worker whose core this is must not be all that the others wait for.
        let is_waited_for = self.cores.is_shared() && self.out <= OUT_MOST as usize;
        self.assemble() || !is_waited_for && self.lay_plane()
    }
}
