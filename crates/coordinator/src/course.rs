//! Ranks the candidates of a scenario over a horizon: every candidate among everybody around.
//!
//! ```text
//! Scenario --Way::next: who is met next, and when--> contacts, one per candidate
//!      ^                                                       |  as candidates of a Request
//!      |                                                       v
//!      +-- light: drive on, heavy: run-out <-- harm <-- SurveyRun: hit sets at the contact
//! no contact left --> CourseHarm per candidate --> damage::rank --> Answer
//! ```
//!
//! The contacts that come next in all candidates are worked on together, as a *round*: each is a
//! candidate of a [`Request`] whose first contact is known, so the survey of its hit sets goes
//! through the same jobs, workers and faults as any other. There are as many rounds as the
//! candidate with the most contacts and looks has.
//!
//! # Invariants
//!
//! - Contacts of a candidate are found in the order of time, whatever the order in which parties
//!   are looked at: [`Way::next`] takes the earliest of all.
//! - What is open is never harmless: from the first open time on everybody may be harmed.
//! - Looks at bodies that still touch come to an end: each is later by at least 10 ms.
//! - What is looked at again is left out only if no impact of these masses could be heavy.

use crate::request::RequestError;
use crate::request_limits::{RequestLimits, Until};
use crate::strategy::SearchOrder;
use crate::work::Effort;
use crate::worker_pool::WorkerPoolReport;
use crate::workspace::{Backend, BodySet, RunError};
use body::Shells;
use damage::course::Severity;
use damage::{CourseHarm, Criteria, Unevaluable};
use runtime::clock;
use scenario::{Members, Name, Scenario, Worlds};
use std::sync::Arc;

mod assembly;
mod assessed_contact;
mod contact_facts;
mod course_answer;
mod explain;
mod flags;
mod harm;
mod history;
mod judged;
mod member;
mod persons;
mod plan_scene;
mod remarks;
mod rounds;
mod search;
mod searched;
mod selection;
mod stages;
mod stop;
#[cfg(any(test, feature = "faults"))]
mod trial;
mod way;
mod worlds;

pub use course_answer::{Answer, ContactRow, CoursePersonRow, CourseRow, RunOutRow};
pub use explain::{CombinedRisk, ContactStep, CourseChain, Explanation};
pub use flags::{Alternative, AtHorizon, NearestRow};
pub use history::{CourseHistory, replay_courses};
pub use plan_scene::{
    ContactScene, PlanContact, PlanCourse, PlanMember, PlanMemberCourse, PlanNearest, PlanParty,
    PlanPath, PlanPoint, PlanSample, PlanScene,
};
pub use rounds::EncounterEffort;
#[cfg(test)]
pub(crate) use rounds::first_round;
pub use searched::{AssessmentError, SearchedCourses, search_courses};
pub use selection::CourseOrder;
pub use stages::{ExpectedRow, MemberRow, MembersRow, MetRow};
#[cfg(any(test, feature = "faults"))]
pub use trial::{CourseFlaw, TrialResult, random_courses, trial_courses};
pub use worlds::{FlipRow, WorldsRow};

use assessed_contact::AssessedContact;
use contact_facts::ContactFacts;
use course_answer::Description;
use harm::{counts, harm_by, harm_of, is_heavy_for_sure, total_harm};
use history::{SearchClock, Surveyor};
use judged::Judged;
use member::Member;
use rounds::Rounds;
use selection::Selection;
use stages::Stages;
use way::{Scenery, Way};

/// One request over a horizon.
#[derive(Clone, Debug)]
pub struct CourseRequest<'a> {
    /// Parties, their motions and candidates.
    pub scenario: &'a Scenario,
    /// The body of each party: its number in the store.
    pub models: &'a [usize],
    /// The shells of each body of the store, [`Shells::of`] its triangles: found once per body, as
    /// that takes about 1 µs per triangle.
    pub shells: &'a [Shells],
    /// Policy, curves and parameters that judge the candidates.
    pub criteria: Criteria,
    /// How many members are followed.
    pub members: Members,
    /// Which worlds are drawn.
    pub worlds: Worlds,
    /// Whether a history is recorded, from which the answer can be made again.
    pub history: bool,
    /// Whether the answer is explained.
    pub explanation: bool,
    /// Whether it is said where everybody is over time, for a picture.
    pub scene: bool,
}

impl CourseRequest<'_> {
    /// The request with a policy that knows its candidates by number.
    fn among_candidates(&self) -> Self {
        let names = self.scenario.candidates.iter().map(|candidate| candidate.name.as_str());
        let policy = self.criteria.policy.among(names);
        Self { criteria: Criteria { policy, ..self.criteria.clone() }, ..self.clone() }
    }
}

/// What the work on a request took.
#[derive(Clone, Copy, Debug, Default)]
pub struct CourseEffort {
    /// The search for contacts.
    pub search: EncounterEffort,
    /// The surveys of hit sets at contacts.
    pub surveys: Effort,
    /// Rounds of contacts.
    pub rounds: u64,
    /// Jobs that this process ran itself.
    pub jobs_in_process: u64,
    /// Time of drawing members, and of the search (ns).
    pub search_ns: u64,
    /// Time of the surveys (ns).
    pub surveys_ns: u64,
    /// Time of assessing contacts and members as they become known (ns).
    pub assess_ns: u64,
    /// Time of flags, harm and ranking, after all other work but worlds (ns).
    pub judge_ns: u64,
    /// Time of worlds (ns).
    pub worlds_ns: u64,
    /// Candidates that were not followed to their end, as that could not change what was asked for.
    pub spared: u64,
    /// When the request was accepted (ns, monotonic).
    pub accepted_ns: u64,
}

/// A request, ranked.
#[derive(Clone, Debug)]
pub struct RankedCourses {
    /// The answer: the same bytes for every backend, if it is complete.
    pub answer: Answer,
    /// How it came to be.
    pub effort: CourseEffort,
    /// What the workers did, if there are any: one report a round.
    pub reports: Vec<WorkerPoolReport>,
    /// What it can be made from again, if that was requested.
    pub history: Option<CourseHistory>,
    /// Every figure from contact to rank, if that was requested.
    pub explanation: Option<Explanation>,
    /// Where everybody is over time, if that was requested.
    pub scene: Option<PlanScene>,
}

/// A candidate as it is followed in one member.
#[derive(Debug)]
struct Course<'s> {
    /// Number of the candidate.
    candidate: usize,
    way: Way<'s>,
    contacts: Vec<AssessedContact>,
    /// Where the course ended before its time.
    stuck: Option<Stuck>,
    /// It is not followed on, as that cannot change what was asked for.
    is_spared: bool,
    /// Its harm, once nothing is open.
    harm: Option<CourseHarm>,
    /// How many steps its search has taken: looks, and contacts that a deadline may leave open.
    steps: u32,
}

/// A contact that cannot be evaluated, or whose work is not done.
#[derive(Clone, Copy, Debug)]
struct Stuck {
    party: usize,
    time_s: f64,
    unevaluable: Option<Unevaluable>,
}

impl<'s> Course<'s> {
    fn new(scenery: Scenery<'s>, member: Arc<Member<'s>>, candidate: usize) -> Self {
        let way = Way::new(scenery, member, candidate);
        let contacts = Vec::new();
        Self { candidate, way, contacts, stuck: None, is_spared: false, harm: None, steps: 0 }
    }

    /// Its contacts as worlds assess them, if they are kept.
    fn facts(&self) -> Vec<&ContactFacts> {
        self.contacts.iter().filter_map(|contact| contact.facts.as_deref()).collect()
    }

    /// Whether anything is not known of it.
    fn is_open(&self) -> bool {
        self.stuck.is_some() || !self.way.is_at_end()
    }

    /// Whether it has to be looked whom it meets next.
    fn needs_looks(&self) -> bool {
        self.stuck.is_none() && self.way.needs_looks()
    }

    /// From when on (s) it is not known what happens, if it is not.
    fn open_from_s(&self) -> Option<f64> {
        let stuck_s = || self.stuck.map(|stuck| stuck.time_s);
        self.way.open_from_s.or_else(stuck_s).or_else(|| self.way.unknown_from_s())
    }

    /// Whether an open course keeps a contact when it is finished. A light one may give way to a
    /// heavy one of the same crash that is found by a second look; its lower ends then count for
    /// nothing. A contact whose survey is not done may still turn out to be light.
    fn is_final(&self, contact: &AssessedContact) -> bool {
        let harm = &contact.harm;
        if harm.unevaluable.is_some() {
            // The course ends here, however much is known.
            return true;
        }
        if !harm.is_settled() || harm.is_open {
            return is_heavy_for_sure(harm);
        }
        contact.severity == Severity::Heavy || !self.way.may_give_way(contact.meeting.party)
    }
}

/// Ranks the candidates of a scenario over a horizon.
///
/// # Errors
///
/// If a contact cannot be assessed at all, or no worker is left to run jobs.
///
/// # Panics
///
/// If there is no model for a party, or no such body, or a body without shells.
pub fn rank_courses(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    limits: RequestLimits,
    backend: &mut Backend,
) -> Result<RankedCourses, RunError> {
    rank_courses_in(CourseOrder::default(), (stage, request), limits, backend)
}

/// [`rank_courses`] with members followed in this order until the winner is certain. There is a
/// history of the usual one alone, as a replay knows no other.
///
/// # Errors
///
/// As [`rank_courses`].
///
/// # Panics
///
/// As [`rank_courses`].
pub fn rank_courses_in(
    order: CourseOrder,
    (stage, request): (&BodySet<'_>, &CourseRequest<'_>),
    limits: RequestLimits,
    backend: &mut Backend,
) -> Result<RankedCourses, RunError> {
    let accepted_ns = clock::now_ns();
    backend.begin(accepted_ns);
    let reserved_ns = SAYING_NS * request.scenario.candidates.len() as u64;
    let due_ns = limits
        .deadline_ns
        .map(|length_ns| accepted_ns + length_ns.saturating_sub(reserved_ns.min(length_ns / 5)));
    let time = SearchClock::until(due_ns).with_idle_hook(backend.idle_hook());
    let is_recorded = request.history && order == CourseOrder::default();
    let rounds = is_recorded.then(Vec::new);
    // Contacts of several members are no candidates of one request: no order of theirs decides.
    let limits = if request.members.is_nominal() {
        limits
    } else {
        RequestLimits { search_order: SearchOrder::AsAsked, ..limits }
    };
    let mut surveyor =
        Surveyor::Backend { backend, limits, due_ns, rounds, open_steps: Vec::new() };
    let mut ranked = follow((stage, request), (limits.until, order), &time, &mut surveyor)?;
    ranked.effort.accepted_ns = accepted_ns;
    if let Surveyor::Backend { rounds: Some(rounds), mut open_steps, .. } = surveyor {
        open_steps.sort_unstable();
        let (until, search) = (limits.until.into(), time.search());
        ranked.history = Some(CourseHistory { until, search, rounds, open_steps });
    }
    backend.end();
    Ok(ranked)
}

/// Follows every candidate until no contact is left, time is over, or no open work can change what
/// was asked for; and ranks them.
fn follow(
    (stage, request): (&BodySet<'_>, &CourseRequest<'_>),
    (until, order): (Until, CourseOrder),
    time: &SearchClock,
    surveyor: &mut Surveyor<'_>,
) -> Result<RankedCourses, RunError> {
    let request = &request.among_candidates();
    let is_over = || time.is_over();
    let is_due = time.is_watched().then_some(&is_over as &dyn Fn() -> bool);
    let mut rounds = Rounds::new(stage, request, until);
    rounds.order = order;
    let mut followed = Followed { rounds, time, surveyor };
    let judged = if request.members.is_nominal() {
        followed.follow(0, false)?;
        followed.judged(0)?
    } else {
        stages::followed(request.members, (until, time), &mut followed)?
    };
    let rounds = followed.rounds;
    let Rounds { scenery, people, courses, mut encounters, mut effort, reports, .. } = rounds;
    // The scene as stated, and the members that harm is the mean of: a late stage has begun more.
    let (courses, all_drawn) = courses.split_at(request.scenario.candidates.len());
    let count = judged.members.as_ref().map_or(0, stages::MembersFound::count);
    let drawn = &all_drawn[..count * courses.len()];
    let begun_ns = clock::now_ns();
    let worlds = if judged.has_worlds() {
        let contacts: Vec<Vec<&ContactFacts>> = drawn.iter().map(Course::facts).collect();
        let contacts = (&contacts[..], request.scenario.parties.len());
        worlds::found(
            (&request.criteria, request.worlds),
            &judged,
            people.stakes(),
            contacts,
            (is_due, &surveyor.idle_cores()),
        )?
    } else {
        None
    };
    effort.worlds_ns = clock::now_ns() - begun_ns;
    let spared = |courses: &[Course<'_>]| courses.iter().filter(|course| course.is_spared).count();
    effort.spared = (spared(courses) + spared(all_drawn)) as u64;
    let begun_ns = clock::now_ns();
    let is_drawn = judged.members.is_some();
    let extremes = stage.extremes.unwrap_or_default();
    let described =
        Description::of(&scenery, &people, courses, (extremes, &mut encounters, is_drawn));
    let explain = || {
        let known = (courses, &judged.harms[..]);
        let criteria = &request.criteria;
        Explanation::new(request.scenario, &people, criteria, (known, drawn), &judged.ranking)
    };
    let explanation = request.explanation.then(explain).transpose().map_err(RequestError::from)?;
    let answer = judged.answer(
        described,
        (&people, &request.criteria.policy),
        worlds,
        (request.members, request.worlds),
    );
    effort.judge_ns = clock::now_ns() - begun_ns;
    let scene = request.scene.then(|| plan_scene::scene(&scenery, courses, drawn, &answer.ranking));
    Ok(RankedCourses { answer, effort, reports, history: None, explanation, scene })
}

/// Candidates as they are followed, stage by stage.
struct Followed<'f, 'r, 's> {
    rounds: Rounds<'r>,
    time: &'f SearchClock,
    surveyor: &'f mut Surveyor<'s>,
}

impl Stages for Followed<'_, '_, '_> {
    type Error = RunError;

    fn follow(&mut self, count: u32, is_part: bool) -> Result<(), RunError> {
        let Self { rounds, time, surveyor } = self;
        rounds.is_part = is_part;
        if count > 0 {
            let begun_ns = clock::now_ns();
            rounds.draw(count)?;
            rounds.effort.search_ns += clock::now_ns() - begun_ns;
        }
        let mut selection = Selection::default();
        loop {
            let begun_ns = clock::now_ns();
            let chosen = selection.next(rounds, time)?;
            rounds.effort.assess_ns += clock::now_ns() - begun_ns;
            if chosen.is_empty() {
                return Ok(());
            }
            rounds.follow_chosen(&chosen, surveyor, time)?;
        }
    }

    fn judged(&mut self, count: u32) -> Result<Judged, RequestError> {
        let begun_ns = clock::now_ns();
        let judged = self.rounds.judged(count);
        self.rounds.effort.assess_ns += clock::now_ns() - begun_ns;
        judged
    }
}

/// The names of all parties.
fn names_of(scenario: &Scenario) -> Vec<Name> {
    scenario.parties.iter().map(|party| party.name.clone()).collect()
}

/// Contacts that are surveyed together, at most: what is known of each takes a bit for each
/// triangle of both bodies.
pub(crate) const PART_MAX: usize = 128;
/// Time reserved before a deadline, for each candidate, for what is only said (ns).
const SAYING_NS: u64 = 1_000_000;
#[cfg(test)]
mod tests;
