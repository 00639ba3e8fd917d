//! Which courses are followed next, where work may end once the winner is certain.
//!
//! A rival is out once the harm that it does for sure is more than all that the winner does: what
//! decides is all of the winner's members, and as many of a rival's as that takes. So whoever seems
//! best is followed through all members first; then its rivals, a few members of each at a time, as
//! long as they may win, or be too close to call. It is the race of LUCB (see
//! [`strategy`](crate::strategy)) between a leader and all its challengers, who are worked on
//! together, as each of them has to fall.
//!
//! With a deadline, the same race says when a part of the first stage is finished. What does not
//! matter in a part is left for the next one, where it may.
//!
//! # Invariants
//!
//! - What is chosen follows from the scene and from the harm found so far, so a replay chooses the
//!   same.
//! - No course is chosen twice in one stage.

use super::history::SearchClock;
use super::rounds::{Rounds, Standing};
use super::stages;
use crate::request::RequestError;
use damage::{CourseHarm, expected, rank};

/// Members in which the leader is followed at a time.
const OF_LEADER: usize = 8;

/// Courses of rivals that are followed at a time, unless there are more rivals.
const OF_RIVALS: usize = 16;

/// In which order courses are followed where work may end once the winner is certain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CourseOrder {
    /// The leader first, then its rivals.
    #[default]
    Race,
    /// One candidate after the other, for comparison.
    Sequential,
    /// Each candidate in turn, for comparison.
    RoundRobin,
}

/// Courses that were chosen in a stage.
#[derive(Debug, Default)]
pub(super) struct Selection {
    was_chosen: Vec<bool>,
}

impl Selection {
    /// The courses to follow next, ascending; none if nothing is left, or nothing that matters.
    pub(super) fn next(
        &mut self,
        rounds: &mut Rounds<'_>,
        time: &SearchClock,
    ) -> Result<Vec<usize>, RequestError> {
        self.was_chosen.resize(rounds.courses.len(), false);
        let is_left = |k: &usize| {
            let course = &rounds.courses[*k];
            course.is_open() && !course.is_spared && !self.was_chosen[*k]
        };
        let left: Vec<usize> = (0..rounds.courses.len()).filter(is_left).collect();
        // Once time is over all is left open at once, without looking what matters.
        let is_choice = rounds.is_for_winner() && !time.is_over();
        let is_hurried = time.has_limit();
        let mut chosen = if is_choice { deciding(rounds, left, is_hurried)? } else { left };
        chosen.sort_unstable();
        chosen.iter().for_each(|k| self.was_chosen[*k] = true);
        Ok(chosen)
    }
}

/// Those of the courses that are left, in ascending order, which tell most of who wins. In a hurry,
/// what the scene as stated has left open is followed of the leader alone: it is only shown.
fn deciding(
    rounds: &mut Rounds<'_>,
    left: Vec<usize>,
    is_hurried: bool,
) -> Result<Vec<usize>, RequestError> {
    let candidates = rounds.scenery.scenario.candidates.len();
    let (stated, drawn) = left.split_at(left.partition_point(|k| *k < candidates));
    if left.is_empty() || (!is_hurried && !stated.is_empty()) {
        return Ok(stated.to_vec());
    }
    let standing = rounds.standing(&[]);
    if rounds.is_settled(&standing)? {
        rounds.spare_open();
        return Ok(Vec::new());
    }
    let (policy, stakes) = (&rounds.request.criteria.policy, rounds.people.stakes());
    let members = &standing.harms[1..];
    let may_draw_more = rounds.may_draw_more();
    let ranking = rounds.ranking();
    let is_open = |k: usize| rounds.is_open_in_members(k);
    if may_draw_more
        && stages::certain_lead(policy, &stakes, members, (ranking, &is_open))?
            .is_some_and(|lead| lead.is_close())
    {
        // The next stage is certain to come, whatever is found here.
        return Ok(Vec::new());
    }
    let winner = ranking.places.first().filter(|_| ranking.settled > 0);
    let leader = match winner {
        Some(place) => place.candidate,
        None => {
            let seen = seen(rounds, &standing);
            rank(policy, &stakes, &seen)?.places[0].candidate
        }
    };
    let of_leader = left.iter().copied().filter(|course| course % candidates == leader);
    let of_leader: Vec<usize> = of_leader.take(OF_LEADER).collect();
    if rounds.order == CourseOrder::Race && !of_leader.is_empty() {
        return Ok(of_leader);
    }
    let left_of = |k: usize| drawn.iter().copied().filter(move |course| course % candidates == k);
    let mut matters: Vec<bool> = if winner.is_some() && may_draw_more {
        expected::may_be_close(policy, &stakes, members, leader)?
    } else {
        (0..candidates).map(|k| ranking.possible.contains(&k)).collect()
    };
    matters[leader] |= !of_leader.is_empty();
    let with_work = |rivals: &dyn Fn(&usize) -> bool| -> Vec<usize> {
        (0..candidates).filter(|k| rivals(k) && left_of(*k).next().is_some()).collect()
    };
    let mut rivals = with_work(&|k| matters[*k]);
    if rivals.is_empty() {
        // Who is second is open.
        rivals = with_work(&|_| true);
    }
    if rivals.is_empty() {
        return Ok(stated.to_vec());
    }
    let each = match rounds.order {
        CourseOrder::Race => OF_RIVALS.div_ceil(rivals.len()).min(most_of_rival(rounds.drawn())),
        CourseOrder::Sequential => {
            rivals.truncate(1);
            OF_LEADER
        }
        CourseOrder::RoundRobin => 1,
    };
    Ok(rivals.into_iter().flat_map(|k| left_of(k).take(each)).collect())
}

/// Members in which a rival is followed at a time, at most: where there are few, what it does in
/// some of them may suffice.
fn most_of_rival(members: usize) -> usize {
    members.div_ceil(4)
}

/// The mean of what was followed to its end of each candidate, and of the scene as stated as far as
/// that is known.
fn seen(rounds: &Rounds<'_>, standing: &Standing) -> Vec<CourseHarm> {
    let candidates = standing.means.len();
    let finished = |k: usize| {
        let all = rounds.courses.iter().zip(standing.harms.iter().flatten());
        let own = all.enumerate().skip(k).step_by(candidates);
        let own = own.filter(|(number, (course, _))| *number < candidates || !course.is_open());
        expected::mean(own.map(|(_, (_, harm))| harm))
    };
    (0..candidates).map(finished).collect()
}

#[cfg(test)]
mod tests;
