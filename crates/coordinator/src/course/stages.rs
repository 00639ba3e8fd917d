//! Stages of members: so many are followed, then twice as many, while the best two are too close
//! to call.
//!
//! Only what is finished decides whether there is another stage: the best two, once it is certain
//! who these are. A stage that time ends is left out: the answer is that of the stage before, of a
//! part of the first one, or of the scene as stated. It is degraded then, and its figures are no
//! bounds on those of more members. So a complete answer depends on nothing but the request.

use super::history::SearchClock;
use super::rounds::means;
use super::{Answer, Course, CourseRow, Judged};
use crate::request::RequestError;
use crate::request_limits::Until;
use damage::expected::{self, Lead, Spread, Spreads};
use damage::rule::Stake;
use damage::{AnswerState, CourseHarm, Interval, Policy, RankedCandidates};
use scenario::{Members, Name};
use schemars::JsonSchema;
use serde::Serialize;
use smallvec::SmallVec;

/// The members of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MembersRow {
    /// How many there are.
    pub count: u32,
    /// How many there might have been.
    pub most: u32,
    /// How many draws were replaced, as the ego overlapped somebody at time 0.
    pub replaced: u32,
    /// By how much the first two candidates differ in the leading measure; `None` where something
    /// is open in members, or there is one candidate.
    pub lead: Option<Lead>,
    /// Whether a further stage, or the rest of the first, was not finished in time.
    pub is_late: bool,
}

/// What members say of a candidate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ExpectedRow {
    /// The share of members in which it meets anybody; where something is open, the least share.
    pub contact: f64,
    /// Whom it meets, the most probable first.
    pub meets: Vec<MetRow>,
    /// How many persons are expected to be injured at the policy's level, over open work.
    pub injured: Interval,
    /// How many members are not followed to their end.
    pub open: u32,
    /// In how many members it was not decided whether the ego and a party lie inside each other at
    /// the start: the outer body is open.
    pub undecided: u32,
    /// The leading measure over members; `None` where something is open in them, here or elsewhere.
    pub spread: Option<Spread>,
    /// The share of worlds that it wins, where these were drawn.
    pub worlds: Option<f64>,
    /// Each member, in the order of the sequence; empty where something is open in them, here or
    /// elsewhere.
    pub members: Vec<MemberRow>,
}

/// A candidate in one member.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MemberRow {
    /// The leading measure.
    pub harm: f64,
    /// Whom it meets first, by number in [`ExpectedRow::meets`]; `None`: nobody.
    pub first: Option<usize>,
}

/// A party that a candidate meets in some members.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MetRow {
    /// Which.
    pub party: String,
    /// The share of members in which it is met.
    pub probability: f64,
    /// The earliest time of contact among them (s).
    pub from_s: f64,
}

/// What a stage has found.
pub(super) struct MembersFound {
    row: MembersRow,
    /// How many were asked for at first.
    asked: u32,
    /// Per candidate.
    expected: Vec<ExpectedRow>,
    /// Whether the best two are too close to call, whatever open work finds.
    is_close: bool,
}

impl MembersFound {
    /// How many members there are.
    pub(super) fn count(&self) -> usize {
        self.row.count as usize
    }

    /// Completes an answer.
    pub(super) fn write(self, answer: &mut Answer, ranking: &RankedCandidates) {
        let Self { row, asked, mut expected, is_close: _ } = self;
        for (place, candidate) in ranking.places.iter().zip(&mut answer.ranking) {
            let own = core::mem::take(&mut expected[place.candidate]);
            if own.undecided > 0 {
                candidate.remarks.push(format!(
                    "in {} of {} members it was not decided whether the ego and somebody lie \
                     inside each other at the start",
                    own.undecided, row.count
                ));
            }
            if own.open > 0 {
                let of = format!("{} of {} members", own.open, row.count);
                answer.missing.push(format!("{}: what happens in {of}", candidate.name));
            }
            candidate.expected = Some(own);
        }
        let is_free =
            |name: &String| answer.ranking.iter().any(|row| row.name == *name && row.hits_nobody());
        let name = |k: &usize| {
            let at = ranking.places.iter().position(|place| place.candidate == *k);
            at.map(|at| answer.ranking[at].name.clone())
        };
        let mut tied: Vec<String> = ranking.tie_class.iter().filter_map(name).collect();
        if answer.ranking.first().is_some_and(CourseRow::hits_nobody) {
            tied.retain(is_free);
        }
        answer.tie_class = tied;
        if row.is_late {
            answer.state = AnswerState::Degraded;
            answer.missing.push(if row.count < asked {
                format!("there was no time for more than {} of {asked} members", row.count)
            } else {
                format!(
                    "the best two are too close to call with {} members, and there was no time \
                     for more",
                    row.count
                )
            });
        }
        answer.members = Some(row);
    }
}

/// Members of the first part of a stage.
const FIRST_PART: u32 = 4;

/// What stages are made of.
pub(super) trait Stages {
    /// Why a stage cannot be followed, or judged.
    type Error: From<RequestError>;

    /// Follows all candidates in the scene as stated and in so many members; `is_part`: what is
    /// left open, as it does not matter, may do so in more members.
    fn follow(&mut self, count: u32, is_part: bool) -> Result<(), Self::Error>;

    /// The order by what is known of so many members; 0: of the scene as stated.
    fn judged(&mut self, count: u32) -> Result<Judged, RequestError>;
}

/// Follows members in stages.
///
/// Where there is a deadline, the scene as stated is followed first, and of the first stage ever
/// longer parts: if it is not finished in time, the answer is that of the last part that was. What
/// is known of a member does not depend on the others, so a finished stage is the same either way.
/// Where the winner is all that is asked for, a part is finished once its winner is certain.
pub(super) fn followed<S: Stages>(
    members: Members,
    (until, time): (Until, &SearchClock),
    stages: &mut S,
) -> Result<Judged, S::Error> {
    let Members { count: asked, most } = members;
    let mut finished: Option<Judged> = None;
    let mut count = if time.has_limit() { 0 } else { asked };
    loop {
        let is_part = count < asked;
        stages.follow(count, is_part)?;
        let judged = stages.judged(count)?;
        if is_part {
            let is_done = match judged.ranking.state {
                AnswerState::Complete => true,
                AnswerState::Certified => until == Until::Certified,
                _ => false,
            };
            if time.is_over() {
                return Ok(late(match finished {
                    Some(before) if !is_done => before,
                    _ => judged,
                }));
            }
            count = count.saturating_mul(2).clamp(FIRST_PART.min(asked), asked);
            finished = is_done.then_some(judged);
            continue;
        }
        let is_close = judged.members.as_ref().is_some_and(|found| found.is_close);
        let is_open = judged.ranking.state == AnswerState::Degraded;
        match finished {
            _ if is_close && count < most => finished = Some(judged),
            // It was not finished, and what it has found does not suffice. Lost jobs are no reason
            // to leave members out.
            Some(before) if is_open && (count > asked || time.is_over()) => {
                return Ok(late(before));
            }
            _ => return Ok(judged),
        }
        count = next_stage(count, most);
    }
}

/// How many members the stage after this one has.
pub(super) fn next_stage(count: u32, most: u32) -> u32 {
    count.saturating_mul(2).min(most)
}

/// A stage after which another one was not finished.
fn late(judged: Judged) -> Judged {
    let Judged { harms, mut ranking, members } = judged;
    ranking.state = AnswerState::Degraded;
    // More members may change any place.
    ranking.settled = 0;
    let members = members
        .map(|found| MembersFound { row: MembersRow { is_late: true, ..found.row }, ..found });
    Judged { harms, ranking, members }
}

/// What a stage is judged by.
pub(super) struct Stage<'s> {
    pub(super) policy: &'s Policy,
    /// What everybody has at stake.
    pub(super) stakes: &'s [Stake],
    /// The names of all parties.
    pub(super) parties: &'s [Name],
    /// How many members are asked for, and how many there are.
    pub(super) members: Members,
    pub(super) count: u32,
    /// How many draws were replaced.
    pub(super) replaced: u32,
    /// The harm of every candidate in the scene as stated, then in each member.
    pub(super) harms: &'s [Vec<CourseHarm>],
    /// Every candidate in the scene as stated, then in each member.
    pub(super) courses: &'s [CourseOutline],
}

/// Whom a candidate has met in one member.
#[derive(Clone, Debug)]
pub(super) struct CourseOutline {
    /// Parties and when each was touched first in a crash (s), in the order of time.
    pub(super) met: SmallVec<[(usize, f64); 2]>,
    /// Whether anything is not known.
    pub(super) is_open: bool,
    /// Whether it was not decided who lies inside whom at the start.
    pub(super) is_undecided: bool,
}

impl CourseOutline {
    pub(super) fn of(course: &Course<'_>) -> Self {
        let met = course.contacts.iter();
        Self {
            met: met.map(|contact| (contact.meeting.party, contact.first_touch_s)).collect(),
            is_open: course.is_open(),
            is_undecided: !course.way.undecided_at_start.is_empty(),
        }
    }
}

impl Stage<'_> {
    /// The order by what is known of it.
    pub(super) fn judged(&self) -> Result<Judged, RequestError> {
        let Self { policy, stakes, members, count, harms: all, .. } = *self;
        let mut judged = Judged::of(policy, stakes, means(&all[1..]))?;
        let candidates = judged.harms.len();
        let is_any_open = |courses: &[CourseOutline]| courses.iter().any(|course| course.is_open);
        let (is_done, are_known) =
            (!is_any_open(self.courses), !is_any_open(&self.courses[candidates..]));
        let ranking = &mut judged.ranking;
        let order: Vec<usize> = ranking.places.iter().map(|place| place.candidate).collect();
        if !is_done && ranking.state == AnswerState::Complete {
            // Something of the scene as stated is open, which is only shown.
            ranking.state = AnswerState::Certified;
        }
        let own = |k: usize| self.courses.iter().skip(k).step_by(candidates);
        let is_open = |k: usize| own(k).skip(1).any(|course| course.is_open);
        let (spreads, lead) = if are_known {
            let spreads = expected::spreads(policy, stakes, &all[1..], &order)?;
            let lead = spreads.lead;
            (spreads, lead)
        } else {
            let lead = certain_lead(policy, stakes, &all[1..], (ranking, &is_open))?;
            let may_draw_more = members.count <= count && count < members.most;
            if ranking.state == AnswerState::Certified && may_draw_more {
                // More members may have another winner.
                let may_be_close = expected::may_be_close(policy, stakes, &all[1..], order[0])?;
                if may_be_close.contains(&true) {
                    ranking.state = AnswerState::Degraded;
                    ranking.settled = 0;
                }
            }
            (Spreads::default(), lead)
        };
        let expected = (0..candidates).map(|k| {
            let own: Vec<&CourseOutline> = own(k).skip(1).collect();
            let known = spreads.candidates.get(k).copied().zip(spreads.leading.get(k));
            expected_row(self.parties, &own, &judged.harms[k], known)
        });
        let row = MembersRow {
            count,
            most: members.most,
            replaced: self.replaced,
            lead: spreads.lead,
            is_late: false,
        };
        let found = MembersFound {
            row,
            asked: members.count,
            expected: expected.collect(),
            is_close: lead.is_some_and(|lead| lead.is_close()),
        };
        judged.members = Some(found);
        Ok(judged)
    }
}

/// The lead of the first candidate, if it is the same whatever open work finds: then it is certain
/// who the first two are, and nothing in these is open. `harms` are those of members; `is_open` is
/// asked by candidate, of members alone.
pub(super) fn certain_lead(
    policy: &Policy,
    stakes: &[Stake],
    harms: &[Vec<CourseHarm>],
    (ranking, is_open): (&RankedCandidates, &dyn Fn(usize) -> bool),
) -> Result<Option<Lead>, RequestError> {
    let [first, second, ..] = &ranking.places[..] else { return Ok(None) };
    let two = [first.candidate, second.candidate];
    if ranking.settled < 2 || two.into_iter().any(is_open) {
        return Ok(None);
    }
    Ok(Some(expected::lead(policy, stakes, harms, two)?))
}

/// What the members of one candidate say.
fn expected_row(
    parties: &[Name],
    courses: &[&CourseOutline],
    harm: &CourseHarm,
    known: Option<(Spread, &Vec<f64>)>,
) -> ExpectedRow {
    let share = 1.0 / courses.len() as f64;
    let met = |party: usize| {
        let firsts = courses.iter().filter_map(|course| {
            let with = course.met.iter().filter(|(met, _)| *met == party);
            with.map(|(_, first_touch_s)| *first_touch_s).reduce(f64::min)
        });
        let (mut members, mut from_s) = (0_u32, f64::INFINITY);
        for first_s in firsts {
            members += 1;
            from_s = from_s.min(first_s);
        }
        let row = MetRow {
            party: parties[party].to_string(),
            probability: f64::from(members) * share,
            from_s: from_s + 0.0,
        };
        (members > 0).then_some(row)
    };
    let mut meets: Vec<MetRow> = (0..parties.len()).filter_map(met).collect();
    meets.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    let first = |course: &CourseOutline| {
        let party = parties[course.met.first()?.0].as_str();
        meets.iter().position(|met| met.party == party)
    };
    let members = known.map(|(_, leading)| {
        let rows = leading.iter().zip(courses);
        rows.map(|(harm, course)| MemberRow { harm: *harm, first: first(course) }).collect()
    });
    let any = courses.iter().filter(|course| !course.met.is_empty()).count();
    let sum =
        |end: fn(Interval) -> f64| harm.persons.iter().map(|risk| end(risk.work)).sum::<f64>();
    ExpectedRow {
        contact: any as f64 * share,
        meets,
        injured: Interval::new(sum(Interval::lo), sum(Interval::hi)),
        open: courses.iter().filter(|course| course.is_open).count() as u32,
        undecided: courses.iter().filter(|course| course.is_undecided).count() as u32,
        spread: known.map(|(spread, _)| spread),
        worlds: None,
        members: members.unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests;
