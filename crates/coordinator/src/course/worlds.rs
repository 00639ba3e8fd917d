//! Worlds: in how many of those that the model allows a candidate wins, and what would have another
//! one win.
//!
//! The contacts of all members are assessed again; nobody goes another way.

use super::contact_facts::ContactFacts;
use super::{Answer, Judged};
use crate::idle_cores::IdleCores;
use crate::request::RequestError;
use damage::expected::Mean;
use damage::world::{Doubt, World, WorldDraw};
use damage::{CourseHarm, Criteria, Interval, RankedCandidates, Risk, Scratch, winners_in};
use schemars::JsonSchema;
use serde::Serialize;
use smallvec::SmallVec;

/// How many there are at most in which one thing alone is drawn.
const WORLDS_OF_ONE: usize = 64;

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
    /// Who shares the work.
    cores: &'w IdleCores,
}

/// Worlds that are drawn before they are ranked.
const WORLDS_AT_ONCE: usize = 256;

/// Contacts in all members below which others do not help: the worlds of one doubt may be few, and
/// then take no longer than some threads take to start.
const SHARED_MIN: usize = 64;

/// Who wins, and with which part where several are equally good.
type Winners = SmallVec<[(usize, f64); 4]>;

/// Ranks the candidates in all worlds; `None` if none are asked for, or if `is_due` says that there
/// is no time, which is asked once for each world that is ranked, whoever does. `contacts` are
/// those of every candidate in every member, by member; a world draws masses for so many `parties`.
pub(super) fn found(
    (criteria, asked): (&Criteria, scenario::Worlds),
    judged: &Judged,
    stakes: Vec<damage::rule::Stake>,
    (contacts, parties): (&[Vec<&ContactFacts>], usize),
    (is_due, cores): (Option<&dyn Fn() -> bool>, &IdleCores),
) -> Result<Option<WorldsFound>, RequestError> {
    if asked.count == 0 {
        return Ok(None);
    }
    let candidates = judged.harms.len();
    let alone = IdleCores::default();
    let contacts_of_one: usize = contacts.iter().map(Vec::len).sum();
    let cores = if contacts_of_one >= SHARED_MIN { cores } else { &alone };
    let worlds = Worlds {
        criteria,
        stakes,
        members: contacts.chunks(candidates).collect(),
        nominal: &judged.harms,
        cores,
    };
    let mut goes_on = || !is_due.is_some_and(|is_due| is_due());
    let mut scratch = Scratch::default();
    let coordinate = |number: u32, dimension: u32| asked.coordinate(number, dimension);
    let draw = |number: u32| WorldDraw {
        restitution: coordinate(number, 0),
        friction: coordinate(number, 1),
        curves: Some(coordinate(number, 2)),
        masses: (0..parties).map(|party| coordinate(number, 3 + party as u32)).collect(),
    };
    let numbers: Vec<u32> = (0..asked.count).collect();
    let mut won = vec![0.0; candidates];
    for some in numbers.chunks(WORLDS_AT_ONCE) {
        let drawn: Vec<World> = some.iter().map(|number| worlds.world(draw(*number))).collect();
        let Some(winners) = worlds.winners(&mut scratch, &drawn, &mut goes_on) else {
            return Ok(None);
        };
        for winners in winners {
            for (winner, share) in winners? {
                won[winner] += share;
            }
        }
    }
    won.iter_mut().for_each(|won| *won /= f64::from(asked.count));
    let first = judged.ranking.places.first().map_or(0, |place| place.candidate);
    let of_one = &numbers[..numbers.len().min(WORLDS_OF_ONE)];
    let mut flips = Vec::new();
    for doubt in Doubt::ALL {
        // There are few sets of curves: many draws are one world.
        let mut known: Vec<World> = Vec::new();
        let mut places: SmallVec<[usize; WORLDS_OF_ONE]> = SmallVec::new();
        for number in of_one {
            let world = worlds.world(draw(*number).only(doubt));
            let place = known.iter().position(|other| other.is_same(&world));
            places.push(place.unwrap_or_else(|| {
                known.push(world);
                known.len() - 1
            }));
        }
        let Some(winners) = worlds.winners(&mut scratch, &known, &mut goes_on) else {
            return Ok(None);
        };
        let share = |winners: Result<Winners, RequestError>| {
            let winners = winners?;
            let share = winners.iter().find(|(winner, _)| *winner == first);
            Ok::<_, RequestError>(share.map_or(0.0, |(_, share)| *share))
        };
        let shares = winners.into_iter().map(share).collect::<Result<Vec<_>, _>>()?;
        let kept: f64 = places.iter().map(|place| shares[*place]).sum();
        let lost = 1.0 - kept / of_one.len() as f64;
        if lost > 0.0 {
            flips.push(FlipRow { doubt, lost });
        }
    }
    flips.sort_by(|a, b| b.lost.total_cmp(&a.lost));
    Ok(Some(WorldsFound { row: WorldsRow { count: asked.count, flips }, won }))
}

impl Worlds<'_> {
    /// The world of a draw.
    fn world(&self, draw: WorldDraw) -> World {
        World::of(draw, &self.criteria.parameters, &self.criteria.curves)
    }

    /// Who wins in each of these worlds; `None`: there is no time.
    fn winners(
        &self,
        scratch: &mut Scratch,
        worlds: &[World],
        goes_on: &mut dyn FnMut() -> bool,
    ) -> Option<Vec<Result<Winners, RequestError>>> {
        let winner = |scratch: &mut Scratch, number: usize| self.winner(scratch, &worlds[number]);
        self.cores.map_while(scratch, worlds.len(), goes_on, winner)
    }

    fn winner(&self, scratch: &mut Scratch, world: &World) -> Result<Winners, RequestError> {
        let harms = self.harms(world)?;
        let winners = winners_in(scratch, &self.criteria.policy, &self.stakes, &harms)?;
        let share = 1.0 / winners.len() as f64;
        Ok(winners.into_iter().map(|winner| (winner, share)).collect())
    }

    /// The expected harm of every candidate in a world.
    fn harms(&self, world: &World) -> Result<Vec<CourseHarm>, RequestError> {
        let mut harms = Vec::with_capacity(self.nominal.len());
        let mut course = CourseHarm::none();
        for (k, nominal) in self.nominal.iter().enumerate() {
            let mut mean = Mean::default();
            for member in &self.members {
                self.write_course(world, &member[k], &mut course)?;
                mean.add(&course);
            }
            let mut harm = mean.finish();
            for risk in &mut harm.persons {
                if let Some(usual) = nominal.risk_of(risk.id) {
                    *risk =
                        Risk { range: usual.range.around(risk.work), high: usual.high, ..*risk };
                }
            }
            harms.push(CourseHarm { others: nominal.others, ..harm });
        }
        Ok(harms)
    }

    /// Replaces the contents of `harm` by the harm of one course in a world.
    fn write_course(
        &self,
        world: &World,
        contacts: &[&ContactFacts],
        harm: &mut CourseHarm,
    ) -> Result<(), RequestError> {
        harm.persons.clear();
        harm.energy_j = Interval::ZERO;
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
        Ok(())
    }
}

#[cfg(test)]
mod tests;
