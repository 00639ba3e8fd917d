//! How far descents run ahead of the queues, and when a full one is tried again.

use super::*;

/// So many jobs, one at a time.
struct Drops(u32);

impl JobSource for Drops {
    type Part<'p> = ();

    fn more(&mut self, jobs: &mut Vec<Job>) {
        if let Some(left) = self.0.checked_sub(1) {
            self.0 = left;
            let section = |model| Section { model, node: left };
            jobs.push(Job { task: TaskId(left), a: section(0), b: section(1) });
        }
    }
    fn is_obsolete(&self, _: &Job) -> bool {
        false
    }
    fn fold(&mut self, _: &Job, (): ()) {}
    fn close(&mut self, _: &Job, _: Closed) {}
    fn weight(&self, _: Section) -> u64 {
        1
    }
}

/// Found by `cargo mutants`: nobody had asked how far descents run ahead, or what a job was.
#[test]
fn as_many_jobs_are_pending_as_all_queues_hold() {
    let queues = Queues { capacity: 5, batch: 5, linger_ns: 0 };
    let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 3);
    let mut work = Drops(1_000);
    dispatcher.begin(NOW);
    let mut effects = Vec::new();
    dispatcher.step(0, Event::Poll, &mut work, &mut effects);
    let made = dispatcher.counts().jobs;
    assert_eq!((dispatcher.pending.len(), made), (15, 15));
    let task = |job| dispatcher.spec(JobId(job)).map(|spec| spec.task);
    assert_eq!([task(0), task(14), task(15)], [Some(TaskId(999)), Some(TaskId(985)), None]);
}

/// A core whose queue was full is of interest only while a job waits for one.
#[test]
fn nothing_is_due_for_a_full_queue_that_no_job_waits_for() {
    let queues = Queues { capacity: 4, batch: 4, linger_ns: 0 };
    let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 2);
    dispatcher.begin(NOW);
    let (mut work, mut effects) = (Waves { left: vec![1], ..Waves::default() }, Vec::new());
    let who = |worker| Incarnation { worker, inc: 0 };
    dispatcher.step(1, Event::Ready(who(0)), &mut work, &mut effects);
    dispatcher.step(2, Event::Unsent { to: who(0), batch: 0 }, &mut work, &mut effects);
    assert!(dispatcher.due_ns().is_some_and(|due_ns| due_ns > 2), "the job waits");
    dispatcher.step(3, Event::Ready(who(1)), &mut work, &mut effects);
    assert!(dispatcher.is_busy(1) && !dispatcher.is_busy(0));
    assert_eq!(dispatcher.due_ns(), None);
}

/// Found by `cargo mutants`: queues of a few batches alone had been filled.
#[test]
fn a_queue_is_filled_with_whole_batches() {
    for (capacity, batch) in [(64, 8), (7, 3), (5, 2), (4, 4), (3, 1)] {
        let queues = Queues { capacity, batch, linger_ns: 0 };
        let mut dispatcher = Dispatcher::new(RoundRobin::default(), queues, Cache::Unlimited, 1);
        dispatcher.begin(NOW);
        let (mut work, mut effects) = (Drops(1_000), Vec::new());
        let who = Incarnation { worker: 0, inc: 0 };
        dispatcher.step(1, Event::Ready(who), &mut work, &mut effects);
        let jobs = |effect: &Effect| match effect {
            Effect::Send { jobs, .. } => jobs.len() as u32,
            Effect::Kill { .. } => 0,
        };
        let sent: Vec<u32> = effects.iter().map(jobs).collect();
        assert_eq!(sent, vec![batch; (capacity / batch) as usize], "{capacity}, {batch}");
    }
}
