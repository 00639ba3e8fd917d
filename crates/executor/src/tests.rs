//! What does not exist is rejected, and jobs are independent of earlier ones.

use super::*;
use body::Body;
use body::testing::{body_of, mesh_of, strip};
use core::ops::ControlFlow;

/// Collects hits, and stops at once if told to.
#[derive(Default)]
struct Ear {
    hits: Vec<u32>,
    is_deaf: bool,
}

impl Sink for Ear {
    fn hit(&mut self, side: bvh::Side, triangle: u32) -> ControlFlow<()> {
        self.hits.push(hit(side, triangle));
        if self.is_deaf { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn beat(&mut self, _: u64) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

const ALL: JobInput = JobInput { start: NodePair::ROOTS, budget: u64::MAX };

fn bodies() -> [Body; 2] {
    [40, 24].map(|count| body_of(&mesh_of(strip(count))))
}

fn task(question: protocol::WireQuestion, u: [f64; 3]) -> WireTask {
    WireTask {
        model_a: 0,
        model_b: 1,
        question: question as u32,
        task: 0,
        rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [2.03, -0.52, 0.01],
        u,
        z: [0.0, 0.0, 1.0],
    }
}

/// A job's summary without its time, its supports, its hits and its remainder.
type Found = (Summary, Option<[f64; SUPPORTS]>, Vec<u32>, Vec<NodePair>);

fn run(executor: &mut Executor, bodies: &[Body; 2], task: &WireTask, job: JobInput) -> Found {
    let body = |number: u32| bodies.get(number as usize).map(Body::view);
    let mut ear = Ear::default();
    let done = executor.execute(task, body, job, &mut ear).expect("it exists");
    let summary = done.summary(ear.hits.len() as u32, 0);
    (summary, done.supports().copied(), ear.hits, executor.rest().to_vec())
}

#[test]
fn what_does_not_exist_is_refused() {
    let bodies = bodies();
    let good = task(protocol::WireQuestion::Sets, [1.0, 0.0, 0.0]);
    let nodes = bodies.each_ref().map(|body| body.nodes.len() as u32);
    let mut executor = Executor::with_room_for(&[]);
    let start = |a, b| JobInput { start: NodePair { a, b }, budget: 100 };
    for (task, job) in [
        (WireTask { model_a: 2, ..good }, ALL),
        (WireTask { model_b: u32::MAX, ..good }, ALL),
        (WireTask { question: 0, ..good }, ALL),
        (good, start(nodes[0], 0)),
        (good, start(0, nodes[1])),
    ] {
        let body = |number: u32| bodies.get(number as usize).map(Body::view);
        let refused = executor.execute(&task, body, job, &mut Ear::default());
        assert_eq!(refused.err(), Some(NotDone::Unknown), "{task:?} {job:?}");
    }
    let body = |number: u32| bodies.get(number as usize).map(Body::view);
    let mut deaf = Ear { is_deaf: true, ..Ear::default() };
    let stopped = executor.execute(&good, body, ALL, &mut deaf);
    assert_eq!(stopped.err(), Some(NotDone::Stopped));
    let last = start(nodes[0] - 1, nodes[1] - 1);
    assert!(executor.execute(&good, body, last, &mut Ear::default()).is_ok());
}

#[test]
fn a_job_finds_the_same_whatever_was_done_before_it() {
    let bodies = bodies();
    // One executor for all, in turn, against one for each, with no initial capacity.
    let mut kept = Executor::with_room_for(&[]);
    for budget in [u64::MAX, 1] {
        for u in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
            for question in [
                protocol::WireQuestion::Pairs,
                protocol::WireQuestion::Touches,
                protocol::WireQuestion::Sets,
                protocol::WireQuestion::Pairs,
            ] {
                let (task, job) = (task(question, u), JobInput { budget, ..ALL });
                let found = run(&mut kept, &bodies, &task, job);
                let fresh = run(&mut Executor::with_room_for(&[]), &bodies, &task, job);
                assert_eq!(found, fresh, "{question:?} {u:?} {budget}");
                assert_eq!(found.1.is_some(), question == protocol::WireQuestion::Pairs);
                assert!(found.3.is_empty() == (found.0.hits > 0), "{found:?}");
                assert_eq!(found.0.rest, found.3.len() as u64);
                let end = if found.3.is_empty() { WireEnd::Complete } else { WireEnd::OutOfBudget };
                assert_eq!(found.0.end, end as u32);
            }
        }
    }
}
