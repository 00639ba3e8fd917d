//! The explanation of an answer: every figure from contact to rank, and what would change the
//! winner.
//!
//! Each contact has its chain from speeds to risks. What is added here: which contacts count, how
//! the risks of a person combine, and what the policy makes of them. Values are copies of those
//! that decided.

use super::persons::People;
use super::rounds::means;
use super::{AssessedContact, Course, counts, harm_by};
use crate::explain::{ContactChain, PolicyStep, Separation, policy_steps, separation};
use crate::request::Person;
use damage::course::{HEAVY_M_S, RUN_OUT_M_S2, Severity};
use damage::curve::Curve;
use damage::{
    CandidateHarm, CourseHarm, Criteria, Interval, Parameters, PersonId, Range, RankError,
    RankedCandidates, Stability,
};
use scenario::Scenario;
use serde::Serialize;
use std::borrow::Cow;

/// Everything that the order of a scenario was made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// The policy's name.
    pub policy: String,
    /// The board that answers for it.
    pub board: String,
    /// The severity that counts.
    pub outcome: &'static str,
    /// What is compared, in turn.
    pub steps: Vec<String>,
    /// How many persons are at stake, in all candidates together.
    pub persons: usize,
    /// How many members risks are means over; 0: they are those of the scene as stated. Contacts
    /// are always of that.
    pub members: u32,
    /// Parameters of contact and dynamics.
    pub parameters: Parameters,
    /// From this change of the ego's velocity on a contact is heavy, and a run-out follows (m/s).
    pub heavy_from_m_s: f64,
    /// Deceleration of a run-out (m/s²).
    pub run_out_m_s2: f64,
    /// Nominal curves in use, with their sources.
    pub curves: Vec<Curve>,
    /// Candidates, least harm first.
    pub chains: Vec<CourseChain>,
    /// What would have to change for another candidate to win; courses stay as they are.
    pub stability: Stability,
    /// Names of the candidates in the order of the request: the numbers of `stability`.
    pub names: Vec<String>,
}

/// One candidate from its contacts to its rank.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CourseChain {
    /// Its name.
    pub name: String,
    /// Its contacts in the order of time.
    pub contacts: Vec<ContactStep>,
    /// From when on (s) it is not known what happens: then everybody may be harmed.
    pub open_from_s: Option<f64>,
    /// Everybody who is in a contact, or may be.
    pub persons: Vec<CombinedRisk>,
    /// Energy lost in all contacts (J), over open work.
    pub energy_j: Interval,
    /// The policy's steps for this candidate.
    pub steps: Vec<PolicyStep>,
    /// Why it comes before the next.
    pub why: Option<String>,
    /// The person whose risk differs most between the two, where persons decided.
    pub separates: Option<Separation>,
}

/// One contact of a candidate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContactStep {
    /// When (s).
    pub time_s: f64,
    /// Whether the ego drives on or runs out.
    pub severity: Severity,
    /// Whether it is in the candidate's harm: a light one is not while it may still turn out to be
    /// the begin of a heavy one.
    pub counts: bool,
    /// From speeds to risks.
    #[serde(flatten)]
    pub chain: ContactChain,
}

/// The risk of a person in all contacts together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CombinedRisk {
    /// Party.
    pub party: String,
    /// Seat; none on foot, and where nobody said.
    pub seat: Option<&'static str>,
    /// R of each contact that the person is in, by its number; none where the risk is a mean over
    /// members.
    pub contacts: Vec<(usize, f64)>,
    /// 1 - Π(1 - R), over open work.
    pub risk: Interval,
    /// The model range: from the greatest of the contacts to their sum.
    pub range: Range,
}

impl Explanation {
    /// Without chains of contacts there are none in it.
    pub(super) fn new(
        scenario: &Scenario,
        people: &People,
        criteria: &Criteria,
        ((courses, harms), drawn): ((&[Course<'_>], &[CourseHarm]), &[Course<'_>]),
        ranking: &RankedCandidates,
    ) -> Result<Self, RankError> {
        let members = drawn.len() / courses.len();
        let Criteria { policy, curves, parameters } = criteria;
        let persons = people.list.len();
        let steps: Vec<String> = policy.steps(persons).iter().map(ToString::to_string).collect();
        let name = |number: usize| scenario.candidates[number].name.as_str();
        let chain = |at: usize| {
            let place = &ranking.places[at];
            let (course, harm) = (&courses[place.candidate], &harms[place.candidate]);
            let next = ranking.places.get(at + 1).map(|next| next.candidate);
            let why = place.why.as_ref().zip(next);
            let risk = |harm: &CourseHarm, id: PersonId| {
                harm.risk_of(id).map_or(0.0, |risk| risk.work.hi())
            };
            CourseChain {
                name: name(place.candidate).to_owned(),
                contacts: course.contacts.iter().filter_map(|c| step(course, c)).collect(),
                open_from_s: course.open_from_s(),
                persons: combined(&people.list, (members == 0).then_some(course), harm),
                energy_j: harm.energy_j,
                steps: policy_steps(&steps, &place.steps),
                why: why.map(|(ground, next)| ground.sentence(name(place.candidate), name(next))),
                separates: why.and_then(|(ground, next)| {
                    let risks = |id| [risk(harm, id), risk(&harms[next], id)];
                    separation(&people.list, ground, risks)
                }),
            }
        };
        let chains: Vec<CourseChain> = (0..ranking.places.len()).map(chain).collect();
        let used = |curve: &&Curve| {
            let contacts = chains.iter().flat_map(|chain| &chain.contacts);
            contacts.flat_map(|contact| &contact.chain.persons).any(|p| *p.curve == *curve.id)
        };
        let curves: Vec<Curve> = curves.curves.iter().filter(used).cloned().collect();
        let with_curve = |curve: &Curve| {
            let changed = |course| {
                let moved = |harm: &CandidateHarm| Cow::Owned(harm.with_curve(curve));
                harm_by(people, course, None, moved)
            };
            if members == 0 {
                return courses.iter().map(changed).collect();
            }
            let each = drawn.chunks(courses.len());
            means(&each.map(|of| of.iter().map(changed).collect()).collect::<Vec<_>>())
        };
        let stability = damage::stability(policy, &people.stakes(), harms, &curves, &with_curve)?;
        Ok(Self {
            policy: policy.name.clone(),
            board: policy.board.clone(),
            outcome: policy.outcome.name(),
            persons,
            members: members as u32,
            parameters: (**parameters).clone(),
            heavy_from_m_s: HEAVY_M_S,
            run_out_m_s2: RUN_OUT_M_S2,
            curves,
            chains,
            stability,
            names: scenario.candidates.iter().map(|way| way.name.to_string()).collect(),
            steps,
        })
    }
}

fn step(course: &Course<'_>, contact: &AssessedContact) -> Option<ContactStep> {
    Some(ContactStep {
        time_s: contact.meeting.touching.time_s + 0.0,
        severity: contact.severity,
        counts: counts(course, contact),
        chain: contact.chain.as_deref()?.clone(),
    })
}

/// What makes up the risk of each person; without a course it is a mean.
fn combined(list: &[Person], course: Option<&Course<'_>>, harm: &CourseHarm) -> Vec<CombinedRisk> {
    let of_contacts = |id: PersonId| {
        let Some(course) = course else { return Vec::new() };
        let counted = course.contacts.iter().enumerate().filter(|(_, c)| counts(course, c));
        let risks = counted.filter_map(move |(number, contact)| {
            let person = contact.harm.persons.iter().find(|person| person.id == id)?;
            Some((number, contact.harm.probability * person.work.hi()))
        });
        risks.collect()
    };
    let risk = |risk: &damage::Risk| {
        let person = &list[risk.id.0];
        CombinedRisk {
            party: person.party.to_string(),
            seat: person.seat.map(body::Seat::name),
            contacts: of_contacts(risk.id),
            risk: risk.work,
            range: risk.range,
        }
    };
    harm.persons.iter().map(risk).collect()
}
