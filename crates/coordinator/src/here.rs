//! All jobs in this process, one after the other: no workers, no channels. For comparison.

use crate::gather::Part;
use crate::work::{Errands, PartOf};
use bvh::{Kernel, NodePair, Outcome, Question, Sink};
use core::ops::ControlFlow;
use dispatch::{Closed, Spec};
use geometry::{Directions, RelativePose};
use model::{BodyView, Meta};
use protocol::result::{End, Last, hit};
use protocol::{Side, Summary};
use runtime::clock;

#[derive(Default)]
pub(crate) struct Hits(Vec<u32>);

impl Sink for Hits {
    fn hit(&mut self, side: bvh::Side, triangle: u32) -> ControlFlow<()> {
        let side = match side {
            bvh::Side::A => Side::A,
            bvh::Side::B => Side::B,
        };
        self.0.push(hit(side, triangle));
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Runs a request to its end in this process. Returns how many jobs there were.
pub fn run_here<W: Errands>(work: &mut W, bodies: &[(Meta, BodyView<'_>)]) -> u64 {
    run_watched(work, bodies, |_, _| {})
}

/// The same, and tells `watch` what each job said of itself before it is folded.
pub fn run_watched<W: Errands>(
    work: &mut W,
    bodies: &[(Meta, BodyView<'_>)],
    mut watch: impl FnMut(&Spec, &Summary),
) -> u64 {
    let depth = bodies.iter().map(|(meta, _)| meta.depth).max().unwrap_or(1);
    let triangles = bodies.iter().map(|(_, body)| body.corners.len()).max().unwrap_or(0);
    let mut kernel = Kernel::with_room(depth, depth, triangles, triangles);
    let (mut jobs, mut hits, mut count) = (Vec::new(), Hits::default(), 0);
    let mut around: Option<(u32, Directions)> = None;
    loop {
        work.more(&mut jobs);
        if jobs.is_empty() {
            return count;
        }
        for job in jobs.drain(..) {
            count += 1;
            if work.is_moot(job.task) {
                work.close(&job, Closed::Cut);
                continue;
            }
            run(&mut kernel, work, bodies, &job, &mut hits, &mut around, &mut watch);
        }
    }
}

pub(crate) fn run<W: Errands>(
    kernel: &mut Kernel,
    work: &mut W,
    bodies: &[(Meta, BodyView<'_>)],
    job: &Spec,
    hits: &mut Hits,
    around: &mut Option<(u32, Directions)>,
    watch: &mut impl FnMut(&Spec, &Summary),
) {
    let begun_ns = clock::now_ns();
    let Some(task) = work.task(job.task).copied() else { return };
    let made = match around.take() {
        Some(made) if made.0 == task.task => made,
        _ => (task.task, Directions::around(task.u.into(), task.z.into())),
    };
    let directions = &around.insert(made).1;
    let question = protocol::Question::from_number(task.question);
    let (question, directions) = match question {
        Some(protocol::Question::Pairs) => (Question::Pairs, Some(directions)),
        Some(protocol::Question::Sets) => (Question::Sets, None),
        Some(protocol::Question::Touches) | None => (Question::Touches, None),
    };
    let asked = bvh::Task {
        a: bodies[task.model_a as usize].1,
        b: bodies[task.model_b as usize].1,
        pose: RelativePose { rotation: task.rotation, translation: task.translation },
        question,
        directions,
    };
    hits.0.clear();
    let start = NodePair { a: job.a.node, b: job.b.node };
    let outcome = kernel.run(&asked, start, u64::MAX, hits);
    let wall_ns = clock::now_ns() - begun_ns;
    let summary = Summary { wall_ns, hits: hits.0.len() as u32, ..summary(&outcome) };
    watch(job, &summary);
    let supports = directions.map(|_| &outcome.supports.0);
    let last = Some(Last { summary, supports, hits: &hits.0 });
    work.fold(job, PartOf(Part { hits: &hits.0, last }));
    work.close(job, Closed::Done);
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
