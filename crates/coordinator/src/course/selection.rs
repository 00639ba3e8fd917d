//! Which courses are followed next, where work may end once the winner is certain.
//!
//! A rival is out once the harm that it does for sure is more than all that the winner does: what
//! decides is all of the winner's members, and as many of a rival's as that takes. So whoever seems
//! best is followed through all members first; then its rivals, a few members of each at a time, as
//! long as they may win, or be too close to call. It is the race of LUCB (see
//! [`strategy`](crate::strategy)) between a leader and all its challengers, who are worked on
//! together, as each of them has to fall.
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
        let mut chosen = if is_choice { deciding(rounds, left)? } else { left };
        chosen.sort_unstable();
        chosen.iter().for_each(|k| self.was_chosen[*k] = true);
        Ok(chosen)
    }
}

/// Those of the courses that are left, in ascending order, which tell most of who wins.
fn deciding(rounds: &mut Rounds<'_>, left: Vec<usize>) -> Result<Vec<usize>, RequestError> {
    let candidates = rounds.scenery.scenario.candidates.len();
    let stated = left.partition_point(|k| *k < candidates);
    if left.is_empty() || stated > 0 {
        return Ok(left[..stated].to_vec());
    }
    let standing = rounds.standing(&[]);
    if rounds.is_settled(&standing)? {
        rounds.spare_open();
        return Ok(Vec::new());
    }
    let (policy, stakes) = (&rounds.request.criteria.policy, rounds.people.stakes());
    let members = &standing.harms[1..];
    let is_last = rounds.is_last_stage();
    let ranking = rounds.ranking();
    let is_open = |k: usize| standing.is_open[k];
    if !is_last
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
    let left_of = |k: usize| left.iter().copied().filter(move |course| course % candidates == k);
    let is_leader_done = left_of(leader).next().is_none();
    if rounds.order == CourseOrder::Race && !is_leader_done {
        return Ok(left_of(leader).take(OF_LEADER).collect());
    }
    let mut matters: Vec<bool> = if winner.is_some() && !is_last {
        expected::may_be_close(policy, &stakes, members, leader)?
    } else {
        (0..candidates).map(|k| ranking.possible.contains(&k)).collect()
    };
    matters[leader] |= !is_leader_done;
    let with_work = |rivals: &dyn Fn(&usize) -> bool| -> Vec<usize> {
        (0..candidates).filter(|k| rivals(k) && left_of(*k).next().is_some()).collect()
    };
    let mut rivals = with_work(&|k| matters[*k]);
    if rivals.is_empty() {
        // Who is second is open.
        rivals = with_work(&|_| true);
    }
    let each = match rounds.order {
        CourseOrder::Race => OF_RIVALS.div_ceil(rivals.len()),
        CourseOrder::Sequential => {
            rivals.truncate(1);
            OF_LEADER
        }
        CourseOrder::RoundRobin => 1,
    };
    Ok(rivals.into_iter().flat_map(|k| left_of(k).take(each)).collect())
}

/// The mean of what was followed to its end of each candidate, the scene as stated included.
fn seen(rounds: &Rounds<'_>, standing: &Standing) -> Vec<CourseHarm> {
    let candidates = standing.means.len();
    let finished = |k: usize| {
        let all = rounds.courses.iter().zip(standing.harms.iter().flatten());
        let own = all.skip(k).step_by(candidates).filter(|(course, _)| !course.is_open());
        expected::mean(own.map(|(_, harm)| harm))
    };
    (0..candidates).map(finished).collect()
}

#[cfg(test)]
mod tests;
