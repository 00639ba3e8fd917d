//! Members as they are followed: where everybody goes in one of them.
//!
//! A point at which the ego overlaps a party at time 0 is not how things are, as both are said to
//! be apart: the next point of the sequence takes its place, for all candidates. Parties that
//! overlap the ego where they are stated are left as they are.

use super::way::Scenery;
use crate::request::RequestError;
use damage::course::RunOut;
use damage::party::is_fixed;
use executor::encounter::{Encounters, Nested};
use geometry::motion::{MotionPath, PathError};
use scenario::{Candidate, MemberDraw, MemberSequence, Motion, PartyDraw};
use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

/// Points that are looked at, at most.
const POINTS_MAX: u32 = 1024;

/// Where everybody goes in one member.
#[derive(Clone, Debug)]
pub(crate) struct Member<'s> {
    /// Per candidate: the ego's path, and the paths of those who react, as the candidate lists
    /// them.
    candidates: Vec<(Cow<'s, MotionPath>, Vec<Cow<'s, MotionPath>>)>,
    /// Per party: the predicted path that it takes; none of the ego.
    parties: Vec<Option<Cow<'s, MotionPath>>>,
    /// What is drawn of a run-out: see [`RunOut::drawn`]; `None`: as usual.
    run_out: Option<(f64, f64)>,
    /// Per party: how it lies to the ego at the start, once that was asked.
    nested: Vec<OnceLock<Nested>>,
}

impl<'s> Member<'s> {
    /// The scene as stated.
    pub(crate) fn nominal(scenery: &Scenery<'s>) -> Self {
        let likeliest = |party: usize| {
            let is_ego = party == scenery.scenario.ego.0;
            (!is_ego).then(|| Cow::Borrowed(&scenery.likeliest(party).1.path))
        };
        let candidate = |candidate: &'s Candidate| {
            let reactions = candidate.reactions.iter();
            let reactions = reactions.map(|reaction| Cow::Borrowed(&reaction.motion.path));
            (Cow::Borrowed(&candidate.ego.path), reactions.collect())
        };
        Self {
            candidates: scenery.scenario.candidates.iter().map(candidate).collect(),
            parties: (0..scenery.scenario.parties.len()).map(likeliest).collect(),
            run_out: None,
            nested: vec![OnceLock::new(); scenery.scenario.parties.len()],
        }
    }

    /// The scene of a draw.
    fn drawn(scenery: &Scenery<'s>, draw: &MemberDraw) -> Result<Self, PathError> {
        let scenario = scenery.scenario;
        let path = |motion: &'s Motion, party: usize| {
            let of = &draw.parties[party];
            let stated = &scenario.parties[party];
            let is_fixed = stated.is_unknown || is_fixed(scenery.body(party).0.kind);
            let of = if is_fixed { of.of_fixed() } else { *of };
            if of == (PartyDraw { choice: of.choice, ..PartyDraw::NOMINAL }) {
                return Ok(Cow::Borrowed(&motion.path));
            }
            motion.drawn(&of, scenario.horizon_s).map(Cow::Owned)
        };
        let candidate = |candidate: &'s Candidate| {
            let ego = path(&candidate.ego, scenario.ego.0)?;
            let reactions = candidate.reactions.iter();
            let reactions = reactions.map(|reaction| path(&reaction.motion, reaction.party.0));
            Ok((ego, reactions.collect::<Result<_, _>>()?))
        };
        let party = |party: usize| {
            if party == scenario.ego.0 {
                return Ok(None);
            }
            path(chosen(scenery, party, draw.parties[party].choice), party).map(Some)
        };
        Ok(Self {
            candidates: scenario.candidates.iter().map(candidate).collect::<Result<_, _>>()?,
            parties: (0..scenario.parties.len()).map(party).collect::<Result<_, _>>()?,
            run_out: Some((draw.run_out_turn_deg, draw.run_out_share)),
            nested: vec![OnceLock::new(); scenario.parties.len()],
        })
    }

    /// The path of the ego in a candidate.
    pub(crate) fn ego(&self, candidate: usize) -> &MotionPath {
        &self.candidates[candidate].0
    }

    /// The path of a party where it does not react; none of the ego.
    pub(crate) fn party(&self, party: usize) -> Option<&MotionPath> {
        self.parties[party].as_deref()
    }

    /// The path of another party in a candidate, which is number `number`.
    pub(crate) fn other(
        &self,
        (number, candidate): (usize, &Candidate),
        party: usize,
    ) -> &MotionPath {
        let reacts = candidate.reactions.iter().position(|reaction| reaction.party.0 == party);
        let path = match reacts {
            Some(reaction) => Some(&self.candidates[number].1[reaction]),
            None => self.parties[party].as_ref(),
        };
        path.expect("every party but the ego has a path")
    }

    /// How a party lies to the ego at the start, if their triangles do not touch.
    pub(super) fn nested(
        &self,
        scenery: &Scenery<'_>,
        party: usize,
        encounters: &mut Encounters,
    ) -> Nested {
        *self.nested[party].get_or_init(|| {
            // All motions of a party begin at one pose, so the first candidate stands for all.
            let first = &scenery.scenario.candidates[0];
            let ways = scenery.ways(party, [self.ego(0), self.other((0, first), party)]);
            encounters.nested(&ways, scenery.shells_of(party), 0.0)
        })
    }

    /// The run-out of the ego in this member.
    pub(crate) fn run_out(&self, usual: RunOut) -> RunOut {
        self.run_out.map_or(usual, |(turn_deg, share)| usual.drawn(turn_deg, share))
    }
}

/// The predicted motion in whose share of the probabilities a number in [0, 1) lies.
fn chosen<'s>(scenery: &Scenery<'s>, party: usize, choice: f64) -> &'s Motion {
    let all = &scenery.scenario.parties[party].predictions;
    let mut sum = 0.0;
    let at = all.iter().position(|prediction| {
        sum += prediction.probability;
        choice < sum
    });
    let possible = || all.iter().rposition(|prediction| prediction.probability > 0.0);
    &all[at.or_else(possible).unwrap_or(0)].motion
}

/// The members of a request, one after the other.
#[derive(Debug)]
pub(super) struct Members<'s> {
    scenery: Scenery<'s>,
    /// Made when the first is drawn.
    sequence: Option<MemberSequence<'s>>,
    /// The scene as stated, and the members so far.
    pub(super) list: Vec<Arc<Member<'s>>>,
    /// The next point of the sequence.
    next: u32,
    /// How many points were replaced.
    pub(super) replaced: u32,
    /// Parties that overlap the ego where they are stated.
    overlap: Vec<usize>,
}

impl<'s> Members<'s> {
    pub(super) fn nominal(scenery: Scenery<'s>) -> Self {
        let list = vec![Arc::new(Member::nominal(&scenery))];
        Self { scenery, sequence: None, list, next: 0, replaced: 0, overlap: Vec::new() }
    }

    /// Draws members until there are so many besides the scene as stated.
    ///
    /// # Errors
    ///
    /// If the first [`POINTS_MAX`] points give fewer.
    pub(super) fn draw(
        &mut self,
        count: usize,
        encounters: &mut Encounters,
    ) -> Result<(), RequestError> {
        if self.next == 0 && count > 0 {
            let nominal = Arc::clone(&self.list[0]);
            self.overlap = self.overlapping(&nominal, encounters);
        }
        let mut last = None;
        while self.list.len() <= count {
            if self.next >= POINTS_MAX {
                let party = last.unwrap_or(self.scenery.scenario.ego.0);
                let party = self.scenery.scenario.parties[party].name.to_string();
                return Err(RequestError::Overlap { party, replaced: self.replaced });
            }
            let scenario = self.scenery.scenario;
            let sequence = self.sequence.get_or_insert_with(|| MemberSequence::new(scenario));
            let draw = sequence.draw(self.next);
            self.next += 1;
            let member = Member::drawn(&self.scenery, &draw)
                .map_err(|source| RequestError::Member { source })?;
            let overlap = self.overlapping(&member, encounters);
            match overlap.into_iter().find(|party| !self.overlap.contains(party)) {
                None => self.list.push(Arc::new(member)),
                Some(party) => {
                    self.replaced += 1;
                    last = Some(party);
                }
            }
        }
        Ok(())
    }

    /// Parties that overlap the ego at time 0.
    fn overlapping(&self, member: &Member<'s>, encounters: &mut Encounters) -> Vec<usize> {
        // As in `Member::nested`.
        let first = &self.scenery.scenario.candidates[0];
        let overlaps = |party: &usize| {
            let paths = [member.ego(0), member.other((0, first), *party)];
            let ways = self.scenery.ways(*party, paths);
            !ways.are_far(&(0.0..0.0))
                && (encounters.touch_at(&ways, 0.0)
                    || matches!(member.nested(&self.scenery, *party, encounters), Nested::Yes(_)))
        };
        self.scenery.others().filter(overlaps).collect()
    }
}
