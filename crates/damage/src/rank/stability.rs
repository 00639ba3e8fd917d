//! What would have to change, and by how much, for another candidate to win.
//!
//! One number is moved at a time, outwards from its value, until the winner of the whole comparison
//! changes: a weight (the others keep their proportions), a tolerance, an accepted risk, or the
//! intercept or slope of a nominal curve. For the numbers of a policy the places where anything can
//! change are known, since every measure is linear in them: so the least change is exact. Curves
//! are stepped outwards by a tenth at a time and then halved, so a flip that is undone within one
//! step may be missed.
//!
//! Model ranges are left alone: what rests on them (precaution) does not move with a curve. Nothing
//! here says that a change would be allowed: the resulting policy may well be refused.

use super::figures::Figures;
use super::{Assessed, Note, RankError, RankOrder, Step, figures_of};
use crate::curve::Curve;
use crate::harm::{CandidateHarm, PersonHarm};
use crate::interval::Interval;
use crate::policy::{Composition, Policy};
use crate::rule::{Measure, Rule, Stake, Term};
use serde::Serialize;

/// Changes of an intercept are sought up to this: a factor of 400 on the odds.
const INTERCEPT_MOST: f64 = 6.0;
/// Slopes are sought up to this factor either way.
const SLOPE_MOST: f64 = 4.0;
/// The first step of a curve's number, and how much longer each next one is.
const STEP: (f64, f64) = (0.01, 1.1);
/// Two places nearer than this count as one.
const SAME: f64 = 1e-12;

/// A number that was moved.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Knob {
    /// The weight of a rule; the others are rescaled to sum to 1.
    Weight {
        /// Whose.
        rule: Rule,
    },
    /// A tolerance.
    Tolerance {
        /// Number of the level in the policy, from 0; `None`: that of the sum or of leximin.
        level: Option<usize>,
    },
    /// The accepted risk of a precaution.
    Accept {
        /// Number of the level in the policy, from 0.
        level: usize,
    },
    /// The intercept a of a nominal curve.
    Intercept {
        /// Its id.
        curve: String,
    },
    /// The slope b of a nominal curve, per unit of its x.
    Slope {
        /// Its id.
        curve: String,
    },
}

/// How far one number is from flipping the winner.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reserve {
    /// Which number.
    pub knob: Knob,
    /// Its value.
    pub value: f64,
    /// Where the winner changes, nearest first to the value; `None`: nowhere in its range.
    pub flips_at: Option<f64>,
    /// Who wins beyond; `None`: nobody, as the policy then lets none be chosen, or nothing flips.
    pub winner: Option<usize>,
}

/// By how much the winner passed one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margin {
    /// Number of the step, from 0.
    pub step: usize,
    /// The winner's figure.
    pub winner: f64,
    /// The least figure of the other candidates still in at that step, and whose; `None`: there is
    /// none.
    pub next: Option<(usize, f64)>,
}

/// How stable the winner is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    /// Number of the winner in the request; `None`: the policy lets none be chosen.
    pub winner: Option<usize>,
    /// Per step of the policy, until the winner is alone.
    pub margins: Vec<Margin>,
    /// Per number of the policy and of the nominal curves in use.
    pub reserves: Vec<Reserve>,
}

/// Moves every number that the order depends on until the winner changes. `curves` are the nominal
/// ones in use, and `with_curve` gives the candidates as they would be if persons who follow the
/// curve of that id followed this one: see [`CandidateHarm::with_curve`].
///
/// # Errors
///
/// As [`super::rank`].
pub fn stability<H: Assessed>(
    policy: &Policy,
    stakes: &[Stake],
    candidates: &[H],
    curves: &[Curve],
    with_curve: &dyn Fn(&Curve) -> Vec<H>,
) -> Result<Stability, RankError> {
    let figures = figures_of(stakes, candidates)?;
    let sought = Sought { policy, stakes, figures: &figures };
    let winner = sought.winner(policy, &figures);
    let mut reserves = sought.of_policy(winner);
    reserves.extend(sought.of_curves(winner, curves, with_curve)?);
    Ok(Stability { winner, margins: sought.margins(), reserves })
}

impl CandidateHarm {
    /// This with the nominal risks of those who follow the curve of this id taken from this one.
    #[must_use]
    pub fn with_curve(&self, curve: &Curve) -> Self {
        let mut moved = self.clone();
        if moved.unevaluable.is_none() {
            let follows =
                |person: &&mut PersonHarm| person.curve == curve.id && person.work.is_settled();
            for person in moved.persons.iter_mut().filter(follows) {
                person.work = Interval::exactly(curve.risk(person.dose()));
            }
        }
        moved
    }
}

/// Number of the candidate that wins; `None`: the policy lets none be chosen.
type Winner = Option<usize>;

struct Sought<'a> {
    policy: &'a Policy,
    stakes: &'a [Stake],
    figures: &'a [Figures],
}

impl<'a> Sought<'a> {
    fn order<'b>(
        &self,
        policy: &'b Policy,
        steps: &'b [Step],
        figures: &'b [Figures],
    ) -> RankOrder<'b>
    where
        'a: 'b,
    {
        RankOrder { policy, stakes: self.stakes, steps, figures }
    }

    /// The steps of a policy among the persons at stake.
    fn steps(&self, policy: &Policy) -> Vec<Step> {
        policy.steps(self.stakes.len())
    }

    fn winner(&self, policy: &Policy, figures: &[Figures]) -> Winner {
        let all: Vec<usize> = (0..figures.len()).collect();
        let steps = self.steps(policy);
        let order = self.order(policy, &steps, figures);
        let is_refused = order.unacceptable().any(|note| Note::is_refusal(&note));
        (!is_refused).then(|| order.round(&all).winner)
    }

    fn margins(&self) -> Vec<Margin> {
        let steps = self.steps(self.policy);
        let order = self.order(self.policy, &steps, self.figures);
        let all: Vec<usize> = (0..self.figures.len()).collect();
        let round = order.round(&all);
        let mut margins = Vec::new();
        for (number, step) in order.steps.iter().enumerate() {
            let figure = |k: usize| match step {
                Step::Least { measure, .. } => order.value(measure, k),
                Step::Accept { .. } => order.figures[k].greatest_high(),
            };
            let came_so_far =
                |k: &usize| *k != round.winner && round.fell[*k].is_none_or(|at| at >= number);
            let others = all.iter().copied().filter(came_so_far).map(|k| (k, figure(k)));
            let next = others.min_by(|a, b| a.1.total_cmp(&b.1));
            margins.push(Margin { step: number, winner: figure(round.winner), next });
            if next.is_none() {
                break;
            }
        }
        margins
    }

    fn of_policy(&self, winner: Winner) -> Vec<Reserve> {
        let mut reserves = Vec::new();
        let mut seek = |knob, value, places: Vec<f64>, with: &dyn Fn(f64) -> Policy| {
            let winner_at = |x: f64| self.winner(&with(x), self.figures);
            let flip = nearest_flip(value, &places, winner, &winner_at);
            reserves.push(Reserve::of(knob, value, flip));
        };
        for (level, step) in self.policy.levels.iter().enumerate() {
            match step {
                Step::Accept { at_most, otherwise } => {
                    let places = self.figures.iter().map(Figures::greatest_high).collect();
                    seek(Knob::Accept { level }, *at_most, places, &|x| {
                        let mut policy = self.policy.clone();
                        let otherwise = otherwise.clone();
                        policy.levels[level] = Step::Accept { at_most: x, otherwise };
                        policy
                    });
                }
                Step::Least { measure, tolerance } => {
                    let places = self.differences(measure);
                    seek(Knob::Tolerance { level: Some(level) }, *tolerance, places, &|x| {
                        let mut policy = self.policy.clone();
                        let measure = measure.clone();
                        policy.levels[level] = Step::Least { measure, tolerance: x };
                        policy
                    });
                }
            }
        }
        match &self.policy.composition {
            Composition::Lexicographic => {}
            Composition::Leximin { tolerance } => {
                let worst = (0..self.stakes.len()).map(Measure::Worst);
                let places = worst.flat_map(|measure| self.differences(&measure)).collect();
                seek(Knob::Tolerance { level: None }, *tolerance, places, &|x| Policy {
                    composition: Composition::Leximin { tolerance: x },
                    ..self.policy.clone()
                });
            }
            Composition::Weighted { terms, tolerance } => {
                for term in terms.iter().filter(|term| term.weight < 1.0) {
                    let places = self.crossings(terms, *term);
                    seek(Knob::Weight { rule: term.rule }, term.weight, places, &|x| Policy {
                        composition: Composition::Weighted {
                            terms: reweighed(terms, *term, x),
                            tolerance: *tolerance,
                        },
                        ..self.policy.clone()
                    });
                }
                let places = self.differences(&Measure::Weighted(terms.as_slice().into()));
                seek(Knob::Tolerance { level: None }, *tolerance, places, &|x| Policy {
                    composition: Composition::Weighted { terms: terms.clone(), tolerance: x },
                    ..self.policy.clone()
                });
            }
        }
        reserves
    }

    /// The tolerances at which some candidate comes within reach of another.
    fn differences(&self, measure: &Measure) -> Vec<f64> {
        let order = self.order(self.policy, &[], self.figures);
        let values: Vec<f64> = (0..self.figures.len()).map(|k| order.value(measure, k)).collect();
        pairs(&values).map(|(a, b)| (a - b).abs()).collect()
    }

    /// The weights of a term at which two sums are equal: they are linear in the weight. The
    /// tolerance decides nothing, as the sum without it is the next step.
    fn crossings(&self, terms: &[Term], term: Term) -> Vec<f64> {
        let order = self.order(self.policy, &[], self.figures);
        let own = Measure::Rule(term.rule);
        let others = Measure::Weighted(reweighed(terms, term, 0.0).into());
        let ends: Vec<(f64, f64)> = (0..self.figures.len())
            .map(|k| (order.value(&own, k), order.value(&others, k)))
            .collect();
        let crossing = |(a, b): ((f64, f64), (f64, f64))| {
            let (at_one, at_zero) = (a.0 - b.0, a.1 - b.1);
            -at_zero / (at_one - at_zero)
        };
        pairs(&ends).map(crossing).collect()
    }

    fn of_curves<H: Assessed>(
        &self,
        winner: Winner,
        curves: &[Curve],
        with_curve: &dyn Fn(&Curve) -> Vec<H>,
    ) -> Result<Vec<Reserve>, RankError> {
        let winner_with = |curve: &Curve| -> Result<Winner, RankError> {
            let figures = figures_of(self.stakes, &with_curve(curve))?;
            Ok(self.winner(self.policy, &figures))
        };
        let mut reserves = Vec::new();
        for curve in curves {
            let id = || curve.id.to_string();
            let winner_with_intercept = |a: f64| winner_with(&Curve { a, ..curve.clone() });
            let place = |moved: f64| curve.a + moved;
            let flip =
                stepped(INTERCEPT_MOST, winner, |moved| winner_with_intercept(place(moved)))?;
            let knob = Knob::Intercept { curve: id() };
            reserves.push(Reserve::of(knob, curve.a, flip.map(|(m, who)| (place(m), who))));
            let winner_with_slope = |b: f64| winner_with(&Curve { b, ..curve.clone() });
            let place = |moved: f64| curve.b * libm::exp(moved);
            let flip =
                stepped(libm::log(SLOPE_MOST), winner, |moved| winner_with_slope(place(moved)))?;
            let knob = Knob::Slope { curve: id() };
            reserves.push(Reserve::of(knob, curve.b, flip.map(|(m, who)| (place(m), who))));
        }
        Ok(reserves)
    }
}

impl Reserve {
    fn of(knob: Knob, value: f64, flip: Option<(f64, Winner)>) -> Self {
        let (flips_at, winner) = (flip.map(|(at, _)| at), flip.and_then(|(_, who)| who));
        Self { knob, value, flips_at, winner }
    }
}

/// The terms with one weight replaced and the others rescaled, so that they sum to 1 again.
fn reweighed(terms: &[Term], moved: Term, weight: f64) -> Vec<Term> {
    let scale = (1.0 - weight) / (1.0 - moved.weight);
    let rescaled = |term: &Term| {
        let weight = if term.rule == moved.rule { weight } else { term.weight * scale };
        Term { weight, ..*term }
    };
    terms.iter().map(rescaled).collect()
}

fn pairs<T: Copy>(items: &[T]) -> impl Iterator<Item = (T, T)> {
    (0..items.len()).flat_map(move |i| (i + 1..items.len()).map(move |j| (items[i], items[j])))
}

/// The nearest place in [0, 1] beyond which another candidate wins. Between two neighbouring places
/// nothing changes, so the middle between them decides.
fn nearest_flip(
    value: f64,
    places: &[f64],
    winner: Winner,
    at: &dyn Fn(f64) -> Winner,
) -> Option<(f64, Winner)> {
    let outwards = |sign: f64, end: f64| {
        let beyond = |x: &f64| sign * (x - value) >= -SAME && sign * (end - x) > SAME;
        let mut places: Vec<f64> = places.iter().copied().filter(beyond).collect();
        places.sort_by(|a, b| (sign * a).total_cmp(&(sign * b)));
        let ends: Vec<f64> = places.iter().copied().skip(1).chain([end]).collect();
        let apart = |(from, to): &(f64, f64)| sign * (to - from) > SAME;
        let mut gaps = places.into_iter().zip(ends).filter(apart);
        gaps.find_map(|(from, to)| {
            let who = at(0.5 * (from + to));
            (who != winner).then_some((from, who))
        })
    };
    let flips = [outwards(-1.0, 0.0), outwards(1.0, 1.0)];
    let distance = |flip: &(f64, Winner)| (flip.0 - value).abs();
    flips.into_iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// The least movement either way, up to `most`, after which another candidate wins.
fn stepped(
    most: f64,
    winner: Winner,
    at: impl Fn(f64) -> Result<Winner, RankError>,
) -> Result<Option<(f64, Winner)>, RankError> {
    let mut nearest: Option<(f64, Winner)> = None;
    for sign in [-1.0, 1.0] {
        let (mut inside, mut outside) = (0.0, STEP.0);
        // Ends: steps grow, and 70 of them pass any limit here.
        while inside < most {
            let mut who = at(sign * outside)?;
            if who != winner {
                for _ in 0..50 {
                    let mid = 0.5 * (inside + outside);
                    match at(sign * mid)? {
                        same if same == winner => inside = mid,
                        other => (outside, who) = (mid, other),
                    }
                }
                if nearest.is_none_or(|(moved, _)| outside < moved.abs()) {
                    nearest = Some((sign * outside, who));
                }
                break;
            }
            (inside, outside) = (outside, (outside * STEP.1).min(most));
        }
    }
    Ok(nearest)
}

#[cfg(test)]
mod tests;
