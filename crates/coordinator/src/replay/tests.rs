//! Whatever became of the jobs and in whatever order, a replay of the ledger gives the same answer.

use super::*;
use crate::fixtures::with;
use crate::run_here;
use proptest::prelude::*;

/// Runs a request, from the last open job to the first, giving up some by a rule.
fn run_badly(
    work: &mut Work<'_>,
    bodies: &[(Meta, BodyView<'_>)],
    mut gives_up: impl FnMut() -> bool,
) {
    let mut desk = Desk::new(bodies);
    let mut open = Vec::new();
    loop {
        // Two tasks' jobs at a time, the last first: another order than any other run has.
        let mut more = Vec::new();
        work.more(&mut more);
        open.append(&mut more);
        work.more(&mut more);
        open.append(&mut more);
        if open.is_empty() {
            return;
        }
        while let Some(job) = open.pop() {
            if work.is_moot(job.task) {
                work.close(&job, Closed::Cut);
            } else if gives_up() {
                work.close(&job, Closed::Abandoned);
            } else {
                desk.run(work, &job, &mut |_, _| {});
            }
        }
    }
}

#[test]
fn a_complete_run_is_replayed_from_its_ledger_alone() {
    with(|request, bodies| {
        let mut work = Work::new(request, bodies, 4).with_ledger();
        run_here(&mut work, bodies);
        let ledger = work.ledger().expect("kept").clone();
        assert!(ledger.jobs.len() > 50, "{} jobs are too few to tell", ledger.jobs.len());
        assert_eq!(ledger.moments.last().map(|m| m.state.as_str()), Some("complete"));
        let mut again = Work::new(request, bodies, 4);
        replay(&mut again, bodies, &ledger.places, &ledger.jobs);
        assert_eq!(again.answer().expect("sound"), work.answer().expect("sound"));
        // Without its last jobs it is another answer, and says that it is not complete.
        let mut cut = Work::new(request, bodies, 4);
        replay(&mut cut, bodies, &ledger.places, &ledger.jobs[..ledger.jobs.len() / 2]);
        assert_ne!(cut.answer().expect("sound").state, damage::State::Complete);
    });
}

#[test]
fn work_intervals_only_nest_from_moment_to_moment() {
    with(|request, bodies| {
        let mut work = Work::new(request, bodies, 3).with_ledger();
        run_here(&mut work, bodies);
        let moments = &work.ledger().expect("kept").moments;
        assert!(moments.len() >= 2);
        for pair in moments.windows(2) {
            for (before, after) in pair[0].work.iter().zip(&pair[1].work) {
                assert!(before[0] <= after[0] && after[1] <= before[1], "{pair:?}");
            }
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn jobs_that_were_given_up_are_given_up_again(seed in any::<u64>(), one_in in 2..400_u64) {
        with(|request, bodies| {
            let mut state = seed;
            let gives_up = || {
                state = geometry::hash::splitmix64(state);
                state.is_multiple_of(one_in)
            };
            let mut work = Work::new(request, bodies, 4).with_ledger();
            run_badly(&mut work, bodies, gives_up);
            let ledger = work.ledger().expect("kept");
            let mut again = Work::new(request, bodies, 4);
            replay(&mut again, bodies, &ledger.places, &ledger.jobs);
            prop_assert_eq!(again.answer().expect("sound"), work.answer().expect("sound"));
            Ok(())
        })?;
    }
}
