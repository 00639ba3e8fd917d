//! Worlds: in how many of those that the model allows a candidate wins, and what would have another
//! one win.
//!
//! The contacts of all members are assessed again; nobody goes another way.

use super::{Answer, Course, CourseRequest, Judged};
use crate::request::RequestError;
use damage::expected;
use damage::world::{Doubt, World, WorldDraw};
use damage::{CourseHarm, Interval, RankedCandidates, Risk, Scratch, rank_in};
use scenario::members::world_coordinate;
use schemars::JsonSchema;
use serde::Serialize;

/// How many worlds there are.
const WORLDS: u32 = 200;
/// How many there are in which one thing alone is drawn.
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
    request: &'w CourseRequest<'w>,
    stakes: Vec<damage::rule::Stake>,
    /// By member.
    members: Vec<&'w [Course<'w>]>,
    /// Expected harm with what is nominal: the model range is that of this.
    nominal: &'w [CourseHarm],
    scratch: Scratch,
    ranking: RankedCandidates,
}

/// Ranks the candidates in all worlds; `None` if `is_due` says that there is no time.
pub(super) fn found<'w>(
    request: &'w CourseRequest<'w>,
    judged: &'w Judged,
    stakes: Vec<damage::rule::Stake>,
    drawn: &'w [Course<'w>],
    is_due: Option<&dyn Fn() -> bool>,
) -> Result<Option<WorldsFound>, RequestError> {
    let candidates = judged.harms.len();
    let parties = request.scenario.parties.len();
    let mut worlds = Worlds {
        request,
        stakes,
        members: drawn.chunks(candidates).collect(),
        nominal: &judged.harms,
        scratch: Scratch::default(),
        ranking: RankedCandidates::default(),
    };
    let is_late = || is_due.is_some_and(|is_due| is_due());
    let draw = |number: u32| WorldDraw {
        restitution: world_coordinate(number, 0),
        friction: world_coordinate(number, 1),
        curves: Some(world_coordinate(number, 2)),
        masses: (0..parties).map(|party| world_coordinate(number, 3 + party as u32)).collect(),
    };
    let mut won = vec![0.0; candidates];
    for number in 0..WORLDS {
        if is_late() {
            return Ok(None);
        }
        worlds.rank(draw(number), |winner, share| won[winner] += share)?;
    }
    won.iter_mut().for_each(|won| *won /= f64::from(WORLDS));
    let first = judged.ranking.places.first().map_or(0, |place| place.candidate);
    let mut flips = Vec::new();
    for doubt in Doubt::ALL {
        let mut kept = 0.0;
        for number in 0..WORLDS_OF_ONE {
            if is_late() {
                return Ok(None);
            }
            worlds.rank(draw(number).only(doubt), |winner, share| {
                if winner == first {
                    kept += share;
                }
            })?;
        }
        let lost = 1.0 - kept / f64::from(WORLDS_OF_ONE);
        if lost > 0.0 {
            flips.push(FlipRow { doubt, lost });
        }
    }
    flips.sort_by(|a, b| b.lost.total_cmp(&a.lost));
    Ok(Some(WorldsFound { row: WorldsRow { count: WORLDS, flips }, won }))
}

impl Worlds<'_> {
    /// Ranks the candidates in a world: `wins` gets each winner, and its part where several are
    /// equally good.
    fn rank(
        &mut self,
        draw: WorldDraw,
        mut wins: impl FnMut(usize, f64),
    ) -> Result<(), RequestError> {
        let criteria = &self.request.criteria;
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
            let harms = member.iter().map(|course| self.course(world, course));
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
    fn course(&self, world: &World, course: &Course<'_>) -> Result<CourseHarm, RequestError> {
        let mut harm = CourseHarm::none();
        let ego = self.request.scenario.ego.0;
        let level = self.request.criteria.policy.outcome;
        for contact in &course.contacts {
            let Some(candidate) = &contact.candidate else { continue };
            let parties = [ego, contact.meeting.party];
            let take = |id, risk| harm.add(id, risk);
            let energy_j = world.assess(&candidate.encounter(), parties, level, take);
            let energy_j = energy_j.map_err(|source| RequestError::Assess {
                name: candidate.name.to_string(),
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
