//! Recomputes the evidence of a recorded request, in this process.

use crate::in_process::InProcessExecutor;
use crate::job_history::{Asked, Ends, Firsts};
use crate::work::RankingRun;
use body::{BodyView, Meta};
use bvh::query::SweepWorkspace;
use dispatch::{Closed, JobSource as _};
use protocol::TaskId;
use record::{PoseQuestion, RecordedEnd, RecordedJob};

/// Asks the questions of a job history, runs the jobs that were done, abandons those that were
/// abandoned, and leaves open those that never ended. Returns the number of jobs run.
///
/// Evidence is made from unions, maxima and minima, so the order in which the jobs ended does not
/// matter.
pub fn replay(
    work: &mut RankingRun<'_>,
    bodies: &[(Meta, BodyView<'_>)],
    places: &[PoseQuestion],
    jobs: &[RecordedJob],
) -> u64 {
    let (ends, firsts) = (Ends::of(places, jobs), Firsts::of(places));
    work.ask_only(Asked::of(places));
    let mut executor = InProcessExecutor::with_room_for(bodies);
    let (mut open, mut done) = (Vec::new(), 0);
    // How a search was cut into jobs depended on which ended first. So it is done again as a whole,
    // and what was recorded of it is held against that.
    let mut workspace = SweepWorkspace::new();
    for number in work.searches() {
        let recorded = work.state(TaskId(number)).and_then(|state| firsts.of_state(state));
        work.recall(number, recorded, &mut workspace);
        done += 1;
    }
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
