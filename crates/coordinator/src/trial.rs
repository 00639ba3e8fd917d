//! Trials of the bounds: a request is worked on in random order, its answer is inspected at random
//! moments, and every interval seen is checked against the finished run.
//!
//! What must hold at every inspection: the final value lies in each interval; no interval is wider
//! than the one before; and places reported as settled are those of the finished run. Jobs run in
//! any order, are cut by any budget, and are sometimes lost permanently.
//!
//! [`BoundFlaw`] makes bounds wrong on purpose: a trial must notice it.

use crate::bound::Open;
use crate::course::TrialResult;
use crate::in_process::InProcessExecutor;
use crate::request::{Request, RequestError};
use crate::request_limits::RequestLimits;
use crate::run_in_process;
use crate::strategy::SearchOrder;
use crate::work::SurveyRun;
use body::{BodyView, Meta};
use damage::{
    AnswerState, AssessError, CandidateBounds, CandidateHarm, Interval, RankedCandidates,
};
use damage::{bounds, needs_high};
use dispatch::{Closed, JobSource as _};
use geometry::rng::Rng;

/// A deliberate flaw in the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BoundFlaw {
    /// Unfinished poses are taken to add nothing.
    ForgetsOpenPoses,
    /// Of what is open the middle is taken for certain.
    TakesMiddles,
}

/// All figures of one candidate that are intervals, with their names.
struct Figures(Vec<(String, Interval)>);

/// Lengths of the patch (m) may differ from the bound by what rounding does to points of contact.
const LENGTH_ROUNDING_M: f64 = 1e-6;
/// Ends of nested intervals may move out by what rounding does to a risk, and to an energy in units
/// of itself.
const FIGURE_ROUNDING: f64 = 1e-11;

impl Figures {
    fn of(harm: &CandidateHarm, steps: &[Interval]) -> Self {
        let mut all = Vec::new();
        for person in &harm.persons {
            let name = |of: &str| format!("person {}: {of}", person.id.0);
            all.push((name("risk"), person.work));
            let high = Interval::new(person.high_at_least, person.range.high());
            all.push((name("upper end of the range"), high));
        }
        all.push(("energy".to_owned(), harm.energy_j));
        for (party, delta_v) in ["ego", "other"].iter().zip(&harm.delta_v) {
            all.push((format!("change of velocity of {party}"), delta_v.work));
        }
        all.extend(steps.iter().enumerate().map(|(k, step)| (format!("step {k}"), *step)));
        Self(all)
    }

    /// The figures of the patch, which come and go with it.
    fn of_patch(harm: &CandidateHarm) -> Self {
        let Some(patch) = &harm.contact else { return Self(Vec::new()) };
        let named = [("width", patch.width_m), ("height", patch.height_m), ("span", patch.span_m)];
        Self(named.map(|(name, interval)| (name.to_owned(), interval)).to_vec())
    }
}

/// The finished run, and what was last seen before it.
struct Trial {
    last: (Vec<CandidateHarm>, RankedCandidates),
    before: Option<(Vec<CandidateHarm>, RankedCandidates)>,
    verdict: TrialResult,
}

/// Works on a request in random order, and inspects it about `stops` times.
///
/// # Errors
///
/// If the request cannot be judged.
pub(crate) fn trial(
    request: &Request,
    bodies: &[(Meta, BodyView<'_>)],
    depth: u32,
    (seed, stops): (u64, u64),
    flaw: Option<BoundFlaw>,
) -> Result<TrialResult, RequestError> {
    let mut whole = SurveyRun::new(request, bodies, depth);
    let jobs = run_in_process(&mut whole, bodies).max(1);
    let mut trial = Trial { last: whole.judge()?, before: None, verdict: TrialResult::default() };
    let mut rng = Rng::new(seed);
    let search_order = SearchOrder::ALL[rng.below(SearchOrder::ALL.len() as u64) as usize];
    let budget = [u64::MAX, 10_000, 30_000][rng.below(3) as usize];
    let loses = [0, 0, 0, 200, 20][rng.below(5) as usize];
    let limits = RequestLimits { search_order, budget, ..RequestLimits::default() };
    let mut work = SurveyRun::new(request, bodies, depth).with_limits(limits);
    let mut executor = InProcessExecutor::with_room_for(bodies);
    let mut open = Vec::new();
    trial.look(&work, flaw)?;
    loop {
        let mut fresh = Vec::new();
        if open.is_empty() || rng.below(8) == 0 {
            work.more(&mut fresh);
        }
        open.append(&mut fresh);
        if open.is_empty() {
            break;
        }
        let job = open.swap_remove(rng.below(open.len() as u64) as usize);
        if work.is_obsolete(&job) {
            work.close(&job, Closed::Cut);
        } else if loses > 0 && rng.below(loses) == 0 {
            work.close(&job, Closed::Abandoned);
        } else {
            executor.run(&mut work, &job, &mut |_, _| {});
        }
        if rng.below(jobs) < stops {
            trial.look(&work, flaw)?;
        }
    }
    trial.look(&work, flaw)?;
    Ok(trial.verdict)
}

impl Trial {
    /// Inspects the answer as it would be now.
    fn look(&mut self, work: &SurveyRun<'_>, flaw: Option<BoundFlaw>) -> Result<(), RequestError> {
        let now = match flaw {
            None => work.judge()?,
            Some(flaw) => flawed(work, flaw)?,
        };
        self.verdict.stops += 1;
        self.hold_against_the_end(&now);
        self.hold_against_what_was_before(&now);
        self.hold_places(&now.1);
        if flaw.is_none() {
            self.hold_standing(work, &now);
        }
        self.before = Some(now);
        Ok(())
    }

    fn fail(&mut self, what: String) {
        self.verdict.violations.push(what);
    }

    fn hold_against_the_end(&mut self, now: &(Vec<CandidateHarm>, RankedCandidates)) {
        let mut wrong = Vec::new();
        for (k, (harm, end)) in now.0.iter().zip(&self.last.0).enumerate() {
            let all = [Figures::of(harm, steps(&now.1, k)), Figures::of_patch(harm)];
            let ends = [Figures::of(end, steps(&self.last.1, k)), Figures::of_patch(end)];
            for (figures, rounding) in [(0, 0.0), (1, LENGTH_ROUNDING_M)] {
                for ((name, seen), (_, end)) in all[figures].0.iter().zip(&ends[figures].0) {
                    self.verdict.intervals += 1;
                    self.verdict.open_intervals += u64::from(!seen.is_settled());
                    // A candidate that overlaps from the start has no final value.
                    let value = end.hi();
                    let is_point = end.is_settled();
                    if is_point && !(seen.lo() - rounding <= value && value <= seen.hi() + rounding)
                    {
                        wrong.push(format!("candidate {k}: {name} is {value:?}, not in {seen:?}"));
                    }
                }
            }
        }
        wrong.into_iter().for_each(|what| self.fail(what));
    }

    fn hold_against_what_was_before(&mut self, now: &(Vec<CandidateHarm>, RankedCandidates)) {
        let Some(before) = self.before.take() else { return };
        for (k, (harm, was)) in now.0.iter().zip(&before.0).enumerate() {
            let all = [Figures::of(harm, &[]), Figures::of_patch(harm)];
            let were = [Figures::of(was, &[]), Figures::of_patch(was)];
            for (figures, rounding) in [(0, FIGURE_ROUNDING), (1, LENGTH_ROUNDING_M)] {
                for ((name, now), (_, was)) in all[figures].0.iter().zip(&were[figures].0) {
                    let by = rounding * (1.0 + was.hi().abs());
                    if now.lo() < was.lo() - by || now.hi() > was.hi() + by {
                        self.fail(format!("candidate {k}: {name} went from {was:?} to {now:?}"));
                    }
                }
            }
        }
        self.before = Some(before);
    }

    fn hold_places(&mut self, ranking: &RankedCandidates) {
        let winners = |ranking: &RankedCandidates| -> Vec<usize> {
            ranking.places.iter().map(|place| place.candidate).collect()
        };
        let (now, end) = (winners(ranking), winners(&self.last.1));
        let settled = ranking.settled;
        if now[..settled] != end[..settled] {
            self.fail(format!("{settled} places were settled as {now:?}, in the end {end:?}"));
        }
        if ranking.state == AnswerState::Certified {
            self.verdict.certified += 1;
        }
        let can_win = ranking.possible.contains(&end[0]);
        if !can_win && ranking.state != AnswerState::Refused {
            self.fail(format!("{:?} could win, in the end {} did", ranking.possible, end[0]));
        }
    }

    /// Checks that what is kept while jobs finish agrees with the answer.
    fn hold_standing(
        &mut self,
        work: &SurveyRun<'_>,
        (harms, ranking): &(Vec<CandidateHarm>, RankedCandidates),
    ) {
        let Some(standing) = work.standing() else { return };
        if standing.settled > ranking.settled {
            let (kept, said) = (standing.settled, ranking.settled);
            self.fail(format!("{kept} places were kept as settled, the answer has {said}"));
        }
        for (k, harm) in harms.iter().enumerate() {
            let Ok(made) = bounds_of(work, k) else { continue };
            let full = CandidateBounds::of(harm);
            let risks = |bounds: &CandidateBounds| -> Vec<Interval> {
                bounds.persons.iter().map(|person| person.work).collect()
            };
            if made.energy_j != full.energy_j || risks(&made) != risks(&full) {
                self.fail(format!("candidate {k}: bounds {made:?} are not those of {full:?}"));
            }
        }
    }
}

/// The bounds of a candidate, from all that is known now.
fn bounds_of(work: &SurveyRun<'_>, k: usize) -> Result<CandidateBounds, AssessError> {
    let request = work.request();
    let high = needs_high(&request.criteria.policy);
    work.lay_plane(k);
    let encounter = request.candidates[k].encounter();
    bounds(&encounter, &work.evidence(k), &work.basis(), high)
}

/// A candidate's measures in the policy's steps.
fn steps(ranking: &RankedCandidates, k: usize) -> &[Interval] {
    let place = ranking.places.iter().find(|place| place.candidate == k);
    place.map_or(&[], |place| &place.steps)
}

fn flawed(
    work: &SurveyRun<'_>,
    flaw: BoundFlaw,
) -> Result<(Vec<CandidateHarm>, RankedCandidates), RequestError> {
    match flaw {
        BoundFlaw::ForgetsOpenPoses => work.judge_by(
            |k| {
                let nothing = |_, _: &damage::Stop| Open::nothing();
                work.candidate_states()[k].evidence(nothing)
            },
            |_| {},
        ),
        BoundFlaw::TakesMiddles => work.judge_by(
            |k| work.evidence(k),
            |harm| {
                let Some(patch) = &mut harm.contact else { return };
                let open = [&mut patch.width_m, &mut patch.height_m, &mut patch.span_m];
                for length in open {
                    *length = Interval::exactly(f64::midpoint(length.lo(), length.hi()));
                }
            },
        ),
    }
}

#[cfg(test)]
pub(crate) mod tests;
