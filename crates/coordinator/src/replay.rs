//! Recomputes the evidence of a recorded round of contacts, in this process.

use crate::in_process::InProcessExecutor;
use crate::job_history::{Asked, Ends};
use crate::work::SurveyRun;
use body::{BodyView, Meta};
use dispatch::{Closed, JobSource as _};
use record::{RecordedEnd, RecordedRound};

/// Asks the questions of a job history, runs the jobs that were done, abandons those that were
/// abandoned, and leaves open those that never ended. Returns the number of jobs run.
///
/// Evidence is made from unions, maxima and minima, so the order in which the jobs ended does not
/// matter.
pub(crate) fn replay(
    work: &mut SurveyRun<'_>,
    bodies: &[(Meta, BodyView<'_>)],
    RecordedRound { places, jobs }: &RecordedRound,
) -> u64 {
    let ends = Ends::of(places, jobs);
    work.ask_only(&Asked::of(places));
    let mut executor = InProcessExecutor::with_room_for(bodies);
    let (mut open, mut done) = (Vec::new(), 0);
    loop {
        work.more(&mut open);
        if open.is_empty() {
            return done;
        }
        for job in open.drain(..) {
            let end = work.state(job.task).and_then(|state| ends.end(state, &job));
            match end {
                _ if work.is_obsolete(&job) => work.close(&job, Closed::Cut),
                // In another order it may be needed here though it was not needed there.
                Some(RecordedEnd::Done | RecordedEnd::Cut) => {
                    done += 1;
                    executor.run(work, &job, &mut |_, _| {});
                }
                Some(RecordedEnd::Abandoned) | None => work.close(&job, Closed::Abandoned),
            }
        }
    }
}

#[cfg(test)]
mod tests;
