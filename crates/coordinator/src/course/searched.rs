//! A scene that was searched to the end, to be assessed under any policy and any curves.
//!
//! ```text
//! bodies, scenario --search_courses--> SearchedCourses --assess(policy, curves, worlds)--> Answer
//!                      geometry                              harm, stages, ranking, worlds
//! ```
//!
//! Where the ego goes and whom it meets follows from bodies, motions and the parameters of contact
//! and dynamics. Policy and curves decide three things of a search only, and all three are settled
//! here: work is not ended early, nothing is lost, and *every* stage of members that a policy may
//! ask for is followed, so that the rule that ends stages can be applied again. So an assessment
//! is, byte for byte, the answer of [`rank_courses`](super::rank_courses) under these criteria.
//!
//! # Invariants
//!
//! - No geometry: an assessment has no bodies to look at.
//! - What could depend on the criteria of the search is not kept, or there is no
//!   [`SearchedCourses`].

use super::contact_facts::ContactFacts;
use super::course_answer::Description;
use super::history::{SearchClock, Surveyor};
use super::persons::People;
use super::rounds::Rounds;
use super::stages::{self, CourseOutline, Stage, Stages, next_stage};
use super::worlds;
use super::{Answer, Course, CourseEffort, CourseRequest, Followed, Judged};
use super::{counts, names_of, total_harm};
use crate::answer::{self, PersonRow};
use crate::idle_cores::IdleCores;
use crate::request::RequestError;
use crate::request_limits::{RequestLimits, Until};
use crate::workspace::{Backend, BodySet, RunError};
use damage::rule::Stake;
use damage::{Basis, CandidateHarm, CourseHarm, Criteria, Evidence, Parameters, assess};
use diagnostic::{Diagnostic, FailureKind};
use scenario::{Members, Name, Worlds};
use std::borrow::Cow;
use std::sync::Arc;

/// A scene, searched: contacts, hit sets and run-outs of all candidates in all members.
#[derive(Clone, Debug)]
pub struct SearchedCourses {
    /// The names of all parties.
    parties: Vec<Name>,
    people: People,
    /// What the ego's run-outs follow from.
    parameters: Arc<Parameters>,
    members: Members,
    described: Description,
    /// All candidates in the scene as stated, then in each member.
    courses: Vec<SearchedCourse>,
    outlines: Vec<CourseOutline>,
    /// The stages that were followed.
    stages: Vec<SearchedStage>,
    /// Why there is no further stage, if a policy may ask for one.
    end: Option<RequestError>,
    /// What the search took.
    pub effort: CourseEffort,
}

#[derive(Clone, Copy, Debug)]
struct SearchedStage {
    /// How many members there are.
    count: u32,
    /// How many draws were replaced.
    replaced: u32,
}

/// A candidate in one member.
#[derive(Clone, Debug)]
struct SearchedCourse {
    contacts: Vec<SearchedContact>,
    /// It ends at a contact without figures, after which everything is open.
    is_unevaluable: bool,
}

#[derive(Clone, Debug)]
struct SearchedContact {
    facts: Box<ContactFacts>,
    evidence: Box<Evidence>,
    /// Whether it is in the harm of its course.
    counts: bool,
}

/// Why a scene that was searched cannot be assessed.
#[derive(Clone, Debug, thiserror::Error)]
pub enum AssessmentError {
    /// It cannot be ranked under these criteria, as a fresh ranking would say.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The parameters are others than those it was searched with: the ego would go elsewhere.
    #[error("the scene was searched with other parameters of contact and dynamics")]
    Parameters,
}

impl Diagnostic for AssessmentError {
    fn kind(&self) -> FailureKind {
        FailureKind::Refused
    }

    fn remedy(&self) -> Option<Cow<'_, str>> {
        match self {
            Self::Request(error) => error.remedy(),
            Self::Parameters => Some("search it anew".into()),
        }
    }
}

/// Searches a scene for all that any policy and any curves may ask of it: as many members as the
/// request allows at most. `None` if work was lost, so that harm has bounds only, or if it is past
/// `due_ns` (monotonic), which is asked between jobs.
///
/// Of the request, `worlds`, `history`, `explanation` and `scene` are not used.
///
/// # Errors
///
/// As [`super::rank_courses`].
///
/// # Panics
///
/// As [`super::rank_courses`].
pub fn search_courses(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    due_ns: Option<u64>,
    backend: &mut Backend,
) -> Result<Option<SearchedCourses>, RunError> {
    let request =
        CourseRequest { history: false, explanation: false, scene: false, ..request.clone() };
    let request = &request.among_candidates();
    let time = &SearchClock::until(due_ns).with_idle_hook(backend.idle_hook());
    let limits = RequestLimits::default();
    let (rounds, open_steps) = (None, Vec::new());
    let surveyor = &mut Surveyor::Backend { backend, limits, due_ns, rounds, open_steps };
    let mut rounds = Rounds::new(stage, request, Until::Complete);
    rounds.keeps_facts = true;
    let mut followed = Followed { rounds, time, surveyor };
    let (mut stages, mut end) = (Vec::new(), None);
    let Members { count: asked, most } = request.members;
    let mut count = if request.members.is_nominal() { 0 } else { asked };
    loop {
        match followed.follow(count, false) {
            Ok(()) => {}
            // What ranks under few members may be refused under more.
            Err(RunError::Request(error)) if count > asked && !error.is_of_criteria() => {
                end = Some(error);
                break;
            }
            Err(error) => return Err(error),
        }
        if time.is_over() {
            return Ok(None);
        }
        stages.push(SearchedStage { count, replaced: followed.rounds.members.replaced });
        if count == 0 || count >= most {
            break;
        }
        count = next_stage(count, most);
    }
    let Rounds { scenery, people, mut courses, mut encounters, effort, .. } = followed.rounds;
    let candidates = request.scenario.candidates.len();
    // A stage that came to no end is left out.
    courses.truncate((1 + stages.last().map_or(0, |stage| stage.count as usize)) * candidates);
    let is_drawn = !request.members.is_nominal();
    let stated = &courses[..candidates];
    let extremes = stage.extremes.unwrap_or_default();
    let described =
        Description::of(&scenery, &people, stated, (extremes, &mut encounters, is_drawn));
    let outlines = courses.iter().map(CourseOutline::of).collect();
    let Some(courses) = courses.into_iter().map(SearchedCourse::of).collect() else {
        return Ok(None);
    };
    Ok(Some(SearchedCourses {
        parties: names_of(request.scenario),
        people,
        parameters: Arc::clone(&request.criteria.parameters),
        members: request.members,
        described,
        courses,
        outlines,
        stages,
        end,
        effort,
    }))
}

impl SearchedCourse {
    /// `None` if something is open but what follows a contact without figures.
    fn of(course: Course<'_>) -> Option<Self> {
        let is_unevaluable = course.stuck.is_some_and(|stuck| stuck.unevaluable.is_some());
        if course.is_open() && !is_unevaluable {
            return None;
        }
        let is_counted: Vec<bool> =
            course.contacts.iter().map(|contact| counts(&course, contact)).collect();
        let contact = |(contact, counts): (super::AssessedContact, bool)| {
            let harm = &contact.harm;
            let is_known = !harm.is_open && (harm.is_settled() || harm.unevaluable.is_some());
            let (facts, evidence) = contact.facts.zip(contact.evidence)?;
            is_known.then_some(SearchedContact { facts, evidence, counts })
        };
        let contacts = course.contacts.into_iter().zip(is_counted).map(contact);
        Some(Self { contacts: contacts.collect::<Option<_>>()?, is_unevaluable })
    }

    fn facts(&self) -> Vec<&ContactFacts> {
        self.contacts.iter().map(|contact| &*contact.facts).collect()
    }
}

impl SearchedContact {
    /// Its harm by these curves, at this level.
    fn harm(&self, basis: &Basis<'_>) -> Result<CandidateHarm, RequestError> {
        let name = || self.facts.candidate.to_string();
        assess(&self.facts.encounter(), &self.evidence, basis)
            .map_err(|source| RequestError::Assess { name: name(), source })
    }
}

impl SearchedCourses {
    /// How many members are known, besides the scene as stated.
    #[must_use]
    pub fn members(&self) -> u32 {
        self.stages.last().map_or(0, |stage| stage.count)
    }

    /// The answer under a policy and curves, and with these worlds: that of a ranking of the scene,
    /// byte for byte. `Answer::implausible` is empty, as there.
    ///
    /// # Errors
    ///
    /// If a fresh ranking had an error, or with other parameters than those of the search.
    pub fn assess(&self, criteria: &Criteria, worlds: Worlds) -> Result<Answer, AssessmentError> {
        if criteria.parameters != self.parameters {
            return Err(AssessmentError::Parameters);
        }
        let names = self.described.rows.iter().map(|row| row.name.as_str());
        let criteria = &Criteria { policy: criteria.policy.among(names), ..criteria.clone() };
        let stakes = self.people.stakes();
        let (harms, persons) = (Vec::new(), Vec::new());
        let mut assessment = Assessment { searched: self, criteria, stakes, harms, persons };
        let judged = if self.members.is_nominal() {
            assessment.assess_members(0)?;
            assessment.judged(0)?
        } else {
            let always = (Until::Complete, &SearchClock::until(None));
            stages::followed(self.members, always, &mut assessment)?
        };
        let Assessment { stakes, persons, .. } = assessment;
        let drawn = judged.members.as_ref().map_or(0, stages::MembersFound::count);
        let worlds_found = if judged.has_worlds() {
            let candidates = self.described.rows.len();
            let drawn = &self.courses[candidates..(1 + drawn) * candidates];
            let contacts: Vec<Vec<&ContactFacts>> =
                drawn.iter().map(SearchedCourse::facts).collect();
            let contacts = (&contacts[..], self.parties.len());
            let alone = (None, &IdleCores::default());
            worlds::found((criteria, worlds), &judged, stakes, contacts, alone)?
        } else {
            None
        };
        let mut described = self.described.clone();
        for (row, persons) in described.rows.iter_mut().zip(persons) {
            for (contact, persons) in row.contacts.iter_mut().zip(persons) {
                contact.persons = persons;
            }
        }
        let of = (&self.people, &*criteria.policy);
        Ok(judged.answer(described, of, worlds_found, (self.members, worlds)))
    }
}

/// A searched scene while it is assessed.
struct Assessment<'a> {
    searched: &'a SearchedCourses,
    criteria: &'a Criteria,
    stakes: Vec<Stake>,
    /// The harm of every candidate in the scene as stated, then in each member, so far.
    harms: Vec<Vec<CourseHarm>>,
    /// Everyone in each contact of each candidate in the scene as stated.
    persons: Vec<Vec<Vec<PersonRow>>>,
}

impl Assessment<'_> {
    /// Assesses the scene as stated and so many members, as far as they are not.
    fn assess_members(&mut self, count: u32) -> Result<(), RequestError> {
        let Self { searched, criteria, .. } = *self;
        let Criteria { policy, curves, parameters } = criteria;
        let basis = Basis { curves, level: policy.outcome, parameters };
        let members = searched.courses.chunks(searched.described.rows.len());
        for member in members.take(1 + count as usize).skip(self.harms.len()) {
            let is_stated = self.harms.is_empty();
            let mut harms = Vec::with_capacity(member.len());
            for course in member {
                let all = course.contacts.iter().map(|contact| contact.harm(&basis));
                let all = all.collect::<Result<Vec<_>, _>>()?;
                if is_stated {
                    let persons = |harm| answer::persons(&searched.people.list, harm);
                    self.persons.push(all.iter().map(persons).collect());
                }
                let counted = course.contacts.iter().zip(&all);
                let counted = counted.filter(|(contact, _)| contact.counts);
                let counted = counted.map(|(_, harm)| Cow::Borrowed(harm));
                // Nothing else is ever open.
                let ends = (course.is_unevaluable, course.is_unevaluable);
                harms.push(total_harm(&searched.people, counted, ends));
            }
            self.harms.push(harms);
        }
        Ok(())
    }
}

impl Stages for Assessment<'_> {
    type Error = RequestError;

    fn follow(&mut self, count: u32, _is_part: bool) -> Result<(), RequestError> {
        if let Some(end) = &self.searched.end
            && count > self.searched.members()
        {
            return Err(end.clone());
        }
        self.assess_members(count)
    }

    fn judged(&mut self, count: u32) -> Result<Judged, RequestError> {
        let Self { searched, criteria, stakes, harms, .. } = self;
        let policy = &*criteria.policy;
        if count == 0 {
            return Judged::of(policy, stakes, harms[0].clone());
        }
        let SearchedCourses { parties, members, outlines, stages, .. } = searched;
        let replaced = stages.iter().find(|stage| stage.count == count);
        let replaced = replaced.map_or(0, |stage| stage.replaced);
        let known = (1 + count as usize) * searched.described.rows.len();
        let (members, courses) = (*members, &outlines[..known]);
        let stage = Stage { policy, stakes, parties, members, count, replaced, harms, courses };
        stage.judged()
    }
}

#[cfg(test)]
mod tests;
