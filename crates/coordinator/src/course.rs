//! Ranks the candidates of a scenario over a horizon: every candidate among everybody around.
//!
//! ```text
//! HorizonScenario --Way::next: who is met next, and when--> contacts, one per candidate
//!      ^                                                       |  as candidates of a Request
//!      |                                                       v
//!      +-- light: drive on, heavy: run-out <-- harm <-- RankingRun: hit sets at the contact
//! no contact left --> CourseHarm per candidate --> damage::rank --> CourseAnswer
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

use crate::answer::{self, PersonRow, PoseRow};
use crate::candidate_state::FirstContact;
use crate::explain::{ContactChain, contact_chain};
use crate::request::{Candidate, Request, RequestError, StatedParty, approach, party};
use crate::request_limits::RequestLimits;
use crate::work::{Effort, RankingRun, RunBuffers};
use crate::worker_pool::WorkerPoolReport;
use crate::workspace::{Backend, BodySet, RunError};
use body::Shells;
use bvh::Witness;
use bvh::support::support;
use damage::approach::STANDSTILL_M_S;
use damage::course::{HEAVY_M_S, PASSED_M, RunOut, Severity};
use damage::path::Path;
use damage::{
    CandidateHarm, CourseHarm, Curves, Meeting, Parameters, Policy, RankedCandidates, Scratch,
    Unevaluable, rank_in,
};
use geometry::motion::MotionPath;
use geometry::{DVec3, RelativePose, Supports};
use runtime::clock;
use scenario::HorizonScenario;
use std::sync::Arc;

mod course_answer;
mod encounter;
mod explain;
mod flags;
mod history;
mod persons;
mod plan_scene;
#[cfg(any(test, feature = "faults"))]
mod trial;
mod way;

pub use course_answer::{ContactRow, CourseAnswer, CoursePersonRow, CourseRow, RunOutRow};
pub use encounter::EncounterEffort;
pub use explain::{CombinedRisk, ContactStep, CourseChain, CourseExplanation};
pub use flags::{Alternative, AtHorizon, NearestRow};
pub use history::{CourseHistory, replay_courses};
pub use plan_scene::{PlanContact, PlanCourse, PlanParty, PlanPath, PlanSample, PlanScene};
#[cfg(any(test, feature = "faults"))]
pub use trial::{CourseFlaw, random_courses, trial_courses};

use encounter::EncounterSearch;
use history::{SearchClock, Surveyor};
use persons::People;
use way::{Begin, NextContact, Scenery, Way};

/// One request over a horizon.
#[derive(Clone, Debug)]
pub struct CourseRequest<'a> {
    /// Parties, their motions and candidates.
    pub scenario: &'a HorizonScenario,
    /// The body of each party: its number in the store.
    pub models: &'a [usize],
    /// The shells of each body of the store, [`Shells::of`] its triangles: found once per body, as
    /// that takes about 1 µs per triangle.
    pub shells: &'a [Shells],
    /// Policy and curves that judge the candidates.
    pub rules: (Arc<Policy>, Arc<Curves>),
    /// Whether a history is recorded, from which the answer can be made again.
    pub history: bool,
    /// Whether the answer is explained.
    pub explanation: bool,
    /// Whether it is said where everybody is over time, for a picture.
    pub scene: bool,
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
    /// Time of the search (ns).
    pub search_ns: u64,
    /// Time of the surveys (ns).
    pub surveys_ns: u64,
    /// Time of flags, harm and ranking (ns).
    pub judge_ns: u64,
    /// When the request was accepted (ns, monotonic).
    pub accepted_ns: u64,
}

/// A request, ranked.
#[derive(Clone, Debug)]
pub struct RankedCourses {
    /// The answer: the same bytes for every backend, if it is complete.
    pub answer: CourseAnswer,
    /// How it came to be.
    pub effort: CourseEffort,
    /// What the workers did, if there are any: one report a round.
    pub reports: Vec<WorkerPoolReport>,
    /// What it can be made from again, if that was requested.
    pub history: Option<CourseHistory>,
    /// Every figure from contact to rank, if that was requested.
    pub explanation: Option<CourseExplanation>,
    /// Where everybody is over time, if that was requested.
    pub scene: Option<PlanScene>,
}

/// A contact of a candidate, assessed.
#[derive(Clone, Debug)]
struct AssessedContact {
    meeting: NextContact,
    /// When the bodies first touched in this crash (s).
    first_touch_s: f64,
    harm: CandidateHarm,
    severity: Severity,
    /// The model range of the ego's change of velocity crosses the threshold.
    may_be_other: bool,
    /// What the answer shows of it besides.
    sides: String,
    is_other_fixed: bool,
    hits: [u64; 2],
    hashes: [String; 2],
    parts: [Vec<String>; 2],
    persons: Vec<PersonRow>,
    poses: Vec<PoseRow>,
    /// If the answer is explained.
    chain: Option<Box<ContactChain>>,
}

/// A candidate as it is followed.
#[derive(Debug)]
struct Course<'s> {
    way: Way<'s>,
    contacts: Vec<AssessedContact>,
    /// Where the course ended before its time.
    stuck: Option<Stuck>,
}

/// A contact that cannot be evaluated, or whose work is not done.
#[derive(Clone, Copy, Debug)]
struct Stuck {
    party: usize,
    time_s: f64,
    unevaluable: Option<Unevaluable>,
}

impl Course<'_> {
    /// From when on (s) it is not known what happens, if it is not.
    fn open_from_s(&self) -> Option<f64> {
        self.way.open_from_s.or(self.stuck.map(|stuck| stuck.time_s))
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
            return harm.delta_v[0].work.lo() >= HEAVY_M_S;
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
    let accepted_ns = clock::now_ns();
    let reserved_ns = SAYING_NS * request.scenario.candidates.len() as u64;
    let due_ns = limits
        .deadline_ns
        .map(|length_ns| accepted_ns + length_ns.saturating_sub(reserved_ns.min(length_ns / 5)));
    let time = SearchClock::until(due_ns).with_idle_hook(backend.idle_hook());
    let rounds = request.history.then(Vec::new);
    let mut surveyor = Surveyor::Backend { backend, limits, due_ns, rounds };
    let mut ranked = follow(stage, request, &time, &mut surveyor)?;
    ranked.effort.accepted_ns = accepted_ns;
    if let Surveyor::Backend { rounds: Some(rounds), .. } = surveyor {
        ranked.history = Some(CourseHistory { search: time.search(), rounds });
    }
    Ok(ranked)
}

/// Follows every candidate until no contact is left or time is over, and ranks them.
fn follow(
    stage: &BodySet<'_>,
    request: &CourseRequest<'_>,
    time: &SearchClock,
    surveyor: &mut Surveyor<'_>,
) -> Result<RankedCourses, RunError> {
    let is_over = || time.is_over();
    let is_due: Option<&dyn Fn() -> bool> = if time.is_watched() { Some(&is_over) } else { None };
    let CourseRequest { scenario, models, shells, rules: (policy, curves), .. } = request;
    let scenery = Scenery { scenario, bodies: stage.bodies, models, shells };
    let people = People::of(scenario, &|party| scenery.body(party));
    let mut effort = CourseEffort::default();
    let mut search = EncounterSearch::default();
    let begin =
        |candidate| Course { way: Way::new(scenery, candidate), contacts: Vec::new(), stuck: None };
    let mut courses: Vec<Course<'_>> = scenario.candidates.iter().map(begin).collect();
    let parameters = Parameters::default();
    let mut buffers = RunBuffers::default();
    let mut reports = Vec::new();
    let support_of = |model: usize, direction: DVec3| match stage.extremes {
        Some(extremes) => extremes[model].support(&stage.bodies[model].1, direction),
        None => support(&stage.bodies[model].1, direction),
    };
    loop {
        let begun_ns = clock::now_ns();
        let mut round: Vec<(usize, NextContact)> = Vec::new();
        let mut contacts: Vec<Candidate> = Vec::new();
        for (k, course) in
            courses.iter_mut().enumerate().filter(|(_, course)| course.stuck.is_none())
        {
            while let Some(meeting) = course.way.next(&mut search, is_due) {
                let contact = contact(&scenery, &people, course, k, &meeting, &support_of)?;
                let approach = &contact.approach;
                let (closing_m_s, extent_m) =
                    (approach.closing_m_s, approach.extent_up_to(PASSED_M));
                let parts = contact.meeting != Meeting::AlreadyOverlapping
                    && (closing_m_s < STANDSTILL_M_S || !approach.is_closing());
                match meeting.begin {
                    Begin::AtStart if parts => {
                        course.way.let_part(&meeting, closing_m_s, extent_m);
                        continue;
                    }
                    // It was assessed before, and stays as light as it was.
                    Begin::Again if !contact.may_be_heavy(&parameters) => {
                        course.way.pass(&meeting, closing_m_s, extent_m);
                        continue;
                    }
                    Begin::AtStart | Begin::Again | Begin::Touched => {}
                }
                round.push((k, meeting));
                contacts.push(contact);
                break;
            }
        }
        effort.search_ns += clock::now_ns() - begun_ns;
        if round.is_empty() {
            break;
        }
        let persons = people.list.clone();
        let (policy, curves) = (policy.clone(), curves.clone());
        let contacts = Request { candidates: contacts, persons, policy, curves, parameters };
        let begun_ns = clock::now_ns();
        let work = RankingRun::with_buffers(&contacts, stage.bodies, stage.depth, buffers);
        let mut work = surveyor.limit(work);
        effort.jobs_in_process += surveyor.survey(&mut work, stage)?;
        reports.extend(surveyor.report());
        effort.surveys_ns += clock::now_ns() - begun_ns;
        effort.rounds += 1;
        effort.surveys.add(&work.effort());
        let (harms, _) = work.judge()?;
        for (number, ((k, meeting), harm)) in round.into_iter().zip(harms).enumerate() {
            let mut assessed = assessed(&contacts, &work, number, meeting, harm);
            if request.explanation {
                let (candidate, harm) = (&contacts.candidates[number], &assessed.harm);
                let state = &work.candidate_states()[number];
                let chain = contact_chain(&contacts, candidate, harm, state);
                assessed.chain = Some(Box::new(chain));
            }
            settle(&mut courses[k], &contacts.candidates[number], assessed);
        }
        buffers = work.into_buffers();
    }
    effort.search = search.effort;
    let begun_ns = clock::now_ns();
    let harms: Vec<CourseHarm> = courses.iter().map(|course| harm_of(&people, course)).collect();
    let stakes: Vec<_> = people.list.iter().map(|person| person.stake).collect();
    let mut ranking = RankedCandidates::default();
    rank_in(&mut Scratch::default(), policy, &stakes, &harms, &mut ranking)
        .map_err(RequestError::from)?;
    let known = (&courses[..], &harms[..]);
    let answer = course_answer::written(&scenery, &people, policy, known, &ranking, &mut search);
    let explanation = request.explanation.then(|| {
        let rules = (&**policy, &**curves, parameters);
        CourseExplanation::new(scenario, &people, rules, known, &ranking)
    });
    effort.judge_ns = clock::now_ns() - begun_ns;
    let scene = request.scene.then(|| plan_scene::scene(&scenery, &courses));
    Ok(RankedCourses { answer, effort, reports, history: None, explanation, scene })
}

/// Velocities of the centres of mass of both bodies just before a time (s), in the world (m/s).
fn velocities(scenery: &Scenery<'_>, course: &Course<'_>, meeting: &NextContact) -> [DVec3; 2] {
    let ways = course.way.ways(meeting.party);
    let parties = [scenery.scenario.ego.0, meeting.party];
    [0, 1].map(|side: usize| {
        let path: &MotionPath = ways.paths[side];
        let centre_m = scenery.body(parties[side]).0.centre_m;
        path.velocity_before(meeting.touching.time_s, centre_m).0
    })
}

/// A contact as a candidate of a request: its first contact is known.
fn contact(
    scenery: &Scenery<'_>,
    people: &People,
    course: &Course<'_>,
    k: usize,
    meeting: &NextContact,
    support_of: &impl Fn(usize, DVec3) -> f64,
) -> Result<Candidate, RequestError> {
    let scenario = scenery.scenario;
    let name = &scenario.candidates[k].name;
    let (ego, other) = (scenario.ego.0, meeting.party);
    let ways = course.way.ways(other);
    let [pose_a, pose_b] = ways.paths.map(|path| path.pose_at(meeting.touching.time_s));
    let pose = RelativePose::between(&pose_a, &pose_b);
    let side = |number: usize, to_ego: Option<&RelativePose>| {
        let stated = &scenario.parties[number];
        let stated = StatedParty {
            is_unknown: stated.is_unknown,
            mass_kg: stated.mass_kg,
            crush: stated.crush,
        };
        party(&scenery.body(number).0, stated, to_ego, people.aboard(number))
    };
    let (a, b) = (side(ego, None), side(other, Some(&pose)));
    let models = [ego, other].map(|number| scenery.models[number]);
    let supports = (|d: DVec3| support_of(models[0], d), |d: DVec3| support_of(models[1], d));
    let approach =
        approach(supports, (&pose_a, &pose), velocities(scenery, course, meeting), (&a, &b));
    let path = Path::from_contact(&approach)
        .map_err(|source| RequestError::Approach { name: name.to_string(), source })?;
    let stands = approach.closing_m_s < STANDSTILL_M_S;
    let is_start = meeting.begin == Begin::AtStart && meeting.touching.time_s <= 0.0;
    let hulls = if is_start && stands { Meeting::AlreadyOverlapping } else { Meeting::Path(path) };
    let touching = &meeting.touching;
    let witness = Witness {
        travel_m: 0.0,
        ids: touching.ids,
        triangles: touching.triangles,
        point: touching.point,
    };
    let mut supports = Supports::EMPTY;
    supports.add(&approach.directions, touching.point);
    let bodies = ways.bodies;
    let zones = encounter::zones([&bodies[0], &bodies[1]], touching.triangles);
    Ok(Candidate {
        name: name.clone(),
        other_name: scenario.parties[other].name.clone(),
        model_a: models[0] as u32,
        model_b: models[1] as u32,
        pose,
        approach,
        meeting: hulls,
        a,
        b,
        probability: 1.0,
        is_assumed_fixed: scenario.parties[other].is_unknown,
        first: Some(FirstContact { witness, zones, supports }),
    })
}

/// What is known of a contact when its round is over.
fn assessed(
    contacts: &Request,
    work: &RankingRun<'_>,
    number: usize,
    meeting: NextContact,
    harm: CandidateHarm,
) -> AssessedContact {
    let candidate = &contacts.candidates[number];
    let state = &work.candidate_states()[number];
    let [a, b] = [candidate.model_a, candidate.model_b].map(|model| work.body_of(model));
    let hit = state.hit.summary(&a.1, &b.1);
    let (severity, may_be_other) = Severity::of(&harm);
    AssessedContact {
        meeting,
        first_touch_s: meeting.touching.time_s,
        severity,
        may_be_other,
        sides: answer::sides(candidate, &harm),
        is_other_fixed: candidate.b.mass_kg.is_none(),
        hits: [hit.hits_a, hit.hits_b],
        hashes: [hit.hash_a, hit.hash_b].map(answer::hex),
        parts: answer::parts(state, [(&a.0, &a.1), (&b.0, &b.1)]),
        persons: answer::persons(contacts, &harm),
        poses: answer::poses(state),
        chain: None,
        harm,
    }
}

/// Lets a course go on after a contact, or end there.
fn settle(course: &mut Course<'_>, candidate: &Candidate, mut assessed: AssessedContact) {
    let meeting = assessed.meeting;
    if !assessed.harm.is_settled() || assessed.harm.is_open {
        // Where the ego goes from here is not known.
        course.stuck = Some(Stuck {
            party: meeting.party,
            time_s: meeting.touching.time_s,
            unevaluable: assessed.harm.unevaluable,
        });
        if meeting.begin != Begin::Again {
            course.contacts.push(assessed);
        }
        return;
    }
    let approach = &candidate.approach;
    match assessed.severity {
        Severity::Light => {
            let extent_m = approach.extent_up_to(PASSED_M);
            course.way.pass(&meeting, approach.closing_m_s, extent_m);
            if meeting.begin != Begin::Again {
                course.contacts.push(assessed);
            }
        }
        Severity::Heavy => {
            let at_s = meeting.touching.time_s;
            let rotation = course.way.ego_path().pose_at(at_s).rotation;
            let impulse = DVec3::from_array(assessed.harm.impulse_n_s);
            let row = |i: usize| DVec3::from_array(rotation[i]).dot(impulse);
            let on_ego = -DVec3::new(row(0), row(1), row(2));
            let (before, _) =
                course.way.ego_path().velocity_before(at_s, candidate.a.centre_m.to_array());
            // The ego has a mass: it is a vehicle.
            let mass_kg = candidate.a.mass_kg.unwrap_or(f64::INFINITY);
            course.way.leave(&meeting, RunOut::after(before, on_ego, mass_kg));
            // A first, light touch was the begin of this crash.
            if meeting.begin == Begin::Again {
                let same = |contact: &AssessedContact| contact.meeting.party == meeting.party;
                if let Some(first) = course.contacts.iter().rposition(same) {
                    assessed.first_touch_s = course.contacts.remove(first).first_touch_s;
                }
            }
            course.contacts.push(assessed);
        }
    }
}

/// Time reserved before a deadline, for each candidate, for what is only said (ns).
const SAYING_NS: u64 = 1_000_000;
/// The energy that a collision of the ego may still take (J): that of 1000 t at 100 m/s. It only
/// keeps an open candidate from winning by less damage.
const ENERGY_MAX_J: f64 = 5e9;

/// Whether a contact is in the harm of its course.
fn counts(course: &Course<'_>, contact: &AssessedContact) -> bool {
    course.open_from_s().is_none() || course.is_final(contact)
}

/// The harm of a course: all contacts together, and whatever is open.
fn harm_of(people: &People, course: &Course<'_>) -> CourseHarm {
    let mut harm = CourseHarm::none();
    for contact in course.contacts.iter().filter(|contact| counts(course, contact)) {
        harm.include(&contact.harm);
    }
    harm.is_unevaluable |= course.stuck.is_some_and(|stuck| stuck.unevaluable.is_some());
    if course.open_from_s().is_some() {
        harm.leave_open(people.all(), ENERGY_MAX_J);
    }
    // Last, as those who may be aboard run the greatest risk there, open ones included.
    people.suppose(&mut harm);
    harm
}

#[cfg(test)]
mod tests;
