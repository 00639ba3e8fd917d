//! All jobs in this process, one after the other: no workers, no channels. For comparison.

use crate::gather::Part;
use crate::work::{Errands, PartOf};
use body::{BodyView, Meta};
use bvh::{Kernel, NodePair, Outcome, Question, Sink, kernel};
use core::ops::ControlFlow;
use dispatch::{Closed, Spec};
use geometry::{Directions, RelativePose};
use protocol::result::{End, Last, hit, write_rest};
use protocol::{Side, Summary};
use runtime::clock;

/// Hits of a job, which ends when the answer is due.
#[derive(Debug)]
struct Hits<'h> {
    hits: &'h mut Vec<u32>,
    due_ns: Option<u64>,
}

impl Sink for Hits<'_> {
    fn hit(&mut self, side: bvh::Side, triangle: u32) -> ControlFlow<()> {
        let side = match side {
            bvh::Side::A => Side::A,
            bvh::Side::B => Side::B,
        };
        self.hits.push(hit(side, triangle));
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        match self.due_ns {
            Some(due_ns) if clock::now_ns() >= due_ns => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

/// Where jobs are done in this process: kept from request to request, it takes nothing from the
/// heap once it is made.
#[derive(Debug)]
pub struct Desk<'b> {
    bodies: &'b [(Meta, BodyView<'b>)],
    kernel: Kernel,
    hits: Vec<u32>,
    rest: Vec<u64>,
    around: Option<(u32, Directions)>,
    jobs: Vec<Spec>,
}

/// Runs a request to its end in this process, or as far as it is wanted. Returns how many jobs
/// there were.
pub fn run_here<W: Errands>(work: &mut W, bodies: &[(Meta, BodyView<'_>)]) -> u64 {
    run_watched(work, bodies, |_, _| {})
}

/// The same, and tells `watch` what each job said of itself before it is folded.
pub fn run_watched<W: Errands>(
    work: &mut W,
    bodies: &[(Meta, BodyView<'_>)],
    watch: impl FnMut(&Spec, &Summary),
) -> u64 {
    Desk::new(bodies).work_off_watched(work, watch)
}

impl<'b> Desk<'b> {
    /// For jobs of these bodies.
    #[must_use]
    pub fn new(bodies: &'b [(Meta, BodyView<'b>)]) -> Self {
        let depth = bodies.iter().map(|(meta, _)| meta.depth).max().unwrap_or(1);
        let triangles = bodies.iter().map(|(_, body)| body.corners.len()).max().unwrap_or(0);
        Self {
            bodies,
            kernel: Kernel::with_room(depth, depth, triangles, triangles),
            hits: Vec::new(),
            rest: Vec::new(),
            around: None,
            jobs: Vec::new(),
        }
    }

    /// Runs a request to its end, or as far as it is wanted. Returns how many jobs there were.
    pub fn work_off<W: Errands>(&mut self, work: &mut W) -> u64 {
        self.work_off_watched(work, |_, _| {})
    }

    fn work_off_watched<W: Errands>(
        &mut self,
        work: &mut W,
        mut watch: impl FnMut(&Spec, &Summary),
    ) -> u64 {
        // Tasks of different requests have the same numbers.
        self.around = None;
        let mut jobs = std::mem::take(&mut self.jobs);
        let mut count = 0;
        work.accept(clock::now_ns());
        'work: loop {
            jobs.clear();
            work.more(&mut jobs);
            if jobs.is_empty() {
                break;
            }
            for job in &jobs {
                if work.is_over(clock::now_ns()) {
                    break 'work;
                }
                count += 1;
                if work.is_moot(job.task) {
                    work.close(job, Closed::Cut);
                    continue;
                }
                self.run(work, job, &mut watch);
            }
        }
        self.jobs = jobs;
        count
    }

    /// Does one job, unless the answer is due before it is done: then it stays open.
    pub(crate) fn run<W: Errands>(
        &mut self,
        work: &mut W,
        job: &Spec,
        watch: &mut impl FnMut(&Spec, &Summary),
    ) {
        let begun_ns = clock::now_ns();
        let Some(task) = work.task(job.task).copied() else { return };
        let made = match self.around.take() {
            Some(made) if made.0 == task.task => made,
            _ => (task.task, Directions::around(task.u.into(), task.z.into())),
        };
        let directions = &self.around.insert(made).1;
        let question = protocol::Question::from_number(task.question);
        let (question, directions) = match question {
            Some(protocol::Question::Pairs) => (Question::Pairs, Some(directions)),
            Some(protocol::Question::Sets) => (Question::Sets, None),
            Some(protocol::Question::Touches) | None => (Question::Touches, None),
        };
        let asked = bvh::Task {
            a: self.bodies[task.model_a as usize].1,
            b: self.bodies[task.model_b as usize].1,
            pose: RelativePose { rotation: task.rotation, translation: task.translation },
            question,
            directions,
        };
        self.hits.clear();
        let mut sink = Hits { hits: &mut self.hits, due_ns: work.deadline_ns() };
        let start = NodePair { a: job.a.node, b: job.b.node };
        let outcome = self.kernel.run(&asked, start, kernel::within(work.budget()), &mut sink);
        if outcome.end == bvh::End::Stopped {
            return;
        }
        let open = self.kernel.remaining();
        self.rest.clear();
        if !open.is_empty() {
            self.rest.resize(1 + open.len(), 0);
            write_rest(&mut self.rest, 0, open.iter().map(|pair| (pair.a, pair.b)));
        }
        let wall_ns = clock::now_ns() - begun_ns;
        let (hits, rest) = (self.hits.len() as u32, open.len() as u64);
        let summary = Summary { wall_ns, hits, rest, ..summary(&outcome) };
        watch(job, &summary);
        let supports = directions.map(|_| &outcome.supports.0);
        let last = Some(Last { summary, supports, hits: &self.hits });
        work.fold(job, PartOf(Part { hits: &self.hits, rest: &self.rest, last }));
        work.close(job, Closed::Done);
    }
}

fn summary(outcome: &Outcome) -> Summary {
    let end = match outcome.end {
        bvh::End::Complete => End::Complete,
        bvh::End::Stopped | bvh::End::OutOfBudget => End::OutOfBudget,
    };
    Summary {
        nb: outcome.counters.nb,
        np: outcome.counters.np,
        pairs: outcome.pairs,
        hash: outcome.hash,
        zones_a: outcome.zones_a,
        zones_b: outcome.zones_b,
        end: end as u32,
        ..Summary::default()
    }
}
