//! However and in whatever order the jobs ended, a replay of the job history gives the same answer.

use super::*;
use crate::fixtures::with;
use crate::request::Request;
use crate::run_in_process;
use crate::{RequestLimits, SearchOrder};
use damage::{AnswerState, CandidateHarm, RankedCandidates};
use proptest::prelude::*;

/// What follows from what is known.
type Judged = (Vec<CandidateHarm>, RankedCandidates);

/// What becomes of a job that is not obsolete.
enum Fate {
    Done,
    GivenUp,
    /// The answer is given before it.
    Late,
}

/// Runs a request from the last open job to the first, abandoning some by a rule, until it is over.
fn run_badly(
    work: &mut SurveyRun<'_>,
    bodies: &[(Meta, BodyView<'_>)],
    mut fate: impl FnMut() -> Fate,
) {
    let mut executor = InProcessExecutor::with_room_for(bodies);
    let mut open = Vec::new();
    loop {
        // Two tasks' jobs at a time, the last first: an order that no other run has.
        let mut more = Vec::new();
        work.more(&mut more);
        open.append(&mut more);
        work.more(&mut more);
        open.append(&mut more);
        if open.is_empty() {
            return;
        }
        while let Some(job) = open.pop() {
            if work.is_obsolete(&job) {
                work.close(&job, Closed::Cut);
                continue;
            }
            match fate() {
                Fate::Done => executor.run(work, &job, &mut |_, _| {}),
                Fate::GivenUp => work.close(&job, Closed::Abandoned),
                Fate::Late => return,
            }
        }
    }
}

/// The answer of a run in which jobs end as given, and that of its replay.
fn given_and_again(
    (request, bodies): (&Request, &[(Meta, BodyView<'_>)]),
    search_order: SearchOrder,
    fate: impl FnMut() -> Fate,
) -> (Judged, Judged) {
    let limits = RequestLimits { search_order, ..RequestLimits::default() };
    let mut work = SurveyRun::new(request, bodies, 4).with_limits(limits).with_job_history();
    run_badly(&mut work, bodies, fate);
    let job_history = work.job_history().expect("kept");
    let mut again = SurveyRun::new(request, bodies, 4);
    replay(&mut again, bodies, &job_history.round);
    (work.judge().expect("sound"), again.judge().expect("sound"))
}

#[test]
fn a_complete_run_is_replayed_from_its_ledger_alone() {
    with(|request, bodies| {
        let mut work = SurveyRun::new(request, bodies, 4).with_job_history();
        run_in_process(&mut work, bodies);
        let job_history = work.job_history().expect("kept").clone();
        let count = job_history.round.jobs.len();
        assert!(count > 50, "{count} jobs are too few to tell");
        let mut again = SurveyRun::new(request, bodies, 4);
        replay(&mut again, bodies, &job_history.round);
        assert_eq!(again.judge().expect("sound"), work.judge().expect("sound"));
        // Without its last jobs the answer differs, and says that it is not complete.
        let mut cut = SurveyRun::new(request, bodies, 4);
        let mut round = job_history.round;
        round.jobs.truncate(count / 2);
        replay(&mut cut, bodies, &round);
        assert_ne!(cut.judge().expect("sound").1.state, AnswerState::Complete);
    });
}

#[test]
fn an_answer_that_was_given_early_is_given_again() {
    with(|request, bodies| {
        for search_order in SearchOrder::ALL {
            let mut states = Vec::new();
            for jobs in (0..300).step_by(4) {
                let mut left = jobs;
                let fate = || {
                    let is_late = left == 0;
                    left -= i32::from(!is_late);
                    if is_late { Fate::Late } else { Fate::Done }
                };
                let (given, again) = given_and_again((request, bodies), search_order, fate);
                assert_eq!(again, given, "{search_order:?} after {jobs} jobs");
                states.push(given.1.state);
            }
            assert_ne!(states.first(), Some(&AnswerState::Complete));
            assert_eq!(states.last(), Some(&AnswerState::Complete));
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn jobs_that_were_given_up_are_given_up_again(seed in any::<u64>(), one_in in 2..400_u64) {
        with(|request, bodies| {
            let mut state = seed;
            let fate = || {
                state = geometry::hash::splitmix64(state);
                if state.is_multiple_of(one_in) { Fate::GivenUp } else { Fate::Done }
            };
            let (given, again) = given_and_again((request, bodies), SearchOrder::default(), fate);
            prop_assert_eq!(again, given);
            Ok(())
        })?;
    }
}
