//! Traces of the plain walk, whose tests are those that the paper counts: two boxes, or two
//! triangles, at a time. They hold counts alone, so they are the same on every machine.

use super::super::bench::Bench;
use body::BodyView;
use bvh::{Counters, Kernel, NodePair, Question, Task, Walk, front, section};
use core::ops::ControlFlow;
use geometry::RelativePose;
use protocol::Section;
use runtime::clock;
use simulate::{JobTrace, Sample, TaskTrace, Trace, fit};

/// Counts the triangles hit.
struct Hits(u64);

impl bvh::Sink for Hits {
    fn hit(&mut self, _: bvh::Side, _: u32) -> ControlFlow<()> {
        self.0 += 1;
        ControlFlow::Continue(())
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// One task per pose, its jobs those of a distribution depth.
pub(crate) fn plain(bench: &Bench<'_>, depth: u32) -> Trace {
    let [(meta_a, a), (meta_b, b)] = &bench.bodies[..] else { return Trace::default() };
    let mut kernel =
        Kernel::with_room(meta_a.depth, meta_b.depth, a.corners.len(), b.corners.len());
    kernel.set_walk(Walk::Plain);
    let poses = bench.pair.poses.iter();
    Trace { tasks: poses.map(|pose| task(&mut kernel, (a, b), pose, depth)).collect() }
}

fn task(
    kernel: &mut Kernel,
    (a, b): (&BodyView<'_>, &BodyView<'_>),
    pose: &RelativePose,
    depth: u32,
) -> TaskTrace {
    let (mut pairs, mut counters) = (Vec::new(), Counters::default());
    front(a, b, pose, depth, &mut pairs, &mut counters);
    let weigh = |model: u32, body: &BodyView<'_>, node: u32| {
        (Section { model, node }, section::bytes(body.nodes, node))
    };
    let mut job = |pair: NodePair| {
        let task = Task { a: *a, b: *b, pose: *pose, question: Question::Pairs, directions: None };
        let mut hits = Hits(0);
        let done = kernel.run(&task, pair, u64::MAX, &mut hits);
        JobTrace {
            a: weigh(0, a, pair.a),
            b: weigh(1, b, pair.b),
            nb: done.counters.nb,
            np: done.counters.np,
            hits: hits.0,
        }
    };
    TaskTrace { descent_nb: counters.nb, jobs: pairs.into_iter().map(&mut job).collect() }
}

/// What the plain walk costs on this machine (ns): a job, a test of two boxes, one of two
/// triangles, a hit. Each job is timed several times, of which the least counts.
pub(crate) fn plain_costs(bench: &Bench<'_>, depths: &[u32]) -> [f64; 4] {
    const REPEATS: usize = 3;
    let [(meta_a, a), (meta_b, b)] = &bench.bodies[..] else { return [0.0; 4] };
    let mut kernel =
        Kernel::with_room(meta_a.depth, meta_b.depth, a.corners.len(), b.corners.len());
    kernel.set_walk(Walk::Plain);
    let mut samples = Vec::new();
    for (pose, depth) in
        bench.pair.poses.iter().flat_map(|pose| depths.iter().map(move |depth| (pose, *depth)))
    {
        let mut pairs = Vec::new();
        front(a, b, pose, depth, &mut pairs, &mut Counters::default());
        let question = Question::Pairs;
        let task = Task { a: *a, b: *b, pose: *pose, question, directions: None };
        for pair in pairs {
            let (mut ns, mut sample) = (f64::INFINITY, None);
            for _repeat in 0..REPEATS {
                let mut hits = Hits(0);
                let begun_ns = clock::now_ns();
                let done = kernel.run(&task, pair, u64::MAX, &mut hits);
                ns = ns.min((clock::now_ns() - begun_ns) as f64);
                let Counters { nb, np, .. } = done.counters;
                sample = Some(Sample { nb, np, hits: hits.0, ns });
            }
            samples.extend(sample);
        }
    }
    fit(&samples)
}
