//! Worlds: in how many of those that the model allows a candidate wins, and what would have another
//! one win.
//!
//! The contacts of all members are assessed again; nobody goes another way.

use super::contact_facts::ContactFacts;
use super::{Answer, Judged};
use crate::request::RequestError;
use damage::expected;
use damage::world::{Doubt, World, WorldDraw};
use damage::{CourseHarm, Criteria, Interval, RankedCandidates, Risk, Scratch, rank_in};
use schemars::JsonSchema;
use serde::Serialize;

/// How many there are at most in which one thing alone is drawn.
const WORLDS_OF_ONE: u32 = 64;

/// The worlds of an answer.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct WorldsRow {
    /// How many there are.
    pub count: u32,
    /// What would have another candidate win, the most likely first.
    pub flips: Vec<FlipRow>,
}

/// One thing that the model does not know.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct FlipRow {
    /// What is drawn, with all else nominal.
    pub doubt: Doubt,
    /// The share of such worlds in which the first candidate does not win.
    pub lost: f64,
}

/// What worlds have found.
pub(super) struct WorldsFound {
    row: WorldsRow,
    /// The share of worlds that each candidate wins.
    won: Vec<f64>,
}

impl WorldsFound {
    /// Completes an answer whose rows have members.
    pub(super) fn write(self, answer: &mut Answer, ranking: &RankedCandidates) {
        for (place, row) in ranking.places.iter().zip(&mut answer.ranking) {
            if let Some(expected) = &mut row.expected {
                expected.worlds = Some(self.won[place.candidate]);
            }
        }
        answer.worlds = Some(self.row);
    }
}

/// What is ranked in a world.
struct Worlds<'w> {
    criteria: &'w Criteria,
    stakes: Vec<damage::rule::Stake>,
    /// By member.
    members: Vec<&'w [Vec<&'w ContactFacts>]>,
    /// Expected harm with what is nominal: the model range is that of this.
    nominal: &'w [CourseHarm],
    scratch: Scratch,
    ranking: RankedCandidates,
}

/// Ranks the candidates in all worlds; `None` if none are asked for, or if `is_due` says that there
/// is no time. `contacts` are those of every candidate in every member, by member; a world draws
/// masses for so many `parties`.
pub(super) fn found(
    (criteria, asked): (&Criteria, scenario::Worlds),
    judged: &Judged,
    stakes: Vec<damage::rule::Stake>,
    (contacts, parties): (&[Vec<&ContactFacts>], usize),
    is_due: Option<&dyn Fn() -> bool>,
) -> Result<Option<WorldsFound>, RequestError> {
    if asked.count == 0 {
        return Ok(None);
    }
    let candidates = judged.harms.len();
    let mut worlds = Worlds {
        criteria,
        stakes,
        members: contacts.chunks(candidates).collect(),
        nominal: &judged.harms,
        scratch: Scratch::default(),
        ranking: RankedCandidates::default(),
    };
    let is_late = || is_due.is_some_and(|is_due| is_due());
    let coordinate = |number: u32, dimension: u32| asked.coordinate(number, dimension);
    let draw = |number: u32| WorldDraw {
        restitution: coordinate(number, 0),
        friction: coordinate(number, 1),
        curves: Some(coordinate(number, 2)),
        masses: (0..parties).map(|party| coordinate(number, 3 + party as u32)).collect(),
    };
    let mut won = vec![0.0; candidates];
    for number in 0..asked.count {
        if is_late() {
            return Ok(None);
        }
        worlds.rank(draw(number), |winner, share| won[winner] += share)?;
    }
    won.iter_mut().for_each(|won| *won /= f64::from(asked.count));
    let first = judged.ranking.places.first().map_or(0, |place| place.candidate);
    let of_one = WORLDS_OF_ONE.min(asked.count);
    let mut flips = Vec::new();
    for doubt in Doubt::ALL {
        let mut kept = 0.0;
        for number in 0..of_one {
            if is_late() {
                return Ok(None);
            }
            worlds.rank(draw(number).only(doubt), |winner, share| {
                if winner == first {
                    kept += share;
                }
            })?;
        }
        let lost = 1.0 - kept / f64::from(of_one);
        if lost > 0.0 {
            flips.push(FlipRow { doubt, lost });
        }
    }
    flips.sort_by(|a, b| b.lost.total_cmp(&a.lost));
    Ok(Some(WorldsFound { row: WorldsRow { count: asked.count, flips }, won }))
}

impl Worlds<'_> {
    /// Ranks the candidates in a world: `wins` gets each winner, and its part where several are
    /// equally good.
    fn rank(
        &mut self,
        draw: WorldDraw,
        mut wins: impl FnMut(usize, f64),
    ) -> Result<(), RequestError> {
        let criteria = self.criteria;
        let world = World::of(draw, &criteria.parameters, &criteria.curves);
        let harms = self.harms(&world)?;
        rank_in(&mut self.scratch, &criteria.policy, &self.stakes, &harms, &mut self.ranking)?;
        let places = &self.ranking.places;
        let ties = places.iter().take_while(|place| place.steps == places[0].steps).count();
        for place in &places[..ties] {
            wins(place.candidate, 1.0 / ties as f64);
        }
        Ok(())
    }

    /// The expected harm of every candidate in a world.
    fn harms(&self, world: &World) -> Result<Vec<CourseHarm>, RequestError> {
        let mut each = Vec::with_capacity(self.members.len());
        for member in &self.members {
            let harms = member.iter().map(|contacts| self.course(world, contacts));
            each.push(harms.collect::<Result<Vec<_>, _>>()?);
        }
        let harms = self.nominal.iter().enumerate().map(|(k, nominal)| {
            let mut mean = expected::mean(each.iter().map(|member| &member[k]));
            for risk in &mut mean.persons {
                if let Some(usual) = nominal.risk_of(risk.id) {
                    *risk =
                        Risk { range: usual.range.around(risk.work), high: usual.high, ..*risk };
                }
            }
            CourseHarm { others: nominal.others, ..mean }
        });
        Ok(harms.collect())
    }

    /// The harm of one course in a world.
    fn course(
        &self,
        world: &World,
        contacts: &[&ContactFacts],
    ) -> Result<CourseHarm, RequestError> {
        let mut harm = CourseHarm::none();
        let level = self.criteria.policy.outcome;
        for contact in contacts {
            let take = |id, risk| harm.add(id, risk);
            let energy_j = world.assess(&contact.encounter(), contact.parties, level, take);
            let energy_j = energy_j.map_err(|source| RequestError::Assess {
                name: contact.candidate.to_string(),
                source,
            })?;
            let before = harm.energy_j.hi();
            harm.energy_j = Interval::exactly(before + energy_j);
        }
        Ok(harm)
    }
}

#[cfg(test)]
mod tests;
