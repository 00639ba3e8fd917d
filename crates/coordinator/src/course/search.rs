//! The search for the contact that comes next in every course.
//!
//! ```text
//! courses --a few at a time--> looks (workers) --> whom each meets next --> contacts (here)
//!    ^                                                                        |
//!    +------------- those that met nobody yet, and need further looks --------+
//! ```
//!
//! While workers look for some courses, the contacts of the last ones are assembled here: what
//! comes about, and with which plane, takes as long as the looks. Which courses are looked at
//! together, and in which order, follows from the request alone, so a replay does the same.

use super::Course;
use super::assessed_contact::contact;
use super::history::{SearchClock, Surveyor};
use super::persons::People;
use super::rounds::{Round, Rounds};
use super::way::{Begin, NextContact, Scenery};
use crate::looks::AskedLook;
use crate::request::{Candidate, Request, RequestError};
use crate::workspace::{BodySet, RunError};
use body::Outlines;
use bvh::support::{Extremes, support_near};
use damage::approach::STANDSTILL_M_S;
use damage::course::{PASSED_M, Severity};
use damage::{Basis, Criteria, Evidence, assess};
use executor::encounter::LookOutcome;
use geometry::DVec3;
use runtime::clock;
use std::collections::VecDeque;
use std::ops::Range;

/// Into how many parts courses are divided, to have contacts assembled while workers look.
const PARTS: usize = 8;
/// Least number of courses that are looked at together.
const TOGETHER_MIN: usize = 4;

/// A contact that comes next, and the same as a candidate of a request.
type Found = (NextContact, Candidate);

impl Rounds<'_> {
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
            let open: Vec<usize> = block.clone().filter(|k| self.courses[*k].is_open()).collect();
            let found = self.search_together(&block, &open, surveyor, time)?;
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

    /// What comes next in each of these open courses of a block.
    fn search_together(
        &mut self,
        block: &Range<usize>,
        open: &[usize],
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<Vec<Option<Found>>, RunError> {
        let mut found: Vec<Option<Found>> = open.iter().map(|_| None).collect();
        let together = open.len().div_ceil(PARTS).max(TOGETHER_MIN);
        // Numbers in `open`: those to look at, and those that were looked at last.
        let mut waiting: VecDeque<usize> = (0..open.len()).collect();
        let mut looked_at: Vec<usize> = Vec::new();
        // Each look is at a later time than the last one at that party.
        while !(waiting.is_empty() && looked_at.is_empty()) {
            let mut now: Vec<usize> = waiting.drain(..together.min(waiting.len())).collect();
            now.sort_unstable();
            let numbers = |of: &[usize]| of.iter().map(|number| open[*number]).collect::<Vec<_>>();
            let next = self.look(block, &numbers(&now), &numbers(&looked_at), surveyor, time)?;
            for (number, next) in looked_at.into_iter().zip(next) {
                found[number] = next;
                if found[number].is_none() && self.courses[open[number]].needs_looks() {
                    waiting.push_back(number);
                }
            }
            looked_at = now;
        }
        Ok(found)
    }

    /// Looks at whomever the courses `now` may meet next. What comes next in the courses `before`,
    /// none of which is one of `now`, is found meanwhile, and returned; both in ascending order.
    fn look(
        &mut self,
        block: &Range<usize>,
        now: &[usize],
        before: &[usize],
        surveyor: &mut Surveyor<'_>,
        time: &SearchClock,
    ) -> Result<Vec<Option<Found>>, RunError> {
        let is_past = || time.is_past();
        let is_due = time.is_watched().then_some(&is_past as &dyn Fn() -> bool);
        let Self { scenery, people, stage, request, courses, encounters, effort, .. } = self;
        let (extremes, search) = (&self.extremes[..], &mut effort.search);
        let assembly = Assembly { scenery, people, stage, criteria: &request.criteria, extremes };
        let all = courses[block.clone()].iter_mut().enumerate();
        let (mut looking, mut ready) = (Vec::new(), Vec::new());
        for (at, course) in all {
            let k = block.start + at;
            if now.binary_search(&k).is_ok() && course.needs_looks() {
                course.way.prepare(encounters);
                looking.push(course);
            } else if before.binary_search(&k).is_ok() {
                ready.push((k, course));
            }
        }
        let (mut asked, mut of_asked, mut far) = (Vec::new(), Vec::new(), Vec::new());
        for (at, course) in looking.iter().enumerate().filter(|(_, course)| course.needs_looks()) {
            for (party, look) in course.way.looks() {
                search.encounters += 1;
                if !look.may_touch && look.ways.are_far(&(look.from_s..look.end_s)) {
                    far.push((at, party));
                    continue;
                }
                search.in_trees += 1;
                of_asked.push((at, party));
                asked.push(AskedLook { models: scenery.numbers(party), look });
            }
        }
        let mut next = Vec::with_capacity(before.len());
        let mut ready = ready.into_iter();
        let mut assemble = || {
            let Some((k, course)) = ready.next() else { return false };
            next.push(assembly.next(k, course, time));
            true
        };
        if !asked.is_empty() {
            let looked = surveyor.look(&asked, stage, encounters, is_due, &mut assemble)?;
            search.nb += looked.counters.nb;
            search.np += looked.counters.np;
            if looked.by_workers {
                search.jobs += looked.seen.len() as u64;
                self.reports.extend(surveyor.report());
            }
            drop(asked);
            for ((at, party), seen) in of_asked.into_iter().zip(looked.seen) {
                looking[at].way.learn(party, seen, encounters);
            }
        }
        while assemble() {}
        for (at, party) in far {
            looking[at].way.learn(party, Some(LookOutcome::Never), encounters);
        }
        Ok(next.into_iter().collect::<Result<_, _>>()?)
    }
}

/// What contacts are assembled from.
struct Assembly<'a, 'r> {
    scenery: &'a Scenery<'r>,
    people: &'a People,
    stage: &'a BodySet<'r>,
    criteria: &'a Criteria,
    /// Extremes of each body, if the stage has none; may be empty.
    extremes: &'a [Extremes],
}

impl Assembly<'_, '_> {
    /// The next contact of course `k` that has to be surveyed; `None`, too, if that needs a look,
    /// or there is no time.
    fn next(
        &self,
        k: usize,
        course: &mut Course<'_>,
        time: &SearchClock,
    ) -> Result<Option<Found>, RequestError> {
        let Self { scenery, people, stage, criteria, extremes } = self;
        let support_of = |model: usize, direction: DVec3, near: &mut Option<[f32; 3]>| {
            let view = &stage.bodies[model].1;
            match stage.extremes.unwrap_or(extremes).get(model) {
                Some(extremes) => extremes.support(view, direction),
                None => support_near(view, direction, near),
            }
        };
        let outlines = |model: u32| &stage.bodies[model as usize].0.outlines;
        let is_member = k >= scenery.scenario.candidates.len();
        if course.stuck.is_some() {
            return Ok(None);
        }
        while let Some(meeting) = course.way.next() {
            // How it comes about, and its plane, take a millisecond where bodies are large.
            if time.has_limit() && time.is_over() {
                course.way.give_up();
                return Ok(None);
            }
            let contact = contact(scenery, people, course, &meeting, &support_of, is_member)?;
            let approach = &contact.approach;
            let (closing_m_s, extent_m) = (approach.closing_m_s, approach.extent_up_to(PASSED_M));
            let parts =
                !contact.is_stuck && (closing_m_s < STANDSTILL_M_S || !approach.is_closing());
            match meeting.begin {
                Begin::AtStart if parts => course.way.let_part(&meeting, closing_m_s, extent_m),
                // It was assessed before, and stays as light as it was: no survey changes that.
                Begin::Again if stays_light(&contact, criteria, &outlines)? => {
                    course.way.pass(&meeting, closing_m_s, extent_m);
                }
                Begin::AtStart | Begin::Again | Begin::Touched => {
                    // After a deadline nothing may be left to do but to assess what was found. And
                    // surveys of members leave no time for it.
                    if time.has_limit() || is_member {
                        contact.lay_plane([contact.model_a, contact.model_b].map(outlines));
                    }
                    return Ok(Some((meeting, contact)));
                }
            }
        }
        Ok(None)
    }
}

/// Whether a contact is light for the ego, which its plane alone decides.
fn stays_light<'o>(
    contact: &Candidate,
    criteria: &Criteria,
    outlines: &impl Fn(u32) -> &'o Outlines,
) -> Result<bool, RequestError> {
    let Criteria { curves, policy, parameters } = criteria;
    if !contact.may_be_heavy(parameters) {
        return Ok(true);
    }
    contact.lay_plane([contact.model_a, contact.model_b].map(outlines));
    let basis = Basis { curves, level: policy.outcome, parameters };
    let harm = assess(&contact.encounter(), &Evidence::none(), &basis)
        .map_err(|source| RequestError::Assess { name: contact.name.to_string(), source })?;
    Ok(harm.is_settled() && Severity::of(&harm).0 == Severity::Light)
}
