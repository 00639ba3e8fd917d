//! The answer for programs: a view of the figures in place, with no text made from them.
//!
//! [`crate::Answer`] is for people and files: it copies names, formats hashes and gives reasons.
//! Code that lays an answer out in a message needs none of that, and runs on every request.

use crate::answer::assumptions;
use crate::request::Request;
use damage::{AnswerState, CandidateHarm, PersonHarm, Place, RankedCandidates, Scratch};

/// Harm of every candidate and their order, with the buffers that they are computed in.
#[derive(Debug, Default)]
pub(crate) struct Judged {
    pub(crate) harms: Vec<CandidateHarm>,
    pub(crate) ranking: RankedCandidates,
    pub(crate) scratch: Scratch,
    /// Spare lists of persons.
    pub(crate) persons: Vec<Vec<PersonHarm>>,
}

/// The answer to a request.
#[derive(Clone, Copy, Debug)]
pub struct AnswerView<'w> {
    request: &'w Request,
    judged: &'w Judged,
}

/// One candidate in its place.
#[derive(Clone, Copy, Debug)]
pub struct AnswerRow<'w> {
    /// Its name.
    pub name: &'w str,
    /// Its rank.
    pub place: &'w Place,
    /// Its figures.
    pub harm: &'w CandidateHarm,
    /// Whether it is the first, or the model cannot tell it from the first.
    pub is_tied: bool,
}

impl<'w> AnswerView<'w> {
    pub(crate) fn new(request: &'w Request, judged: &'w Judged) -> Self {
        Self { request, judged }
    }

    /// How complete it is.
    #[must_use]
    pub fn state(&self) -> AnswerState {
        self.judged.ranking.state
    }

    /// Candidates, least harm first.
    pub fn rows(&self) -> impl Iterator<Item = AnswerRow<'w>> {
        let Self { request, judged } = *self;
        judged.ranking.places.iter().map(|place| AnswerRow {
            name: &request.candidates[place.candidate].name,
            place,
            harm: &judged.harms[place.candidate],
            is_tied: judged.ranking.tie_class.contains(&place.candidate),
        })
    }

    /// The name of the party that a person belongs to.
    #[must_use]
    pub fn party_of(&self, person: &PersonHarm) -> &'w str {
        &self.request.persons[person.id.0].party
    }

    /// What was assumed for lack of data, in a sentence; the first of several.
    #[must_use]
    pub fn assumption(&self) -> Option<String> {
        assumptions(self.request).into_iter().next()
    }
}
