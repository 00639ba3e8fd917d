//! When work may stop: once no open work can change the winner, or the order.
//!
//! What is open may harm everybody, so most work ends early because a way is proven to touch
//! nobody, or because a contact is bad for sure. The winner itself is always followed to its end:
//! an answer says whom it meets.

use crate::request_limits::Until;
use damage::rule::Stake;
use damage::{CourseHarm, Policy, RankError, RankedCandidates, Scratch, rank_in};

/// What was asked for, and what is known of it.
#[derive(Debug)]
pub(super) struct Stop<'r> {
    until: Until,
    policy: &'r Policy,
    stakes: Vec<Stake>,
    scratch: Scratch,
    ranking: RankedCandidates,
    is_decided: bool,
    /// Who cannot win need not be followed.
    may_spare_losers: bool,
}

/// Whether the lead of a candidate may turn out too close, so that more members are drawn.
pub(super) type MayBeClose<'c> = &'c dyn Fn(usize) -> Result<bool, RankError>;

impl<'r> Stop<'r> {
    pub(super) fn new(until: Until, policy: &'r Policy, stakes: Vec<Stake>) -> Self {
        let (scratch, ranking) = (Scratch::default(), RankedCandidates::default());
        Self { until, policy, stakes, scratch, ranking, is_decided: false, may_spare_losers: false }
    }

    /// Whether work may end before all of it is done.
    pub(super) fn is_watched(&self) -> bool {
        self.until != Until::Complete
    }

    /// Whether all that was asked for is the winner.
    pub(super) fn is_for_winner(&self) -> bool {
        self.until == Until::Certified
    }

    /// The order by the last look.
    pub(super) fn ranking(&self) -> &RankedCandidates {
        &self.ranking
    }

    /// Looks at what is known; whether no open work can change what was asked for. Where more
    /// members may be drawn, `may_be_close` says whether open work could have them drawn.
    pub(super) fn look(
        &mut self,
        harms: &[CourseHarm],
        is_open: &[bool],
        may_be_close: Option<MayBeClose<'_>>,
    ) -> Result<bool, RankError> {
        rank_in(&mut self.scratch, self.policy, &self.stakes, harms, &mut self.ranking)?;
        let ranking = &self.ranking;
        let is_certain = match self.until {
            Until::Complete => false,
            Until::Ordered => ranking.settled == harms.len(),
            Until::Certified => ranking.settled > 0,
        };
        let winner = ranking.places.first().map(|place| place.candidate);
        self.may_spare_losers = may_be_close.is_none();
        self.is_decided = match winner.filter(|winner| is_certain && !is_open[*winner]) {
            None => false,
            Some(winner) => match may_be_close {
                Some(may_be_close) => !may_be_close(winner)?,
                None => true,
            },
        };
        Ok(self.is_decided)
    }

    /// Whether, by the last look, a candidate need not be followed on.
    pub(super) fn may_spare(&self, candidate: usize) -> bool {
        let cannot_win = || !self.ranking.possible.contains(&candidate);
        let is_asked = self.is_for_winner() && self.may_spare_losers;
        self.is_decided || (is_asked && cannot_win())
    }
}

#[cfg(test)]
mod tests;
