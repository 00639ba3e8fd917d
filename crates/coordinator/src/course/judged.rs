//! The order of candidates by what is known of them, and the answer that it makes.

use super::Answer;
use super::course_answer::Description;
use super::persons::People;
use super::stages::MembersFound;
use super::worlds::WorldsFound;
use crate::request::RequestError;
use damage::rule::Stake;
use damage::{AnswerState, CourseHarm, Policy, RankedCandidates, Scratch, rank_in};
use scenario::{Members, Worlds};

/// The order of candidates, and what it was made from.
pub(super) struct Judged {
    pub(super) harms: Vec<CourseHarm>,
    pub(super) ranking: RankedCandidates,
    /// What members say; `None`: the scene as stated was followed alone.
    pub(super) members: Option<MembersFound>,
}

impl Judged {
    pub(super) fn of(
        policy: &Policy,
        stakes: &[Stake],
        harms: Vec<CourseHarm>,
    ) -> Result<Self, RequestError> {
        let mut ranking = RankedCandidates::default();
        rank_in(&mut Scratch::default(), policy, stakes, &harms, &mut ranking)?;
        Ok(Self { harms, ranking, members: None })
    }

    /// Whether worlds can be drawn.
    pub(super) fn has_worlds(&self) -> bool {
        self.members.is_some() && self.ranking.state == AnswerState::Complete
    }

    /// The answer, if `worlds` are what was found where there are any.
    pub(super) fn answer(
        self,
        described: Description,
        of: (&People, &Policy),
        worlds: Option<WorldsFound>,
        (members, asked): (Members, Worlds),
    ) -> Answer {
        let Self { harms, ranking, members: found } = self;
        let mut answer = described.answer(of, &harms, &ranking);
        let Some(found) = found else {
            if !members.is_nominal() {
                let none = "there was no time for members: the scene is ranked as stated";
                answer.missing.push(none.to_owned());
                answer.ranking.iter_mut().for_each(|row| row.is_stated_alone = true);
            }
            return answer;
        };
        found.write(&mut answer, &ranking);
        match worlds {
            Some(worlds) => worlds.write(&mut answer, &ranking),
            // No world changes the winner.
            None if answer.state == AnswerState::Complete && asked.count > 0 => {
                answer.state = AnswerState::Certified;
                answer.missing.push("in how many worlds each would win".to_owned());
            }
            None => {}
        }
        answer
    }
}
