//! The order of candidates under a policy, and how sure it is.
//!
//! Two computations run side by side. The *order* comes from the upper work ends, as points: a
//! value inside each interval, so a sure pair is never inverted. *Certainty* comes from intervals
//! (`rank/interval.rs`): which candidates can still win, whatever open work finds. All figures are
//! rounded to 1e-9 before, so that floating-point rounding never decides.
//!
//! The order is found rank by rank: all steps of the policy thin the remaining candidates out, the
//! declared tie-break takes one of those kept, it is removed, and the next rank begins. (Comparing
//! pairs would cycle under tolerances.)
//!
//! Every candidate is ranked, unevaluable ones at `[0, 1]` for everyone in them. Nothing here
//! changes a candidate's figures.

use crate::interval::{Interval, Range};
use crate::party::PersonId;
use crate::policy::{Otherwise, Policy, Step, TieBreak};
use crate::rule::{Measure, Rule, Stake};
use schemars::JsonSchema;
use serde::Serialize;
use smallvec::SmallVec;

mod assessed;
mod figures;
mod ground;
mod interval;
mod note;
pub mod stability;
pub mod standing;
#[cfg(test)]
mod tests;

pub use assessed::Assessed;
use figures::{Figures, rounded};
pub use ground::Ground;
pub use note::Note;

/// A value per candidate. A request has at most sixteen; more would be allocated on the heap.
type Each<T> = SmallVec<[T; 16]>;

/// Buffers for ranking, kept from one ranking to the next: after the first of its size none
/// allocates.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    figures: Vec<Figures>,
    steps: Vec<Step>,
    /// Spare lists of places.
    spare: Vec<Vec<Interval>>,
}

impl Scratch {
    /// What a ranking is computed from, and spare lists of places.
    fn order<'a, H: Assessed>(
        &'a mut self,
        policy: &'a Policy,
        stakes: &'a [Stake],
        candidates: &[H],
    ) -> Result<(RankOrder<'a>, &'a mut Vec<Vec<Interval>>), RankError> {
        let Self { figures, steps, spare } = self;
        write_figures(stakes, candidates, figures)?;
        policy.write_steps(stakes.len(), steps);
        let figures = &figures[..candidates.len()];
        Ok((RankOrder { policy, stakes, steps, figures }, spare))
    }
}

/// The first `count` elements of a list that only grows.
fn taken<T: Clone + Default>(list: &mut Vec<T>, count: usize) -> &mut [T] {
    if list.len() < count {
        list.resize(count, T::default());
    }
    &mut list[..count]
}

/// How complete an answer is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AnswerState {
    /// All work is done.
    Complete,
    /// No open work can change the winner.
    Certified,
    /// Open work could change the winner.
    Degraded,
    /// No candidate has a bound.
    #[default]
    Refused,
}

impl AnswerState {
    /// The name as answers write it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Certified => "certified",
            Self::Degraded => "degraded",
            Self::Refused => "refused",
        }
    }
}

/// One rank.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Number of the candidate in the request.
    pub candidate: usize,
    /// The leading measure, over the work interval.
    pub work: Interval,
    /// The leading measure, over the model range.
    pub range: Range,
    /// Every step's measure over the work interval, in the order of the steps.
    pub steps: Vec<Interval>,
    /// Whether the model itself is sure that this comes before the next: their model ranges are
    /// further apart than the leading tolerance.
    pub certain: bool,
    /// Why this comes before the next; `None` for the last.
    pub why: Option<Ground>,
}

/// The answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RankedCandidates {
    /// How complete it is.
    pub state: AnswerState,
    /// All candidates, least harm first.
    pub places: Vec<Place>,
    /// Candidates that can still win, in the order of the request.
    pub possible: Vec<usize>,
    /// Number of leading places that no open work can change; 0 while open work can change whether
    /// the policy refuses them all.
    pub settled: usize,
    /// Candidates that the model cannot tell from the winner, itself included.
    pub tie_class: Vec<usize>,
    /// Further remarks.
    pub notes: Vec<Note>,
}

impl RankedCandidates {
    /// Whether the policy lets no candidate be chosen: then the first place wins nothing.
    #[must_use]
    pub fn is_refused(&self) -> bool {
        self.notes.iter().any(Note::is_refusal)
    }
}

/// Candidates that cannot be ranked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RankError {
    /// Nothing to rank.
    #[error("no candidates: a request needs at least one")]
    NoCandidates,
    /// A candidate names a person who is not in the request.
    #[error("candidate {candidate} names person {}, beyond the request's list", .person.0)]
    UnknownPerson {
        /// Number of the candidate.
        candidate: usize,
        /// Who.
        person: PersonId,
    },
    /// ρ is not in [0, 1].
    #[error("responsibility of person {} is not in [0, 1]", .0.0)]
    Responsibility(PersonId),
    /// A figure is not a valid probability or energy.
    #[error("candidate {0} has a figure that is not a number in its range")]
    Figure(usize),
}

/// Ranks candidates under a policy. `stakes` are all persons of the request, the one fixed set; a
/// candidate's [`PersonId`]s count into it.
///
/// # Errors
///
/// No candidate, a person beyond the list, a responsibility outside [0, 1], or a figure that is not
/// a number in its range.
pub fn rank<H: Assessed>(
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
) -> Result<RankedCandidates, RankError> {
    let mut ranking = RankedCandidates::default();
    rank_in(&mut Scratch::default(), policy, stakes, candidates, &mut ranking)?;
    Ok(ranking)
}

/// [`rank()`] in reused buffers, to avoid allocation. The contents of `ranking` are replaced unless
/// there is an error.
///
/// # Errors
///
/// As [`rank()`].
pub fn rank_in<H: Assessed>(
    scratch: &mut Scratch,
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
    ranking: &mut RankedCandidates,
) -> Result<(), RankError> {
    let (order, spare) = scratch.order(policy, stakes, candidates)?;
    order.write(candidates, spare, ranking);
    Ok(())
}

/// The first of the candidates, as [`rank_in`] has it, and those directly after it that are equal
/// by all steps.
///
/// # Errors
///
/// As [`rank()`].
pub fn winners_in<H: Assessed>(
    scratch: &mut Scratch,
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
) -> Result<SmallVec<[usize; 4]>, RankError> {
    Ok(scratch.order(policy, stakes, candidates)?.0.winners())
}

/// The leading measure of each candidate over open work, as [`Place::work`] has it; the contents of
/// `leading` are replaced.
///
/// # Errors
///
/// As [`rank()`].
pub(crate) fn leading_in<H: Assessed>(
    scratch: &mut Scratch,
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
    leading: &mut Vec<Interval>,
) -> Result<(), RankError> {
    scratch.order(policy, stakes, candidates)?.0.write_leading(leading);
    Ok(())
}

/// [`winners_in`] and [`leading_in`] at once.
pub(crate) fn best_in<H: Assessed>(
    scratch: &mut Scratch,
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
    leading: &mut Vec<Interval>,
) -> Result<SmallVec<[usize; 4]>, RankError> {
    let (order, _) = scratch.order(policy, stakes, candidates)?;
    order.write_leading(leading);
    Ok(order.winners())
}

/// The figures of all candidates, checked.
fn figures_of<H: Assessed>(stakes: &[Stake], candidates: &[H]) -> Result<Vec<Figures>, RankError> {
    let mut figures = Vec::new();
    write_figures(stakes, candidates, &mut figures)?;
    Ok(figures)
}

/// [`figures_of`] into the first elements of a list that only grows.
fn write_figures<H: Assessed>(
    stakes: &[Stake],
    candidates: &[H],
    figures: &mut Vec<Figures>,
) -> Result<(), RankError> {
    if candidates.is_empty() {
        return Err(RankError::NoCandidates);
    }
    if let Some(i) = stakes.iter().position(|s| !(0.0..=1.0).contains(&s.responsibility)) {
        return Err(RankError::Responsibility(PersonId(i)));
    }
    let figures = taken(figures, candidates.len());
    for (k, (figures, harm)) in figures.iter_mut().zip(candidates).enumerate() {
        figures.assessed(k, harm, stakes.len())?;
    }
    Ok(())
}

/// Everything that a ranking is computed from.
struct RankOrder<'a> {
    policy: &'a Policy,
    stakes: &'a [Stake],
    steps: &'a [Step],
    figures: &'a [Figures],
}

/// One rank found: its candidate, and at which step each other one fell out, if it did.
struct Round {
    winner: usize,
    fell: Each<Option<usize>>,
}

impl RankOrder<'_> {
    fn write<H: Assessed>(
        &self,
        candidates: &[H],
        spare: &mut Vec<Vec<Interval>>,
        ranking: &mut RankedCandidates,
    ) {
        let mut left: Each<usize> = (0..candidates.len()).collect();
        let mut rounds: Each<Round> = SmallVec::new();
        while !left.is_empty() {
            let round = self.round(&left);
            left.retain(|k| *k != round.winner);
            rounds.push(round);
        }
        let places = &mut ranking.places;
        spare.extend(places.drain(..).map(|place| place.steps));
        for (i, round) in rounds.iter().enumerate() {
            let next = rounds.get(i + 1).map(|next| next.winner);
            places.push(self.place(round, next, spare.pop().unwrap_or_default()));
        }
        let winner = places[0].range.high();
        let tie_class = |k: &usize| *k == rounds[0].winner || self.leading(*k).1.low() <= winner;
        let is_done = |k: &usize| candidates[*k].is_done();
        let (possible, settled) = self.settled(is_done);
        ranking.state = if candidates.iter().all(Assessed::is_unevaluable) {
            AnswerState::Refused
        } else if (0..candidates.len()).all(|k| is_done(&k)) {
            AnswerState::Complete
        } else if settled > 0 {
            AnswerState::Certified
        } else {
            AnswerState::Degraded
        };
        ranking.settled = settled;
        ranking.possible.clear();
        ranking.possible.extend_from_slice(&possible);
        ranking.tie_class.clear();
        ranking.tie_class.extend((0..candidates.len()).filter(tie_class));
        ranking.notes.clear();
        self.note(&mut ranking.notes);
    }

    /// Replaces the contents of a list by the leading measure of each candidate over open work.
    fn write_leading(&self, leading: &mut Vec<Interval>) {
        let (measure, _) = self.leading_measure();
        leading.clear();
        leading.extend((0..self.figures.len()).map(|k| self.over(measure, k)));
    }

    /// The first, and those directly after it that are equal by all steps.
    fn winners(&self) -> SmallVec<[usize; 4]> {
        let mut left: Each<usize> = (0..self.figures.len()).collect();
        let mut winners: SmallVec<[usize; 4]> = SmallVec::new();
        while !left.is_empty() {
            let next = self.round(&left).winner;
            let is_equal =
                |first: &usize| self.steps.iter().all(|s| self.at(s, *first) == self.at(s, next));
            if !winners.first().is_none_or(is_equal) {
                break;
            }
            winners.push(next);
            left.retain(|k| *k != next);
        }
        winners
    }

    /// A step's measure of a candidate over its work intervals.
    fn at(&self, step: &Step, k: usize) -> Interval {
        match step {
            Step::Least { measure, .. } => self.over(measure, k),
            Step::Accept { .. } => self.figures[k].greatest_high_over(),
        }
    }

    /// Takes all steps among the candidates left, on their upper work ends.
    fn round(&self, left: &[usize]) -> Round {
        let mut kept: Each<usize> = left.into();
        let mut fell: Each<Option<usize>> = SmallVec::from_elem(None, self.figures.len());
        for (number, step) in self.steps.iter().enumerate() {
            let stays: Each<bool> = match step {
                Step::Accept { at_most, otherwise } => {
                    let fits = |k: &usize| self.is_acceptable(*k, *at_most);
                    let any = kept.iter().any(fits);
                    let back = otherwise.fall_back().filter(|back| kept.contains(back));
                    let stays =
                        |k: &usize| if any { fits(k) } else { back.is_none_or(|b| b == *k) };
                    kept.iter().map(stays).collect()
                }
                Step::Least { measure, tolerance } => {
                    let values: Each<f64> = kept.iter().map(|k| self.value(measure, *k)).collect();
                    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                    let limit = rounded(least + tolerance);
                    values.iter().map(|v| *v <= limit).collect()
                }
            };
            for (k, _) in kept.iter().zip(&stays).filter(|(_, stays)| !**stays) {
                fell[*k] = Some(number);
            }
            let mut stays = stays.iter();
            kept.retain(|_| stays.next().copied().unwrap_or(true));
        }
        Round { winner: self.tie_winner(&kept), fell }
    }

    /// Whether nobody's risk in a candidate may exceed the accepted one.
    fn is_acceptable(&self, k: usize, at_most: f64) -> bool {
        self.figures[k].greatest_high() <= rounded(at_most)
    }

    /// The candidate that the declared tie-break chooses.
    fn tie_winner(&self, kept: &[usize]) -> usize {
        let before = |a: &&usize, b: &&usize| {
            let by = |t: &TieBreak| self.tie_value(*t, **a).total_cmp(&self.tie_value(*t, **b));
            let keys = self.policy.tie_break.iter().map(by);
            keys.fold(core::cmp::Ordering::Equal, core::cmp::Ordering::then).then(a.cmp(b))
        };
        kept.iter().min_by(before).copied().unwrap_or(0)
    }

    fn tie_value(&self, by: TieBreak, k: usize) -> f64 {
        match by {
            TieBreak::BrakeInLane => self.preference(k),
            TieBreak::Energy => self.figures[k].energy_j.hi(),
            TieBreak::High => self.leading(k).1.high(),
            TieBreak::Request => k as f64,
        }
    }

    /// The place of a candidate in the policy's list of preferred ones, or behind it.
    fn preference(&self, k: usize) -> f64 {
        let preferred = &self.policy.preferred;
        let at = preferred.iter().position(|named| named.number == Some(k));
        at.unwrap_or(preferred.len()) as f64
    }

    /// A measure of a candidate at its upper work ends.
    fn value(&self, measure: &Measure, k: usize) -> f64 {
        let Figures { risks, energy_j, .. } = &self.figures[k];
        rounded(measure.of(risks.len(), |i| risks[i].hi(), energy_j.hi(), self.stakes))
    }

    /// A measure of a candidate over its work intervals.
    fn over(&self, measure: &Measure, k: usize) -> Interval {
        let figures = &self.figures[k];
        measure.over(&figures.risks, figures.energy_j, self.stakes).map(rounded)
    }

    /// The leading measure, and its tolerance.
    fn leading_measure(&self) -> (&Measure, f64) {
        let first = self.steps.iter().find_map(|step| match step {
            Step::Least { measure, tolerance } => Some((measure, *tolerance)),
            Step::Accept { .. } => None,
        });
        first.unwrap_or((&Measure::Rule(Rule::Bayes), 0.0))
    }

    /// The leading measure of a candidate, over work and over the model, and its tolerance.
    fn leading(&self, k: usize) -> (Interval, Range, f64) {
        let (measure, tolerance) = self.leading_measure();
        let figures = &self.figures[k];
        let work = self.over(measure, k);
        let model = measure.over(&figures.ranges, figures.energy_j, self.stakes).map(rounded);
        let high = measure.with_others(model.hi(), self.stakes, &figures.others);
        let high = rounded(high).max(model.hi());
        (work, Range::new(model.lo(), high).around(work), tolerance)
    }

    fn place(&self, round: &Round, next: Option<usize>, mut steps: Vec<Interval>) -> Place {
        let k = round.winner;
        let (work, range, tolerance) = self.leading(k);
        steps.clear();
        steps.extend(self.steps.iter().map(|step| self.at(step, k)));
        Place {
            candidate: k,
            work,
            range,
            steps,
            certain: next.is_none_or(|l| range.high() + tolerance < self.leading(l).1.low()),
            why: next.map(|l| self.ground(k, l, round.fell[l])),
        }
    }

    /// What the policy says of all candidates, if none is acceptable.
    fn unacceptable(&self) -> impl Iterator<Item = Note> {
        self.steps.iter().filter_map(|step| {
            let Step::Accept { at_most, otherwise } = step else { return None };
            let mut all = 0..self.figures.len();
            if all.any(|k| self.is_acceptable(k, *at_most)) {
                return None;
            }
            let at_most = *at_most;
            let is_there = |number: usize| number < self.figures.len();
            Some(match otherwise {
                Otherwise::NextRule => Note::NobodyAcceptable { at_most },
                Otherwise::Refuse => Note::Refused { at_most, missing: None },
                Otherwise::FallBack(named) if named.number.is_some_and(is_there) => {
                    Note::FellBack { at_most, on: named.name.clone() }
                }
                Otherwise::FallBack(named) => {
                    Note::Refused { at_most, missing: Some(named.name.clone()) }
                }
            })
        })
    }

    fn note(&self, notes: &mut Vec<Note>) {
        notes.extend(self.unacceptable());
        if self.policy.is_ego_only() {
            notes.push(Note::EgoOnly);
        }
    }
}
